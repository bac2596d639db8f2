// SPDX-License-Identifier: Apache-2.0
#include "diagnose/chance.h"

#include <doctest/doctest.h>

#include "plant/laws.h"
#include "tests/diagnose/one_limb.h"
#include "tests/long_when_sanitized.h"

namespace diagnose_chance_test {

using namespace sinew;
using diagnose::ProcessNoiseByChance;

namespace {

sim::Scenario with_sensors_of_the_paper() {
  sim::Scenario scenario = testing::babbling(40.0);
  scenario.sensors = sim::usual_sensors(scenario.plant.system());
  return scenario;
}

}  // namespace

TEST_CASE("chance: much process noise never comes by it, whatever the number of threads" * long_when_sanitized) {
  testing::FittedCore limb(with_sensors_of_the_paper());
  REQUIRE(limb.core.usable);
  CHECK(limb.core.process_noise < 50.0);
  const ProcessNoiseByChance by_one = diagnose::process_noise_by_chance(limb.core, 1e4, limb.data, 1, 7, limb.settings);
  CHECK(by_one.drawn == 99);
  CHECK(by_one.as_large == 0);
  CHECK(by_one.probability() == 0.01);
  CHECK(by_one.largest > 0.0);
  CHECK(by_one.largest < 250.0);
  CHECK(diagnose::process_noise_by_chance(limb.core, 1e4, limb.data, 2, 7, limb.settings).largest == by_one.largest);
  CHECK(diagnose::process_noise_by_chance(limb.core, 1e4, limb.data, 2, 8, limb.settings).largest != by_one.largest);
}

TEST_CASE("chance: as much as any has comes with the first draws, and no more are made") {
  testing::FittedCore limb(with_sensors_of_the_paper());
  REQUIRE(limb.core.usable);
  const ProcessNoiseByChance any = diagnose::process_noise_by_chance(limb.core, -1e9, limb.data, 2, 7, limb.settings);
  CHECK(any.drawn == 4);
  CHECK(any.as_large == 4);
  CHECK(any.probability() == 1.0);
}

TEST_CASE("chance: process noise that other parameters take away as well is none") {
  testing::FittedCore limb(with_sensors_of_the_paper());
  REQUIRE(limb.core.usable);
  limb.core.process_noise = 1e4;  // as where the forcings beside the air let the parameters slide
  CHECK(diagnose::process_noise_after_refit(limb.core, limb.data, limb.settings) < 20.0);
  limb.core.process_noise = -5.0;
  CHECK(diagnose::process_noise_after_refit(limb.core, limb.data, limb.settings) <= -5.0);
}

TEST_CASE("chance: air of its own at one wire is ordinary, ten times as much is not") {
  const auto with_heat = [](double most_W) {
    sim::Scenario scenario = with_sensors_of_the_paper();
    // At A it follows the time; at B the duty, where it is nearly nothing.
    plant::Law law{.entry = testing::group("heat"),
                   .argument = {testing::variable("time"), testing::variable("duty B")},
                   .factor = {},
                   .knots = {},
                   .curve = Eigen::MatrixXd(41, 1)};
    for (int k = 0; k < 41; ++k) {
      law.knots.push_back(k);
      law.curve(k, 0) = most_W * std::sin(2.0 * M_PI * k / 20.0);
    }
    scenario.plant = plant::with_laws_on(scenario.plant, {std::move(law)});
    return testing::recorded(scenario);
  };
  for (const double most_W : {0.03, 0.5}) {
    const sim::Recording recording = with_heat(most_W);
    diagnose::ExplanationSettings fit;
    fit.start = diagnose::StartPolicy::at_rest;
    const diagnose::Explanation core = diagnose::explain(plant::default_plant(), testing::data_of(recording), {}, fit);
    REQUIRE(core.usable);
    INFO(most_W << " W: process noise " << core.process_noise);
    CHECK(core.process_noise > 250.0);  // of one air around the whole limb
    CHECK((diagnose::process_noise_beyond_ordinary(core) > 250.0) == (most_W > 0.05));
  }
}

TEST_CASE("chance: what is missing leaves process noise that no other parameters take away") {
  sim::Scenario scenario = with_sensors_of_the_paper();
  scenario.plant = diagnose::with_effect(scenario.plant, testing::effect("thermocouple_lag"));
  scenario.plant.set_in_file_units(testing::parameter("thermocouple_lag.time_constant_s"), 0.5);
  const testing::FittedCore limb(scenario);
  REQUIRE(limb.core.usable);
  CHECK(diagnose::process_noise_after_refit(limb.core, limb.data, limb.settings) > 250.0);
}

}  // namespace diagnose_chance_test

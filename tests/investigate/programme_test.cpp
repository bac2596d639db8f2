// SPDX-License-Identifier: Apache-2.0
#include "investigate/programme.h"

#include <doctest/doctest.h>

#include <map>
#include <set>

#include "investigate/information.h"
#include "plant/systems.h"
#include "sim/plant_file.h"
#include "sim/simulation.h"
#include "tests/diagnose/one_limb.h"

namespace {

using namespace sinew;
using namespace sinew::investigate;

const plant::Plant limb = plant::default_plant();

TEST_CASE("programme: pulses in turn are on the coils one after the other, at the times of the shape") {
  const Programme programme = programme_of({Family::pulses_in_turn, 0, 0.4, 3.0, 7.0, 40.0}, limb.system());
  // By hand: from 2 s on, every 10 s, for 3 s: A at 2, 22; B at 12, 32.
  CHECK(programme.parts.size() == 4);
  CHECK(programme.duty(0, 1.9) == 0.0);
  CHECK(programme.duty(0, 2.0) == 0.4);
  CHECK(programme.duty(0, 4.9) == 0.4);
  CHECK(programme.duty(0, 5.0) == 0.0);
  CHECK(programme.duty(1, 12.5) == 0.4);
  CHECK(programme.duty(0, 22.5) == 0.4);
  CHECK(programme.duty(1, 32.5) == 0.4);
}

TEST_CASE("programme: a sweep rises and falls in a straight line") {
  const Programme programme = programme_of({Family::sweep_in_turn, 1, 0.2, 20.0, 5.0, 60.0}, limb.system());
  CHECK(programme.duty(1, 12.0) == doctest::Approx(0.1));  // half-way up, from 2 to 22 s
  CHECK(programme.duty(1, 32.0) == doctest::Approx(0.1));  // half-way down
  CHECK(programme.duty(0, 12.0) == 0.0);
}

TEST_CASE("programmes: each family drives every coil, and the words name those that are driven") {
  for (const plant::Plant& of : {limb, sim::read_plant_file(std::string(SINEW_SOURCE_DIR) + "/plant/limbs/lab_two_limbs_2023.yaml")}) {
    std::map<Family, std::set<std::size_t>> driven;
    for (const Shape& shape : first_shapes(of.system(), 160.0)) {
      const std::string words = words_of(shape, of.system());
      std::set<std::size_t> by_this;
      for (const Part& part : programme_of(shape, of.system()).parts) by_this.insert(part.input);
      driven[shape.family].insert(by_this.begin(), by_this.end());
      const bool says_all = words.find("both coils") != std::string::npos || words.find("all coils") != std::string::npos;
      CHECK_MESSAGE(says_all == (by_this.size() == of.system().inputs().size() && shape.family != Family::against), words);
      if (says_all) continue;
      for (const std::size_t input : by_this)
        CHECK_MESSAGE(words.find(of.system().inputs()[plant::InputId{input}].part) != std::string::npos, words);
    }
    CHECK(driven.size() == 7);
    for (const auto& [family, inputs] : driven) CHECK_MESSAGE(inputs.size() == of.system().inputs().size(), text_of(family));
  }
}

TEST_CASE("programme: its scenario commands what the programme says, to the tick") {
  for (const Shape& shape : first_shapes(limb.system(), 60.0)) {
    Programme programme = programme_of(shape, limb.system());
    programme.cool_s = 5.0;
    const sim::Scenario scenario = sim::parse_scenario(sim::to_yaml(scenario_of(programme, limb, 3, {"For a test."})), "programme.yaml");
    const sim::Recording rows = rows_of(programme, limb.system());
    const sim::Driver driver_of_scenario(limb.system(), scenario.input, 3, scenario.sample_period_s);
    sim::Driver driver = driver_of_scenario;
    REQUIRE(scenario.ticks() == static_cast<std::int64_t>(rows.samples.size()));
    const sim::Measurement nothing{0, std::vector<double>(limb.system().channels().size(), 0.0)};
    for (const sim::Sample& row : rows.samples) {
      const sim::Command command = driver.command(nothing, row.time_s);
      for (std::size_t i = 0; i < row.inputs.size(); ++i) CHECK(command.inputs[i] == doctest::Approx(row.inputs[i]).epsilon(1e-9));
    }
  }
}

TEST_CASE("programme by chance: one number one shape, others other ones, all within what shapes may be") {
  const Shape one = random_shape(limb.system(), 160.0, 3001, 5), again = random_shape(limb.system(), 160.0, 3001, 5);
  CHECK(one.drive_s == again.drive_s);
  CHECK(one.level_fraction == again.level_fraction);
  std::set<Family> families;
  std::set<std::size_t> coils;
  std::set<double> levels;
  for (std::uint64_t n = 0; n < 200; ++n) {
    const Shape shape = random_shape(limb.system(), 160.0, 3001, n);
    families.insert(shape.family);
    coils.insert(shape.coil);
    levels.insert(shape.level_fraction);
    CHECK(shape.drive_s >= 40.0);
    CHECK(shape.drive_s <= 160.0);
    CHECK(shape.level_fraction >= 0.08);
    CHECK(shape.level_fraction <= 0.6);
    CHECK_FALSE(programme_of(shape, limb.system()).parts.empty());
  }
  CHECK(families.size() == 7);
  CHECK(coils.size() == 2);
  CHECK(levels.size() > 50);
  CHECK(random_shape(limb.system(), 45.0, 1, 0).drive_s <= 45.0);
}

TEST_CASE("information: an answer that is the most probable one again is no distance from it, wherever the room is; another one is") {
  // A room 4 K warmer than the plant believes: where the experiment is believed to begin is not where it rests.
  plant::Plant warm = limb;
  warm.set_in_file_units(limb.system().parameter("ambient_temperature_degC"), 29.0);
  const testing::FittedCore core(testing::babbling(60.0, warm));
  REQUIRE(core.core.usable);
  // With so much latent heat, and all else fitted beside it.
  const auto with_latent_heat = [&](double latent_heat_J) {
    plant::Plant with = diagnose::with_effect(core.core.problem->centres(), testing::effect("latent_heat"));
    with.set_in_file_units(testing::parameter("latent_heat.latent_heat_J"), latent_heat_J);
    with.set_own_deviation(testing::parameter("latent_heat.latent_heat_J"), 0.0);
    return std::make_shared<const diagnose::Explanation>(explain(with, core.data, core.core.as_guess(), core.settings));
  };
  const auto alternative_of = [](std::shared_ptr<const diagnose::Explanation> fitted) {
    Alternative one;
    one.probability = 0.5;
    one.model = fitted->model();
    const auto parameters = static_cast<Eigen::Index>(fitted->problem->parameters().size());
    one.z = fitted->z.head(parameters);
    one.spread = 0.01 * Eigen::MatrixXd::Identity(parameters, parameters);
    one.fitted = std::move(fitted);
    return one;
  };
  const auto expected_against = [&](double latent_heat_J) {
    Question question;
    question.alternatives = {alternative_of(std::make_shared<const diagnose::Explanation>(core.core)),
                             alternative_of(with_latent_heat(latent_heat_J))};
    question.forcing = core.core.forcing;
    question.noise = testing::paper_noise;
    question.numerics = core.settings.numerics;
    question.mass = 1.0;
    return expected_of(question, {Family::pulses_in_turn, 0, 0.3, 3.0, 7.0, 40.0}, 600.0);
  };
  const Expected same = expected_against(0.0), apart = expected_against(10.0);
  REQUIRE(same.possible);
  REQUIRE(apart.possible);
  CHECK(same.separation < 0.1);
  CHECK(same.information_nat < 1e-3);
  CHECK(apart.separation > 10.0);
}

TEST_CASE("device limits: full duty for half a minute passes the on-time, short pulses do not") {
  CHECK_FALSE(within_device_limits(programme_of({Family::pulses_on_one, 0, 0.6, 30.0, 10.0, 60.0}, limb.system()), limb.system()));
  CHECK(within_device_limits(programme_of({Family::pulses_on_one, 0, 0.3, 4.0, 20.0, 60.0}, limb.system()), limb.system()));
  // By hand: 0.6 for 15 s is 9 s of full duty within 20 s, the host allows 8.6 s.
  CHECK_FALSE(within_device_limits(programme_of({Family::pulses_on_one, 0, 0.6, 15.0, 60.0, 40.0}, limb.system()), limb.system()));
}

}  // namespace

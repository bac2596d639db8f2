// SPDX-License-Identifier: Apache-2.0
// Names in a form of their own, and laws without a name, as the search finds them.
#include <doctest/doctest.h>

#include <cmath>

#include "diagnose/search.h"
#include "tests/diagnose/one_limb.h"
#include "tests/long_when_sanitized.h"

namespace diagnose_bent_test {

using namespace sinew;
using namespace sinew::diagnose;

namespace {

using testing::group;
using testing::variable;
plant::Law law_at(std::string_view entry, std::vector<plant::VariableId> argument, std::vector<plant::VariableId> factor = {}) {
  return {.entry = group(entry), .argument = std::move(argument), .factor = std::move(factor), .knots = {}, .curve = {}};
}
bool own(std::string_view name, const plant::Law& law) { return is_own(testing::limb_system(), {testing::effect(name)}, law); }

// 120 s of babbling by a limb with this law, its core a little off, measured by the paper's sensors.
sim::Recording recorded_with(plant::Law law, double first, double last, double (*curve)(double)) {
  constexpr int knots = 41;
  law.curve = Eigen::VectorXd(knots);
  for (int k = 0; k < knots; ++k) {
    law.knots.push_back(first + (last - first) * k / (knots - 1));
    law.curve(k, 0) = curve(law.knots.back());
  }
  sim::Scenario scenario = testing::babbling(120.0);
  scenario.sensors = sim::usual_sensors(scenario.plant.system());
  scenario.plant.set(testing::parameter("heat_loss_A_W_K"), 0.043);
  scenario.plant.set(testing::parameter("beam_stiffness_Nm_rad"), 0.047);
  scenario.plant = plant::with_laws_on(scenario.plant, {std::move(law)});
  return testing::recorded(scenario);
}

Search searched(const sim::Recording& recording, const std::vector<plant::EffectId>& without = {}) {
  SearchSettings settings;
  settings.fit.start = StartPolicy::at_rest;
  settings.without = without;
  return search(plant::default_plant(), testing::data_of(recording, testing::noise_of(recording)), settings);
}

const plant::Law& law_of(const Search& found) { return found.best.system().laws().back(); }

}  // namespace

TEST_CASE("bent: a law is the form of a name where it enters what the name enters, as a function of the same quantity") {
  const plant::VariableId duty_A = variable("duty A"), duty_B = variable("duty B"), temperature_A = variable("temperature A"),
                          temperature_B = variable("temperature B"), bend = variable("angle");
  CHECK(own("duty_deadband", law_at("heat", {duty_A, duty_B})));
  CHECK(own("duty_deadband", law_at("heat", {duty_A, duty_B}, {variable("heat of the current A"), variable("heat of the current B")})));
  CHECK_FALSE(own("duty_deadband", law_at("heat", {temperature_A, temperature_B})));
  CHECK(own("convection_nonlinearity", law_at("heat", {temperature_A, temperature_B})));
  CHECK_FALSE(own("convection_nonlinearity", law_at("heat", {temperature_B, temperature_A})));
  CHECK_FALSE(own("convection_nonlinearity",
                  law_at("heat", {temperature_A, temperature_B}, {variable("heat of the current A"), variable("heat of the current B")})));

  CHECK(own("cross_heating", law_at("heat", {temperature_B, temperature_A})));
  CHECK_FALSE(own("cross_heating", law_at("heat", {temperature_A, temperature_B})));
  CHECK(own("hard_stop", law_at("moment", {bend})));
  CHECK_FALSE(own("hard_stop", law_at("angle_reading", {bend})));
  plant::Law fading = law_at("moment", {bend});
  fading.fading_memory_s = 15.0;
  CHECK(own("viscoelastic_creep", fading));
  CHECK_FALSE(own("hard_stop", fading));
  // What is a function of nothing that is listed, as what changes with time, has no such form.
  CHECK_FALSE(own("ambient_drift", law_at("heat", {temperature_A, temperature_B})));
  CHECK_FALSE(own("stress_shift", law_at("transformation", {temperature_A, temperature_B})));
  CHECK_FALSE(own("stress_shift", law_at("moment", {bend})));
}

TEST_CASE("bent: every argument of the catalogue is a variable of the limb") {
  for (const plant::EffectInfo& effect : testing::limb_system().effects()) {
    std::string_view argument = effect.argument;
    for (const std::string_view prefix : {"memory of ", "other "})
      if (argument.starts_with(prefix)) argument.remove_prefix(prefix.size());
    if (argument.empty()) continue;
    bool is_there = false;
    for (const plant::VariableInfo& v : testing::limb_system().variables())
      is_there = is_there || v.name == argument || v.name == std::string(argument) + " A";
    CHECK_MESSAGE(is_there, effect.name, " is of ", effect.argument);
  }
}

TEST_CASE("bent: the same physics in a form that no effect has is named, with its curve, and nothing is left" * long_when_sanitized) {
  // Of small duties less than their share heats: a dead band that is soft and ends nowhere.
  const sim::Recording recording = recorded_with(law_at("heat", {variable("duty A"), variable("duty B")},
                                                        {variable("heat of the current A"), variable("heat of the current B")}),
                                                 0.0, 1.0, [](double duty) { return -0.5 * std::exp(-duty / 0.15); });
  const Search found = searched(recording);
  REQUIRE(found.bent.size() > 1);
  REQUIRE(found.best.system().laws().size() == 1);
  CHECK(law_of(found).entry == group("heat"));
  CHECK(law_of(found).argument.front() == variable("duty A"));
  CHECK(is_own(found.best.system(), {testing::effect("duty_deadband")}, law_of(found)));
  CHECK(nothing_left(found, {}));
  // Beside a free curve the name has nothing to do.
  CHECK(found.bent.front().names.empty());
}

TEST_CASE("bent: physics without a name has a place and a curve" * long_when_sanitized) {
  // The thermocouples read too much in the middle of their range; the effect that acts there may not be named.
  const sim::Recording recording = recorded_with(law_at("temperature_reading", {variable("temperature A"), variable("temperature B")}),
                                                 20.0, 130.0, [](double degC) { return 5.0 * std::sin(M_PI * (degC - 20.0) / 110.0); });
  const Search found = searched(recording, {testing::effect("thermocouple_heat_sink")});
  REQUIRE(found.best.system().laws().size() >= 1);
  CHECK(found.best.system().laws().front().entry == group("temperature_reading"));
  CHECK(found.best.system().laws().front().argument.front() == variable("temperature A"));
  CHECK(found.bent.front().names.empty());
  CHECK_FALSE(found.rounds.front().accepted);
}

TEST_CASE("bent: where the catalogue's own form does, no law is sought") {
  sim::Scenario scenario = testing::babbling(90.0);
  scenario.sensors = sim::usual_sensors(scenario.plant.system());
  scenario.plant = with_effect(scenario.plant, testing::effect("duty_deadband"));
  scenario.plant.set(testing::parameter("duty_deadband.threshold_fraction"), 0.05);
  const Search found = searched(testing::recorded(scenario));
  CHECK(found.bent.empty());
  CHECK(found.best.system().laws().empty());
}

}  // namespace diagnose_bent_test

// SPDX-License-Identifier: Apache-2.0
#include "diagnose/wander.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>

#include "diagnose/calibrate.h"
#include "tests/diagnose/one_limb.h"
#include "tests/long_when_sanitized.h"

namespace diagnose_wander_test {

using namespace sinew;
using namespace sinew::diagnose;

namespace {

// Air that moves half as much again from 60 s on, or not at all.
sim::Recording recorded_with_wind(double relative_change) {
  sim::Scenario scenario = testing::babbling(120.0);
  scenario.sensors = sim::usual_sensors(scenario.plant.system());  // the paper's
  scenario.plant = with_effect(scenario.plant, testing::effect("airflow_change"));
  scenario.plant.set(testing::parameter("airflow_change.relative_change"), relative_change);
  scenario.plant.set(testing::parameter("airflow_change.onset_s"), 60.0);
  return testing::recorded(scenario);
}

const Wanderer& named(const std::vector<Wanderer>& all, const std::string& words) {
  const auto found = std::find_if(all.begin(), all.end(), [&](const Wanderer& one) {
    return one.effect ? testing::limb_system().effects()[*one.effect].name == words : one.words == words;
  });
  REQUIRE(found != all.end());
  return *found;
}

}  // namespace

TEST_CASE("wander: what has states, a delay or no strength cannot wander; nor what may not be named, or is on") {
  const auto has = [](const std::vector<Wanderer>& all, const char* name) {
    return std::any_of(all.begin(), all.end(), [&](const Wanderer& one) { return one.effect == testing::effect(name); });
  };
  const std::vector<Wanderer> all = wanderers(plant::default_plant(), {testing::effect("supply_sag")});
  CHECK(has(all, "airflow_change"));
  CHECK(has(all, "angle_sensor_drift"));
  CHECK_FALSE(has(all, "thermocouple_lag"));
  CHECK_FALSE(has(all, "input_delay"));
  CHECK_FALSE(has(all, "coil_slack"));
  CHECK_FALSE(has(all, "thermocouple_heat_sink"));  // the sensors' gains are there
  CHECK_FALSE(has(all, "supply_sag"));
  CHECK_FALSE(has(wanderers(with_effect(plant::default_plant(), testing::effect("airflow_change")), {}), "airflow_change"));
}

TEST_CASE("wander: each enters the equations where it acts, and nowhere else") {
  const sim::Recording recording = recorded_with_wind(0.0);
  const FitProblem problem(plant::default_plant(), {}, testing::data_of(recording), StartPolicy::at_rest, {plant::Method::automatic, 1e-6});
  const std::vector<Wanderer> all = wanderers(plant::default_plant(), {});
  const std::size_t k = 400;  // in the middle of it
  const auto at_k = [&](const char* name) {
    VaryingPush push;
    REQUIRE(varying_push(problem, nullptr, {named(all, name), 30.0}, push));
    Eigen::VectorXd both(push.rates[0][k].size() + 3);
    both << push.rates[0][k], push.readings[0][k];
    return both;
  };
  plant::Integrator integrator(plant::default_plant(), problem.start_at(nullptr, 0), problem.numerics());
  for (std::size_t i = 0; i <= k; ++i) {
    REQUIRE_FALSE(integrator.advance_to(recording.samples[i].time_s));
    integrator.hold(recording.samples[i].inputs);
  }
  const auto core = [](const char* key) { return plant::default_plant().get(testing::parameter(key)); };
  const double warmer_K = integrator.state()[0] - core("ambient_temperature_degC");
  REQUIRE(warmer_K > 1.0);

  const Eigen::VectorXd thermocouple = at_k("the thermocouples' gain");
  CHECK(thermocouple.head(6).norm() == 0.0);
  CHECK(thermocouple(6) == doctest::Approx(0.1 * warmer_K));
  CHECK(thermocouple(8) == 0.0);
  // h (1 + 0.25) instead of h.
  const Eigen::VectorXd air = at_k("airflow_change");
  CHECK(air(0) == doctest::Approx(-0.25 * core("heat_loss_A_W_K") * warmer_K / core("heat_capacity_A_J_K")).epsilon(1e-6));
  CHECK(air.tail(3).norm() == 0.0);
  REQUIRE(std::abs(integrator.state()[4]) > 0.01);
  const Eigen::VectorXd beam = at_k("the beam's stiffness");
  CHECK(beam.head(5).norm() == 0.0);
  CHECK(beam(5) == doctest::Approx(-0.1 * core("beam_stiffness_Nm_rad") * integrator.state()[4] / core("beam_inertia_kgm2")).epsilon(1e-6));
}

TEST_CASE("wander: wind that rises is found to be wind, when it rises and by how much" * long_when_sanitized) {
  const sim::Recording recording = recorded_with_wind(0.5);
  const Explanation core = explain(plant::default_plant(), testing::data_of(recording, testing::noise_of(recording)), {}, {});
  REQUIRE(core.usable);
  const std::optional<Wandering> found = what_wanders(core, {.threads = 2}, {});
  REQUIRE(found);
  CHECK(found->of.effect == testing::effect("airflow_change"));
  CHECK(found->explained_share > 0.8);
  // Calibration may take a part of it into the heat loss of all times. Linear about the calibrated path, so within three tenths.
  double before = 0.0, after = 0.0, befores = 0.0, afters = 0.0;
  for (std::size_t b = 0; b < found->time_s.size(); ++b) {
    if (found->time_s[b] > 10.0 && found->time_s[b] < 55.0) before += found->value[b], befores += 1.0;
    if (found->time_s[b] > 65.0) after += found->value[b], afters += 1.0;
  }
  CHECK(std::abs(after / afters - before / befores - 0.5) < 0.15);
}

TEST_CASE("wander: nothing stands out where nothing is missing" * long_when_sanitized) {
  const sim::Recording recording = recorded_with_wind(0.0);
  const Explanation core = explain(plant::default_plant(), testing::data_of(recording, testing::noise_of(recording)), {}, {});
  REQUIRE(core.usable);
  for (const bool temperatures : {true, false}) CHECK_FALSE(what_wanders(core, {.upstream_is_off = temperatures, .threads = 2}, {}));
}

}  // namespace diagnose_wander_test

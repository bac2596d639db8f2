// SPDX-License-Identifier: Apache-2.0
#include "diagnose/calibrate.h"

#include <doctest/doctest.h>

#include <limits>

#include "diagnose/compare.h"
#include "tests/diagnose/one_limb.h"
#include "tests/long_when_sanitized.h"

namespace diagnose_calibrate_test {

using namespace sinew;

namespace {

plant::ParameterId index(const char* key) { return testing::parameter(key); }

const diagnose::Estimate& estimate(const diagnose::Calibration& calibration, const std::string& name) {
  for (const auto& e : calibration.estimates)
    if (e.unknown.name == name) return e;
  FAIL("no estimate of " << name);
  return calibration.estimates.front();
}

// A limb off the nominal one, recorded with the paper's sensors.
sim::Scenario other_limb(double duration_s) {
  sim::Scenario scenario = testing::babbling(duration_s);
  scenario.sensors = sim::usual_sensors(scenario.plant.system());
  scenario.plant.set(index("heat_loss_A_W_K"), 0.043);
  scenario.plant.set(index("heat_capacity_B_J_K"), 0.80);
  scenario.plant.set(index("ambient_temperature_degC"), 27.0);
  scenario.plant.set(index("heating_midpoint_degC"), 78.0);
  scenario.plant.set(index("beam_stiffness_Nm_rad"), 0.054);
  return scenario;
}
const std::vector<plant::ParameterId> changed{index("heat_loss_A_W_K"), index("heat_capacity_B_J_K"), index("ambient_temperature_degC"),
                                              index("heating_midpoint_degC"), index("beam_stiffness_Nm_rad")};

}  // namespace

TEST_CASE("calibrate: finds the parameters of another limb within its own standard errors, and what is left is noise") {
  const sim::Scenario truth = other_limb(120.0);
  const sim::Recording recording = testing::recorded(truth);
  const auto noise = testing::noise_of(recording);
  diagnose::CalibrationSettings settings;
  settings.parameters = changed;
  settings.starts = 2;
  const auto result = diagnose::calibrate(plant::default_plant(), testing::data_of(recording, noise), settings);
  CHECK(result.several_starts_agree);
  CHECK(result.flipped_signs.empty());
  for (const plant::ParameterId p : changed) {
    const auto& e = estimate(result, testing::limb_system().parameters()[p].key());
    INFO(e.unknown.name << " = " << e.value << " +- " << e.standard_error << ", true " << truth.plant.get(p));
    CHECK(e.told());
    CHECK(std::abs(e.value - truth.plant.get(p)) < 4.0 * e.standard_error);
    CHECK(e.standard_error < 0.1 * e.unknown.deviation);
  }
  const auto comparison = diagnose::compare(result.fitted, result.starts_of_recordings[0], recording, noise,
                                            std::numeric_limits<double>::infinity(), {plant::Method::cvode, 1e-8});
  for (const plant::ChannelId c : testing::limb_system().channels().ids()) CHECK(comparison.fitted[c].rmse < 1.1 * noise[c]);
}

TEST_CASE("calibrate: a recording that begins in mid-motion is fitted with its first values") {
  const sim::Recording whole = testing::recorded(other_limb(120.0));
  sim::Recording late = whole;
  late.samples.erase(late.samples.begin(), late.samples.begin() + 500);
  const auto noise = testing::noise_of(late);
  diagnose::CalibrationSettings settings;
  settings.parameters = changed;
  settings.starts = 1;
  const auto result = diagnose::calibrate(plant::default_plant(), testing::data_of(late, noise), settings);
  const auto comparison = diagnose::compare(result.fitted, result.starts_of_recordings[0], late, noise,
                                            std::numeric_limits<double>::infinity(), {plant::Method::cvode, 1e-8});
  for (const plant::ChannelId c : testing::limb_system().channels().ids()) CHECK(comparison.fitted[c].rmse < 1.15 * noise[c]);
}

TEST_CASE("calibrate: the room has warmed on until the second recording begins" * long_when_sanitized) {
  plant::Plant limb = plant::default_plant();
  const plant::ParameterId rate = testing::parameter("ambient_drift.rate_K_s");
  limb.set_in_file_units(rate, 0.02);
  limb.turn_on_by_strength();
  sim::Scenario first = testing::babbling(60.0, limb);
  first.sensors = sim::usual_sensors(limb.system());
  sim::Scenario second = first;
  second.seed = first.seed + 1;
  second.start.assign(limb.states().size(), std::nullopt);
  for (const plant::StateId i : limb.states().ids())
    if (limb.states()[i].key == "ambient_drift.elapsed_s") second.start[i.index] = 200.0;
  const sim::Recording one = testing::recorded(first), other = testing::recorded(second);
  const auto noise = testing::noise_of(one);
  diagnose::CalibrationSettings settings;
  settings.parameters = {rate, testing::parameter("ambient_temperature_degC")};
  settings.starts = 1;
  const auto result = diagnose::calibrate(limb, {{&one, one.samples.size(), noise}, {&other, other.samples.size(), noise}}, settings);
  const auto& found = estimate(result, "ambient_drift.rate_K_s");
  CHECK(std::abs(found.value - 0.02) < 4.0 * found.standard_error);
  CHECK(found.standard_error < 0.002);
  const auto& elapsed = estimate(result, "start[1].ambient_drift.elapsed_s");
  CHECK(std::abs(elapsed.value - 200.0) < 4.0 * elapsed.standard_error);
  CHECK(elapsed.standard_error < 40.0);
  CHECK_FALSE(result.starts_of_recordings[0].given[limb.states().size() - 1].has_value());
}

TEST_CASE("calibrate: parameters that only appear as a product cannot be told, and name each other" * long_when_sanitized) {
  const sim::Recording recording = testing::recorded(other_limb(60.0));
  diagnose::CalibrationSettings settings;
  // V^2/(R C), h/C: resistance, heat capacity and heat loss have one direction that no temperature shows.
  settings.parameters = {index("resistance_A_Ohm"), index("heat_capacity_A_J_K"), index("heat_loss_A_W_K")};
  settings.starts = 1;
  const auto result = diagnose::calibrate(plant::default_plant(), testing::data_of(recording, testing::noise_of(recording)), settings);
  const auto& resistance = estimate(result, "resistance_A_Ohm");
  CHECK_FALSE(resistance.told());
  CHECK(std::abs(resistance.partner_correlation) > 0.99);
  CHECK((resistance.partner == "heat_capacity_A_J_K" || resistance.partner == "heat_loss_A_W_K"));
}

TEST_CASE("calibrate: a limb wired the other way is noticed") {
  sim::Scenario truth = other_limb(40.0);
  truth.plant.set(index("bend_sign"), -1.0);
  std::get<sim::BabbleInput>(truth.input).positive_drives = "B";
  const sim::Recording recording = testing::recorded(truth);
  diagnose::CalibrationSettings settings;
  settings.parameters = changed;
  settings.starts = 1;
  const auto result = diagnose::calibrate(plant::default_plant(), testing::data_of(recording, testing::noise_of(recording)), settings);
  CHECK(result.flipped_signs == std::vector<plant::ParameterId>{index("bend_sign")});
  CHECK(result.fitted.get(index("bend_sign")) == -1.0);
}

TEST_CASE("calibrate: standard errors grow where physics is missing" * long_when_sanitized) {
  sim::Scenario truth = other_limb(120.0);
  const sim::Recording right = testing::recorded(truth);
  truth.plant.set(index("viscoelastic_creep.stiffness_Nm_rad"), 0.02);
  truth.plant.set(index("viscoelastic_creep.time_constant_s"), 15.0);
  truth.plant.turn_on_by_strength();
  const sim::Recording creeping = testing::recorded(truth);
  diagnose::CalibrationSettings settings;
  settings.parameters = changed;
  settings.starts = 1;
  const auto error = [&](const sim::Recording& recording) {
    const auto result = diagnose::calibrate(plant::default_plant(), testing::data_of(recording, testing::noise_of(recording)), settings);
    return estimate(result, "beam_stiffness_Nm_rad").standard_error;
  };
  CHECK(error(creeping) > 10.0 * error(right));
}

TEST_CASE("calibrate: the same result to the last bit whatever the number of threads" * long_when_sanitized) {
  const sim::Recording recording = testing::recorded(other_limb(20.0));
  diagnose::CalibrationSettings settings;
  settings.parameters = changed;
  settings.starts = 3;
  const auto values = [&](int threads) {
    settings.threads = threads;
    const auto result = diagnose::calibrate(plant::default_plant(), testing::data_of(recording, testing::noise_of(recording)), settings);
    std::vector<double> all;
    for (const auto& e : result.estimates) all.insert(all.end(), {e.value, e.standard_error});
    return all;
  };
  const auto one = values(1);
  CHECK(one == values(2));
  CHECK(one == values(3));
}

TEST_CASE("calibrate: stops when asked to, with an exception") {
  const sim::Recording recording = testing::recorded(other_limb(10.0));
  diagnose::CalibrationSettings settings;
  settings.should_stop = [] { return true; };
  CHECK_THROWS_AS(diagnose::calibrate(plant::default_plant(), testing::data_of(recording), settings), diagnose::Stopped);
}

}  // namespace diagnose_calibrate_test

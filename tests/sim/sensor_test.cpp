// SPDX-License-Identifier: Apache-2.0
#include "sim/sensor.h"

#include <doctest/doctest.h>

#include <cmath>
#include <cstdint>
#include <limits>
#include <string>
#include <vector>

#include "plant/limb/limb.h"
#include "sim/recording.h"
#include "sim/simulation.h"

namespace sim_sensor_test {

using namespace sinew::sim;

namespace {

// The two-coil limb's coils, inputs and thermocouples, and the channel of its angle.
constexpr std::size_t A = 0, B = 1, angle = 2;
const Columns columns = columns_of(*sinew::plant::two_coil_limb());

constexpr std::size_t samples = 50000;
const double one_deviation = 1.0 / std::sqrt(static_cast<double>(samples));

// What a sensor reports of something that does not change, at 10 Hz.
std::vector<double> reports_of(const SensorSettings& settings, double shown, std::uint64_t seed = 1) {
  Sensor sensor(settings, seed, "angle");
  std::vector<double> reports;
  for (std::size_t k = 0; k < samples; ++k)
    reports.push_back(sensor.report(shown, static_cast<std::int64_t>(k), static_cast<double>(k) / 10.0));
  return reports;
}

double one_report(const SensorSettings& settings, double shown) { return Sensor(settings, 1, "angle").report(shown, 0, 0.0); }

bool same(double a, double b) { return a == b || (std::isnan(a) && std::isnan(b)); }

}  // namespace

TEST_CASE("sensor: without noise, steps and bias it reports what there is") {
  CHECK(one_report({}, 21.3456789) == 21.3456789);
  CHECK(one_report({}, -3.25) == -3.25);
}

TEST_CASE("sensor: reports are whole steps, the nearest one") {
  const SensorSettings thermocouple{.step = 0.25};
  CHECK(one_report(thermocouple, 25.12) == 25.0);
  CHECK(one_report(thermocouple, 25.13) == 25.25);
  CHECK(one_report(thermocouple, -0.13) == -0.25);
  // The bend sensor's steps are 1/32 deg: 10.02 * 32 = 320.64, so 321/32 = 10.03125.
  CHECK(one_report({.step = 0.03125}, 10.02) == 10.03125);
}

TEST_CASE("sensor: halves are rounded away from zero, and zero has no sign") {
  const SensorSettings thermocouple{.step = 0.25};
  CHECK(one_report(thermocouple, 25.125) == 25.25);
  CHECK(one_report(thermocouple, -25.125) == -25.25);
  CHECK_FALSE(std::signbit(one_report(thermocouple, -0.1)));
}

TEST_CASE("sensor: bias is added before the steps") {
  CHECK(one_report({.bias = 1.5}, 20.0) == 21.5);
  CHECK(one_report({.bias = -0.125}, 20.0) == 19.875);
  // 20.1 + 0.1 = 20.2, to the nearest quarter 20.25; after the steps it would be 20 + 0.1.
  CHECK(one_report({.step = 0.25, .bias = 0.1}, 20.1) == 20.25);
}

TEST_CASE("sensor: noise has its standard deviation and no mean") {
  const std::vector<double> reports = reports_of({.noise = 0.1}, 25.0);
  double sum = 0.0, squares = 0.0;
  for (const double r : reports) sum += r - 25.0, squares += (r - 25.0) * (r - 25.0);
  const double mean = sum / samples, deviation = std::sqrt(squares / samples);
  // Four deviations of the mean and of the standard deviation of so many samples.
  CHECK(std::abs(mean) < 4.0 * 0.1 * one_deviation);
  CHECK(std::abs(deviation - 0.1) < 4.0 * 0.1 * std::sqrt(0.5) * one_deviation);
}

TEST_CASE("sensor: twice the noise is twice the same deviations") {
  const std::vector<double> once = reports_of({.noise = 0.125}, 0.0), twice = reports_of({.noise = 0.25}, 0.0);
  bool all = true;
  for (std::size_t k = 0; k < samples; ++k) all = all && twice[k] == 2.0 * once[k];
  CHECK(all);
}

TEST_CASE("sensor: a sensor that is stuck reports what it reported last, then what there is") {
  Sensor sensor({.stuck = Stuck{0.2, 0.5}}, 1, "angle");
  CHECK(sensor.report(10.0, 0, 0.0) == 10.0);
  CHECK(sensor.report(11.0, 1, 0.1) == 11.0);
  CHECK(sensor.report(12.0, 2, 0.2) == 11.0);
  CHECK(sensor.report(13.0, 3, 0.3) == 11.0);
  CHECK(sensor.report(14.0, 4, 0.4) == 11.0);
  CHECK(sensor.report(15.0, 5, 0.5) == 15.0);
}

TEST_CASE("sensor: a stuck sensor repeats its report with noise and steps") {
  const SensorSettings free{.noise = 0.1, .step = 0.25};
  SensorSettings stuck = free;
  stuck.stuck = Stuck{0.3, 1e6};
  const std::vector<double> without = reports_of(free, 25.0), with = reports_of(stuck, 25.0);
  CHECK(with[2] == without[2]);
  bool all = true;
  for (std::size_t k = 3; k < samples; ++k) all = all && with[k] == without[2];
  CHECK(all);
}

TEST_CASE("sensor: stuck from the beginning, it repeats its first report") {
  Sensor sensor({.stuck = Stuck{0.0, 0.25}}, 1, "angle");
  CHECK(sensor.report(10.0, 0, 0.0) == 10.0);
  CHECK(sensor.report(11.0, 1, 0.1) == 10.0);
  CHECK(sensor.report(12.0, 2, 0.2) == 10.0);
  CHECK(sensor.report(13.0, 3, 0.3) == 13.0);
}

TEST_CASE("sensor: what it reported last is its only state") {
  const SensorSettings settings{.noise = 0.1, .step = 0.25, .dropout_fraction = 0.3, .stuck = Stuck{0.5, 1.0}};
  Sensor whole(settings, 3, "angle"), first(settings, 3, "angle"), second(settings, 3, "angle");
  for (std::int64_t k = 0; k < 20; ++k) {
    const double time_s = static_cast<double>(k) / 10.0, shown = 20.0 + static_cast<double>(k);
    if (k == 7) second.set_last(first.last());
    const double expected = whole.report(shown, k, time_s);
    CHECK(same((k < 7 ? first : second).report(shown, k, time_s), expected));
  }
}

TEST_CASE("sensor: the share of samples that are missing is what was asked for") {
  for (const double fraction : {0.002, 0.1, 0.5}) {
    double missing = 0.0;
    for (const double r : reports_of({.noise = 0.1, .dropout_fraction = fraction}, 25.0)) missing += std::isnan(r);
    CAPTURE(fraction);
    CHECK(std::abs(missing / samples - fraction) < 4.0 * std::sqrt(fraction * (1.0 - fraction)) * one_deviation);
  }
  bool none = false, all = true;
  for (const double r : reports_of({.dropout_fraction = 0.0}, 25.0)) none = none || std::isnan(r);
  for (const double r : reports_of({.dropout_fraction = 1.0}, 25.0)) all = all && std::isnan(r);
  CHECK_FALSE(none);
  CHECK(all);
}

TEST_CASE("sensor: a missing sample does not move the noise of the others") {
  const std::vector<double> all = reports_of({.noise = 0.1, .step = 0.25}, 25.0),
                            some = reports_of({.noise = 0.1, .step = 0.25, .dropout_fraction = 0.2}, 25.0);
  bool equal = true;
  for (std::size_t k = 0; k < samples; ++k) equal = equal && (std::isnan(some[k]) || some[k] == all[k]);
  CHECK(equal);
}

TEST_CASE("sensor: more dropout takes the same samples and further ones") {
  const std::vector<double> few = reports_of({.dropout_fraction = 0.1}, 25.0), many = reports_of({.dropout_fraction = 0.3}, 25.0);
  bool nested = true;
  for (std::size_t k = 0; k < samples; ++k) nested = nested && (!std::isnan(few[k]) || std::isnan(many[k]));
  CHECK(nested);
}

TEST_CASE("sensor: another seed is another noise") {
  CHECK(reports_of({.noise = 0.1}, 25.0, 1)[0] != reports_of({.noise = 0.1}, 25.0, 2)[0]);
}

TEST_CASE("sensor: dropout, bias, noise or a fault of one channel leaves the others bit for bit as they were") {
  Scenario scenario;
  scenario.duration_s = 12.0;
  OpenLoopInput input{.signals = {{}, {}}};
  input.signals[A].push_back(StepSignal{0.5, 1.0, 6.0});
  input.signals[B].push_back(StepSignal{0.3, 4.0, 9.0});
  scenario.input = input;
  const auto samples_of = [](const Scenario& s) { return parse_recording(run(s).recording_csv, "run", columns).samples; };
  const std::vector<Sample> before = samples_of(scenario);
  const auto change = [](SensorSettings& settings) {
    settings.dropout_fraction = 0.3;
    settings.noise *= 3.0;
    settings.bias = 1.0;
    settings.stuck = Stuck{5.0, 7.0};
  };
  for (std::size_t changed = 0; changed < 3; ++changed) {
    Scenario other = scenario;
    change(other.sensors[changed]);
    const std::vector<Sample> after = samples_of(other);
    REQUIRE(after.size() == before.size());
    CAPTURE(changed);
    std::size_t differences = 0;
    for (std::size_t k = 0; k < before.size(); ++k) {
      CHECK(after[k].inputs == before[k].inputs);
      if (changed != 0) CHECK(after[k].channels[A] == before[k].channels[A]);
      if (changed != 1) CHECK(after[k].channels[B] == before[k].channels[B]);
      if (changed != 2) CHECK(after[k].channels[angle] == before[k].channels[angle]);
      const double here = after[k].channels[changed];
      const double there = before[k].channels[changed];
      differences += !same(here, there);
    }
    CHECK(differences > before.size() / 2);
  }
}

}  // namespace sim_sensor_test

// SPDX-License-Identifier: Apache-2.0
#include "diagnose/channels.h"

#include <doctest/doctest.h>

#include "sim/random.h"
#include "tests/diagnose/one_limb.h"

namespace diagnose_channels_test {

using namespace sinew;

TEST_CASE("noise: white noise on a slow signal is found from second differences") {
  sim::Recording recording;
  const sim::RandomStream a(1, "a"), c(1, "c");
  for (std::uint64_t k = 0; k < 6000; ++k) {
    const double t = 0.1 * static_cast<double>(k);
    recording.samples.push_back(
        {t, {0.0, 0.0}, {60.0 + 20.0 * std::sin(t / 20.0) + 0.1 * a.normal(k), 25.0, 30.0 * std::sin(t / 5.0) + 0.05 * c.normal(k)}});
  }
  const auto noise = testing::noise_of(recording);
  // The standard deviation of an estimate from 6000 samples is about 1.5 %; cutting at 4 sigma takes 0.1 %.
  CHECK(noise[testing::temperature_A] == doctest::Approx(0.1).epsilon(0.05));
  CHECK(noise[testing::angle] == doctest::Approx(0.05).epsilon(0.05));
}

TEST_CASE("noise: is the same where each reading has a row of its own, between rows that have none") {
  sim::Recording together, apart;
  const sim::RandomStream a(1, "a"), c(1, "c");
  const double none = std::nan("");
  for (std::uint64_t k = 0; k < 2000; ++k) {
    const double t = 0.1 * static_cast<double>(k), first = 60.0 + 20.0 * std::sin(t / 20.0) + 0.3 * a.normal(k),
                 third = 30.0 * std::sin(t / 5.0) + 0.2 * c.normal(k);
    together.samples.push_back({t, {0.0, 0.0}, {first, 25.0, third}});
    apart.samples.push_back({t, {0.0, 0.0}, {none, none, none}});
    apart.samples.push_back({t + 0.02, {0.0, 0.0}, {first, 25.0, none}});
    apart.samples.push_back({t + 0.05, {0.0, 0.0}, {none, none, third}});
  }
  const auto as_one = testing::noise_of(together), of_each = testing::noise_of(apart);
  CHECK(of_each[testing::temperature_A] == as_one[testing::temperature_A]);
  CHECK(of_each[testing::angle] == as_one[testing::angle]);
  CHECK(as_one[testing::angle] == doctest::Approx(0.2).epsilon(0.06));
  const diagnose::MeasuredRows rows = diagnose::measured_rows(apart, testing::angle);
  CHECK(rows.rows.size() == 2000);
  CHECK(rows.rows[1] == 5);
  CHECK(rows.period_s == doctest::Approx(0.1).epsilon(1e-9));
  CHECK(std::isnan(diagnose::measured_rows({}, testing::angle).period_s));
}

TEST_CASE("noise: a quantised sensor without noise has that of its steps") {
  sim::Recording recording;
  for (int k = 0; k < 2000; ++k) {
    const double t = 0.1 * k;
    recording.samples.push_back({t, {0.0, 0.0}, {std::round((40.0 + 0.05 * t) / 0.25) * 0.25, 25.0, 0.0}});
  }
  // 0.25 / sqrt(12) = 0.0722
  CHECK(testing::noise_of(recording)[testing::temperature_A] == doctest::Approx(0.0722).epsilon(0.02));
}

TEST_CASE("noise: a channel that never moves has the noise of the paper's sensor, not none") {
  sim::Recording recording;
  for (int k = 0; k < 100; ++k) recording.samples.push_back({0.1 * k, {0.0, 0.0}, {25.0, 25.0, 3.0}});
  const auto noise = testing::noise_of(recording);
  // White noise of 0.1 K and steps of 0.25 K: hypot(0.1, 0.25 / sqrt(12)); of 0.05 and 1/32 degrees.
  CHECK(noise[testing::temperature_A] == doctest::Approx(0.12332).epsilon(1e-4));
  CHECK(noise[testing::angle] == doctest::Approx(0.050807).epsilon(1e-4));
}

TEST_CASE("correlation length: white residuals have 1, a first-order process has (1 + a)/(1 - a)") {
  const sim::RandomStream chance(3, "residual");
  std::vector<double> white, slow;
  double state = 0.0;
  for (std::uint64_t k = 0; k < 50000; ++k) {
    white.push_back(chance.normal(k));
    state = 0.8 * state + chance.normal(k);
    slow.push_back(state);
  }
  CHECK(diagnose::correlation_samples(white) == doctest::Approx(1.0).epsilon(0.02));
  // (1 + 0.8)/(1 - 0.8) = 9; the sum ends where the correlation falls below 0.05, which leaves out 2 * 0.05 / 0.2 = 0.4.
  CHECK(diagnose::correlation_samples(slow) == doctest::Approx(8.6).epsilon(0.08));
}

}  // namespace diagnose_channels_test

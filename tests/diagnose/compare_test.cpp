// SPDX-License-Identifier: Apache-2.0
#include "diagnose/compare.h"

#include <doctest/doctest.h>

#include "tests/diagnose/one_limb.h"

namespace diagnose_compare_test {

using namespace sinew;

TEST_CASE("compare: a limb against its own recording is off by the integrator's tolerance alone") {
  const sim::Scenario scenario = testing::babbling(30.0);
  const sim::Recording recording = testing::recorded(scenario);
  const auto comparison = diagnose::compare(scenario.plant, {}, recording, testing::paper_noise, 20.0, {plant::Method::arkode, 1e-9});
  // 200 samples before 20 s, 101 from there on.
  CHECK(comparison.fitted[testing::temperature_A].samples == 200);
  CHECK(comparison.unfitted[testing::temperature_A].samples == 101);
  for (const plant::ChannelId c : testing::limb_system().channels().ids()) {
    CHECK(comparison.fitted[c].rmse < 1e-3);
    CHECK(comparison.unfitted[c].rmse < 1e-3);
    CHECK(comparison.fitted[c].more_than_noise == 0.0);
  }
}

TEST_CASE("compare: a constant offset is bias, RMSE and largest error, and is shared evenly over time") {
  const sim::Scenario scenario = testing::babbling(30.0);
  sim::Recording recording = testing::recorded(scenario);
  for (auto& sample : recording.samples) sample.channels[2] -= 2.0;
  const auto comparison =
      diagnose::compare(scenario.plant, {}, recording, diagnose::PerChannel({0.12, 0.12, 0.5}), 1e9, {plant::Method::arkode, 1e-9});
  const auto& angle = comparison.fitted[testing::angle];
  CHECK(angle.bias == doctest::Approx(2.0).epsilon(1e-3));
  CHECK(angle.rmse == doctest::Approx(2.0).epsilon(1e-3));
  CHECK(angle.largest == doctest::Approx(2.0).epsilon(1e-2));
  // 1 - 0.5^2 / 2^2 = 0.9375
  CHECK(angle.more_than_noise == doctest::Approx(0.9375).epsilon(1e-3));
  // Half of the error needs about half of the seven windows (the last one holds a single sample).
  CHECK(comparison.worst[testing::angle].share_of_time >= 3.0 / 7.0);
  CHECK(comparison.unfitted[testing::angle].samples == 0);
}

TEST_CASE("compare: after a pause each part goes on from its own start, and the errors are those of all parts") {
  const sim::Scenario scenario = testing::babbling(30.0);
  sim::Recording recording = testing::recorded(scenario), first = recording, second = recording;
  for (auto& sample : second.samples) sample.time_s += 100.0;  // the same again, from rest, after a pause
  const std::vector<sim::Recording> parts{first, second};
  const std::vector<plant::Start> starts(2);
  const auto comparison = diagnose::compare(scenario.plant, starts, parts, testing::paper_noise, 110.0, {plant::Method::arkode, 1e-9});
  CHECK(comparison.time_s.size() == 602);
  CHECK(comparison.time_s[301] == 100.0);
  CHECK(comparison.fitted[testing::angle].samples == 301 + 100);
  for (const plant::ChannelId c : testing::limb_system().channels().ids()) {
    CHECK(comparison.fitted[c].rmse < 1e-3);
    CHECK(comparison.unfitted[c].rmse < 1e-3);
  }
}

TEST_CASE("compare: an error that happens in one window is found there") {
  const sim::Scenario scenario = testing::babbling(50.0);
  sim::Recording recording = testing::recorded(scenario);
  for (std::size_t k = 210; k < 240; ++k) recording.samples[k].channels[2] += 5.0;  // 21 s to 24 s
  const auto comparison = diagnose::compare(scenario.plant, {}, recording, testing::paper_noise, 1e9, {plant::Method::arkode, 1e-9});
  REQUIRE(comparison.worst[testing::angle].windows_s.size() == 1);
  CHECK(comparison.worst[testing::angle].windows_s[0].first == 20.0);
  CHECK(comparison.worst[testing::angle].windows_s[0].second == 25.0);
  CHECK(comparison.worst[testing::angle].share_of_error > 0.99);
}

}  // namespace diagnose_compare_test

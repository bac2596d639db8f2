// SPDX-License-Identifier: Apache-2.0
#include "hil/timed_recording.h"

#include <doctest/doctest.h>

#include <array>
#include <cmath>
#include <limits>

#include "plant/systems.h"

namespace hil_timed_recording_test {

using namespace sinew;

namespace {

constexpr double none = std::numeric_limits<double>::quiet_NaN();

hil::SessionView view_at(double time_s, double duty, double temperature_degC, double temperature_age_s, double angle_deg,
                         double angle_age_s) {
  hil::SessionView view;
  view.time_s = time_s;
  view.duty_fraction = {duty, 0.0};
  view.measured.channels = {temperature_degC, temperature_degC + 1.0, angle_deg};
  view.temperature_age_s = temperature_age_s;
  view.angle_age_s = angle_age_s;
  return view;
}

bool same(double a, double b) { return std::isnan(a) ? std::isnan(b) : a == doctest::Approx(b).epsilon(1e-12); }

void check_row(const sim::Sample& row, double time_s, double duty, std::array<double, 3> channels) {
  CHECK(row.time_s == doctest::Approx(time_s).epsilon(1e-12));
  CHECK(row.inputs == std::vector<double>{duty, 0.0});
  for (std::size_t c = 0; c < 3; ++c) CHECK(same(row.channels[c], channels[c]));
}

}  // namespace

TEST_CASE("timed recording: each reading stands at its time, with the duty of then, and is there once") {
  hil::TimedRecording timed(plant::default_plant());
  timed.add(view_at(0.0, 0.5, 25.0, 0.04, 1.0, 0.01));  // made before the first tick
  timed.add(view_at(0.1, 0.25, 26.0, 0.03, 2.0, 0.01));
  timed.add(view_at(0.2, 0.0, 26.0, 0.13, 3.0, 0.0));  // the same temperatures; the angle at the tick itself
  timed.add(view_at(0.3, 0.0, 27.0, 0.02, none, 0.0));
  const sim::Recording recording = timed.recording();
  REQUIRE(recording.samples.size() == 7);
  check_row(recording.samples[0], 0.0, 0.5, {none, none, none});
  check_row(recording.samples[1], 0.07, 0.5, {26.0, 27.0, none});
  check_row(recording.samples[2], 0.09, 0.5, {none, none, 2.0});
  check_row(recording.samples[3], 0.1, 0.25, {none, none, none});
  check_row(recording.samples[4], 0.2, 0.0, {none, none, 3.0});
  check_row(recording.samples[5], 0.28, 0.0, {27.0, 28.0, none});
  check_row(recording.samples[6], 0.3, 0.0, {none, none, none});
}

TEST_CASE("timed recording: without a tick there is nothing") {
  CHECK(hil::TimedRecording(plant::default_plant()).recording().samples.empty());
}

}  // namespace hil_timed_recording_test

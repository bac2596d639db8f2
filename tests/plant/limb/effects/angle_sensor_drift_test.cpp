// SPDX-License-Identifier: Apache-2.0
#include "plant/limb/effects/angle_sensor_drift.h"

#include <numbers>

#include "plant/integrator.h"
#include "tests/plant/limb/one_instant.h"

namespace plant_limb_effects_angle_sensor_drift_test {

using namespace sinew::plant;
using namespace sinew::test;

namespace {

double shown_rad(double rate_deg_s, double time_s) {
  const auto limb = limb_with("angle_sensor_drift", {{"rate_deg_s", rate_deg_s}});
  Integrator run(limb, Start{}, {.relative_tolerance = 1e-9});
  REQUIRE_FALSE(run.advance_to(time_s));
  return at_one_instant(limb, {.time_s = time_s}, {25.0, 25.0, 1.0, 1.0, 0.2, 0.0, run.state()[6]}).reading[angle];
}

}  // namespace

TEST_CASE("angle sensor drift: at 0.005 deg/s the reading is a degree high after 200 s") {
  CHECK(shown_rad(0.005, 200.0) == doctest::Approx(0.2 + std::numbers::pi / 180.0).epsilon(1e-12));
  CHECK(shown_rad(-0.01, 100.0) == doctest::Approx(0.2 - std::numbers::pi / 180.0).epsilon(1e-12));
  CHECK(shown_rad(0.005, 0.0) == 0.2);
}

TEST_CASE("angle sensor drift: it also drifts away from what a late sensor shows, and the limb stays where it is") {
  Plant limb = limb_with("angle_sensor_drift", {{"rate_deg_s", 0.01}});
  turn_on(limb, "angle_sensor_lag", {{"time_constant_s", 0.4}});
  const auto at = at_one_instant(limb, {.time_s = 100.0}, {25.0, 25.0, 1.0, 1.0, 0.5, 0.0, 0.3, 100.0});
  CHECK(at.reading[angle] == by_hand(0.3 + std::numbers::pi / 180.0));
  CHECK(at.now.angle_rad[0] == 0.5);
}

}  // namespace plant_limb_effects_angle_sensor_drift_test

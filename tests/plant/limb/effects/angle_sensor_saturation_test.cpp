// SPDX-License-Identifier: Apache-2.0
#include "plant/limb/effects/angle_sensor_saturation.h"

#include <numbers>

#include "tests/plant/limb/one_instant.h"

namespace plant_limb_effects_angle_sensor_saturation_test {

using namespace sinew::plant;
using namespace sinew::test;

namespace {

double shown_rad(double saturation_1_rad2, double angle_rad) {
  const auto limb = limb_with("angle_sensor_saturation", {{"saturation_1_rad2", saturation_1_rad2}});
  return at_one_instant(limb, {}, {25.0, 25.0, 1.0, 1.0, angle_rad, 0.0}).reading[angle];
}

}  // namespace

TEST_CASE("angle sensor saturation: a large bend is shown smaller, alike to both sides, and never beyond the limit") {
  CHECK(shown_rad(3.0, 1.0) == by_hand(0.5));  // by hand: 1 / sqrt(1 + 3)
  CHECK(shown_rad(3.0, -1.0) == by_hand(-0.5));
  CHECK(shown_rad(0.5625, 1.0) == by_hand(0.8));  // by hand: 1 / sqrt(1.5625) = 1 / 1.25
  CHECK(shown_rad(0.0, 1.0) == 1.0);
  CHECK(shown_rad(3.0, 0.0) == 0.0);
  CHECK(shown_rad(4.0, 1000.0) == doctest::Approx(0.5).epsilon(1e-6));
}

TEST_CASE("angle sensor saturation: of what a late sensor shows, before its zero drifts; and the limb stays where it is") {
  Plant limb = limb_with("angle_sensor_saturation", {{"saturation_1_rad2", 3.0}});
  turn_on(limb, "angle_sensor_lag", {{"time_constant_s", 0.4}});
  turn_on(limb, "angle_sensor_drift", {{"rate_deg_s", 0.01}});
  const auto at = at_one_instant(limb, {.time_s = 100.0}, {25.0, 25.0, 1.0, 1.0, 0.3, 0.0, 1.0, 100.0});
  CHECK(at.reading[angle] == by_hand(0.5 + std::numbers::pi / 180.0));
  CHECK(at.now.angle_rad[0] == 0.3);
}

}  // namespace plant_limb_effects_angle_sensor_saturation_test

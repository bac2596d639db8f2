// SPDX-License-Identifier: Apache-2.0
#include "plant/limb/effects/stress_shift_curved.h"

#include "tests/plant/limb/one_instant.h"

namespace plant_limb_effects_stress_shift_curved_test {

using namespace sinew::plant;
using namespace sinew::test;

namespace {

Plant curved(double slack, double taut) {
  return limb_with("stress_shift_curved", {{"shift_K_N", 0.8}, {"slope_slack", slack}, {"slope_taut", taut}});
}
// Of coil A, cold and hot, the limb straight. Tensions: 113 N/m * 2 mm = 0.226 N, 313 N/m * 30 mm = 9.39 N.
double cold_rise_K(const Plant& limb) {
  return at_one_instant(limb, {}, {25.0, 25.0, 1.0, 1.0, 0.0, 0.0}).now.heating_midpoint_degC[A] - 75.0;
}
double hot_rise_K(const Plant& limb) {
  return at_one_instant(limb, {}, {100.0, 25.0, 0.0, 1.0, 0.0, 0.0}).now.heating_midpoint_degC[A] - 75.0;
}

}  // namespace

TEST_CASE("curved stress shift: with one slope throughout it is the stress shift") {
  CHECK(hot_rise_K(curved(1.0, 1.0)) == by_hand(7.512));
  CHECK(cold_rise_K(curved(1.0, 1.0)) == doctest::Approx(0.1808).epsilon(1e-11));
}

TEST_CASE("curved stress shift: slopes by hand") {
  // Of a hot coil, x = 1: the mean slope is (3 + 1)/2 over the first half and (1 + 0.2)/2 over the second, 1.3 in all; 7.512 K * 1.3.
  CHECK(hot_rise_K(curved(3.0, 0.2)) == by_hand(9.7656));
  // Of a cold one, x = 0.226/9.39: the slope falls from 3 by 4 a unit, so that its mean is 3 - 2 x; 0.1808 K * (3 - 2 * 0.0240682...).
  CHECK(cold_rise_K(curved(3.0, 0.2)) == doctest::Approx(0.1808 * (3.0 - 2.0 * 0.226 / 9.39)).epsilon(1e-11));
}

TEST_CASE("curved stress shift: heating and cooling shift alike, and beyond a hot coil's tension the slope stays") {
  // Bent by 0.5 rad away, coil A is stretched by its moment arm times that: 313 N/m more for each metre.
  const Plant limb = curved(3.0, 0.2);
  const auto straight = at_one_instant(limb, {}, {100.0, 25.0, 0.0, 1.0, 0.0, 0.0});
  const auto away = at_one_instant(limb, {}, {100.0, 25.0, 0.0, 1.0, -0.5, 0.0});
  REQUIRE(away.now.tension_N[A] > straight.now.tension_N[A]);
  CHECK(away.now.heating_midpoint_degC[A] - straight.now.heating_midpoint_degC[A] ==
        doctest::Approx(0.8 * 0.2 * (away.now.tension_N[A] - straight.now.tension_N[A])).epsilon(1e-10));
  CHECK(away.now.heating_midpoint_degC[A] - away.now.cooling_midpoint_degC[A] == doctest::Approx(15.0).epsilon(1e-12));
}

}  // namespace plant_limb_effects_stress_shift_curved_test

// SPDX-License-Identifier: Apache-2.0
#include "plant/limb/effects/stress_shift_two_slopes.h"

#include "tests/plant/limb/one_instant.h"

namespace plant_limb_effects_stress_shift_two_slopes_test {

using namespace sinew::plant;
using namespace sinew::test;

TEST_CASE("stress shift of two slopes: cooling rises by its own share") {
  const auto at = at_one_instant(limb_with("stress_shift_two_slopes", {{"shift_K_N", 0.8}, {"cooling_ratio", 1.5}}), {},
                                 {100.0, 25.0, 0.0, 1.0, 0.0, 0.0});
  // By hand: hot coil 313 N/m * 30 mm = 9.39 N, 7.512 K and 11.268 K; cold coil 113 N/m * 2 mm = 0.226 N, 0.1808 K and 0.2712 K.
  CHECK(at.now.heating_midpoint_degC[A] == by_hand(82.512));
  CHECK(at.now.cooling_midpoint_degC[A] == by_hand(71.268));
  CHECK(at.now.heating_midpoint_degC[B] == by_hand(75.1808));
  CHECK(at.now.cooling_midpoint_degC[B] == by_hand(60.2712));
}

TEST_CASE("stress shift of two slopes: with one for both it is the stress shift") {
  const std::vector<double> y{90.0, 40.0, 0.3, 0.8, 0.2, 0.0};
  const auto two = at_one_instant(limb_with("stress_shift_two_slopes", {{"shift_K_N", 0.8}, {"cooling_ratio", 1.0}}), {}, y);
  const auto one = at_one_instant(limb_with("stress_shift", {{"shift_K_N", 0.8}}), {}, y);
  CHECK(two.now.heating_midpoint_degC[A] == one.now.heating_midpoint_degC[A]);
  CHECK(two.now.cooling_midpoint_degC[B] == one.now.cooling_midpoint_degC[B]);
}

}  // namespace plant_limb_effects_stress_shift_two_slopes_test

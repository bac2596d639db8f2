// SPDX-License-Identifier: Apache-2.0
#include "plant/limb/effects/stress_shift.h"

#include "tests/plant/limb/one_instant.h"

namespace plant_limb_effects_stress_shift_test {

using namespace sinew::plant;
using namespace sinew::test;

TEST_CASE("stress shift: both midpoints of a coil rise with its tension") {
  const auto at = at_one_instant(limb_with("stress_shift", {{"shift_K_N", 0.8}}), {}, {100.0, 25.0, 0.0, 1.0, 0.0, 0.0});
  // By hand: hot coil 313 N/m * 30 mm = 9.39 N, 7.512 K; cold coil 113 N/m * 2 mm = 0.226 N, 0.1808 K.
  CHECK(at.now.heating_midpoint_degC[A] == by_hand(82.512));
  CHECK(at.now.cooling_midpoint_degC[A] == by_hand(67.512));
  CHECK(at.now.heating_midpoint_degC[B] == by_hand(75.1808));
  CHECK(at.now.cooling_midpoint_degC[B] == doctest::Approx(60.1808).epsilon(1e-13));
}

TEST_CASE("stress shift: a tight coil is still martensite at a temperature where a loose one is not") {
  // At 82.512 degC the shifted heating envelope of the coil above is 1/2, the core's is 1 / (1 + exp(7.512/7)).
  const std::vector<double> y{82.512, 25.0, 0.0, 1.0, 0.0, 0.0};
  CHECK(at_one_instant(limb_with("stress_shift", {{"shift_K_N", 0.8}}), {}, y).now.heating_envelope[A] ==
        doctest::Approx(0.5).epsilon(1e-13));
  CHECK(at_one_instant(default_plant(), {}, y).now.heating_envelope[A] == by_hand(1.0 / (1.0 + std::exp(7.512 / 7.0))));
}

TEST_CASE("stress shift: a slack coil has its own midpoints") {
  Plant limb = limb_with("stress_shift", {{"shift_K_N", 0.8}});
  turn_on(limb, "coil_slack", {{"enabled", 1.0}});
  const auto at = at_one_instant(limb, {}, {25.0, 25.0, 1.0, 1.0, 1.0, 0.0});
  CHECK(at.now.tension_N[A] == 0.0);
  CHECK(at.now.heating_midpoint_degC[A] == 75.0);
}

}  // namespace plant_limb_effects_stress_shift_test

// SPDX-License-Identifier: Apache-2.0
#include "plant/limb/effects/r_phase.h"

#include "tests/plant/limb/one_instant.h"

namespace plant_limb_effects_r_phase_test {

using namespace sinew::plant;
using namespace sinew::test;

TEST_CASE("r phase: at its midpoint half of its share of the stretch is recovered") {
  const auto limb = limb_with("r_phase", {{"share", 0.2}, {"midpoint_degC", 45.0}, {"width_K", 4.0}});
  const auto at = at_one_instant(limb, {}, {45.0, 49.0, 1.0, 1.0, 0.0, 0.0});
  // By hand: share of the stretch 0.8 + 0.2 / 2 = 0.9; 113 N/m * (30 - 25.2) mm = 0.5424 N.
  CHECK(at.now.longer_share[A] == by_hand(0.9));
  CHECK(at.now.tension_N[A] == doctest::Approx(0.5424).epsilon(1e-13));
  // One width above: 0.8 + 0.2 / (1 + e).
  CHECK(at.now.longer_share[B] == by_hand(0.8 + 0.2 / (1.0 + std::exp(1.0))));
}

TEST_CASE("r phase: it pulls when the wire is warm, long before the main transformation") {
  const auto limb = limb_with("r_phase", {{"share", 0.2}});
  const double cold_N = at_one_instant(limb, {}, {25.0, 25.0, 1.0, 1.0, 0.0, 0.0}).now.tension_N[A];
  const double warm_N = at_one_instant(limb, {}, {60.0, 25.0, 1.0, 1.0, 0.0, 0.0}).now.tension_N[A];
  CHECK(warm_N > cold_N + 0.5);  // by hand: at most 113 N/m * 0.2 * 28 mm = 0.63 N
  CHECK(warm_N < cold_N + 0.63);
}

TEST_CASE("r phase: with the whole share the stretch forgets the main transformation, the stiffness does not") {
  const auto limb = limb_with("r_phase", {{"share", 1.0}, {"midpoint_degC", 45.0}, {"width_K", 4.0}});
  const auto at = at_one_instant(limb, {}, {45.0, 45.0, 1.0, 0.0, 0.0, 0.0});
  CHECK(at.now.longer_share[A] == by_hand(0.5));
  CHECK(at.now.longer_share[B] == by_hand(0.5));
  CHECK(at.now.tension_N[A] == doctest::Approx(113.0 * 0.016).epsilon(1e-13));
  CHECK(at.now.tension_N[B] == doctest::Approx(313.0 * 0.016).epsilon(1e-13));
}

}  // namespace plant_limb_effects_r_phase_test

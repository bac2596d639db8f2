// SPDX-License-Identifier: Apache-2.0
#include "plant/limb/effects/resistance_change.h"

#include "tests/plant/limb/one_instant.h"

namespace plant_limb_effects_resistance_change_test {

using namespace sinew::plant;
using namespace sinew::test;

TEST_CASE("resistance change: martensite resists by its share more, austenite as before") {
  const auto limb = limb_with("resistance_change", {{"relative_increase", 0.15}});
  const auto at = at_one_instant(limb, {.inputs = {0.6, 0.6}}, {25.0, 100.0, 1.0, 0.0, 0.0, 0.0});
  // By hand: 2.5 * 1.15 = 2.875 Ohm; 0.6 * 49 V^2 over it, and over 2.5 Ohm.
  CHECK(at.now.resistance_Ohm[A] == by_hand(2.875));
  CHECK(at.now.joule_heat_W[A] == by_hand(29.4 / 2.875));
  CHECK(at.now.joule_heat_W[B] == by_hand(11.76));
}

TEST_CASE("resistance change: between the phases it goes with the fraction") {
  const auto at = at_one_instant(limb_with("resistance_change", {{"relative_increase", 0.15}}), {}, {70.0, 70.0, 0.4, 0.6, 0.0, 0.0});
  CHECK(at.now.resistance_Ohm[A] == by_hand(2.65));
  CHECK(at.now.resistance_Ohm[B] == by_hand(2.725));
}

}  // namespace plant_limb_effects_resistance_change_test

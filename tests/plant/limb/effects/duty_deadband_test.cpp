// SPDX-License-Identifier: Apache-2.0
#include "plant/limb/effects/duty_deadband.h"

#include "tests/plant/limb/one_instant.h"

namespace plant_limb_effects_duty_deadband_test {

using namespace sinew::plant;
using namespace sinew::test;

TEST_CASE("duty deadband: the threshold is taken off every duty, and less than it is nothing") {
  const auto limb = limb_with("duty_deadband", {{"threshold_fraction", 0.05}});
  const auto at = at_one_instant(limb, {.inputs = {0.3, 0.03}}, {25.0, 25.0, 1.0, 1.0, 0.0, 0.0});
  CHECK(at.now.joule_heat_W[A] == by_hand(4.9));  // by hand: 0.25 * 49 V^2 / 2.5 Ohm
  CHECK(at.now.joule_heat_W[B] == 0.0);
}

TEST_CASE("duty deadband: at null even the smallest duty heats") {
  const auto limb = limb_with("duty_deadband", {{"threshold_fraction", 0.0}});
  const auto at = at_one_instant(limb, {.inputs = {1e-6, 0.0}}, {25.0, 25.0, 1.0, 1.0, 0.0, 0.0});
  CHECK(at.now.joule_heat_W[A] == by_hand(1.96e-5));
  CHECK(at.now.joule_heat_W[B] == 0.0);
}

}  // namespace plant_limb_effects_duty_deadband_test

// SPDX-License-Identifier: Apache-2.0
#include "plant/limb/effects/driver_lag.h"

#include "tests/plant/limb/one_instant.h"

namespace plant_limb_effects_driver_lag_test {

using namespace sinew::plant;
using namespace sinew::test;

TEST_CASE("driver lag: the wire is heated by the duty that the driver has come to, which nears the commanded one") {
  const auto limb = limb_with("driver_lag", {{"time_constant_s", 0.4}});
  const auto at = at_one_instant(limb, {.inputs = {0.6, 0.1}}, {25.0, 25.0, 1.0, 1.0, 0.0, 0.0, 0.2, 0.3});
  CHECK(at.now.duty_fraction[A] == 0.2);
  CHECK(at.now.duty_fraction[B] == 0.3);
  CHECK(at.rates[6] == by_hand(1.0));   // by hand: (0.6 - 0.2) / 0.4 s
  CHECK(at.rates[7] == by_hand(-0.5));  // by hand: (0.1 - 0.3) / 0.4 s
}

TEST_CASE("driver lag: the dead band is of what the driver gives") {
  Plant limb = limb_with("driver_lag", {{"time_constant_s", 0.4}});
  turn_on(limb, "duty_deadband", {{"threshold_fraction", 0.05}});
  const auto at = at_one_instant(limb, {.inputs = {0.6, 0.6}}, {25.0, 25.0, 1.0, 1.0, 0.0, 0.0, 0.2, 0.02});
  CHECK(at.now.duty_fraction[A] == by_hand(0.15));
  CHECK(at.now.duty_fraction[B] == 0.0);
}

TEST_CASE("driver lag: a quick driver gives what is commanded") {
  const auto quick = at_one_instant(limb_with("driver_lag", {{"time_constant_s", 0.5e-3}}), {.inputs = {0.6, 0.0}},
                                    {25.0, 25.0, 1.0, 1.0, 0.0, 0.0, 0.2, 0.0});
  CHECK(quick.now.duty_fraction[A] == 0.6);
}

}  // namespace plant_limb_effects_driver_lag_test

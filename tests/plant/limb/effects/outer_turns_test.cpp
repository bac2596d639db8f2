// SPDX-License-Identifier: Apache-2.0
#include "plant/limb/effects/outer_turns.h"

#include "tests/plant/limb/one_instant.h"

namespace plant_limb_effects_outer_turns_test {

using namespace sinew::plant;
using namespace sinew::test;

namespace {

Plant limb_with_outer_turns(double relative_heat_loss = 0.5, double power_share = 0.6) {
  return limb_with("outer_turns", {{"relative_heat_loss", relative_heat_loss}, {"power_share", power_share}});
}

}  // namespace

TEST_CASE("outer turns: their balance is that of a turn with its own power and heat loss, less that of the turns inside") {
  const Situation heating{.inputs = {0.5, 0.0}};
  const auto at = at_one_instant(limb_with_outer_turns(), heating, {85.0, 55.0, 0.2, 0.8, 0.0, 0.0, 20.0, -8.0});
  // Half of it is how much warmer they are: 10 K and -4 K. By hand, A: inside 9.8 W - 0.04 * 60 = 7.4 W; outside
  // 1.3 * 9.8 - 1.5 * 0.04 * 70 = 8.54 W; 1.14 W into 0.85 J/K.
  CHECK(0.5 * at.rates[6] == by_hand(1.14 / 0.85));
  // B: inside -0.04 * 30 = -1.2 W; outside -1.5 * 0.04 * 26 = -1.56 W.
  CHECK(0.5 * at.rates[7] == by_hand(-0.36 / 0.85));
}

TEST_CASE("outer turns: the thermocouple shows them, the wire that pulls is untouched") {
  const auto with = at_one_instant(limb_with_outer_turns(), {}, {85.0, 55.0, 0.2, 0.8, 0.0, 0.0, 20.0, -8.0});
  const auto without = at_one_instant(default_plant(), {}, {85.0, 55.0, 0.2, 0.8, 0.0, 0.0});
  CHECK(with.reading[A] == 95.0);
  CHECK(with.reading[B] == 51.0);
  for (std::size_t i = 0; i < 6; ++i) CHECK(with.rates[i] == without.rates[i]);
}

TEST_CASE("outer turns: without a difference in heat loss there is none in temperature, whatever the share of power") {
  const auto at = at_one_instant(limb_with_outer_turns(0.0, 3.0), {.inputs = {0.5, 0.5}}, {85.0, 55.0, 0.2, 0.8, 0.0, 0.0, 30.0, 40.0});
  CHECK(at.reading[A] == 85.0);
  CHECK(at.reading[B] == 55.0);
}

TEST_CASE("outer turns: at rest they are as warm as the others") {
  const auto y = at_rest(limb_with_outer_turns());
  CHECK(y[6] == 0.0);
  CHECK(y[7] == 0.0);
}

}  // namespace plant_limb_effects_outer_turns_test

// SPDX-License-Identifier: Apache-2.0
#include "plant/limb/effects/sheath_heat_storage.h"

#include "tests/plant/limb/one_instant.h"

namespace plant_limb_effects_sheath_heat_storage_test {

using namespace sinew::plant;
using namespace sinew::test;

namespace {

Plant limb_with_sheaths() {
  return limb_with("sheath_heat_storage", {{"conductance_W_K", 0.04}, {"heat_capacity_J_K", 2.0}, {"heat_loss_W_K", 0.03}});
}

}  // namespace

TEST_CASE("sheath heat storage: each sheath warms by what its own wire gives it less what it loses") {
  const auto at = at_one_instant(limb_with_sheaths(), {}, {85.0, 55.0, 0.2, 0.8, 0.0, 0.0, 45.0, 65.0});
  // By hand: A: 0.04 * (85 - 45) - 0.03 * (45 - 25) = 1.6 - 0.6 = 1 W into 2 J/K; B: 0.04 * -10 - 0.03 * 40 = -1.6 W.
  CHECK(at.rates[6] == by_hand(0.5));
  CHECK(at.rates[7] == by_hand(-0.8));
}

TEST_CASE("sheath heat storage: a warm sheath holds its wire up and leaves the other one alone") {
  const auto with = at_one_instant(limb_with_sheaths(), {}, {85.0, 25.0, 0.2, 1.0, 0.0, 0.0, 95.0, 25.0});
  // By hand: wire A loses 0.04 * 60 and gains 0.04 * 10; wire B is as cold as the room and its sheath.
  CHECK(with.now.heat_W[A] == by_hand(-2.0));
  CHECK(with.now.heat_W[B] == 0.0);
}

TEST_CASE("sheath heat storage: heat is neither made nor lost between wires and sheaths") {
  const Situation heating{.inputs = {0.5, 0.2}};
  const auto at = at_one_instant(limb_with_sheaths(), heating, {85.0, 55.0, 0.2, 0.8, 0.0, 0.0, 45.0, 35.0});
  const double stored_rate_W = 0.85 * (at.rates[0] + at.rates[1]) + 2.0 * (at.rates[6] + at.rates[7]);
  // By hand: in 13.72 W; out 0.04 * (60 + 30) + 0.03 * (20 + 10) = 4.5 W.
  CHECK(at.now.heat_to_surroundings_W == by_hand(4.5));
  CHECK(stored_rate_W == by_hand(13.72 - 4.5));
  const auto warmer = at_one_instant(limb_with_sheaths(), heating, {85.0, 55.0, 0.2, 0.8, 0.0, 0.0, 46.0, 35.0});
  CHECK(warmer.stored_heat_J - at.stored_heat_J == doctest::Approx(2.0).epsilon(1e-12));  // rounding of a sum of 300 J
}

TEST_CASE("sheath heat storage: at rest both sheaths are as warm as the room") {
  Plant limb = limb_with_sheaths();
  set(limb, "ambient_temperature_degC", 18.0);
  const auto y = at_rest(limb);
  CHECK(y[6] == 18.0);
  CHECK(y[7] == 18.0);
}

}  // namespace plant_limb_effects_sheath_heat_storage_test

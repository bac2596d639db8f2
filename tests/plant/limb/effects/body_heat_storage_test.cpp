// SPDX-License-Identifier: Apache-2.0
#include "plant/limb/effects/body_heat_storage.h"

#include "tests/plant/limb/one_instant.h"

namespace plant_limb_effects_body_heat_storage_test {

using namespace sinew::plant;
using namespace sinew::test;

namespace {

Plant limb_with_body() {
  return limb_with("body_heat_storage", {{"conductance_W_K", 0.01}, {"heat_capacity_J_K", 8.0}, {"heat_loss_W_K", 0.05}});
}

}  // namespace

TEST_CASE("body heat storage: the body warms by what both wires give it less what it loses") {
  const auto at = at_one_instant(limb_with_body(), {}, {85.0, 55.0, 0.2, 0.8, 0.0, 0.0, 35.0});
  // By hand: 0.01 * (85 - 35) + 0.01 * (55 - 35) - 0.05 * (35 - 25) = 0.5 + 0.2 - 0.5 = 0.2 W into 8 J/K.
  CHECK(at.rates[6] == by_hand(0.025));
}

TEST_CASE("body heat storage: a wire loses what the body gains, and a warm body warms a cold wire") {
  const auto with = at_one_instant(limb_with_body(), {}, {85.0, 25.0, 0.2, 1.0, 0.0, 0.0, 35.0});
  // By hand: wire A loses 0.04 * 60 + 0.01 * 50 = 2.9 W, wire B gains 0.01 * 10 = 0.1 W.
  CHECK(with.now.heat_W[A] == by_hand(-2.9));
  CHECK(with.now.heat_W[B] == by_hand(0.1));
}

TEST_CASE("body heat storage: heat is neither made nor lost between wires and body") {
  const Situation heating{.inputs = {0.5, 0.2}};
  const auto at = at_one_instant(limb_with_body(), heating, {85.0, 55.0, 0.2, 0.8, 0.0, 0.0, 41.0});
  const double stored_rate_W = 0.85 * at.rates[0] + 0.85 * at.rates[1] + 8.0 * at.rates[6];
  // By hand: in 0.7 * 49 / 2.5 = 13.72 W; out 0.04 * (60 + 30) + 0.05 * 16 = 4.4 W.
  CHECK(at.now.heat_to_surroundings_W == by_hand(4.4));
  CHECK(stored_rate_W == by_hand(13.72 - 4.4));
  // Heat stored counts the body: another degree of it is 8 J.
  const auto warmer = at_one_instant(limb_with_body(), heating, {85.0, 55.0, 0.2, 0.8, 0.0, 0.0, 42.0});
  CHECK(warmer.stored_heat_J - at.stored_heat_J == doctest::Approx(8.0).epsilon(1e-12));  // rounding of a sum of 500 J
}

TEST_CASE("body heat storage: at rest the body is as warm as the room") {
  Plant limb = limb_with_body();
  set(limb, "ambient_temperature_degC", 18.0);
  const auto y = at_rest(limb);
  CHECK(y[6] == 18.0);
}

}  // namespace plant_limb_effects_body_heat_storage_test

// SPDX-License-Identifier: Apache-2.0
#include "plant/limb/effects/junction_layer.h"

#include "tests/plant/limb/limb_with_junctions.h"
#include "tests/plant/limb/one_instant.h"

namespace plant_limb_effects_junction_layer_test {

using namespace sinew::plant;
using namespace sinew::test;

namespace {

Plant limb_with_layers(double conductance_W_K = 0.02) {
  Plant limb = limb_with_junctions();
  turn_on(limb, "junction_layer", {{"conductance_W_K", conductance_W_K}, {"heat_capacity_J_K", 0.5}, {"heat_loss_W_K", 0.01}});
  return limb;
}

// The last two are the layers', those before them the junctions'.
const std::vector<double> warm{85.0, 55.0, 0.2, 0.8, 0.0, 0.0, 65.0, 75.0, 45.0, 80.0};
const std::vector<double> warm_junctions(warm.begin(), warm.begin() + 8);
const Situation heating{.inputs = {0.5, 0.0}};

}  // namespace

TEST_CASE("junction layer: each layer warms by what its own junction gives it less what it loses") {
  const auto at = at_one_instant(limb_with_layers(), heating, warm);
  // By hand: A: 0.02 * (65 - 45) - 0.01 * (45 - 25) = 0.4 - 0.2 = 0.2 W into 0.5 J/K; B: 0.02 * (75 - 80) - 0.01 * 55 = -0.65 W.
  CHECK(at.rates[8] == by_hand(0.4));
  CHECK(at.rates[9] == by_hand(-1.3));
}

TEST_CASE("junction layer: it hangs on the junction, which pays for it; wire and reading do not know of it") {
  const auto with = at_one_instant(limb_with_layers(), heating, warm);
  const auto without = at_one_instant(limb_with_junctions(), heating, warm_junctions);
  // By hand: the junctions' own 3.7 W and -1.3 W (junction_test.cpp), less 0.4 W and plus 0.1 W, into 0.15 J/K.
  CHECK(with.rates[6] == by_hand(22.0));
  CHECK(with.rates[7] == by_hand(-8.0));
  for (std::size_t i = 0; i < core_state::count; ++i) CHECK(with.rates[i] == without.rates[i]);
  CHECK(with.reading == without.reading);
  CHECK(with.reading[A] == 65.0);
}

TEST_CASE("junction layer: a cold layer cools its junction fast, a warm one holds it up") {
  const std::vector<double> as_warm_as_wire{65.0, 65.0, 0.2, 0.8, 0.0, 0.0, 65.0, 65.0, 25.0, 60.0};
  const auto at = at_one_instant(limb_with_layers(), {}, as_warm_as_wire);
  // By hand: each junction loses 0.006 * 40 = 0.24 W, A's a further 0.02 * 40 W and B's 0.02 * 5 W.
  CHECK(at.rates[6] == by_hand(-1.04 / 0.15));
  CHECK(at.rates[7] == by_hand(-0.34 / 0.15));
}

TEST_CASE("junction layer: heat is neither made nor lost between wires, junctions and layers") {
  const Situation both{.inputs = {0.5, 0.2}};
  const auto at = at_one_instant(limb_with_layers(), both, warm);
  const double stored_rate_W = 0.85 * (at.rates[A] + at.rates[B]) + 0.15 * (at.rates[6] + at.rates[7]) + 0.5 * (at.rates[8] + at.rates[9]);
  // By hand: in 13.72 W; out 0.04 * (60 + 30) + 0.006 * (40 + 50) + 0.01 * (20 + 55) = 4.89 W.
  CHECK(at.now.heat_to_surroundings_W == by_hand(4.89));
  CHECK(stored_rate_W == by_hand(13.72 - 4.89));
  std::vector<double> y = warm;
  y[8] += 1.0;
  const auto warmer = at_one_instant(limb_with_layers(), both, y);
  CHECK(warmer.stored_heat_J - at.stored_heat_J == doctest::Approx(0.5).epsilon(1e-12));  // rounding of a sum of 200 J
}

TEST_CASE("junction layer: one that takes no heat is not there, to the last bit") {
  const auto with = at_one_instant(limb_with_layers(0.0), heating, warm);
  const auto without = at_one_instant(limb_with_junctions(), heating, warm_junctions);
  CHECK(with.reading == without.reading);
  for (std::size_t i = 0; i < warm_junctions.size(); ++i) CHECK(with.rates[i] == without.rates[i]);
}

TEST_CASE("junction layer: round a junction without heat capacity it lies on the wire") {
  Plant limb = limb_with_layers();
  set(limb, "junction.heat_capacity_J_K", 0.0);
  const auto with = at_one_instant(limb, heating, warm);
  const auto without = at_one_instant(limb_with_junctions(0.0), heating, warm_junctions);
  // By hand: 0.02 * (85 - 45) W and 0.02 * (55 - 80) W.
  CHECK(with.now.heat_W[A] == by_hand(without.now.heat_W[A] - 0.8));
  CHECK(with.now.heat_W[B] == by_hand(without.now.heat_W[B] + 0.5));
  CHECK(with.rates[8] == by_hand((0.8 - 0.2) / 0.5));
}

TEST_CASE("junction layer: a bead that is late follows the junction as the layer slows it") {
  Plant limb = limb_with_layers();
  turn_on(limb, "thermocouple_lag", {{"time_constant_s", 0.5e-3}});
  std::vector<double> y = warm;
  y.insert(y.end(), {65.0, 75.0});
  const auto at = at_one_instant(limb, heating, y);
  CHECK(at.rates[10] == by_hand(22.0));
  CHECK(at.reading[A] == by_hand(65.0 - 0.5e-3 * 22.0));
}

TEST_CASE("junction layer: at rest it is where its heat in is its heat out, by its junction and not by the wire") {
  const Plant limb = limb_with_layers();
  std::vector<std::optional<double>> given(10);
  given[A] = 85.0;
  given[6] = 55.0;
  const auto y = at_rest(limb, given);
  // By hand: 0.02 / (0.02 + 0.01) of 30 K above ambient. rest() keeps clear of 0 / 0 by 1e-12 W/K, 1e-9 K here.
  CHECK(y[8] == doctest::Approx(45.0).epsilon(1e-10));
  CHECK(y[9] == 25.0);
  const auto at = at_one_instant(limb, {}, y);
  CHECK(std::abs(at.rates[8]) < 1e-9);
  CHECK(at.rates[9] == 0.0);
}

}  // namespace plant_limb_effects_junction_layer_test

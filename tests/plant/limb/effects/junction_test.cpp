// SPDX-License-Identifier: Apache-2.0
#include "plant/limb/effects/junction.h"

#include "tests/plant/limb/general.h"
#include "tests/plant/limb/limb_with_junctions.h"
#include "tests/plant/limb/one_instant.h"

namespace plant_limb_effects_junction_test {

using namespace sinew::plant;
using namespace sinew::test;

namespace {

// The last two are the junctions'.
const std::vector<double> warm{85.0, 55.0, 0.2, 0.8, 0.0, 0.0, 65.0, 75.0};
const std::vector<double> warm_core{85.0, 55.0, 0.2, 0.8, 0.0, 0.0};
const Situation heating{.inputs = {0.5, 0.0}};

}  // namespace

TEST_CASE("junction: it warms by its share of the current and by conduction from its wire, less what it loses") {
  const auto at = at_one_instant(limb_with_junctions(), heating, warm);
  // By hand, A: 0.3 * 9.8 W + 0.05 * (85 - 65) - 0.006 * (65 - 25) = 2.94 + 1 - 0.24 = 3.7 W into 0.15 J/K.
  CHECK(at.rates[6] == by_hand(3.7 / 0.15));
  // B: no current, 0.05 * (55 - 75) - 0.006 * 50 = -1.3 W.
  CHECK(at.rates[7] == by_hand(-1.3 / 0.15));
}

TEST_CASE("junction: the wire keeps the rest of its current's heat and loses what is conducted away") {
  const auto at = at_one_instant(limb_with_junctions(), heating, warm);
  // By hand, A: 0.7 * 9.8 W - 0.05 * 20 - 0.04 * 60 = 3.46 W; B: 0.05 * 20 - 0.04 * 30 = -0.2 W; each into 0.85 J/K.
  CHECK(at.now.heat_W[A] == by_hand(3.46));
  CHECK(at.rates[A] == by_hand(3.46 / 0.85));
  CHECK(at.rates[B] == by_hand(-0.2 / 0.85));
}

TEST_CASE("junction: its share of the current is the same in all coils, by the mean heat capacity of their wires") {
  Plant limb = limb_with_junctions();
  set(limb, "heat_capacity_B_J_K", 0.65);
  const auto at = at_one_instant(limb, {.inputs = {0.5, 0.5}}, {25.0, 25.0, 1.0, 1.0, 0.0, 0.0, 25.0, 25.0});
  // By hand: the mean wire has 0.75 J/K, so 2 * 0.15 / 0.9 of 9.8 W; the wires have what is left.
  CHECK(at.rates[6] == by_hand(9.8 / 3.0 / 0.15));
  CHECK(at.rates[7] == by_hand(9.8 / 3.0 / 0.15));
  CHECK(at.now.heat_W[A] == by_hand(9.8 * 2.0 / 3.0));
  CHECK(at.now.heat_W[B] == by_hand(9.8 * 2.0 / 3.0));
}

TEST_CASE("junction: the thermocouple shows it, and not the wire") {
  const auto with = at_one_instant(limb_with_junctions(), heating, warm);
  const auto without = at_one_instant(default_plant(), heating, warm_core);
  CHECK(with.reading[A] == 65.0);
  CHECK(with.reading[B] == 75.0);
  CHECK(with.reading[angle] == without.reading[angle]);
}

TEST_CASE("junction: heat is neither made nor lost between wires and junctions") {
  const Situation both{.inputs = {0.5, 0.2}};
  const auto at = at_one_instant(limb_with_junctions(), both, warm);
  const double stored_rate_W = 0.85 * (at.rates[A] + at.rates[B]) + 0.15 * (at.rates[6] + at.rates[7]);
  // By hand: in 13.72 W; out 0.04 * (60 + 30) + 0.006 * (40 + 50) = 4.14 W.
  CHECK(at.now.heat_to_surroundings_W == by_hand(4.14));
  CHECK(stored_rate_W == by_hand(13.72 - 4.14));
  std::vector<double> y = warm;
  y[6] += 1.0;
  const auto warmer = at_one_instant(limb_with_junctions(), both, y);
  CHECK(warmer.stored_heat_J - at.stored_heat_J == doctest::Approx(0.15).epsilon(1e-12));  // rounding of a sum of 140 J
}

TEST_CASE("junction: a current that lasts leaves it warmer than its wire, where it takes more than its part") {
  // By hand: with a and b above ambient, 0.04 a + 0.006 b = P and 0.3 P + 0.05 (a - b) = 0.006 b; of 2.54 W, a = 54.2 and b = 62 K.
  const Plant limb = limb_with_junctions();
  const Situation lasting{.inputs = {2.54 / 19.6, 2.54 / 19.6}};
  const auto at = at_one_instant(limb, lasting, {79.2, 79.2, 0.1, 0.1, 0.0, 0.0, 87.0, 87.0});
  // Rounding of some watts, over the least heat capacity.
  for (const std::size_t i : {0, 1, 6, 7}) CHECK(std::abs(at.rates[i]) < 1e-13);
  Integrator run(limb, Start{{}, lasting.inputs}, {.method = Method::cvode, .relative_tolerance = 1e-9});
  REQUIRE_FALSE(run.advance_to(600.0));  // 26 of the slower time constant, 23 s
  for (const std::size_t j : coils) {
    CHECK(std::abs(run.state()[j] - 79.2) < 1e-6);  // the solver's tolerance, 1e-9 of 50 K a step
    CHECK(std::abs(run.readings()[j] - 87.0) < 1e-6);
  }
}

TEST_CASE("junction: without heat capacity it is not there, to the last bit, whatever else it is") {
  for (const double duty : {0.0, 0.7}) {
    const auto with = at_one_instant(limb_with_junctions(0.0), {.inputs = {duty, duty}}, warm);
    const auto without = at_one_instant(default_plant(), {.inputs = {duty, duty}}, warm_core);
    CHECK(with.reading == without.reading);
    for (std::size_t i = 0; i < core_state::count; ++i) CHECK(with.rates[i] == without.rates[i]);
    CHECK(with.now.heat_to_surroundings_W == without.now.heat_to_surroundings_W);
  }
}

TEST_CASE("junction: one that follows at once takes part to first order in its heat capacity") {
  // 0.04 mJ/K over 0.05 W/K, 0.8 ms; what its states hold does not matter.
  const auto at = at_one_instant(limb_with_junctions(4e-5), heating, warm);
  // By hand: the wire has 0.85004 J/K and loses 0.04 * 4e-5 * 60 = 9.6e-5 W more than 2.4 W.
  const double warming_K_s = (9.8 - 2.4 - 9.6e-5) / 0.85004;
  CHECK(at.rates[A] == by_hand(warming_K_s));
  CHECK(at.rates[6] == at.rates[A]);
  CHECK(at.now.heat_to_surroundings_W == by_hand(2.4 + 1.2 + 9.6e-5 + 4.8e-5));
  // The junction's own balance, with the wire's rate: 8e-5 / 0.85004 of the current's heat is its own.
  const double into_junction_W = 4e-5 * warming_K_s + 9.6e-5 - 9.8 * 8e-5 / 0.85004;
  CHECK(at.reading[A] == by_hand(85.0 - into_junction_W / 0.05));
}

TEST_CASE("junction: where it begins to follow at once, at 1 ms, nothing jumps") {
  const auto end_of_run = [](double heat_capacity_J_K) {
    Integrator run(limb_with_junctions(heat_capacity_J_K), Start{{}, {0.6, 0.1}}, {.method = Method::cvode, .relative_tolerance = 1e-10});
    REQUIRE_FALSE(run.advance_to(4.0));
    std::vector<double> all = run.readings();
    all.insert(all.end(), run.state().begin(), run.state().begin() + core_state::count);
    return all;
  };
  const auto late = end_of_run(5.00001e-5), at_once = end_of_run(4.99999e-5);
  // What first order leaves out is (1 ms)^2 times a second derivative of about 1 K/s^2; the solver is right to 1e-7 K.
  for (std::size_t i = 0; i < late.size(); ++i) CHECK(std::abs(late[i] - at_once[i]) < 3e-6);
  // There is something that could jump: 1 ms times what the junction alone would warm by, less what the wire does.
  const auto on_wire = end_of_run(0.0);
  for (const std::size_t j : coils) CHECK(std::abs(at_once[j] - on_wire[j]) > 1e-3);
}

TEST_CASE("junction: a bead that is late follows the junction, not the wire") {
  Plant limb = limb_with_junctions();
  turn_on(limb, "thermocouple_lag", {{"time_constant_s", 1.5}});
  std::vector<double> y = warm;
  y.insert(y.end(), {50.0, 78.0});
  const auto slow = at_one_instant(limb, heating, y);
  // By hand: (65 - 50) K / 1.5 s and (75 - 78) K / 1.5 s.
  CHECK(slow.rates[8] == by_hand(10.0));
  CHECK(slow.rates[9] == by_hand(-2.0));
  CHECK(slow.reading[A] == 50.0);
  CHECK(slow.reading[B] == 78.0);
  // A bead too quick to have a state of its own is late behind the junction's 3.7 W / 0.15 J/K.
  set(limb, "thermocouple_lag.time_constant_s", 0.5e-3);
  const auto quick = at_one_instant(limb, heating, y);
  CHECK(quick.rates[8] == by_hand(3.7 / 0.15));
  CHECK(quick.reading[A] == by_hand(65.0 - 0.5e-3 * 3.7 / 0.15));
}

TEST_CASE("junction: what a lead drains, it drains from the junction") {
  Plant limb = limb_with_junctions();
  turn_on(limb, "thermocouple_heat_sink", {{"gain", 0.9}});
  CHECK(at_one_instant(limb, heating, warm).reading[A] == by_hand(25.0 + 0.9 * 40.0));
}

TEST_CASE("junction: a coil without a thermocouple has none") {
  Plant limb = plant_of(two_segments);  // of coils A to D, C has one
  const auto without = at_one_instant(limb, {.inputs = {0.5, 0.5, 0.5, 0.5}}, at_rest(limb));
  turn_on(limb, "junction", {{"heat_capacity_J_K", 0.15}, {"conductance_W_K", 0.05}, {"relative_power", 2.0}});
  const auto with = at_one_instant(limb, {.inputs = {0.5, 0.5, 0.5, 0.5}}, at_rest(limb));
  REQUIRE(with.rates.size() == without.rates.size() + 1);
  for (const std::size_t j : {0, 1, 3}) CHECK(with.rates[j] == without.rates[j]);
  CHECK(with.rates[2] == by_hand(0.7 * without.rates[2]));
}

TEST_CASE("junction: at rest it is as warm as its wire") {
  Plant limb = limb_with_junctions();
  set(limb, "ambient_temperature_degC", 18.0);
  std::vector<std::optional<double>> given(8);
  given[0] = 61.0;
  const auto y = at_rest(limb, given);
  CHECK(y[6] == 61.0);
  CHECK(y[7] == 18.0);
}

}  // namespace plant_limb_effects_junction_test

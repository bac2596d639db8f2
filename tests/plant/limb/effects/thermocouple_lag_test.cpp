// SPDX-License-Identifier: Apache-2.0
#include "plant/limb/effects/thermocouple_lag.h"

#include "tests/plant/limb/one_instant.h"

namespace plant_limb_effects_thermocouple_lag_test {

using namespace sinew::plant;
using namespace sinew::test;

TEST_CASE("thermocouple lag: the bead follows its wire at the difference over the time constant") {
  const auto limb = limb_with("thermocouple_lag", {{"time_constant_s", 1.5}});
  const auto at = at_one_instant(limb, {}, {80.0, 30.0, 0.2, 1.0, 0.0, 0.0, 50.0, 33.0});
  // By hand: (80 - 50) K / 1.5 s = 20 K/s and (30 - 33) K / 1.5 s = -2 K/s.
  CHECK(at.rates[6] == by_hand(20.0));
  CHECK(at.rates[7] == by_hand(-2.0));
}

TEST_CASE("thermocouple lag: the sensor shows the bead, and the wire does not know of it") {
  const std::vector<double> core_state{80.0, 30.0, 0.2, 1.0, 0.1, 0.5};
  std::vector<double> y = core_state;
  y.insert(y.end(), {50.0, 33.0});
  const auto with = at_one_instant(limb_with("thermocouple_lag", {{"time_constant_s", 1.5}}), {}, y);
  const auto without = at_one_instant(default_plant(), {}, core_state);
  CHECK(with.reading[A] == 50.0);
  CHECK(with.reading[B] == 33.0);
  CHECK(with.reading[angle] == without.reading[angle]);
  for (std::size_t i = 0; i < core_state::count; ++i) CHECK(with.rates[i] == without.rates[i]);
}

TEST_CASE("thermocouple lag: behind a steady ramp the bead stays late by its time constant") {
  const Situation heating{.inputs = {0.6, 0.0}};
  // By hand: (0.6 * 49 V^2 / 2.5 Ohm - 0.04 W/K * 55 K) / 0.85 J/K = 9.56 / 0.85 K/s.
  const double ramp_K_s = 9.56 / 0.85;
  const double late_degC = 80.0 - 1.5 * ramp_K_s;
  const auto slow =
      at_one_instant(limb_with("thermocouple_lag", {{"time_constant_s", 1.5}}), heating, {80.0, 30.0, 0.2, 1.0, 0.0, 0.0, late_degC, 30.0});
  CHECK(slow.rates[6] == by_hand(ramp_K_s));
  // A bead too quick to have a state of its own is late by the same law.
  const auto quick =
      at_one_instant(limb_with("thermocouple_lag", {{"time_constant_s", 0.5e-3}}), heating, {80.0, 30.0, 0.2, 1.0, 0.0, 0.0, 80.0, 30.0});
  CHECK(quick.reading[A] == by_hand(80.0 - 0.5e-3 * ramp_K_s));
}

TEST_CASE("thermocouple lag: at rest the bead is as warm as its wire") {
  Plant limb = limb_with("thermocouple_lag", {{"time_constant_s", 1.5}});
  std::vector<std::optional<double>> given(8);
  given[0] = 61.0;
  const auto y = at_rest(limb, given);
  CHECK(y[6] == 61.0);
  CHECK(y[7] == 25.0);
}

}  // namespace plant_limb_effects_thermocouple_lag_test

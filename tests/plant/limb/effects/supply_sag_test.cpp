// SPDX-License-Identifier: Apache-2.0
#include "plant/limb/effects/supply_sag.h"

#include "tests/plant/limb/one_instant.h"

namespace plant_limb_effects_supply_sag_test {

using namespace sinew::plant;
using namespace sinew::test;

TEST_CASE("supply sag: the voltage falls by the source's resistance times the current that flows") {
  const auto limb = limb_with("supply_sag", {{"source_resistance_Ohm", 0.25}});
  const auto at = at_one_instant(limb, {.inputs = {0.5, 0.5}}, {25.0, 25.0, 1.0, 1.0, 0.0, 0.0});
  // By hand: each wire takes 0.5 V / 2.5 Ohm, so V = 7 - 0.25 * 0.4 V, V = 7 / 1.1.
  const double volts = 7.0 / 1.1;
  CHECK(at.now.supply_voltage_V == by_hand(volts));
  const double ampere = 2.0 * 0.5 * volts / 2.5;
  CHECK(at.now.supply_voltage_V == by_hand(7.0 - 0.25 * ampere));
  CHECK(at.now.joule_heat_W[A] == by_hand(0.5 * volts * volts / 2.5));
}

TEST_CASE("supply sag: one wire's current takes heat from the other, and no current leaves the voltage alone") {
  const auto limb = limb_with("supply_sag", {{"source_resistance_Ohm", 0.2}});
  const std::vector<double> y{25.0, 25.0, 1.0, 1.0, 0.0, 0.0};
  const double alone = at_one_instant(limb, {.inputs = {0.4, 0.0}}, y).now.joule_heat_W[A];
  const double both = at_one_instant(limb, {.inputs = {0.4, 0.4}}, y).now.joule_heat_W[A];
  CHECK(both < alone);
  CHECK(at_one_instant(limb, {}, y).now.supply_voltage_V == 7.0);
}

TEST_CASE("supply sag: the current is that of the duty and the resistance that are really there") {
  Plant limb = limb_with("supply_sag", {{"source_resistance_Ohm", 0.5}});
  turn_on(limb, "duty_deadband", {{"threshold_fraction", 0.1}});
  turn_on(limb, "resistance_change", {{"relative_increase", 0.2}});
  const auto at = at_one_instant(limb, {.inputs = {0.7, 0.1}}, {25.0, 25.0, 1.0, 1.0, 0.0, 0.0});
  // By hand: duty 0.6 and 0, 2.5 * 1.2 = 3 Ohm: V = 7 / (1 + 0.5 * 0.2).
  CHECK(at.now.supply_voltage_V == by_hand(7.0 / 1.1));
}

}  // namespace plant_limb_effects_supply_sag_test

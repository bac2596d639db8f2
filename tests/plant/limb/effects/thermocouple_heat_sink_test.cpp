// SPDX-License-Identifier: Apache-2.0
#include "plant/limb/effects/thermocouple_heat_sink.h"

#include "tests/plant/limb/one_instant.h"

namespace plant_limb_effects_thermocouple_heat_sink_test {

using namespace sinew::plant;
using namespace sinew::test;

TEST_CASE("thermocouple heat sink: the reading rises by its share of the wire's rise over ambient") {
  const auto limb = limb_with("thermocouple_heat_sink", {{"gain", 0.9}});
  const auto at = at_one_instant(limb, {}, {85.0, 15.0, 0.2, 1.0, 0.0, 0.0});
  // By hand, 25 degC around: 25 + 0.9 * 60 = 79 and 25 - 0.9 * 10 = 16.
  CHECK(at.reading[A] == by_hand(79.0));
  CHECK(at.reading[B] == by_hand(16.0));
}

TEST_CASE("thermocouple heat sink: a wire at ambient temperature is read right, whatever the gain") {
  for (const double gain : {0.2, 0.5, 1.0}) {
    const auto at = at_one_instant(limb_with("thermocouple_heat_sink", {{"gain", gain}}), {}, {25.0, 25.0, 1.0, 1.0, 0.0, 0.0});
    CHECK(at.reading[A] == 25.0);
  }
}

TEST_CASE("thermocouple heat sink: it drains the bead, which is itself late") {
  Plant limb = limb_with("thermocouple_heat_sink", {{"gain", 0.8}});
  turn_on(limb, "thermocouple_lag", {{"time_constant_s", 1.5}});
  const auto at = at_one_instant(limb, {}, {85.0, 25.0, 0.2, 1.0, 0.0, 0.0, 65.0, 25.0});
  CHECK(at.reading[A] == by_hand(57.0));  // by hand: 25 + 0.8 * (65 - 25)
}

TEST_CASE("thermocouple heat sink: the wire keeps its heat") {
  const std::vector<double> y{85.0, 15.0, 0.2, 1.0, 0.1, 0.3};
  const auto with = at_one_instant(limb_with("thermocouple_heat_sink", {{"gain", 0.5}}), {}, y);
  const auto without = at_one_instant(default_plant(), {}, y);
  CHECK(with.rates == without.rates);
}

}  // namespace plant_limb_effects_thermocouple_heat_sink_test

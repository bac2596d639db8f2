// SPDX-License-Identifier: Apache-2.0
#include "plant/limb/effects/thermocouple_two_lags.h"

#include "tests/plant/limb/one_instant.h"

namespace plant_limb_effects_thermocouple_two_lags_test {

using namespace sinew::plant;
using namespace sinew::test;

TEST_CASE("thermocouple with two lags: the sleeve follows the wire, the bead the sleeve") {
  const auto limb = limb_with("thermocouple_two_lags", {{"time_constant_s", 2.0}, {"second_share", 0.25}});
  // The states of a part stand together: sleeve A, bead A, sleeve B, bead B.
  const auto at = at_one_instant(limb, {}, {80.0, 25.0, 0.0, 1.0, 0.0, 0.0, 60.0, 50.0, 25.0, 25.0});
  CHECK(at.reading[A] == 50.0);
  CHECK(at.rates[6] == by_hand(10.0));  // by hand: 20 K / 2 s
  CHECK(at.rates[7] == by_hand(20.0));  // by hand: 10 K / (0.25 * 2 s)
  CHECK(at.rates[8] == 0.0);
}

TEST_CASE("thermocouple with two lags: behind a steady rise a quick one is late by both") {
  const auto limb = limb_with("thermocouple_two_lags", {{"time_constant_s", 0.5e-3}, {"second_share", 0.5}});
  const auto at = at_one_instant(limb, {.inputs = {0.5, 0.0}}, {80.0, 25.0, 0.0, 1.0, 0.0, 0.0, 80.0, 80.0, 25.0, 25.0});
  CHECK(at.reading[A] == by_hand(80.0 - 0.75e-3 * at.rates[0]));
}

TEST_CASE("thermocouple with two lags: at rest both are as warm as the wire") {
  std::vector<std::optional<double>> warm(10);
  warm[0] = 100.0;
  const auto y = at_rest(limb_with("thermocouple_two_lags", {{"time_constant_s", 2.0}}), warm);
  CHECK(y[6] == 100.0);
  CHECK(y[7] == 100.0);
}

}  // namespace plant_limb_effects_thermocouple_two_lags_test

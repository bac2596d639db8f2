// SPDX-License-Identifier: Apache-2.0
#include "plant/limb/effects/convection_nonlinearity.h"

#include "tests/plant/limb/one_instant.h"

namespace plant_limb_effects_convection_nonlinearity_test {

using namespace sinew::plant;
using namespace sinew::test;

TEST_CASE("convection nonlinearity: a wire 50 K above ambient loses a fifth more at 0.004 /K") {
  const auto at = at_one_instant(limb_with("convection_nonlinearity", {{"slope_1_K", 0.004}}), {}, {75.0, 45.0, 0.5, 1.0, 0.0, 0.0});
  // By hand: 0.04 * (1 + 0.004 * 50) * 50 = 2.4 W and 0.04 * (1 + 0.004 * 20) * 20 = 0.864 W.
  CHECK(at.rates[0] == by_hand(-2.4 / 0.85));
  CHECK(at.rates[1] == by_hand(-0.864 / 0.85));
  CHECK(at.now.heat_to_surroundings_W == by_hand(3.264));
}

TEST_CASE("convection nonlinearity: at ambient temperature nothing flows, below it heat flows in") {
  const auto at = at_one_instant(limb_with("convection_nonlinearity", {{"slope_1_K", 0.004}}), {}, {25.0, 15.0, 1.0, 1.0, 0.0, 0.0});
  CHECK(at.rates[0] == 0.0);
  CHECK(at.rates[1] > 0.0);
}

TEST_CASE("convection nonlinearity: what it adds grows with the square of the rise") {
  const auto added_W = [](double temperature_degC) {
    const std::vector<double> y{temperature_degC, 25.0, 0.5, 1.0, 0.0, 0.0};
    return at_one_instant(limb_with("convection_nonlinearity", {{"slope_1_K", 0.004}}), {}, y).now.heat_to_surroundings_W -
           at_one_instant(default_plant(), {}, y).now.heat_to_surroundings_W;
  };
  // By hand: 0.04 * 0.004 * 20^2 = 0.064 W; twice the rise, four times as much. Differences of watts round at 1e-15.
  CHECK(added_W(45.0) == doctest::Approx(0.064).epsilon(1e-13));
  CHECK(added_W(65.0) == doctest::Approx(0.256).epsilon(1e-13));
}

}  // namespace plant_limb_effects_convection_nonlinearity_test

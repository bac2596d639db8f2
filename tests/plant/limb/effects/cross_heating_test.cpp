// SPDX-License-Identifier: Apache-2.0
#include "plant/limb/effects/cross_heating.h"

#include "tests/plant/limb/one_instant.h"

namespace plant_limb_effects_cross_heating_test {

using namespace sinew::plant;
using namespace sinew::test;

TEST_CASE("cross heating: a wire 30 K hotter than the other gives it heat by Fourier's law") {
  const CrossHeating<double> link{.conductance_W_K = 0.012};
  CHECK(link.heat_from_a_to_b_W(85.0, 55.0) == by_hand(0.36));  // by hand: 0.012 W/K * 30 K
  CHECK(link.heat_from_a_to_b_W(55.0, 85.0) == by_hand(-0.36));
  CHECK(link.heat_from_a_to_b_W(70.0, 70.0) == 0.0);
}

TEST_CASE("cross heating: what one wire loses, the other gains, and the room sees none of it") {
  const std::vector<double> y{85.0, 55.0, 0.2, 0.8, 0.0, 0.0};
  const auto with = at_one_instant(limb_with("cross_heating", {{"conductance_W_K", 0.012}}), {}, y);
  const auto without = at_one_instant(default_plant(), {}, y);
  CHECK(with.now.heat_W[A] - without.now.heat_W[A] == doctest::Approx(-0.36).epsilon(1e-13));
  CHECK(with.now.heat_W[B] - without.now.heat_W[B] == doctest::Approx(0.36).epsilon(1e-13));
  CHECK(with.now.heat_to_surroundings_W == without.now.heat_to_surroundings_W);
  CHECK(with.stored_heat_J == without.stored_heat_J);
}

}  // namespace plant_limb_effects_cross_heating_test

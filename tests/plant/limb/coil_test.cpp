// SPDX-License-Identifier: Apache-2.0
#include "plant/limb/coil.h"

#include "tests/plant/limb/one_instant.h"

namespace plant_limb_coil_test {

using namespace sinew::plant;
using namespace sinew::test;

TEST_CASE("coil: cold it is as soft as martensite, hot as stiff as austenite, between in proportion") {
  CHECK(coil_stiffness_N_m(0.0, 313.0, 113.0) == 313.0);
  CHECK(coil_stiffness_N_m(1.0, 313.0, 113.0) == 113.0);
  CHECK(coil_stiffness_N_m(0.25, 313.0, 113.0) == 263.0);
}

TEST_CASE("coil: tension is stiffness times what is stretched over the length it has now") {
  CHECK(coil_tension_N(313.0, 0.030, 0.0, 0.028) == by_hand(9.39));
  CHECK(coil_tension_N(113.0, 0.030, 1.0, 0.028) == doctest::Approx(0.226).epsilon(1e-13));
  CHECK(coil_tension_N(213.0, 0.030, 0.5, 0.028) == by_hand(3.408));                          // by hand: 213 * 16 mm
  CHECK(coil_tension_N(113.0, 0.020, 1.0, 0.028) == doctest::Approx(-0.904).epsilon(1e-13));  // the core lets it push
}

}  // namespace plant_limb_coil_test

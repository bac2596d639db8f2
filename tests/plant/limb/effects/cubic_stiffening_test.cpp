// SPDX-License-Identifier: Apache-2.0
#include "plant/limb/effects/cubic_stiffening.h"

#include "tests/plant/limb/one_instant.h"

namespace plant_limb_effects_cubic_stiffening_test {

using namespace sinew::plant;
using namespace sinew::test;

namespace {

double stiffening_Nm(double angle_rad) {
  const std::vector<double> y{25.0, 25.0, 1.0, 1.0, angle_rad, 0.0};
  return at_one_instant(limb_with("cubic_stiffening", {{"stiffness_Nm_rad3", 0.05}}), {}, y).now.moment_Nm[0] -
         at_one_instant(default_plant(), {}, y).now.moment_Nm[0];
}

}  // namespace

TEST_CASE("cubic stiffening: it resists with the cube of the bend") {
  CHECK(stiffening_Nm(0.5) == doctest::Approx(-0.00625).epsilon(1e-13));  // by hand: 0.05 * 0.125
  CHECK(stiffening_Nm(1.0) == doctest::Approx(-0.05).epsilon(1e-13));     // twice the bend, eight times the moment
}

TEST_CASE("cubic stiffening: it is the same both ways and nothing when straight") {
  CHECK(stiffening_Nm(-0.7) == doctest::Approx(-stiffening_Nm(0.7)).epsilon(1e-13));
  CHECK(stiffening_Nm(0.0) == 0.0);
}

}  // namespace plant_limb_effects_cubic_stiffening_test

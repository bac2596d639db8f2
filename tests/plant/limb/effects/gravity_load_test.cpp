// SPDX-License-Identifier: Apache-2.0
#include "plant/limb/effects/gravity_load.h"

#include <numbers>

#include "tests/plant/limb/one_instant.h"

namespace plant_limb_effects_gravity_load_test {

using namespace sinew::plant;
using namespace sinew::test;

namespace {

double weight_Nm(double angle_deg, double tilt_deg) {
  const std::vector<double> y{25.0, 25.0, 1.0, 1.0, angle_deg * std::numbers::pi / 180.0, 0.0};
  return at_one_instant(limb_with("gravity_load", {{"moment_Nm", 0.01}, {"tilt_deg", tilt_deg}}), {}, y).now.moment_Nm[0] -
         at_one_instant(default_plant(), {}, y).now.moment_Nm[0];
}

}  // namespace

TEST_CASE("gravity load: the weight pulls with the sine of bend and tilt together") {
  CHECK(weight_Nm(10.0, 20.0) == doctest::Approx(-0.005).epsilon(1e-13));  // by hand: sin 30 deg
  CHECK(weight_Nm(40.0, 50.0) == doctest::Approx(-0.01).epsilon(1e-13));
}

TEST_CASE("gravity load: a limb that hangs straight down is pulled back to where it hangs") {
  CHECK(weight_Nm(0.0, 0.0) == 0.0);
  CHECK(weight_Nm(30.0, 0.0) == doctest::Approx(-0.005).epsilon(1e-13));
  CHECK(weight_Nm(-30.0, 0.0) == doctest::Approx(0.005).epsilon(1e-13));
  CHECK(std::abs(weight_Nm(-20.0, 20.0)) < 1e-17);
}

}  // namespace plant_limb_effects_gravity_load_test

// SPDX-License-Identifier: Apache-2.0
#include "plant/limb/effects/dry_friction.h"

#include "tests/plant/limb/one_instant.h"

namespace plant_limb_effects_dry_friction_test {

using namespace sinew::plant;
using namespace sinew::test;

namespace {

double friction_Nm(double angular_velocity_rad_s) {
  const std::vector<double> y{25.0, 25.0, 1.0, 1.0, 0.0, angular_velocity_rad_s};
  const auto limb = limb_with("dry_friction", {{"moment_Nm", 0.003}, {"smoothing_rad_s", 0.05}});
  return at_one_instant(limb, {}, y).now.moment_Nm[0] - at_one_instant(default_plant(), {}, y).now.moment_Nm[0];
}

}  // namespace

TEST_CASE("dry friction: at its smoothing velocity it has tanh 1 of its moment, against the motion") {
  CHECK(friction_Nm(0.05) == doctest::Approx(-0.003 * 0.7615941559557649).epsilon(1e-13));
  CHECK(friction_Nm(-0.05) == doctest::Approx(0.003 * 0.7615941559557649).epsilon(1e-13));
}

TEST_CASE("dry friction: it takes energy whichever way the limb moves, and holds nothing at rest") {
  for (const double velocity : {-2.0, -0.01, 0.003, 1.0}) CHECK(friction_Nm(velocity) * velocity < 0.0);
  CHECK(friction_Nm(0.0) == 0.0);
}

TEST_CASE("dry friction: a fast limb is not rubbed harder") {
  CHECK(friction_Nm(1.0) == doctest::Approx(-0.003).epsilon(1e-12));  // by hand: 1 - tanh 20 is 1e-17
  CHECK(friction_Nm(2.0) == doctest::Approx(-0.003).epsilon(1e-12));
}

}  // namespace plant_limb_effects_dry_friction_test

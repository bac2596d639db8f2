// SPDX-License-Identifier: Apache-2.0
#include "plant/limb/effects/hard_stop.h"

#include <numbers>

#include "tests/plant/limb/one_instant.h"

namespace plant_limb_effects_hard_stop_test {

using namespace sinew::plant;
using namespace sinew::test;

namespace {

double contact_Nm(double angle_deg) {
  const std::vector<double> y{25.0, 25.0, 1.0, 1.0, angle_deg * std::numbers::pi / 180.0, 0.0};
  return at_one_instant(limb_with("hard_stop", {{"stiffness_Nm_rad", 0.2}, {"angle_deg", 25.0}}), {}, y).now.moment_Nm[0] -
         at_one_instant(default_plant(), {}, y).now.moment_Nm[0];
}

}  // namespace

TEST_CASE("hard stop: ten degrees into it, it pushes back by ten degrees of its stiffness") {
  const double ten_degrees_Nm = 0.2 * std::numbers::pi / 18.0;
  CHECK(contact_Nm(35.0) == doctest::Approx(-ten_degrees_Nm).epsilon(1e-13));
  CHECK(contact_Nm(-35.0) == doctest::Approx(ten_degrees_Nm).epsilon(1e-13));
  CHECK(contact_Nm(45.0) == doctest::Approx(-2.0 * ten_degrees_Nm).epsilon(1e-13));
}

TEST_CASE("hard stop: short of it there is nothing") {
  for (const double angle_deg : {-24.9, -10.0, 0.0, 24.9}) CHECK(contact_Nm(angle_deg) == 0.0);
}

}  // namespace plant_limb_effects_hard_stop_test

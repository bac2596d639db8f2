// SPDX-License-Identifier: Apache-2.0
#include "plant/limb/effects/angle_sensor_second_order.h"

#include "tests/plant/limb/one_instant.h"

namespace plant_limb_effects_angle_sensor_second_order_test {

using namespace sinew::plant;
using namespace sinew::test;

TEST_CASE("angle sensor of second order: what it shows is pulled to the angle, and damped") {
  const auto limb = limb_with("angle_sensor_second_order", {{"time_s", 0.2}, {"damping", 0.5}});
  const auto at = at_one_instant(limb, {}, {25.0, 25.0, 1.0, 1.0, 0.5, 0.0, 0.3, 0.4});
  CHECK(at.reading[angle] == 0.3);
  CHECK(at.rates[6] == 0.4);
  CHECK(at.rates[7] == by_hand(3.0));  // by hand: (0.2 rad / 0.2 s - 2 * 0.5 * 0.4 rad/s) / 0.2 s
}

TEST_CASE("angle sensor of second order: behind a steady turn a quick sensor is late by twice the damping times its time") {
  const auto quick = at_one_instant(limb_with("angle_sensor_second_order", {{"time_s", 0.5e-3}, {"damping", 0.7}}), {},
                                    {25.0, 25.0, 1.0, 1.0, 0.5, 2.0, 0.5, 2.0});
  CHECK(quick.reading[angle] == by_hand(0.4986));  // by hand: 0.5 rad - 2 * 0.7 * 0.5 ms * 2 rad/s
}

TEST_CASE("angle sensor of second order: at rest it shows where the limb is, and stands still") {
  std::vector<std::optional<double>> bent(8);
  bent[0] = 100.0;
  const auto y = at_rest(limb_with("angle_sensor_second_order", {{"time_s", 0.2}}), bent);
  CHECK(y[4] > 0.5);
  CHECK(y[6] == y[4]);
  CHECK(y[7] == 0.0);
}

}  // namespace plant_limb_effects_angle_sensor_second_order_test

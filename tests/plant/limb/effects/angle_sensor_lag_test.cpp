// SPDX-License-Identifier: Apache-2.0
#include "plant/limb/effects/angle_sensor_lag.h"

#include "tests/plant/limb/one_instant.h"

namespace plant_limb_effects_angle_sensor_lag_test {

using namespace sinew::plant;
using namespace sinew::test;

TEST_CASE("angle sensor lag: the sensor follows the limb at the difference over the time constant") {
  const auto limb = limb_with("angle_sensor_lag", {{"time_constant_s", 0.4}});
  const auto at = at_one_instant(limb, {}, {25.0, 25.0, 1.0, 1.0, 0.5, 0.0, 0.3});
  CHECK(at.rates[6] == by_hand(0.5));  // by hand: 0.2 rad / 0.4 s
  CHECK(at.reading[angle] == 0.3);
}

TEST_CASE("angle sensor lag: the limb does not know of it, and its offset is added to what the sensor shows") {
  Plant limb = limb_with("angle_sensor_lag", {{"time_constant_s", 0.4}});
  set(limb, "angle_offset_deg", 0.1);
  const auto with = at_one_instant(limb, {}, {25.0, 25.0, 1.0, 1.0, 0.5, 0.2, 0.3});
  const auto core = at_one_instant(default_plant(), {}, {25.0, 25.0, 1.0, 1.0, 0.5, 0.2});
  CHECK(with.reading[angle] == by_hand(0.4));
  for (std::size_t i = 0; i < core_state::count; ++i) CHECK(with.rates[i] == core.rates[i]);
}

TEST_CASE("angle sensor lag: behind a steady turn a quick sensor is late by its time constant") {
  const auto quick =
      at_one_instant(limb_with("angle_sensor_lag", {{"time_constant_s", 0.5e-3}}), {}, {25.0, 25.0, 1.0, 1.0, 0.5, 2.0, 0.5});
  CHECK(quick.reading[angle] == by_hand(0.499));  // by hand: 0.5 rad - 0.5 ms * 2 rad/s
}

TEST_CASE("angle sensor lag: at rest it shows where the limb is") {
  std::vector<std::optional<double>> bent(7);
  bent[0] = 100.0;
  const auto y = at_rest(limb_with("angle_sensor_lag", {{"time_constant_s", 0.4}}), bent);
  CHECK(y[4] > 0.5);
  CHECK(y[6] == y[4]);
}

}  // namespace plant_limb_effects_angle_sensor_lag_test

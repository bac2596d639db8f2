// SPDX-License-Identifier: Apache-2.0
#include "plant/limb/effects/ambient_drift.h"

#include "plant/integrator.h"
#include "tests/plant/limb/one_instant.h"

namespace plant_limb_effects_ambient_drift_test {

using namespace sinew::plant;
using namespace sinew::test;

TEST_CASE("ambient drift: after 200 s at 0.005 K/s the room is one kelvin warmer") {
  const auto limb = limb_with("ambient_drift", {{"rate_K_s", 0.005}});
  Integrator run(limb, Start{}, {.relative_tolerance = 1e-9});
  REQUIRE_FALSE(run.advance_to(200.0));
  CHECK(run.state()[6] == doctest::Approx(200.0).epsilon(1e-12));
  const std::vector<double> y{76.0, 26.0, 0.5, 1.0, 0.0, 0.0, 200.0};
  const auto at = at_one_instant(limb, {.time_s = 200.0}, y);
  CHECK(at.now.ambient_temperature_degC == by_hand(26.0));
  CHECK(at.rates[0] == by_hand(-2.0 / 0.85));  // by hand: 0.04 W/K * (76 - 26) K
  CHECK(at.rates[1] == 0.0);                   // as warm as the room
  CHECK(at.rates[6] == 1.0);
  CHECK(at.now.heat_to_surroundings_W == by_hand(2.0));
}

TEST_CASE("ambient drift: nothing has drifted at the start, and a negative rate cools") {
  const auto limb = limb_with("ambient_drift", {{"rate_K_s", -0.01}});
  Integrator run(limb, Start{}, {.relative_tolerance = 1e-9});
  CHECK(at_one_instant(limb, run).now.ambient_temperature_degC == 25.0);
  REQUIRE_FALSE(run.advance_to(300.0));
  CHECK(at_one_instant(limb, run).now.ambient_temperature_degC == doctest::Approx(22.0).epsilon(1e-12));
}

TEST_CASE("ambient drift: the thermocouples' heat sink follows the room") {
  Plant limb = limb_with("ambient_drift", {{"rate_K_s", 0.01}});
  turn_on(limb, "thermocouple_heat_sink", {{"gain", 0.5}});
  const auto at = at_one_instant(limb, {.time_s = 500.0}, {50.0, 30.0, 1.0, 1.0, 0.0, 0.0, 500.0});
  CHECK(at.reading[A] == by_hand(40.0));  // half-way from 50 to 30
  CHECK(at.reading[B] == by_hand(30.0));
}

}  // namespace plant_limb_effects_ambient_drift_test

// SPDX-License-Identifier: Apache-2.0
#include "plant/limb/effects/latent_heat.h"

#include "tests/plant/limb/one_instant.h"

namespace plant_limb_effects_latent_heat_test {

using namespace sinew::plant;
using namespace sinew::test;

namespace {

const Plant latent = limb_with("latent_heat", {{"latent_heat_J", 8.0}});

}  // namespace

TEST_CASE("latent heat: a wire that turns to austenite warms slower") {
  // At 75 degC the heating envelope is 1/2; a fraction of 0.6 falls by (0.6 - 0.5) / 0.1 s = 1 /s.
  const Situation heating{.inputs = {0.6, 0.0}};
  const std::vector<double> y{75.0, 25.0, 0.6, 1.0, 0.0, 0.0};
  const auto with = at_one_instant(latent, heating, y);
  CHECK(with.rates[2] == by_hand(-1.0));
  // By hand: (11.76 W - 0.04 * 50 W - 8 J * 1 /s) / 0.85 J/K.
  CHECK(with.rates[0] == by_hand(1.76 / 0.85));
  CHECK(at_one_instant(default_plant(), heating, y).rates[0] == by_hand(9.76 / 0.85));
}

TEST_CASE("latent heat: a wire that turns to martensite is warmed by it") {
  // At 60 degC the cooling envelope is 1/2; a fraction of 0.4 rises by 1 /s. By hand: (-1.4 W + 8 W) / 0.85 J/K.
  const auto with = at_one_instant(latent, {}, {60.0, 25.0, 0.4, 1.0, 0.0, 0.0});
  CHECK(with.rates[2] == by_hand(1.0));
  CHECK(with.rates[0] == by_hand(6.6 / 0.85));
}

TEST_CASE("latent heat: where nothing transforms, it does nothing") {
  const std::vector<double> y{68.0, 25.0, 0.5, 0.995, 0.0, 0.0};  // both inside the loop
  CHECK(at_one_instant(latent, {}, y).rates == at_one_instant(default_plant(), {}, y).rates);
}

TEST_CASE("latent heat: twice the heat holds the wire back twice as much") {
  const std::vector<double> y{75.0, 25.0, 0.6, 1.0, 0.0, 0.0};
  const Situation heating{.inputs = {0.6, 0.0}};
  const double none = at_one_instant(default_plant(), heating, y).rates[0];
  const double once = at_one_instant(latent, heating, y).rates[0];
  const double twice = at_one_instant(limb_with("latent_heat", {{"latent_heat_J", 16.0}}), heating, y).rates[0];
  CHECK(none - twice == by_hand(2.0 * (none - once)));
}

TEST_CASE("latent heat: what transformation takes from temperature stays in the wire") {
  const Situation heating{.inputs = {0.6, 0.0}};
  const auto at = at_one_instant(latent, heating, {75.0, 60.0, 0.6, 0.4, 0.0, 0.0});
  // Heat stored is C T - L xi, so its rate is what flows in: 11.76 - 0.04 * (50 + 35) = 8.36 W.
  const double stored_rate_W = 0.85 * (at.rates[0] + at.rates[1]) - 8.0 * (at.rates[2] + at.rates[3]);
  CHECK(stored_rate_W == doctest::Approx(8.36).epsilon(1e-13));
  CHECK(at.stored_heat_J == by_hand(0.85 * 135.0 - 8.0 * 1.0));
}

}  // namespace plant_limb_effects_latent_heat_test

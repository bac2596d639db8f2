// SPDX-License-Identifier: Apache-2.0
#include "plant/limb/effects/minor_loops.h"

#include "tests/plant/limb/one_instant.h"

namespace plant_limb_effects_minor_loops_test {

using namespace sinew::plant;
using namespace sinew::test;

namespace {

const Plant looping = limb_with("minor_loops", {{"slope_share", 0.2}});

// By hand at 70 degC: envelopes 1/(1 + exp(-5/7)) and 1/(1 + exp(10/7)), slopes -y (1 - y) / 7 K.
constexpr double heating_envelope = 0.6713474534827301, heating_slope_1_K = -0.03152000716928338;
constexpr double cooling_envelope = 0.1933213698023087, cooling_slope_1_K = -0.022278316825723957;
constexpr double to_all_digits = 1e-13;

}  // namespace

TEST_CASE("minor loops: inside the loop a warming wire follows a share of the heating envelope's slope") {
  // By hand: 11.76 W less 0.04 * 45 W warm it at 9.96 / 0.85 K/s.
  const auto at = at_one_instant(looping, {.inputs = {0.6, 0.0}}, {70.0, 25.0, 0.45, 1.0, 0.0, 0.0});
  CHECK(at.rates[2] == doctest::Approx(0.2 * heating_slope_1_K * 9.96 / 0.85).epsilon(to_all_digits));
}

TEST_CASE("minor loops: a cooling wire follows the cooling envelope's, and gains martensite") {
  const auto at = at_one_instant(looping, {}, {70.0, 25.0, 0.45, 1.0, 0.0, 0.0});
  CHECK(at.rates[2] == doctest::Approx(0.2 * cooling_slope_1_K * -1.8 / 0.85).epsilon(to_all_digits));
  CHECK(at.rates[2] > 0.0);
}

TEST_CASE("minor loops: outside the loop the envelopes rule alone") {
  for (const double fraction : {0.8, heating_envelope + 1e-3, cooling_envelope - 1e-3, 0.05}) {
    const std::vector<double> y{70.0, 25.0, fraction, 1.0, 0.0, 0.0};
    CHECK(at_one_instant(looping, {}, y).rates == at_one_instant(default_plant(), {}, y).rates);
  }
}

TEST_CASE("minor loops: the term fades in from the edge of the loop") {
  const auto rate_1_s = [&](double fraction) { return at_one_instant(looping, {}, {70.0, 25.0, fraction, 1.0, 0.0, 0.0}).rates[2]; };
  const double whole_1_s = 0.2 * cooling_slope_1_K * -1.8 / 0.85;
  // Half-way through the edge of 0.001 half of it is there; the depth is a difference of numbers near 1/2.
  CHECK(rate_1_s(cooling_envelope + 0.0005) == doctest::Approx(0.5 * whole_1_s).epsilon(1e-11));
  CHECK(rate_1_s(heating_envelope - 0.0005) == doctest::Approx(0.5 * whole_1_s).epsilon(1e-11));
  CHECK(rate_1_s(heating_envelope - 0.00101) == doctest::Approx(whole_1_s).epsilon(1e-12));
}

TEST_CASE("minor loops: latent heat and fraction are solved for together") {
  Plant limb = looping;
  turn_on(limb, "latent_heat", {{"latent_heat_J", 8.0}});
  const auto at = at_one_instant(limb, {.inputs = {0.6, 0.0}}, {70.0, 25.0, 0.45, 1.0, 0.0, 0.0});
  // By hand: C dT/dt = q + L s dT/dt, so dT/dt = 9.96 / (0.85 + 8 * 0.2 * 0.03152...).
  const double warming_K_s = 9.96 / (0.85 - 8.0 * 0.2 * heating_slope_1_K);
  CHECK(at.rates[0] == doctest::Approx(warming_K_s).epsilon(to_all_digits));
  CHECK(at.rates[2] == doctest::Approx(0.2 * heating_slope_1_K * warming_K_s).epsilon(to_all_digits));
}

}  // namespace plant_limb_effects_minor_loops_test

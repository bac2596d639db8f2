// SPDX-License-Identifier: Apache-2.0
#include "plant/limb/wire.h"

#include "plant/limb/equations.h"
#include "tests/plant/limb/one_instant.h"

namespace plant_limb_wire_test {

using namespace sinew::plant;
using namespace sinew::test;

TEST_CASE("wire: at its midpoint each envelope is a half, one logarithm of three away a quarter and three quarters") {
  const double three = 7.0 * std::log(3.0);
  CHECK(envelopes(75.0, 75.0, 7.0, 60.0, 7.0).heating == 0.5);
  CHECK(envelopes(60.0, 75.0, 7.0, 60.0, 7.0).cooling == 0.5);
  // By hand: 1 / (1 + 3) and 1 / (1 + 1/3).
  CHECK(envelopes(75.0 + three, 75.0, 7.0, 60.0, 7.0).heating == by_hand(0.25));
  CHECK(envelopes(75.0 - three, 75.0, 7.0, 60.0, 7.0).heating == by_hand(0.75));
  CHECK(envelopes(60.0 - three, 75.0, 7.0, 60.0, 7.0).cooling == by_hand(0.75));
}

TEST_CASE("wire: cold is martensite, hot is austenite, and no temperature overflows") {
  for (const double temperature_degC : {-1e6, -300.0, 25.0, 150.0, 1e6}) {
    const auto envelope = envelopes(temperature_degC, 75.0, 7.0, 60.0, 7.0);
    CHECK(envelope.heating >= envelope.cooling);
    CHECK(envelope.heating >= 0.0);
    CHECK(envelope.heating <= 1.0);
  }
  CHECK(envelopes(-1e6, 75.0, 7.0, 60.0, 7.0).cooling == 1.0);
  CHECK(envelopes(1e6, 75.0, 7.0, 60.0, 7.0).heating == 0.0);
  using J = Jet;
  for (const double x : {-1e6, -800.0, 0.0, 800.0, 1e6}) CHECK(std::isfinite(falling_logistic(J(x, 0)).v[0]));
  CHECK(falling_logistic(J(0.0, 0)).v[0] == -0.25);  // by hand: -y (1 - y)
}

TEST_CASE("wire: where the envelopes cross, both are their mean") {
  // Widths of 2 K on heating and 20 K on cooling cross at 76.67 degC; above, the wide cooling envelope is the higher one.
  const auto crossed = envelopes(90.0, 75.0, 2.0, 60.0, 20.0);
  const double mean = 0.5 * (1.0 / (1.0 + std::exp(7.5)) + 1.0 / (1.0 + std::exp(1.5)));
  CHECK(crossed.heating == by_hand(mean));
  CHECK(crossed.cooling == crossed.heating);
  // By hand: (T - 75) / 2 = (T - 60) / 20 at T = 690 / 9.
  const auto crossing = envelopes(690.0 / 9.0, 75.0, 2.0, 60.0, 20.0);
  CHECK(crossing.heating == doctest::Approx(crossing.cooling).epsilon(1e-13));
}

TEST_CASE("wire: between the envelopes the fraction is held, outside it is pulled back in its time") {
  const Envelopes<double> envelope{.heating = 0.7, .cooling = 0.2};
  CHECK(pull_to_envelopes_1_s(0.2, envelope, 0.1) == 0.0);
  CHECK(pull_to_envelopes_1_s(0.45, envelope, 0.1) == 0.0);
  CHECK(pull_to_envelopes_1_s(0.7, envelope, 0.1) == 0.0);
  CHECK(pull_to_envelopes_1_s(0.9, envelope, 0.1) == doctest::Approx(-2.0).epsilon(1e-13));
  CHECK(pull_to_envelopes_1_s(0.1, envelope, 0.1) == doctest::Approx(1.0).epsilon(1e-13));
  CHECK(pull_to_envelopes_1_s(0.9, envelope, 0.2) == doctest::Approx(-1.0).epsilon(1e-13));
}

TEST_CASE("joule heating: duty times voltage squared over resistance, and twice the duty is twice the heat") {
  const std::vector<double> y{25.0, 25.0, 1.0, 1.0, 0.0, 0.0};
  const auto at = at_one_instant(default_plant(), {.inputs = {0.3, 0.6}}, y);
  CHECK(at.now.joule_heat_W[A] == by_hand(5.88));  // by hand: 0.3 * 49 V^2 / 2.5 Ohm
  CHECK(at.now.joule_heat_W[B] == by_hand(11.76));
  CHECK(at.rates[1] == by_hand(11.76 / 0.85));
}

TEST_CASE("heat balance: each wire has its own resistance, capacity and loss") {
  Plant limb = default_plant();
  set(limb, "resistance_A_Ohm", 2.0);
  set(limb, "resistance_B_Ohm", 4.0);
  set(limb, "heat_capacity_A_J_K", 0.5);
  set(limb, "heat_capacity_B_J_K", 1.0);
  set(limb, "heat_loss_A_W_K", 0.1);
  set(limb, "heat_loss_B_W_K", 0.2);
  const auto at = at_one_instant(limb, {.inputs = {0.4, 0.4}}, {35.0, 45.0, 1.0, 1.0, 0.0, 0.0});
  // By hand: 0.4 * 49 / 2 - 0.1 * 10 = 8.8 W into 0.5 J/K; 0.4 * 49 / 4 - 0.2 * 20 = 0.9 W into 1 J/K.
  CHECK(at.rates[0] == by_hand(17.6));
  CHECK(at.rates[1] == by_hand(0.9));
}

}  // namespace plant_limb_wire_test

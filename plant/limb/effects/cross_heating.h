// SPDX-License-Identifier: Apache-2.0
// Heat that one wire gives the other through the silicone between them.
//
//   q = G_AB (T_A - T_B)      [W], positive when it leaves wire A
//
// Source: Fourier conduction, lumped; Incropera et al., 6th ed. (2007), section 3.1.
// Leaves out the heat that the silicone itself stores (body_heat_storage.h).
#pragma once

#include "plant/limb/instant.h"

namespace sinew::plant {

template <class S>
struct CrossHeating {
  static constexpr std::string_view name = "cross_heating";
  static constexpr Place place = Place::thermal;
  static constexpr Part part = Part::pair;
  static constexpr std::string_view equation = "q = G_AB (T_A - T_B), out of wire A and into wire B";
  static constexpr std::string_view words = "one wire heats the other through the silicone";
  static constexpr std::string_view argument = "other temperature";

  S conductance_W_K{0.0};

  template <class Self, class Visitor>
  static void parameters(Self& self, Visitor&& visit) {
    visit(self.conductance_W_K, Declaration{.name = "conductance_W_K",
                                            .symbol = "G_AB",
                                            .unit = units::W_K,
                                            .range = {0.0, 1.0},
                                            .typical = 0.005,
                                            .null_value = 0.0,
                                            .prior_deviation = 0.01,
                                            .meaning = "heat that crosses from wire to wire, per kelvin between them",
                                            .source = "conduction through the body's width"});
  }

  S heat_from_a_to_b_W(const S& temperature_a_degC, const S& temperature_b_degC) const {
    return conductance_W_K * (temperature_a_degC - temperature_b_degC);
  }
  void heat(Instant<S>& now, std::size_t pair) const {
    const auto [a, b] = now.shape().pairs[pair];
    const S q = heat_from_a_to_b_W(now.temperature_degC[a], now.temperature_degC[b]);
    now.heat_W[a] = now.heat_W[a] - q;
    now.heat_W[b] = now.heat_W[b] + q;
  }
};

}  // namespace sinew::plant

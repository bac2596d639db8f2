// SPDX-License-Identifier: Apache-2.0
// A hotter wire loses more heat per kelvin, by natural convection and radiation.
//
//   h -> h (1 + beta (T - T_inf))
//
// Source: first term of the series of h ~ (T - T_inf)^n; Incropera et al., 6th ed. (2007), section 9.6.
#pragma once

#include "plant/limb/instant.h"

namespace sinew::plant {

template <class S>
struct ConvectionNonlinearity {
  static constexpr std::string_view name = "convection_nonlinearity";
  static constexpr Place place = Place::thermal;
  static constexpr Part part = Part::coil;
  static constexpr std::string_view equation = "h -> h (1 + beta (T - T_inf))";
  static constexpr std::string_view words = "heat loss grows with temperature (natural convection and radiation)";
  static constexpr std::string_view argument = "temperature";

  S slope_1_K{0.0};

  template <class Self, class Visitor>
  static void parameters(Self& self, Visitor&& visit) {
    visit(self.slope_1_K, Declaration{.name = "slope_1_K",
                                      .symbol = "beta",
                                      .unit = units::per_K,
                                      .range = {0.0, 0.1},
                                      .typical = 0.004,
                                      .null_value = 0.0,
                                      .prior_deviation = 0.005,
                                      .meaning = "relative growth of the heat loss coefficient per kelvin above ambient",
                                      .source = "h ~ (T - T_inf)^0.25 has 0.25/50 K"});
  }

  void environment(Instant<S>& now, std::size_t coil) const {
    now.heat_loss_W_K[coil] = now.heat_loss_W_K[coil] * (1.0 + slope_1_K * (now.temperature_degC[coil] - now.ambient_temperature_degC));
  }
};

}  // namespace sinew::plant

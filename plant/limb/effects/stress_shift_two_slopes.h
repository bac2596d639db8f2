// SPDX-License-Identifier: Apache-2.0
// Stress favours martensite, austenite by one slope and martensite by another. Another form of `stress_shift`.
//
//   T_heat rises by F / C_F,  T_cool by r F / C_F
//
// Source: Liang and Rogers 1990, Brinson 1993: C_A differs from C_M, r = C_A / C_M; stress replaced by the coil's tension F.
#pragma once

#include "plant/limb/effects/stress_shift.h"

namespace sinew::plant {

template <class S>
struct StressShiftTwoSlopes {
  static constexpr std::string_view name = "stress_shift_two_slopes";
  static constexpr std::string_view form_of = "stress_shift";
  static constexpr Place place = Place::transformation;
  static constexpr Part part = Part::coil;
  static constexpr std::string_view equation = "T_heat rises by F / C_F, T_cool by r F / C_F";
  static constexpr std::string_view words = "tension raises the transformation temperatures, on cooling by another amount than on heating";

  S shift_K_N{0.0}, cooling_ratio{1.0};

  template <class Self, class Visitor>
  static void parameters(Self& self, Visitor&& visit) {
    visit(self.shift_K_N, declared_shift_K_N("rise of the transformation temperature on heating per newton", "as of stress_shift"));
    visit(self.cooling_ratio, Declaration{.name = "cooling_ratio",
                                          .symbol = "r",
                                          .unit = units::none,
                                          .range = {0.0, 10.0},
                                          .typical = 1.0,
                                          .prior_deviation = 0.5,
                                          .meaning = "rise on cooling as a share of the rise on heating",
                                          .source = "Brinson 1993, table 1: C_A/C_M = 13.8/8"});
  }

  void envelopes(Instant<S>& now, std::size_t coil) const {
    const S rise_K = shift_K_N * now.tension_N[coil];
    now.heating_midpoint_degC[coil] = now.heating_midpoint_degC[coil] + rise_K;
    now.cooling_midpoint_degC[coil] = now.cooling_midpoint_degC[coil] + cooling_ratio * rise_K;
  }
};

}  // namespace sinew::plant

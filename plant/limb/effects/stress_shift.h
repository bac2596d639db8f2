// SPDX-License-Identifier: Apache-2.0
// Stress favours martensite: a tight coil transforms at a higher temperature (Clausius-Clapeyron).
//
//   T_heat, T_cool rise by F / C_F
//
// Source: Liang and Rogers 1990, with stress replaced by the coil's tension F; the parameter is 1/C_F.
#pragma once

#include "plant/limb/instant.h"

namespace sinew::plant {

// The strength of every form of it.
inline Declaration declared_shift_K_N(std::string_view meaning, std::string_view source) {
  return {.name = "shift_K_N",
          .symbol = "1/C_F",
          .unit = units::K_N,
          .range = {0.0, 20.0},
          .typical = 0.8,
          .null_value = 0.0,
          .prior_deviation = 1.0,
          .meaning = meaning,
          .source = source};
}

template <class S>
struct StressShift {
  static constexpr std::string_view name = "stress_shift";
  static constexpr Place place = Place::transformation;
  static constexpr Part part = Part::coil;
  static constexpr std::string_view equation = "T_heat, T_cool rise by F / C_F";
  static constexpr std::string_view words = "tension raises the transformation temperatures (Clausius-Clapeyron)";

  S shift_K_N{0.0};

  template <class Self, class Visitor>
  static void parameters(Self& self, Visitor&& visit) {
    visit(self.shift_K_N,
          declared_shift_K_N("rise of the transformation temperatures per newton", "6 to 10 MPa/K through the spring's shear stress"));
  }

  void envelopes(Instant<S>& now, std::size_t coil) const {
    now.heating_midpoint_degC[coil] = now.heating_midpoint_degC[coil] + shift_K_N * now.tension_N[coil];
    now.cooling_midpoint_degC[coil] = now.cooling_midpoint_degC[coil] + shift_K_N * now.tension_N[coil];
  }
};

}  // namespace sinew::plant

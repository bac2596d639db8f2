// SPDX-License-Identifier: Apache-2.0
// Stress favours martensite, but not by as much for each newton: the slope of `stress_shift` changes with the tension. Another form of it.
//
//   T_heat, T_cool rise by  F_0/C_F G(F/F_0),   dG/dx = g_0 at x <= 0, 1 at x = 1/2, g_1 at x >= 1, straight between
//
// F_0 = k_a delta_0 is the tension of a hot coil of the straight limb. g_0 > 1 > g_1: less and less, as where the wire's stress is no
// longer in proportion to the coil's tension.
//
// Source: phase diagrams with curved boundaries, Lagoudas (ed.) 2008, Shape Memory Alloys, section 1.4; the curve is ours: the simplest
// with a slope of its own at small and at large tension.
#pragma once

#include "plant/limb/instant.h"

namespace sinew::plant {

template <class S>
struct StressShiftBent {
  static constexpr std::string_view name = "stress_shift_bent";
  static constexpr std::string_view form_of = "stress_shift";
  static constexpr Place place = Place::transformation;
  static constexpr Part part = Part::coil;
  static constexpr std::string_view equation = "T_heat, T_cool rise by F_0/C_F G(F/F_0), G' = g_0, 1, g_1 at 0, 1/2, 1";
  static constexpr std::string_view words = "tension raises the transformation temperatures, each newton by another amount";

  S shift_K_N{0.0}, slope_at_none{1.0}, slope_at_most{1.0};

  template <class Self, class Visitor>
  static void parameters(Self& self, Visitor&& visit) {
    visit(self.shift_K_N, Declaration{.name = "shift_K_N",
                                      .symbol = "1/C_F",
                                      .unit = units::K_N,
                                      .range = {0.0, 20.0},
                                      .typical = 0.8,
                                      .null_value = 0.0,
                                      .prior_deviation = 1.0,
                                      .meaning = "rise of the transformation temperatures per newton, at half the tension of a hot coil",
                                      .source = "as of stress_shift"});
    visit(self.slope_at_none, Declaration{.name = "slope_at_none",
                                          .symbol = "g_0",
                                          .unit = units::none,
                                          .range = {0.0, 10.0},
                                          .typical = 1.0,
                                          .prior_deviation = 1.0,
                                          .meaning = "rise per newton of a slack coil, as a share of that",
                                          .source = "1: stress_shift"});
    visit(self.slope_at_most,
          Declaration{.name = "slope_at_most",
                      .symbol = "g_1",
                      .unit = units::none,
                      .range = {0.0, 10.0},
                      .typical = 1.0,
                      .prior_deviation = 1.0,
                      .meaning = "rise per newton at the tension of a hot coil of the straight limb, as a share of that",
                      .source = "1: stress_shift"});
  }

  void envelopes(Instant<S>& now, std::size_t coil) const {
    const S scale_N = now.core->austenite_stiffness_N_m * now.core->coil_stretch_m;
    const S rise_K = shift_K_N * scale_N * risen(now.tension_N[coil] / scale_N);
    now.heating_midpoint_degC[coil] = now.heating_midpoint_degC[coil] + rise_K;
    now.cooling_midpoint_degC[coil] = now.cooling_midpoint_degC[coil] + rise_K;
  }

 private:
  S risen(const S& x) const {  // G
    if (!(value_of(x) > 0.0)) return slope_at_none * x;
    if (!(value_of(x) > 0.5)) return slope_at_none * x + (1.0 - slope_at_none) * x * x;
    const S at_half = 0.25 * (slope_at_none + 1.0);
    if (!(value_of(x) > 1.0)) return at_half + (x - 0.5) + (slope_at_most - 1.0) * (x - 0.5) * (x - 0.5);
    return at_half + 0.25 * (1.0 + slope_at_most) + slope_at_most * (x - 1.0);
  }
};

}  // namespace sinew::plant

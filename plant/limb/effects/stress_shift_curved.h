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

#include "plant/limb/effects/stress_shift.h"

namespace sinew::plant {

template <class S>
struct StressShiftCurved {
  static constexpr std::string_view name = "stress_shift_curved";
  static constexpr std::string_view form_of = "stress_shift";
  static constexpr Place place = Place::transformation;
  static constexpr Part part = Part::coil;
  static constexpr std::string_view equation =
      "T_heat, T_cool rise by F_0/C_F G(F/F_0), F_0 = k_a delta_0, G' = g_0 at 0, 1 at 1/2, g_1 from 1 on, straight between";
  static constexpr std::string_view words =
      "tension raises the transformation temperatures, and each further newton by more, or by less, than the one before";

  S shift_K_N{0.0}, slope_slack{1.0}, slope_taut{1.0};

  template <class Self, class Visitor>
  static void parameters(Self& self, Visitor&& visit) {
    visit(self.shift_K_N, declared_shift_K_N("rise of the transformation temperatures per newton, at half the tension of a hot coil",
                                             "as of stress_shift"));
    visit(self.slope_slack, Declaration{.name = "slope_slack",
                                        .symbol = "g_0",
                                        .unit = units::none,
                                        .range = {0.0, 10.0},
                                        .typical = 1.0,
                                        .prior_deviation = 1.0,
                                        .meaning = "rise per newton of a slack coil, as a share of shift_K_N",
                                        .source = "1 in both is stress_shift itself"});
    visit(self.slope_taut, Declaration{.name = "slope_taut",
                                       .symbol = "g_1",
                                       .unit = units::none,
                                       .range = {0.0, 10.0},
                                       .typical = 1.0,
                                       .prior_deviation = 1.0,
                                       .meaning = "rise per newton of a taut coil, from F_0 on, as a share of shift_K_N",
                                       .source = "1 in both is stress_shift itself"});
  }

  void envelopes(Instant<S>& now, std::size_t coil) const {
    const S scale_N = now.core->austenite_stiffness_N_m[coil] * now.core->coil_stretch_m[coil];
    const S rise_K = shift_K_N * scale_N * risen(now.tension_N[coil] / scale_N);
    now.heating_midpoint_degC[coil] = now.heating_midpoint_degC[coil] + rise_K;
    now.cooling_midpoint_degC[coil] = now.cooling_midpoint_degC[coil] + rise_K;
  }

 private:
  S risen(const S& x) const {  // G
    if (!(value_of(x) > 0.0)) return slope_slack * x;
    if (!(value_of(x) > 0.5)) return slope_slack * x + (1.0 - slope_slack) * x * x;
    const S at_half = 0.25 * (slope_slack + 1.0);
    if (!(value_of(x) > 1.0)) return at_half + (x - 0.5) + (slope_taut - 1.0) * (x - 0.5) * (x - 0.5);
    return at_half + 0.25 * (1.0 + slope_taut) + slope_taut * (x - 1.0);
  }
};

}  // namespace sinew::plant

// SPDX-License-Identifier: Apache-2.0
// Part of the stroke comes from the R-phase, which transforms at its own temperature without hysteresis.
//
//   F = k(xi) (delta - delta_t ((1 - f) xi + f xi_R)),   xi_R = 1 / (1 + exp((T - T_R)/w_R))
//
// Source: docs/plant.md, section 2; R-phase of Ni-Ti, Otsuka and Ren 2005, section 3. Written xi + f (xi_R - xi),
// exact at f = 0. Leaves out that the R-phase changes stiffness and resistance.
#pragma once

#include "plant/limb/instant.h"

namespace sinew::plant {

template <class S>
struct RPhase {
  static constexpr std::string_view name = "r_phase";
  static constexpr Place place = Place::transformation;
  static constexpr Part part = Part::coil;
  static constexpr std::string_view equation = "share f of delta_t follows 1 / (1 + exp((T - T_R)/w_R)) instead of xi";
  static constexpr std::string_view words = "part of the stroke comes from the R-phase, without hysteresis";

  S share{0.0};
  S midpoint_degC{45.0};
  S width_K{4.0};

  template <class Self, class Visitor>
  static void parameters(Self& self, Visitor&& visit) {
    visit(self.share, Declaration{.name = "share",
                                  .symbol = "f",
                                  .unit = units::none,
                                  .range = {0.0, 1.0},
                                  .typical = 0.2,
                                  .null_value = 0.0,
                                  .prior_deviation = 0.2,
                                  .meaning = "share of the transformation stretch that the R-phase recovers",
                                  .source = "R-phase strain is a tenth to a fifth of the whole"});
    visit(self.midpoint_degC, Declaration{.name = "midpoint_degC",
                                          .symbol = "T_R",
                                          .unit = units::degC,
                                          .range = {-20.0, 150.0},
                                          .typical = 45.0,
                                          .prior_deviation = 10.0,
                                          .meaning = "temperature at which half of it is recovered",
                                          .source = "some 15 K below the main transformation"});
    visit(self.width_K, Declaration{.name = "width_K",
                                    .symbol = "w_R",
                                    .unit = units::K,
                                    .range = {0.5, 50.0},
                                    .typical = 4.0,
                                    .prior_deviation = 3.0,
                                    .meaning = "width of its transformation"});
  }

  void stretch(Instant<S>& now, std::size_t coil) const {
    const S r_phase_fraction = falling_logistic(S((now.temperature_degC[coil] - midpoint_degC) / width_K));
    now.longer_share[coil] = now.longer_share[coil] + share * (r_phase_fraction - now.longer_share[coil]);
  }
};

}  // namespace sinew::plant

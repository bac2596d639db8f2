// SPDX-License-Identifier: Apache-2.0
// Martensite resists more than austenite, so that a cold wire draws less current.
//
//   R -> R (1 + rho xi)
//
// Source: Ikuta, Tsukamoto, Hirose 1991. Leaves out that resistance also changes with strain and temperature.
#pragma once

#include "plant/limb/instant.h"

namespace sinew::plant {

template <class S>
struct ResistanceChange {
  static constexpr std::string_view name = "resistance_change";
  static constexpr Place place = Place::actuation;
  static constexpr Part part = Part::coil;
  static constexpr std::string_view equation = "R -> R (1 + rho xi)";
  static constexpr std::string_view words = "the wire's resistance depends on its phase";
  static constexpr std::string_view argument = "martensite fraction";

  S relative_increase{0.0};

  template <class Self, class Visitor>
  static void parameters(Self& self, Visitor&& visit) {
    visit(self.relative_increase, Declaration{.name = "relative_increase",
                                              .symbol = "rho",
                                              .unit = units::none,
                                              .range = {-0.5, 2.0},
                                              .typical = 0.15,
                                              .null_value = 0.0,
                                              .prior_deviation = 0.2,
                                              .meaning = "by which share martensite resists more than austenite",
                                              .source = "10 to 20 % for Ni-Ti"});
  }

  void electrics(Instant<S>& now, std::size_t coil) const {
    now.resistance_Ohm[coil] = now.resistance_Ohm[coil] * (1.0 + relative_increase * now.martensite_fraction[coil]);
  }
};

}  // namespace sinew::plant

// SPDX-License-Identifier: Apache-2.0
// The transformation absorbs heat on heating and frees it on cooling.
//
//   C_w dT/dt = ... + L dxi/dt      (L in J, of the whole wire; xi falls while it absorbs)
//
// Source: about 24 J/g for Ni-Ti (Flexinol data sheet), times 0.8 g of wire. Leaves out heat of friction at the interfaces.
#pragma once

#include "plant/limb/instant.h"

namespace sinew::plant {

template <class S>
struct LatentHeat {
  static constexpr std::string_view name = "latent_heat";
  static constexpr Place place = Place::thermal;
  static constexpr Part part = Part::coil;
  static constexpr std::string_view equation = "C_w dT/dt = ... + L dxi/dt";
  static constexpr std::string_view words = "the phase transformation absorbs and frees heat";
  static constexpr std::string_view argument = "rate of temperature";

  S latent_heat_J{0.0};

  template <class Self, class Visitor>
  static void parameters(Self& self, Visitor&& visit) {
    visit(self.latent_heat_J, Declaration{.name = "latent_heat_J",
                                          .symbol = "L",
                                          .unit = units::J,
                                          .range = {0.0, 100.0},
                                          .typical = 8.0,
                                          .null_value = 0.0,
                                          .prior_deviation = 12.0,
                                          .meaning = "latent heat of one whole wire",
                                          .source = "24 J/g times 0.8 g is 19 J"});
  }

  void heat(Instant<S>& now, std::size_t coil) const { now.latent_heat_J[coil] += latent_heat_J; }
  S stored_heat_J(const Instant<S>& now, std::size_t coil) const { return -latent_heat_J * now.martensite_fraction[coil]; }
};

}  // namespace sinew::plant

// SPDX-License-Identifier: Apache-2.0
// What is glued around each wire (epoxy, adhesive, the silicone of its ridge) takes up heat and gives it back: one node of
// temperature T_s,j for each wire, so that a wire cools fast at first and slowly later.
//
//   C_s dT_s,j/dt = G_s (T_j - T_s,j) - h_s (T_s,j - T_inf);   each wire loses G_s (T_j - T_s,j)
//
// Source: lumped heat capacity; Incropera et al., 6th ed. (2007), section 5.1. Asked for by the physical limb, whose
// thermocouples sit in large amounts of epoxy and a soft adhesive (results/paper_limb).
// Leaves out heat that goes from one wire's sheath to the other's (body_heat_storage.h, cross_heating.h).
#pragma once

#include "plant/limb/instant.h"

namespace sinew::plant {

template <class S>
struct SheathHeatStorage {
  static constexpr std::string_view name = "sheath_heat_storage";
  static constexpr Place place = Place::thermal;
  static constexpr Part part = Part::coil;
  static constexpr std::string_view equation = "C_s dT_s,j/dt = G_s (T_j - T_s,j) - h_s (T_s,j - T_inf)";
  static constexpr std::string_view words = "what is glued around each wire stores heat and gives it back to that wire";
  static constexpr std::string_view argument = "memory of temperature";
  static constexpr std::array states{StateDeclaration{"temperature_{}_degC", units::degC, 20.0}};

  S conductance_W_K{0.0};
  S heat_capacity_J_K{2.0};
  S heat_loss_W_K{0.03};

  template <class Self, class Visitor>
  static void parameters(Self& self, Visitor&& visit) {
    visit(self.conductance_W_K, Declaration{.name = "conductance_W_K",
                                            .symbol = "G_s",
                                            .unit = units::W_K,
                                            .range = {0.0, 1.0},
                                            .typical = 0.03,
                                            .null_value = 0.0,
                                            .prior_deviation = 0.04,
                                            .meaning = "heat from a wire to its sheath, per kelvin",
                                            .source = "conduction through a millimetre of epoxy or silicone"});
    visit(self.heat_capacity_J_K, Declaration{.name = "heat_capacity_J_K",
                                              .symbol = "C_s",
                                              .unit = units::J_K,
                                              .range = {0.05, 50.0},
                                              .typical = 2.0,
                                              .prior_deviation = 2.0,
                                              .meaning = "heat that warms one sheath by one kelvin",
                                              .source = "1.3 J/(g K), a gram or two"});
    visit(self.heat_loss_W_K, Declaration{.name = "heat_loss_W_K",
                                          .symbol = "h_s",
                                          .unit = units::W_K,
                                          .range = {0.0, 1.0},
                                          .typical = 0.03,
                                          .prior_deviation = 0.03,
                                          .meaning = "heat that a sheath loses to the surroundings, per kelvin",
                                          .source = "natural convection over its surface"});
  }

  void rest(const Instant<S>& now, std::size_t, S* own) const { own[0] = now.ambient_temperature_degC; }
  void heat(Instant<S>& now, std::size_t coil, const S* own) const {
    now.heat_W[coil] = now.heat_W[coil] - conductance_W_K * (now.temperature_degC[coil] - own[0]);
    now.heat_to_surroundings_W += heat_loss_W_K * (own[0] - now.ambient_temperature_degC);
  }
  void rates(const Instant<S>& now, std::size_t coil, const S* own, S* rate) const {
    rate[0] = (conductance_W_K * (now.temperature_degC[coil] - own[0]) - heat_loss_W_K * (own[0] - now.ambient_temperature_degC)) /
              heat_capacity_J_K;
  }
  S stored_heat_J(const Instant<S>&, std::size_t, const S* own) const { return heat_capacity_J_K * own[0]; }
};

}  // namespace sinew::plant

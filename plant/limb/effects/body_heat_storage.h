// SPDX-License-Identifier: Apache-2.0
// The silicone between the wires of a segment takes up heat and gives it back later: one node of temperature T_b.
//
//   C_b dT_b/dt = sum_j G_b (T_j - T_b) - h_b (T_b - T_inf);   each wire loses G_b (T_j - T_b)
//
// Source: lumped heat capacity; Incropera et al., 6th ed. (2007), section 5.1.
// Leaves out gradients inside the silicone, and heat that goes straight from wire to wire (cross_heating.h).
#pragma once

#include "plant/limb/instant.h"

namespace sinew::plant {

template <class S>
struct BodyHeatStorage {
  static constexpr std::string_view name = "body_heat_storage";
  static constexpr Place place = Place::thermal;
  static constexpr Part part = Part::segment;
  static constexpr std::string_view equation = "C_b dT_b/dt = sum_j G_b (T_j - T_b) - h_b (T_b - T_inf)";
  static constexpr std::string_view words = "the silicone body stores heat and gives it back to the wires";
  static constexpr std::string_view argument = "memory of temperature";
  static constexpr std::array states{StateDeclaration{"temperature_{}_degC", units::degC, 10.0}};

  S conductance_W_K{0.0};
  S heat_capacity_J_K{8.0};
  S heat_loss_W_K{0.05};

  template <class Self, class Visitor>
  static void parameters(Self& self, Visitor&& visit) {
    visit(self.conductance_W_K, Declaration{.name = "conductance_W_K",
                                            .symbol = "G_b",
                                            .unit = units::W_K,
                                            .range = {0.0, 1.0},
                                            .typical = 0.01,
                                            .null_value = 0.0,
                                            .prior_deviation = 0.02,
                                            .meaning = "heat from one wire to the body, per kelvin",
                                            .source = "conduction through a few millimetres of silicone"});
    visit(self.heat_capacity_J_K, Declaration{.name = "heat_capacity_J_K",
                                              .symbol = "C_b",
                                              .unit = units::J_K,
                                              .range = {0.05, 500.0},
                                              .typical = 8.0,
                                              .prior_deviation = 8.0,
                                              .meaning = "heat that warms the body by one kelvin",
                                              .source = "silicone 1.3 J/(g K), some grams of it near the wires"});
    visit(self.heat_loss_W_K, Declaration{.name = "heat_loss_W_K",
                                          .symbol = "h_b",
                                          .unit = units::W_K,
                                          .range = {0.0, 5.0},
                                          .typical = 0.05,
                                          .prior_deviation = 0.05,
                                          .meaning = "heat that the body loses to the surroundings, per kelvin",
                                          .source = "natural convection over the body's surface"});
  }

  void rest(const Instant<S>& now, std::size_t, S* own) const { own[0] = now.ambient_temperature_degC; }
  void heat(Instant<S>& now, std::size_t segment, const S* own) const {
    for (const std::size_t j : now.shape().coils_of[segment])
      now.heat_W[j] = now.heat_W[j] - conductance_W_K * (now.temperature_degC[j] - own[0]);
    now.heat_to_surroundings_W += heat_loss_W_K * (own[0] - now.ambient_temperature_degC);
  }
  void rates(const Instant<S>& now, std::size_t segment, const S* own, S* rate) const {
    S into_body_W = -heat_loss_W_K * (own[0] - now.ambient_temperature_degC);
    for (const std::size_t j : now.shape().coils_of[segment]) into_body_W += conductance_W_K * (now.temperature_degC[j] - own[0]);
    rate[0] = into_body_W / heat_capacity_J_K;
  }
  S stored_heat_J(const Instant<S>&, std::size_t, const S* own) const { return heat_capacity_J_K * own[0]; }
};

}  // namespace sinew::plant

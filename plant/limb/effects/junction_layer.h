// SPDX-License-Identifier: Apache-2.0
// A layer round each junction (junction.h), such as a soft adhesive over the epoxy: it takes up the junction's heat and gives it
// back, so that the thermocouple cools fast at first and slowly later.
//
//   C_y dT_y,j/dt = G_y (T_x,j - T_y,j) - h_y (T_y,j - T_inf);   each junction loses G_y (T_x,j - T_y,j)
//
// Source: lumped heat capacity; Incropera et al., 6th ed. (2007), section 5.1. "A soft adhesive over" the thermocouple's epoxy:
// Sabelhaus et al. 2022, methods. A layer round the working wire is sheath_heat_storage.h.
#pragma once

#include "plant/limb/instant.h"

namespace sinew::plant {

template <class S>
struct JunctionLayer {
  static constexpr std::string_view name = "junction_layer";
  static constexpr Place place = Place::sensor_temperature;
  static constexpr Part part = Part::thermocouple;
  static constexpr std::string_view needs = "junction";
  static constexpr std::string_view equation = "C_y dT_y,j/dt = G_y (T_x,j - T_y,j) - h_y (T_y,j - T_inf)";
  static constexpr std::string_view words = "a layer round the body that the thermocouple shows stores heat and gives it back";
  static constexpr std::array states{StateDeclaration{"temperature_{}_degC", units::degC, 20.0}};

  S conductance_W_K{0.0};
  S heat_capacity_J_K{0.5};
  S heat_loss_W_K{0.01};

  template <class Self, class Visitor>
  static void parameters(Self& self, Visitor&& visit) {
    visit(self.conductance_W_K, Declaration{.name = "conductance_W_K",
                                            .symbol = "G_y",
                                            .unit = units::W_K,
                                            .range = {0.0, 1.0},
                                            .typical = 0.03,
                                            .null_value = 0.0,
                                            .prior_deviation = 0.04,
                                            .meaning = "heat from a junction to the layer round it, per kelvin",
                                            .source = "conduction through a millimetre of soft adhesive"});
    visit(self.heat_capacity_J_K, Declaration{.name = "heat_capacity_J_K",
                                              .symbol = "C_y",
                                              .unit = units::J_K,
                                              .range = {0.02, 20.0},
                                              .typical = 0.5,
                                              .prior_deviation = 0.5,
                                              .meaning = "heat that warms one layer by one kelvin",
                                              .source = "1.3 J/(g K), some tenths of a gram"});
    visit(self.heat_loss_W_K, Declaration{.name = "heat_loss_W_K",
                                          .symbol = "h_y",
                                          .unit = units::W_K,
                                          .range = {0.0, 1.0},
                                          .typical = 0.01,
                                          .prior_deviation = 0.02,
                                          .meaning = "heat that a layer loses to the surroundings, per kelvin",
                                          .source = "natural convection over its surface"});
  }

  S junction_degC(const Instant<S>& now, std::size_t coil) const {
    return now.sensor_is_on_wire[coil] ? now.temperature_degC[coil] : now.sensor_body_degC[coil];
  }

  // At rest the layer is where its heat in equals its heat out.
  void rest(const Instant<S>& now, std::size_t coil, S* own) const {
    const S above = junction_degC(now, coil) - now.ambient_temperature_degC;
    own[0] = now.ambient_temperature_degC + conductance_W_K / (conductance_W_K + heat_loss_W_K + 1e-12) * above;
  }
  void heat(Instant<S>& now, std::size_t coil, const S* own) const {
    const S flow_W = conductance_W_K * (junction_degC(now, coil) - own[0]);
    now.sensor_body_heat_W[coil] = now.sensor_body_heat_W[coil] - flow_W;
    if (now.sensor_is_on_wire[coil]) now.heat_W[coil] = now.heat_W[coil] - flow_W;
    now.heat_to_surroundings_W += heat_loss_W_K * (own[0] - now.ambient_temperature_degC);
  }
  void rates(const Instant<S>& now, std::size_t coil, const S* own, S* rate) const {
    rate[0] = (conductance_W_K * (junction_degC(now, coil) - own[0]) - heat_loss_W_K * (own[0] - now.ambient_temperature_degC)) /
              heat_capacity_J_K;
  }
  S stored_heat_J(const Instant<S>&, std::size_t, const S* own) const { return heat_capacity_J_K * own[0]; }
};

}  // namespace sinew::plant

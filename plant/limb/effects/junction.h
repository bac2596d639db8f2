// SPDX-License-Identifier: Apache-2.0
// The thermocouple does not sit on the wire that works. It sits on a body of its own: turns of the coil that lie outside, and the
// epoxy that holds the bead. This junction is heated by its share of the current, cools by itself, and is joined to the working
// wire by conduction.
//
//   C_x dT_x,j/dt = s P_j + G_x (T_j - T_x,j) - r_x C_x (T_x,j - T_inf),   s = q_x C_x / (C + C_x), at most 1,   reading: T_x,j
//   the working wire: C_j dT_j/dt = (1 - s) P_j - G_x (T_j - T_x,j) - ...
//
// C is the mean heat capacity of the wires: how many turns lie outside does not depend on how heavy one coil's wire is, so that coils
// with equal junctions have equal shares. Without heat capacity the junction takes no current
// and loses no heat: T_x is T, and nothing is changed (but by what another effect hangs on it, junction_layer.h). Near there,
// where C_x/G_x is short, the same to first order: T_x = T - (C_x (dT/dt + r_x (T - T_inf)) - s P + what is hung on it)/G_x, and the wire
// has the heat capacity C + C_x and loses r_x C_x (T - T_inf) more.
//
// Source: lumped heat balance of two bodies; Incropera et al., 6th ed. (2007), section 5.1. How such limbs are built: two or
// three turns of each coil behind the base, a thermocouple on them with epoxy "in rather large amounts" (Sabelhaus et al. 2022,
// methods). Leaves out that turns outside do not transform.
#pragma once

#include "plant/limb/instant.h"

namespace sinew::plant {

template <class S>
struct Junction {
  static constexpr std::string_view name = "junction";
  static constexpr Place place = Place::sensor_temperature;
  static constexpr Part part = Part::thermocouple;
  static constexpr std::string_view argument = "memory of temperature";
  static constexpr std::string_view equation =
      "C_x dT_x,j/dt = s P_j + G_x (T_j - T_x,j) - r_x C_x (T_x,j - T_inf), T_m,j = T_x,j, s = min(1, q_x C_x / (C + C_x))";
  static constexpr std::string_view words =
      "the thermocouple shows a body of its own (epoxy, turns outside) that is joined to the wire, not the wire";
  // Once the thermocouple sits on the junction, nothing shows the wire's own heat balance directly, nor when it transforms.
  static constexpr std::array hides{Hidden{"heat_capacity", 2.0}, Hidden{"heat_loss", 2.0}, Hidden{"transformation_time", 2.0}};
  static constexpr std::array states{StateDeclaration{"temperature_{}_degC", units::degC, 20.0}};

  S heat_capacity_J_K{0.0};
  S conductance_W_K{0.08};
  S relative_power{0.5};
  S cooling_rate_1_s{0.02};

  template <class Self, class Visitor>
  static void parameters(Self& self, Visitor&& visit) {
    visit(self.heat_capacity_J_K, Declaration{.name = "heat_capacity_J_K",
                                              .symbol = "C_x",
                                              .unit = units::J_K,
                                              .range = {0.0, 10.0},
                                              .typical = 0.4,
                                              .null_value = 0.0,
                                              .prior_deviation = 0.4,
                                              .meaning = "heat that warms one junction by one kelvin",
                                              .source = "a quarter of a gram of epoxy, 1.2 J/(g K), and 0.1 g of wire"});
    visit(self.conductance_W_K, Declaration{.name = "conductance_W_K",
                                            .symbol = "G_x",
                                            .unit = units::W_K,
                                            .range = {0.001, 2.0},
                                            .typical = 0.08,
                                            .prior_deviation = 0.8,
                                            .meaning = "heat from the working wire to its junction, per kelvin",
                                            .source = "epoxy of 1 W/(m K) over some millimetres; next to none between bare turns"});
    visit(self.relative_power,
          Declaration{.name = "relative_power",
                      .symbol = "q_x",
                      .unit = units::none,
                      .range = {0.0, 10.0},
                      .typical = 0.5,
                      .prior_deviation = 0.5,
                      .meaning =
                          "the junction's share of the coil's current heat, over its share of their heat capacity (of the wires, the mean)",
                      .source = "0 for a body without current, 1 where both are bare wire"});
    visit(self.cooling_rate_1_s,
          Declaration{.name = "cooling_rate_1_s",
                      .symbol = "r_x",
                      .unit = units::per_s,
                      .range = {0.0, 2.0},
                      .typical = 0.02,
                      .prior_deviation = 0.03,
                      .meaning = "heat that the junction loses to the surroundings, per kelvin, over its heat capacity",
                      .source = "natural convection over a few millimetres of epoxy"});
  }

  bool follows_at_once() const { return value_of(heat_capacity_J_K) < Smoothing::shortest_lag_s * value_of(conductance_W_K); }
  S power_W(const Instant<S>& now, std::size_t coil) const {
    const S share = relative_power * heat_capacity_J_K / (now.mean_heat_capacity_J_K + heat_capacity_J_K);
    return value_of(share) < 1.0 ? share * now.joule_heat_W[coil] : now.joule_heat_W[coil];
  }
  S loss_W(const Instant<S>& now, const S& temperature_degC) const {
    return cooling_rate_1_s * heat_capacity_J_K * (temperature_degC - now.ambient_temperature_degC);
  }

  void rest(const Instant<S>& now, std::size_t coil, S* own) const { own[0] = now.temperature_degC[coil]; }
  void environment(Instant<S>& now, std::size_t coil, const S* own) const {
    now.sensor_body_heat_W[coil] = S(0.0);
    if (follows_at_once()) return;
    now.sensor_is_on_wire[coil] = false;
    now.sensor_body_degC[coil] = own[0];
  }
  void heat(Instant<S>& now, std::size_t coil, const S* own) const {
    if (follows_at_once()) {
      const S loss = loss_W(now, now.temperature_degC[coil]);
      now.heat_W[coil] = now.heat_W[coil] - loss;
      now.heat_to_surroundings_W += loss;
      now.heat_capacity_J_K[coil] += heat_capacity_J_K;
      return;
    }
    const S power = power_W(now, coil), to_junction = conductance_W_K * (now.temperature_degC[coil] - own[0]);
    const S loss = loss_W(now, own[0]);
    now.heat_W[coil] = now.heat_W[coil] - power - to_junction;
    now.sensor_body_heat_W[coil] += power + to_junction - loss;
    now.heat_to_surroundings_W += loss;
  }
  // After `heat`, in which what hangs on the junction has taken its part.
  void sensor_body(Instant<S>& now, std::size_t coil) const {
    if (!follows_at_once()) now.sensor_body_rate_K_s[coil] = now.sensor_body_heat_W[coil] / heat_capacity_J_K;
  }
  void rates(const Instant<S>& now, std::size_t coil, const S*, S* rate) const {
    rate[0] = follows_at_once() ? now.temperature_rate_K_s[coil] : now.sensor_body_rate_K_s[coil];
  }
  void reading(Instant<S>& now, std::size_t coil, const S* own) const {
    if (follows_at_once()) {
      const S into_junction_W = heat_capacity_J_K * now.temperature_rate_K_s[coil] + loss_W(now, now.temperature_degC[coil]);
      now.shown_temperature_degC[coil] =
          now.shown_temperature_degC[coil] - (into_junction_W - power_W(now, coil) - now.sensor_body_heat_W[coil]) / conductance_W_K;
    } else {
      now.shown_temperature_degC[coil] = own[0];
    }
  }
  S stored_heat_J(const Instant<S>&, std::size_t, const S* own) const { return heat_capacity_J_K * own[0]; }
};

}  // namespace sinew::plant

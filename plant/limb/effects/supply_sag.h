// SPDX-License-Identifier: Apache-2.0
// The supply's voltage falls with the current that both wires draw.
//
//   V = V_s - R_src I,  I = sum_j u_j V / R_j      so that  V = V_s / (1 + R_src sum_j u_j / R_j)
//
// Source: Thevenin source; docs/plant.md, section 2, with I the current that flows at the sagged voltage.
// Leaves out the ripple within a PWM period: currents are their means.
#pragma once

#include "plant/limb/instant.h"

namespace sinew::plant {

template <class S>
struct SupplySag {
  static constexpr std::string_view name = "supply_sag";
  static constexpr Place place = Place::actuation;
  static constexpr Part part = Part::supply;
  static constexpr std::string_view equation = "V_s -> V_s - R_src I, I the summed mean current of all wires";
  static constexpr std::string_view words = "the supply voltage sags under load";
  static constexpr std::string_view argument = "duty";

  S source_resistance_Ohm{0.0};

  template <class Self, class Visitor>
  static void parameters(Self& self, Visitor&& visit) {
    visit(self.source_resistance_Ohm, Declaration{.name = "source_resistance_Ohm",
                                                  .symbol = "R_src",
                                                  .unit = units::Ohm,
                                                  .range = {0.0, 5.0},
                                                  .typical = 0.2,
                                                  .null_value = 0.0,
                                                  .prior_deviation = 0.3,
                                                  .meaning = "inner resistance of the supply, its leads and the switch",
                                                  .source = "bench supply and leads"});
  }

  void electrics(Instant<S>& now, std::size_t) const {
    S conductance(0.0);
    for (std::size_t j = 0; j < now.duty_fraction.size(); ++j) conductance += now.duty_fraction[j] / now.resistance_Ohm[j];
    now.supply_voltage_V = now.supply_voltage_V / (1.0 + source_resistance_Ohm * conductance);
  }
};

}  // namespace sinew::plant

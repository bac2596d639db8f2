// SPDX-License-Identifier: Apache-2.0
// The bead of epoxy that holds a thermocouple on its wire has to be warmed first.
//
//   tau_s dT_m/dt = T - T_m,   reading: T_m
//
// Source: first-order sensor; Doebelin, Measurement Systems, 5th ed. (2004), section 3.3.
// Leaves out what drains through the leads (thermocouple_heat_sink.h) and the heat the bead takes from the wire.
#pragma once

#include "plant/instant.h"

namespace sinew::plant {

template <class S>
struct ThermocoupleLag {
  static constexpr std::string_view name = "thermocouple_lag";
  static constexpr Place place = Place::sensor_temperature;
  static constexpr std::string_view equation = "tau_s dT_m/dt = T - T_m";
  static constexpr std::string_view words = "the thermocouple's epoxy bead follows the wire late";
  static constexpr std::array states{StateDeclaration{"temperature_A_degC", units::degC, 20.0},
                                     StateDeclaration{"temperature_B_degC", units::degC, 20.0}};

  S time_constant_s{0.0};

  template <class Self, class Visitor>
  static void parameters(Self& self, Visitor&& visit) {
    visit(self.time_constant_s,
          Declaration{.name = "time_constant_s", .symbol = "tau_s", .unit = units::s, .range = {0.0, 30.0}, .typical = 1.5,
                      .null_value = 0.0, .prior_deviation = 3.0, .meaning = "time constant of the bead",
                      .source = "epoxy bead of a few millimetres"});
  }

  void rest(const Instant<S>& now, S* own) const {
    for (const std::size_t j : coils) own[j] = now.temperature_degC[j];
  }
  void rates(const Instant<S>& now, const S* own, S* rate) const {
    for (const std::size_t j : coils)
      rate[j] = value_of(time_constant_s) < Smoothing::shortest_lag_s
                    ? now.temperature_rate_K_s[j]
                    : (now.temperature_degC[j] - own[j]) / time_constant_s;
  }
  void reading(const Instant<S>& now, const S* own, Reading<S>& shown) const {
    for (const std::size_t j : coils)
      shown.temperature_degC[j] = value_of(time_constant_s) < Smoothing::shortest_lag_s
                                      ? now.temperature_degC[j] - time_constant_s * now.temperature_rate_K_s[j]
                                      : own[j];
  }
};

}  // namespace sinew::plant

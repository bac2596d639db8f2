// SPDX-License-Identifier: Apache-2.0
// The bead of epoxy that holds a thermocouple on its wire has to be warmed first.
//
//   tau_s dT_m/dt = T - T_m,   reading: T_m
//
// Source: first-order sensor; Doebelin, Measurement Systems, 5th ed. (2004), section 3.3.
// Leaves out what drains through the leads (thermocouple_heat_sink.h) and the heat the bead takes from the wire.
#pragma once

#include "plant/limb/instant.h"

namespace sinew::plant {

template <class S>
struct ThermocoupleLag {
  static constexpr std::string_view name = "thermocouple_lag";
  static constexpr Place place = Place::sensor_temperature;
  static constexpr Part part = Part::thermocouple;
  static constexpr std::string_view equation = "tau_s dT_m/dt = T - T_m";
  static constexpr std::string_view words = "the thermocouple's epoxy bead follows the wire late";
  static constexpr std::string_view argument = "rate of temperature";
  static constexpr std::array states{StateDeclaration{"temperature_{}_degC", units::degC, 20.0}};

  S time_constant_s{0.0};

  template <class Self, class Visitor>
  static void parameters(Self& self, Visitor&& visit) {
    visit(self.time_constant_s, Declaration{.name = "time_constant_s",
                                            .symbol = "tau_s",
                                            .unit = units::s,
                                            .range = {0.0, 30.0},
                                            .typical = 1.5,
                                            .null_value = 0.0,
                                            .prior_deviation = 3.0,
                                            .meaning = "time constant of the bead",
                                            .source = "epoxy bead of a few millimetres"});
  }

  void rest(const Instant<S>& now, std::size_t coil, S* own) const { own[0] = followed_degC(now, coil); }
  // Of the wire, or of the body that the thermocouple sits on.
  static const S& followed_degC(const Instant<S>& now, std::size_t coil) {
    return now.sensor_is_on_wire[coil] ? now.temperature_degC[coil] : now.sensor_body_degC[coil];
  }
  static const S& followed_rate_K_s(const Instant<S>& now, std::size_t coil) {
    return now.sensor_is_on_wire[coil] ? now.temperature_rate_K_s[coil] : now.sensor_body_rate_K_s[coil];
  }
  void rates(const Instant<S>& now, std::size_t coil, const S* own, S* rate) const {
    rate[0] = value_of(time_constant_s) < Smoothing::shortest_lag_s ? followed_rate_K_s(now, coil)
                                                                    : (followed_degC(now, coil) - own[0]) / time_constant_s;
  }
  void reading(Instant<S>& now, std::size_t coil, const S* own) const {
    now.shown_temperature_degC[coil] = value_of(time_constant_s) < Smoothing::shortest_lag_s
                                           ? now.shown_temperature_degC[coil] - time_constant_s * followed_rate_K_s(now, coil)
                                           : own[0];
  }
};

}  // namespace sinew::plant

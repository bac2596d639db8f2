// SPDX-License-Identifier: Apache-2.0
// The thermocouple follows late through two lags in a row: a sleeve, and the bead in it. Another form of `thermocouple_lag`.
//
//   tau_1 dT_1/dt = T - T_1,   r tau_1 dT_m/dt = T_1 - T_m,   reading: T_m
//
// Source: two thermal lags of a sheathed probe; Doebelin, Measurement Systems, 5th ed. (2004), section 8.7.
#pragma once

#include "plant/limb/effects/thermocouple_lag.h"

namespace sinew::plant {

template <class S>
struct ThermocoupleTwoLags {
  static constexpr std::string_view name = "thermocouple_two_lags";
  static constexpr std::string_view form_of = "thermocouple_lag";
  static constexpr Place place = Place::sensor_temperature;
  static constexpr Part part = Part::thermocouple;
  static constexpr std::string_view equation = "tau_1 dT_1/dt = T - T_1, r tau_1 dT_m/dt = T_1 - T_m";
  static constexpr std::string_view words = "the thermocouple follows the wire late, through two lags in a row";
  static constexpr std::array states{StateDeclaration{"sleeve_{}_degC", units::degC, 20.0},
                                     StateDeclaration{"bead_{}_degC", units::degC, 20.0}};

  S time_constant_s{0.0}, second_share{0.5};

  template <class Self, class Visitor>
  static void parameters(Self& self, Visitor&& visit) {
    visit(self.time_constant_s, Declaration{.name = "time_constant_s",
                                            .symbol = "tau_1",
                                            .unit = units::s,
                                            .range = {0.0, 30.0},
                                            .typical = 1.0,
                                            .null_value = 0.0,
                                            .prior_deviation = 2.0,
                                            .meaning = "time constant of the longer lag",
                                            .source = "epoxy bead of a few millimetres"});
    visit(self.second_share, Declaration{.name = "second_share",
                                         .symbol = "r",
                                         .unit = units::none,
                                         .range = {0.02, 1.0},
                                         .typical = 0.5,
                                         .prior_deviation = 0.3,
                                         .meaning = "the shorter lag's time constant over the longer's",
                                         .source = "sleeve and bead of one material: as their sizes, squared"});
  }

  bool follows() const { return value_of(time_constant_s) >= Smoothing::shortest_lag_s; }
  void rest(const Instant<S>& now, std::size_t coil, S* own) const { own[0] = own[1] = ThermocoupleLag<S>::followed_degC(now, coil); }
  void rates(const Instant<S>& now, std::size_t coil, const S* own, S* rate) const {
    if (follows()) {
      rate[0] = (ThermocoupleLag<S>::followed_degC(now, coil) - own[0]) / time_constant_s;
      rate[1] = (own[0] - own[1]) / (second_share * time_constant_s);
    } else {
      rate[0] = rate[1] = ThermocoupleLag<S>::followed_rate_K_s(now, coil);
    }
  }
  void reading(Instant<S>& now, std::size_t coil, const S* own) const {
    now.shown_temperature_degC[coil] = follows()
                                           ? own[1]
                                           : S(now.shown_temperature_degC[coil] -
                                               (1.0 + second_share) * time_constant_s * ThermocoupleLag<S>::followed_rate_K_s(now, coil));
  }
};

}  // namespace sinew::plant

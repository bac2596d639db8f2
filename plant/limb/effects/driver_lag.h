// SPDX-License-Identifier: Apache-2.0
// The current follows the duty late: the driver's gate, the filter of its supply. Another form of `input_delay`.
//
//   tau_u du_l/dt = u - u_l,   u -> u_l
//
// Source: first-order low pass; Horowitz, Hill, The Art of Electronics, 3rd ed. (2015), section 1.7.
#pragma once

#include "plant/limb/instant.h"

namespace sinew::plant {

template <class S>
struct DriverLag {
  static constexpr std::string_view name = "driver_lag";
  static constexpr std::string_view form_of = "input_delay";
  static constexpr Place place = Place::actuation;
  static constexpr Part part = Part::coil;
  static constexpr std::string_view equation = "tau_u du_l/dt = u - u_l, u -> u_l";
  static constexpr std::string_view words = "commands act late, through a lag of the driver";
  static constexpr std::array states{StateDeclaration{"duty_{}_fraction", units::none, 0.1}};

  S time_constant_s{0.0};

  template <class Self, class Visitor>
  static void parameters(Self& self, Visitor&& visit) {
    visit(self.time_constant_s, Declaration{.name = "time_constant_s",
                                            .symbol = "tau_u",
                                            .unit = units::s,
                                            .range = {0.0, 5.0},
                                            .typical = 0.3,
                                            .null_value = 0.0,
                                            .prior_deviation = 0.3,
                                            .meaning = "time constant of the driver",
                                            .source = "gate resistor and filter of a MOSFET module"});
  }

  bool follows() const { return value_of(time_constant_s) >= Smoothing::shortest_lag_s; }
  void rest(const Instant<S>& now, std::size_t coil, S* own) const { own[0] = S(now.given->input(coil)); }
  void electrics(Instant<S>& now, std::size_t coil, const S* own) const {
    if (follows()) now.duty_fraction[coil] = own[0];
  }
  void rates(const Instant<S>& now, std::size_t coil, const S* own, S* rate) const {
    rate[0] = (now.given->input(coil) - own[0]) / (follows() ? time_constant_s : S(Smoothing::shortest_lag_s));
  }
};

}  // namespace sinew::plant

// SPDX-License-Identifier: Apache-2.0
// The bend sensor follows late, by a filter of second order: it rings where the damping is below one, and is two lags in a row above.
// Another form of `angle_sensor_lag`.
//
//   tau^2 d2theta_m/dt2 + 2 zeta tau dtheta_m/dt + theta_m = theta,   reading: theta_m
//
// Source: second-order sensor; Doebelin, Measurement Systems, 5th ed. (2004), section 3.3.
#pragma once

#include "plant/limb/instant.h"

namespace sinew::plant {

template <class S>
struct AngleSensorSecondOrder {
  static constexpr std::string_view name = "angle_sensor_second_order";
  static constexpr std::string_view form_of = "angle_sensor_lag";
  static constexpr Place place = Place::sensor_angle;
  static constexpr Part part = Part::bend_sensor;
  static constexpr std::string_view equation = "tau^2 d2theta_m/dt2 + 2 zeta tau dtheta_m/dt + theta_m = theta";
  static constexpr std::string_view words = "the bend sensor follows the limb late, by a filter of second order";
  static constexpr std::array states{StateDeclaration{"angle_{}_rad", units::rad, 0.3},
                                     StateDeclaration{"angular_velocity_{}_rad_s", units::rad_s, 0.5}};

  S time_s{0.0}, damping{0.7};

  template <class Self, class Visitor>
  static void parameters(Self& self, Visitor&& visit) {
    visit(self.time_s, Declaration{.name = "time_s",
                                   .symbol = "tau",
                                   .unit = units::s,
                                   .range = {0.0, 10.0},
                                   .typical = 0.3,
                                   .null_value = 0.0,
                                   .prior_deviation = 0.5,
                                   .meaning = "one over the filter's angular frequency",
                                   .source = "sensor's own filter"});
    visit(self.damping, Declaration{.name = "damping",
                                    .symbol = "zeta",
                                    .unit = units::none,
                                    .range = {0.1, 5.0},
                                    .typical = 0.7,
                                    .prior_deviation = 0.4,
                                    .meaning = "damping ratio of the filter",
                                    .source = "Butterworth filter: 0.7; two equal lags in a row: 1"});
  }

  bool follows() const { return value_of(time_s) >= Smoothing::shortest_lag_s; }
  void rest(const Instant<S>& now, std::size_t bend, S* own) const {
    own[0] = now.angle_rad[bend];
    own[1] = S(0.0);
  }
  void rates(const Instant<S>& now, std::size_t bend, const S* own, S* rate) const {
    if (follows()) {
      rate[0] = own[1];
      rate[1] = ((now.angle_rad[bend] - own[0]) / time_s - 2.0 * damping * own[1]) / time_s;
    } else {
      rate[0] = now.angular_velocity_rad_s[bend];
      rate[1] = (now.angular_velocity_rad_s[bend] - own[1]) / Smoothing::shortest_lag_s;
    }
  }
  void reading(Instant<S>& now, std::size_t bend, const S* own) const {
    now.shown_angle_rad[bend] = follows() ? own[0] : S(now.angle_rad[bend] - 2.0 * damping * time_s * now.angular_velocity_rad_s[bend]);
  }
};

}  // namespace sinew::plant

// SPDX-License-Identifier: Apache-2.0
// The bend sensor follows late: its own filter, or silicone that slides over it.
//
//   tau_theta dtheta_m/dt = theta - theta_m,   reading: theta_m
//
// Source: first-order sensor; Doebelin, Measurement Systems, 5th ed. (2004), section 3.3.
#pragma once

#include "plant/limb/instant.h"

namespace sinew::plant {

template <class S>
struct AngleSensorLag {
  static constexpr std::string_view name = "angle_sensor_lag";
  static constexpr Place place = Place::sensor_angle;
  static constexpr Part part = Part::bend_sensor;
  static constexpr std::string_view equation = "tau_theta dtheta_m/dt = theta - theta_m";
  static constexpr std::string_view words = "the bend sensor follows the limb late";
  static constexpr std::string_view argument = "angular velocity";
  static constexpr std::array states{StateDeclaration{"angle_{}_rad", units::rad, 0.3}};

  S time_constant_s{0.0};

  template <class Self, class Visitor>
  static void parameters(Self& self, Visitor&& visit) {
    visit(self.time_constant_s, Declaration{.name = "time_constant_s",
                                            .symbol = "tau_theta",
                                            .unit = units::s,
                                            .range = {0.0, 30.0},
                                            .typical = 0.4,
                                            .null_value = 0.0,
                                            .prior_deviation = 1.0,
                                            .meaning = "time constant of the bend sensor",
                                            .source = "sensor's own filter"});
  }

  void rest(const Instant<S>& now, std::size_t bend, S* own) const { own[0] = now.angle_rad[bend]; }
  void rates(const Instant<S>& now, std::size_t bend, const S* own, S* rate) const {
    rate[0] = value_of(time_constant_s) < Smoothing::shortest_lag_s ? now.angular_velocity_rad_s[bend]
                                                                    : S((now.angle_rad[bend] - own[0]) / time_constant_s);
  }
  void reading(Instant<S>& now, std::size_t bend, const S* own) const {
    now.shown_angle_rad[bend] = value_of(time_constant_s) < Smoothing::shortest_lag_s
                                    ? S(now.angle_rad[bend] - time_constant_s * now.angular_velocity_rad_s[bend])
                                    : own[0];
  }
};

}  // namespace sinew::plant

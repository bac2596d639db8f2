// SPDX-License-Identifier: Apache-2.0
// The bend sensor's zero moves steadily.
//
//   theta_m = theta + d_theta t,  t since the first recording began
//
// Source: docs/plant.md, section 2. Leaves out everything but a straight line.
#pragma once

#include "plant/limb/instant.h"

namespace sinew::plant {

template <class S>
struct AngleSensorDrift {
  static constexpr std::string_view name = "angle_sensor_drift";
  static constexpr Place place = Place::sensor_angle;
  static constexpr Part part = Part::bend_sensor;
  static constexpr std::string_view equation = "theta_m = theta + d_theta t";
  static constexpr std::string_view words = "the bend sensor's zero drifts";

  static constexpr std::array states{StateDeclaration{"elapsed_{}_s", units::s, 100.0, AtStart::elapsed, 1800.0}};

  static constexpr std::string_view grown_words = "the zero of the bend sensor", grown_unit = "deg";

  S rate_rad_s{0.0};

  template <class Self, class Visitor>
  static void parameters(Self& self, Visitor&& visit) {
    visit(self.rate_rad_s, Declaration{.name = "rate_deg_s",
                                       .symbol = "d_theta",
                                       .unit = units::deg_s,
                                       .range = {-1.0, 1.0},
                                       .typical = 0.005,
                                       .null_value = 0.0,
                                       .prior_deviation = 0.01,
                                       .meaning = "rate at which the reading drifts",
                                       .source = "a few degrees in ten minutes"});
  }

  void rest(const Instant<S>&, std::size_t, S* own) const { own[0] = S(0.0); }
  void reading(Instant<S>& now, std::size_t bend, const S* own) const {
    now.shown_angle_rad[bend] = now.shown_angle_rad[bend] + rate_rad_s * own[0];
  }
  void rates(const Instant<S>&, std::size_t, const S*, S* rate) const { rate[0] = S(1.0); }
};

}  // namespace sinew::plant

// SPDX-License-Identifier: Apache-2.0
// The limb runs against something.
//
//   moment -> moment - k_c (|theta| - theta_c)_+ sgn theta
//
// Source: linear contact; docs/plant.md, section 2. Leaves out friction and damping at the contact.
#pragma once

#include "plant/limb/instant.h"

namespace sinew::plant {

template <class S>
struct HardStop {
  static constexpr std::string_view name = "hard_stop";
  static constexpr Place place = Place::mechanics;
  static constexpr Part part = Part::bend;
  static constexpr std::string_view equation = "moment -> moment - k_c (|theta| - theta_c)_+ sgn theta";
  static constexpr std::string_view words = "the limb runs against a stop";
  static constexpr std::string_view argument = "angle";

  S stiffness_Nm_rad{0.0};
  S angle_rad{25.0 * radians_per_degree};

  template <class Self, class Visitor>
  static void parameters(Self& self, Visitor&& visit) {
    visit(self.stiffness_Nm_rad, Declaration{.name = "stiffness_Nm_rad",
                                             .symbol = "k_c",
                                             .unit = units::Nm_rad,
                                             .range = {0.0, 100.0},
                                             .typical = 0.2,
                                             .null_value = 0.0,
                                             .prior_deviation = 0.5,
                                             .meaning = "stiffness of the contact",
                                             .source = "a soft body on a bench"});
    visit(self.angle_rad, Declaration{.name = "angle_deg",
                                      .symbol = "theta_c",
                                      .unit = units::deg,
                                      .range = {1.0, 180.0},
                                      .typical = 25.0,
                                      .prior_deviation = 10.0,
                                      .meaning = "bend at which it touches"});
  }

  void moment(Instant<S>& now, std::size_t bend) const {
    const double side = value_of(now.angle_rad[bend]) < 0.0 ? -1.0 : 1.0;
    now.moment_Nm[bend] = now.moment_Nm[bend] - stiffness_Nm_rad * side * positive_part(S(side * now.angle_rad[bend] - angle_rad));
  }
};

}  // namespace sinew::plant

// SPDX-License-Identifier: Apache-2.0
// The limb is mounted off the horizontal plane, so that its weight bends it.
//
//   moment -> moment - m g l sin(theta + phi)
//
// Source: weight at the end of a lever; docs/plant.md, section 2.
#pragma once

#include "plant/limb/instant.h"

namespace sinew::plant {

template <class S>
struct GravityLoad {
  static constexpr std::string_view name = "gravity_load";
  static constexpr Place place = Place::mechanics;
  static constexpr Part part = Part::bend;
  static constexpr std::string_view equation = "moment -> moment - m g l sin(theta + phi)";
  static constexpr std::string_view words = "the limb's weight bends it";
  static constexpr std::string_view argument = "angle";

  S moment_Nm{0.0};
  S tilt_rad{20.0 * radians_per_degree};

  template <class Self, class Visitor>
  static void parameters(Self& self, Visitor&& visit) {
    visit(self.moment_Nm, Declaration{.name = "moment_Nm",
                                      .symbol = "m g l",
                                      .unit = units::Nm,
                                      .range = {0.0, 1.0},
                                      .typical = 0.01,
                                      .null_value = 0.0,
                                      .prior_deviation = 0.01,
                                      .meaning = "weight times lever",
                                      .source = "20 g at 5 cm is 0.01 N m"});
    visit(self.tilt_rad, Declaration{.name = "tilt_deg",
                                     .symbol = "phi",
                                     .unit = units::deg,
                                     .range = {-180.0, 180.0},
                                     .typical = 20.0,
                                     .prior_deviation = 60.0,
                                     .meaning = "angle from the plane of bending's vertical when the limb is straight"});
  }

  // The weight feels the angle to the room: that of this segment and of all before it.
  void moment(Instant<S>& now, std::size_t bend) const {
    using std::sin;
    S absolute_rad(0.0);
    for (const std::size_t before : now.shape().bends_before[bend]) absolute_rad += now.angle_rad[before];
    now.moment_Nm[bend] = now.moment_Nm[bend] - moment_Nm * sin(absolute_rad + tilt_rad);
  }
};

}  // namespace sinew::plant

// SPDX-License-Identifier: Apache-2.0
// The edge between what people write (degrees) and what the equations use (radians).
//
// Temperatures are in degrees Celsius on both sides of the edge: every law of the plant uses differences of
// temperature, which are the same in kelvin. Degrees are converted once, by the reader and the writer, through
// `Unit::internal_per_unit`.
#pragma once

#include <numbers>
#include <string_view>

namespace sinew::plant {

inline constexpr double radians_per_degree = std::numbers::pi / 180.0;

struct Unit {
  std::string_view text;           // as printed; empty for a plain number
  double internal_per_unit = 1.0;  // internal value = value in the file * this
};

namespace units {
inline constexpr Unit none{""}, degC{"degC"}, K{"K"}, s{"s"}, V{"V"}, Ohm{"Ohm"}, J{"J"}, J_K{"J/K"}, W_K{"W/K"}, K_s{"K/s"}, per_K{"1/K"},
    K_N{"K/N"}, N_m{"N/m"}, m{"m"}, Nm{"N*m"}, Nm_rad{"N*m/rad"}, Nm_rad3{"N*m/rad^3"}, Nms_rad{"N*m*s/rad"}, kgm2{"kg*m^2"}, rad{"rad"},
    per_rad2{"1/rad^2"}, rad_s{"rad/s"}, per_s{"1/s"}, kg{"kg"}, N{"N"}, Ns_m{"N*s/m"}, m_s{"m/s"}, N_V{"N/V"}, Ns2_m2{"N*s^2/m^2"},
    V_s{"V/s"}, V_V{"V/V"}, per_V{"1/V"}, per_V2{"1/V^2"}, sqrtV_s{"sqrt(V)/s"}, s2{"s^2"}, s2_V{"s^2/V"};
inline constexpr Unit deg{"deg", radians_per_degree}, deg_s{"deg/s", radians_per_degree};
}  // namespace units

}  // namespace sinew::plant

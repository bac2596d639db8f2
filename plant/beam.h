// SPDX-License-Identifier: Apache-2.0
// The silicone beam in one bending mode of constant curvature, and how far each coil is stretched by its bend.
//
//   delta_A = delta_0 - sign r_A theta,   delta_B = delta_0 + sign r_B theta
//   J domega/dt = sign (r_A F_A - r_B F_B) - c omega - k_b theta
//
// Source: docs/plant.md, section 1; constant curvature as in Webster and Jones 2010.
#pragma once

#include "plant/core.h"

namespace sinew::plant {

template <class S>
S coil_stretch_m(std::size_t coil, const Core<S>& core, const S& angle_rad) {
  const S shortening_m = core.bend_sign * core.moment_arm_m[coil] * angle_rad;
  return coil == A ? S(core.coil_stretch_m - shortening_m) : S(core.coil_stretch_m + shortening_m);
}

template <class S>
S beam_moment_Nm(const Core<S>& core, const PerCoil<S>& tension_N, const S& angle_rad, const S& angular_velocity_rad_s) {
  return core.bend_sign * (core.moment_arm_m[A] * tension_N[A] - core.moment_arm_m[B] * tension_N[B]) -
         core.beam_damping_Nms_rad * angular_velocity_rad_s - core.beam_stiffness_Nm_rad * angle_rad;
}

}  // namespace sinew::plant

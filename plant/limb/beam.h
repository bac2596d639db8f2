// SPDX-License-Identifier: Apache-2.0
// Silicone beams of constant curvature, and how far each coil is stretched by their bends.
//
//   delta_j = delta_0 - sum_b sign_b r_j theta_b cos(direction_j - axis_b)            b: bends of the coil's segment
//   J domega_b/dt = sign_b sum_j r_j F_j cos(direction_j - axis_b) - c omega_b - k_b theta_b
//
// With coils A at 0 and B at 180 degrees: sign (r_A F_A - r_B F_B) - c omega - k_b theta.
//
// Source: docs/plant.md, section 1; constant curvature as in Webster and Jones 2010. Segments in series: each angle is
// relative to the segment before; the inertial coupling between them is left out (light limbs, slow motion).
#pragma once

#include "plant/limb/instant.h"

namespace sinew::plant {

template <class S>
void stretch_coils(Instant<S>& now) {
  const Core<S>& core = *now.core;
  for (std::size_t j = 0; j < now.stretch_m.size(); ++j) now.stretch_m[j] = core.coil_stretch_m[j];
  for (const auto& [j, b, cosine] : core.shape->couplings)
    now.stretch_m[j] = now.stretch_m[j] - core.bend_sign[b] * core.moment_arm_m[j] * now.angle_rad[b] * cosine;
}

template <class S>
void bend_beams(Instant<S>& now) {
  const Core<S>& core = *now.core;
  const Shape& shape = *core.shape;
  for (S& moment_Nm : now.moment_Nm) moment_Nm = S(0.0);
  for (const auto& [j, b, cosine] : shape.couplings) now.moment_Nm[b] = now.moment_Nm[b] + core.moment_arm_m[j] * now.tension_N[j] * cosine;
  for (std::size_t b = 0; b < shape.bends.size(); ++b) {
    const std::size_t s = shape.bends[b].segment;
    now.moment_Nm[b] = core.bend_sign[b] * now.moment_Nm[b] - core.beam_damping_Nms_rad[s] * now.angular_velocity_rad_s[b] -
                       core.beam_stiffness_Nm_rad[s] * now.angle_rad[b];
  }
}

}  // namespace sinew::plant

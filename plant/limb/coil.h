// SPDX-License-Identifier: Apache-2.0
// One coil: a spring that is softer, and longer by delta_t, when its wire is martensite.
//
//   k(xi) = k_a + xi (k_m - k_a)        F = k(xi) (delta - longer_share delta_t)
//
// Source: docs/plant.md, section 1. In the core the share of delta_t that is there is xi itself.
#pragma once

#include "plant/scalar.h"

namespace sinew::plant {

template <class S>
S coil_stiffness_N_m(const S& martensite_fraction, const S& austenite_stiffness_N_m, const S& martensite_stiffness_N_m) {
  return austenite_stiffness_N_m + martensite_fraction * (martensite_stiffness_N_m - austenite_stiffness_N_m);
}

template <class S>
S coil_tension_N(const S& stiffness_N_m, const S& stretch_m, const S& longer_share, const S& transformation_stretch_m) {
  return stiffness_N_m * (stretch_m - longer_share * transformation_stretch_m);
}

}  // namespace sinew::plant

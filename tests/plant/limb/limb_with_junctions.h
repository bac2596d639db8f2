// SPDX-License-Identifier: Apache-2.0
// A limb whose thermocouples sit on junctions, for the tests of these and of what hangs on them.
#pragma once

#include "tests/plant/limb/one_instant.h"

namespace sinew::test {

// With a wire of 0.85 J/K it has 0.15 of their heat capacity, takes twice that, 0.3, of the current's heat, and loses 0.006 W/K.
inline plant::Plant limb_with_junctions(double heat_capacity_J_K = 0.15) {
  return limb_with("junction", {{"heat_capacity_J_K", heat_capacity_J_K},
                                {"conductance_W_K", 0.05},
                                {"relative_power", 2.0},
                                {"cooling_rate_1_s", 0.04}});
}

}  // namespace sinew::test

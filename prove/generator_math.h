// SPDX-License-Identifier: Apache-2.0
// What the generator's limbs compute with: an angle's unit, and two functions of their equations.
#pragma once

#include <cmath>
#include <numbers>

namespace sinew::prove {

inline constexpr double degree = std::numbers::pi / 180.0;

inline double falling(double z) { return 1.0 / (1.0 + std::exp(z)); }
inline double positive(double x) { return x > 0.0 ? x : 0.0; }

}  // namespace sinew::prove

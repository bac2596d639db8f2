// SPDX-License-Identifier: Apache-2.0
// Numbers that the plants' equations are written in: double, or a ceres::Jet that carries derivatives along.
//
// The equations are templates on the scalar, so that Jacobians and sensitivities are those of the very code that is
// integrated, without differences. Functions here are those with a corner or an overflow to look after.
#pragma once

#include <ceres/jet.h>

#include <cmath>

// For functions full of Jets or small matrices, whose operators cost more as calls than the arithmetic in them. Not under a
// sanitizer, which puts a check into each operation: one function of them all then takes minutes to compile.
#if defined(__SANITIZE_ADDRESS__)
#define SINEW_FLATTEN
#else
#define SINEW_FLATTEN [[gnu::flatten]]
#endif

namespace sinew::plant {

// Derivatives that one pass carries; more take several passes. The only instantiation beside double: the equations are what
// takes longest to compile.
inline constexpr int jet_width = 16;
using Jet = ceres::Jet<double, jet_width>;

inline double value_of(double x) { return x; }
inline double value_of(const Jet& x) { return x.a; }

// max(0, x); its derivative at the corner is that of the zero side.
template <class S>
S positive_part(const S& x) {
  return value_of(x) > 0.0 ? x : S(0.0);
}

// 1 / (1 + exp(x)), without overflow in value or derivative for any x.
template <class S>
S falling_logistic(const S& x) {
  using std::exp;
  if (value_of(x) > 0.0) {
    const S e = exp(-x);
    return e / (1.0 + e);
  }
  return 1.0 / (1.0 + exp(x));
}

}  // namespace sinew::plant

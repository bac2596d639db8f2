// SPDX-License-Identifier: Apache-2.0
// One wire: the two envelopes of its transformation and the pull that keeps the fraction between them.
//
//   xi_heat(T) = 1 / (1 + exp((T - T_heat)/w_heat))
//   xi_cool(T) = 1 / (1 + exp((T - T_cool)/w_cool))
//   pull       = [ max(0, xi_cool - xi) - max(0, xi - xi_heat) ] / tau_xi
//
// Source: docs/plant.md, section 1; a play operator (Visintin, Differential Models of Hysteresis, 1994, chapter III) with
// logistic envelopes as in Ikuta, Tsukamoto, Hirose 1991, made Lipschitz by the finite rate 1/tau_xi.
#pragma once

#include "plant/scalar.h"

namespace sinew::plant {

template <class S>
struct Envelopes {
  S heating;  // highest fraction that can be held at this temperature
  S cooling;  // lowest
};

// Where the two cross (cooling above heating), both are their mean.
template <class S>
Envelopes<S> envelopes(const S& temperature_degC, const S& heating_midpoint_degC, const S& heating_width_K, const S& cooling_midpoint_degC,
                       const S& cooling_width_K) {
  const S heating = falling_logistic(S((temperature_degC - heating_midpoint_degC) / heating_width_K));
  const S cooling = falling_logistic(S((temperature_degC - cooling_midpoint_degC) / cooling_width_K));
  if (value_of(cooling) > value_of(heating)) {
    const S mean = 0.5 * (heating + cooling);
    return {mean, mean};
  }
  return {heating, cooling};
}

template <class S>
S pull_to_envelopes_1_s(const S& martensite_fraction, const Envelopes<S>& envelope, const S& transformation_time_s) {
  return (positive_part(S(envelope.cooling - martensite_fraction)) - positive_part(S(martensite_fraction - envelope.heating))) /
         transformation_time_s;
}

}  // namespace sinew::plant

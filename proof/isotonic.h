// SPDX-License-Identifier: Apache-2.0
// A map from the probability that was given to how often it came true, learnt from forecasts.
#pragma once

#include "proof/forecasts.h"

namespace sinew::proof {

// Never falls. Between knots straight in the log odds of what was given, constant beyond the first and the last.
struct MonotoneMap {
  std::vector<double> log_odds;   // of the probability given, ascending; of 0 and 1 infinite
  std::vector<double> frequency;  // never falling
  // NaN of a map without knots.
  double operator()(double probability) const;
};

// Isotonic regression by pooling adjacent violators (Ayer et al. 1955, Ann. Math. Stat. 26:641): the map that never falls and has the
// least Brier score on these forecasts. Each pool has two knots, at its least and at its greatest log odds, both at the share of it that
// came true: 0 or 1 where a pool at an end is all of one kind, which is more than few forecasts can know. No forecasts: no knots.
MonotoneMap isotonic(std::vector<Forecast> forecasts);

}  // namespace sinew::proof

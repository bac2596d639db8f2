// SPDX-License-Identifier: Apache-2.0
// Does the error of rollouts grow with time, beyond chance?
//
// Of each session, the slope b of least squares through the squared error over time, e^2(t) = a + b t, from the second minute on: in
// the first one the state, which one measured value does not show, still settles. Errors within a session go together, so that a
// session is one block: the interval is that of a bootstrap which draws sessions with replacement (Efron and Tibshirani 1993,
// chapters 6, 8 and 13). What is drawn is the ratio of the mean slope and the mean square.
#pragma once

#include <vector>

#include "model/series.h"

namespace sinew::model {

inline constexpr Index drift_from = 600;  // samples: what comes before is left out

// In the unit of the error, squared, per minute. NaN for a session with less than two minutes after drift_from.
double squared_error_slope_1_min(const Vector<double>& error);

struct Drift {
  double rmse = 0.0;                   // over the same samples
  double relative_slope_1_min = 0.0;   // mean slope / mean square
  double lowest = 0.0, highest = 0.0;  // 95 % of the bootstrap lies between
};
// Slope and mean square of sessions, [predictors][sessions]: those of several predictors (seeds of one method) over the same sessions
// are averaged session by session first. The same numbers give the same interval.
Drift drift_of(const std::vector<std::vector<double>>& slopes_1_min, const std::vector<std::vector<double>>& mean_squares);

}  // namespace sinew::model

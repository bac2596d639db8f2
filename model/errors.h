// SPDX-License-Identifier: Apache-2.0
// How far off a prediction is: as a whole, and whether it drifts.
#pragma once

#include <cmath>

#include "model/series.h"

namespace sinew::model {

// In the unit of the channel that is predicted.
struct Errors {
  double rmse = 0.0;
  double largest = 0.0;
  double second_minute = 0.0, last_minute = 0.0;  // NaN where the series is shorter than three minutes
};

// Of `count` samples from `first`; the sample that was given is left out.
inline double root_mean_square_error(const Vector<double>& predicted, const Series& series, Index first, Index count) {
  return std::sqrt((predicted - series.y).segment(first, count).squaredNorm() / static_cast<double>(count));
}

inline Errors errors_of(const Vector<double>& predicted, const Series& series) {
  const Index n = series.samples();
  constexpr Index minute = 600;
  const bool is_long = n >= 3 * minute;
  return {root_mean_square_error(predicted, series, 1, n - 1), (predicted - series.y).cwiseAbs().maxCoeff(),
          is_long ? root_mean_square_error(predicted, series, minute, minute) : std::nan(""),
          is_long ? root_mean_square_error(predicted, series, n - minute, minute) : std::nan("")};
}

}  // namespace sinew::model

// SPDX-License-Identifier: Apache-2.0
// How far off a prediction is: as a whole, and whether it drifts.
#pragma once

#include <cmath>

#include "model/series.h"

namespace sinew::model {

struct Errors {
  double rmse_deg = 0.0;
  double largest_deg = 0.0;
  double second_minute_deg = 0.0, last_minute_deg = 0.0;  // NaN where the series is shorter than three minutes
};

// Of `count` samples from `first`; the sample that was given is left out.
inline double rmse_deg(const Vector<double>& predicted, const Series& series, Index first, Index count) {
  return std::sqrt((predicted - series.angle_deg).segment(first, count).squaredNorm() / static_cast<double>(count));
}

inline Errors errors_of(const Vector<double>& predicted, const Series& series) {
  const Index n = series.samples();
  constexpr Index minute = 600;
  const bool is_long = n >= 3 * minute;
  return {rmse_deg(predicted, series, 1, n - 1), (predicted - series.angle_deg).cwiseAbs().maxCoeff(),
          is_long ? rmse_deg(predicted, series, minute, minute) : std::nan(""),
          is_long ? rmse_deg(predicted, series, n - minute, minute) : std::nan("")};
}

}  // namespace sinew::model

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

// Over those of `count` samples from `first` that were measured.
struct SquaredError {
  double sum = 0.0, count = 0.0;
  double root_mean() const { return std::sqrt(sum / count); }  // NaN where nothing was
};
inline SquaredError squared_error(const Vector<double>& predicted, const Series& series, Index first, Index count) {
  if (series.counted.size() == 0) return {(predicted - series.y).segment(first, count).squaredNorm(), static_cast<double>(count)};
  const auto counted = series.counted.segment(first, count);
  return {(predicted - series.y).segment(first, count).cwiseAbs2().dot(counted), counted.sum()};
}

// The sample that was given is to be left out by the caller.
inline double root_mean_square_error(const Vector<double>& predicted, const Series& series, Index first, Index count) {
  return squared_error(predicted, series, first, count).root_mean();
}

inline Errors errors_of(const Vector<double>& predicted, const Series& series) {
  const Index n = series.samples();
  constexpr Index minute = 600;
  const bool is_long = n >= 3 * minute;
  return {root_mean_square_error(predicted, series, 1, n - 1),
          series.counted.size() > 0 ? (predicted - series.y).cwiseAbs().cwiseProduct(series.counted).maxCoeff()
                                    : (predicted - series.y).cwiseAbs().maxCoeff(),
          is_long ? root_mean_square_error(predicted, series, minute, minute) : std::nan(""),
          is_long ? root_mean_square_error(predicted, series, n - minute, minute) : std::nan("")};
}

}  // namespace sinew::model

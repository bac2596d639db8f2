// SPDX-License-Identifier: Apache-2.0
#include "model/drift.h"

#include <algorithm>
#include <cmath>

#include "sim/random.h"

namespace sinew::model {
namespace {

constexpr int draws = 4000;
constexpr double outside = 0.025;  // on either side

std::vector<double> mean_over_first(const std::vector<std::vector<double>>& values) {
  std::vector<double> mean(values.front().size(), 0.0);
  for (const auto& one : values)
    for (std::size_t i = 0; i < mean.size(); ++i) mean[i] += one[i] / static_cast<double>(values.size());
  return mean;
}

}  // namespace

double squared_error_slope_1_min(const Vector<double>& error) {
  const Index n = error.size() - drift_from;
  if (n < 1200) return std::nan("");
  const Vector<double> squared = error.tail(n).array().square();
  const Vector<double> minutes = Vector<double>::LinSpaced(n, 0.0, static_cast<double>(n - 1)) * (period_s / 60.0);
  const Vector<double> from_mean = (minutes.array() - minutes.mean()).matrix();
  return from_mean.dot(squared) / from_mean.squaredNorm();
}

Drift drift_of(const std::vector<std::vector<double>>& slopes_1_min, const std::vector<std::vector<double>>& mean_squares) {
  const std::vector<double> slopes = mean_over_first(slopes_1_min), squares = mean_over_first(mean_squares);
  const std::size_t n = slopes.size();
  double slope = 0.0, square = 0.0;
  for (std::size_t i = 0; i < n; ++i) {
    slope += slopes[i];
    square += squares[i];
  }
  const sim::RandomStream chance(1, "drift.bootstrap");
  std::vector<double> ratios;
  std::uint64_t drawn = 0;
  for (int d = 0; d < draws; ++d) {
    double some_slope = 0.0, some_square = 0.0;
    for (std::size_t i = 0; i < n; ++i) {
      const auto which = std::min(n - 1, static_cast<std::size_t>(chance.uniform(drawn++) * static_cast<double>(n)));
      some_slope += slopes[which];
      some_square += squares[which];
    }
    ratios.push_back(some_slope / some_square);
  }
  std::sort(ratios.begin(), ratios.end());
  const auto at = [&](double share) { return ratios[static_cast<std::size_t>(share * (draws - 1))]; };
  return {std::sqrt(square / static_cast<double>(n)), slope / square, at(outside), at(1.0 - outside)};
}

}  // namespace sinew::model

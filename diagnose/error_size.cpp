// SPDX-License-Identifier: Apache-2.0
#include "diagnose/error_size.h"

#include <algorithm>
#include <cmath>

namespace sinew::diagnose {

PerChannel scale_of(const plant::System& system, const std::vector<FitData>& data) {
  PerChannel moves = per_channel(system);
  for (const FitData& one : data)
    for (const plant::ChannelId c : moves.ids()) {
      double sum = 0.0, squares = 0.0, count = 0.0;
      for (std::size_t k = 0; k < one.sample_count; ++k) {
        const double value = measured(one.recording->samples[k], c);
        if (std::isnan(value)) continue;
        sum += value;
        ++count;
      }
      for (std::size_t k = 0; k < one.sample_count; ++k)
        if (const double value = measured(one.recording->samples[k], c); !std::isnan(value)) squares += std::pow(value - sum / count, 2);
      if (count > 0.0) moves[c] = std::max(moves[c], std::sqrt(squares / count));
    }
  PerChannel scale = moves;
  for (const plant::ChannelId c : scale.ids())
    for (const plant::ChannelId other : scale.ids())
      if (system.channels()[c].unit.text == system.channels()[other].unit.text) scale[c] = std::max(scale[c], moves[other]);
  return scale;
}

ErrorSize error_size(const SquaredErrors& errors, const std::vector<FitData>& data, const PerChannel& scale,
                     const std::vector<PerChannel>& samples_alike) {
  const auto deviation = [&](std::size_t r, plant::ChannelId c, double share) {
    return std::hypot(data[r].deviation[c], share * scale[c]);
  };
  const auto log_likelihood = [&](double share) {
    double sum = 0.0;
    for (std::size_t r = 0; r < data.size(); ++r)
      for (const plant::ChannelId c : scale.ids()) {
        if (errors.count[r][c] == 0.0) continue;
        const double size = deviation(r, c, share);
        sum -= (errors.count[r][c] * std::log(size) + 0.5 * errors.sum[r][c] / (size * size)) / samples_alike[r][c];
      }
    return sum;
  };
  // Nothing, or between a millionth and a thousandfold, to a hundredth.
  constexpr double lowest = 1e-6, highest = 1e3;
  constexpr int steps = 90;
  double best = 0.0, most = log_likelihood(0.0);
  const auto look = [&](double share) {
    if (const double likely = log_likelihood(share); likely > most) {
      most = likely;
      best = share;
    }
  };
  const double step = std::pow(highest / lowest, 1.0 / steps);
  for (int i = 0; i <= steps; ++i) look(lowest * std::pow(step, i));
  for (double finer = std::sqrt(step); finer > 1.002 && best > 0.0; finer = std::sqrt(finer)) {
    const double middle = best;
    look(middle * finer);
    look(middle / finer);
  }
  ErrorSize result{best, {}, most};
  for (std::size_t r = 0; r < data.size(); ++r) {
    result.deviation.push_back(data[r].deviation);
    for (const plant::ChannelId c : scale.ids()) result.deviation[r][c] = deviation(r, c, best);
  }
  return result;
}

}  // namespace sinew::diagnose

// SPDX-License-Identifier: Apache-2.0
#include "diagnose/compare.h"

#include <algorithm>
#include <limits>
#include <numeric>
#include <stdexcept>

#include "sim/simulation.h"

namespace sinew::diagnose {
namespace {

constexpr double window_s = 5.0;

ChannelError error_of(const std::vector<double>& residual, std::size_t begin, std::size_t end, double noise) {
  ChannelError error;
  double squares = 0.0;
  for (std::size_t k = begin; k < end; ++k) {
    if (std::isnan(residual[k])) continue;
    ++error.samples;
    squares += residual[k] * residual[k];
    error.bias += residual[k];
    error.largest = std::max(error.largest, std::abs(residual[k]));
  }
  if (error.samples == 0) {
    constexpr double nan = std::numeric_limits<double>::quiet_NaN();
    return {0, nan, nan, nan, nan};
  }
  const auto n = static_cast<double>(error.samples);
  error.bias /= n;
  error.rmse = std::sqrt(squares / n);
  error.more_than_noise = squares > 0.0 ? std::max(0.0, 1.0 - noise * noise * n / squares) : 0.0;
  return error;
}

}  // namespace

WorstTime worst_of(const std::vector<double>& time_s, const std::vector<double>& residual) {
  WorstTime worst;
  const double first_s = time_s.front();
  const auto count = static_cast<std::size_t>((time_s.back() - first_s) / window_s) + 1;
  std::vector<double> squares(count, 0.0);
  for (std::size_t k = 0; k < residual.size(); ++k)
    if (!std::isnan(residual[k])) squares[static_cast<std::size_t>((time_s[k] - first_s) / window_s)] += residual[k] * residual[k];
  const double total = std::accumulate(squares.begin(), squares.end(), 0.0);
  if (total == 0.0) return worst;
  std::vector<std::size_t> order(count);
  std::iota(order.begin(), order.end(), 0);
  std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) { return squares[a] > squares[b]; });
  double sum = 0.0;
  std::size_t taken = 0;
  while (taken < count && sum < 0.5 * total) sum += squares[order[taken++]];
  order.resize(taken);
  std::sort(order.begin(), order.end());
  for (const std::size_t w : order) {
    const double from = first_s + static_cast<double>(w) * window_s, until = std::min(from + window_s, time_s.back());
    if (!worst.windows_s.empty() && worst.windows_s.back().second >= from)
      worst.windows_s.back().second = until;
    else
      worst.windows_s.emplace_back(from, until);
  }
  worst.share_of_time = static_cast<double>(taken) / static_cast<double>(count);
  worst.share_of_error = sum / total;
  return worst;
}

std::size_t samples_until(const sim::Recording& recording, double until_s) {
  std::size_t count = 0;
  while (count < recording.samples.size() && recording.samples[count].time_s < until_s) ++count;
  return count;
}

Comparison compare(const plant::Plant& plant, const plant::Start& start, const sim::Recording& recording, const PerChannel& noise,
                   double fit_until_s, const plant::NumericalSettings& numerics) {
  return compare(plant, std::span(&start, 1), std::span(&recording, 1), noise, fit_until_s, numerics);
}

Comparison compare(const plant::Plant& plant, std::span<const plant::Start> starts, std::span<const sim::Recording> parts,
                   const PerChannel& noise, double fit_until_s, const plant::NumericalSettings& numerics) {
  Comparison result;
  result.system = plant.shared_system();
  result.noise = noise;
  result.fit_until_s = fit_until_s;
  const plant::System& system = plant.system();
  result.model = result.residual = Series(system.channels().size(), {});
  for (std::size_t p = 0; p < parts.size(); ++p) {
    const std::vector<sim::Sample>& samples = parts[p].samples;
    plant::Integrator integrator(plant, starts[p], numerics);
    const auto failure = sim::replay(integrator, system, samples, [&](std::size_t k) {
      const std::vector<double> readings = integrator.readings();
      result.time_s.push_back(samples[k].time_s);
      for (const plant::ChannelId c : system.channels().ids()) {
        result.model[c].push_back(shown(system, readings, c));
        result.residual[c].push_back(result.model[c].back() - measured(samples[k], c));
      }
    });
    if (failure) throw std::runtime_error("the integration failed at " + std::to_string(failure->time_s) + " s: " + failure->reason);
  }
  const auto split =
      static_cast<std::size_t>(std::lower_bound(result.time_s.begin(), result.time_s.end(), fit_until_s) - result.time_s.begin());
  for (const plant::ChannelId c : system.channels().ids()) {
    result.fitted.push_back(error_of(result.residual[c], 0, split, noise[c]));
    result.unfitted.push_back(error_of(result.residual[c], split, result.time_s.size(), noise[c]));
    result.worst.push_back(worst_of(result.time_s, result.residual[c]));
  }
  return result;
}

}  // namespace sinew::diagnose

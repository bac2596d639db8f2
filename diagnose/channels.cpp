// SPDX-License-Identifier: Apache-2.0
#include "diagnose/channels.h"

#include <algorithm>
#include <vector>

#include "sim/table.h"

namespace sinew::diagnose {
namespace {

// Second differences beyond this many of the central ones' standard deviation are edges of the signal, not noise.
constexpr double edge_factor = 4.0;

double noise_of_channel(const sim::Recording& recording, plant::ChannelId channel, double otherwise) {
  std::vector<double> second, first;
  const auto& samples = recording.samples;
  const auto [rows, period_s] = measured_rows(recording, channel);
  const auto follows = [&](std::size_t i) { return samples[rows[i]].time_s - samples[rows[i - 1]].time_s < 1.5 * period_s; };
  const auto value = [&](std::size_t i) { return measured(samples[rows[i]], channel); };
  for (std::size_t i = 1; i < rows.size(); ++i) {
    if (!follows(i)) continue;
    if (const double step = std::abs(value(i) - value(i - 1)); step > 1e-9) first.push_back(step);
    if (i + 1 < rows.size() && follows(i + 1)) second.push_back(std::abs(value(i + 1) - 2.0 * value(i) + value(i - 1)));
  }
  if (second.size() < 8 || first.empty()) return otherwise;  // too little to tell, or a channel that never moves
  // Trimmed root mean square, repeated until no more is cut: robust like a median, but not blind to steps.
  std::sort(second.begin(), second.end());
  std::size_t kept = second.size() * 9 / 10;
  double deviation = 0.0;
  for (int pass = 0; pass < 20; ++pass) {
    double sum = 0.0;
    for (std::size_t i = 0; i < kept; ++i) sum += second[i] * second[i];
    deviation = std::sqrt(sum / static_cast<double>(kept));
    const auto end = std::upper_bound(second.begin(), second.end(), edge_factor * deviation);
    const auto now_kept = std::max<std::size_t>(static_cast<std::size_t>(end - second.begin()), second.size() / 2);
    if (now_kept == kept) break;
    kept = now_kept;
  }
  const double smallest_step = *std::min_element(first.begin(), first.end());
  return std::max(deviation / std::sqrt(6.0), smallest_step / std::sqrt(12.0));
}

}  // namespace

MeasuredRows measured_rows(const sim::Recording& recording, plant::ChannelId channel) {
  MeasuredRows result{};
  std::vector<double> steps_s;
  for (std::size_t k = 0; k < recording.samples.size(); ++k) {
    if (std::isnan(measured(recording.samples[k], channel))) continue;
    if (!result.rows.empty()) steps_s.push_back(recording.samples[k].time_s - recording.samples[result.rows.back()].time_s);
    result.rows.push_back(k);
  }
  result.period_s = sim::lower_median(std::move(steps_s));
  return result;
}

PerChannel noise_of(const plant::System& system, const sim::Recording& recording) {
  PerChannel noise;
  for (const plant::ChannelId c : system.channels().ids()) {
    const plant::ChannelInfo& usual = system.channels()[c];
    noise.push_back(noise_of_channel(recording, c, std::hypot(usual.noise, usual.step / std::sqrt(12.0))));
  }
  return noise;
}

double correlation_samples(const std::vector<double>& residual) {
  std::vector<double> r;
  for (const double value : residual)
    if (!std::isnan(value)) r.push_back(value);
  if (r.size() < 4) return 1.0;
  double variance = 0.0;
  for (const double value : r) variance += value * value;
  if (variance == 0.0) return 1.0;
  double sum = 1.0;
  for (std::size_t lag = 1; lag < r.size() / 2; ++lag) {
    double product = 0.0;
    for (std::size_t i = lag; i < r.size(); ++i) product += r[i] * r[i - lag];
    const double correlation = product / variance;
    if (correlation < 0.05) break;
    sum += 2.0 * correlation;
  }
  return sum;
}

}  // namespace sinew::diagnose

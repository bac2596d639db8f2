// SPDX-License-Identifier: Apache-2.0
#include "diagnose/channels.h"

#include <algorithm>
#include <vector>

namespace sinew::diagnose {
namespace {

// Second differences beyond this many of the central ones' standard deviation are edges of the signal, not noise.
constexpr double edge_factor = 4.0;

double noise_of_channel(const sim::Recording& recording, plant::ChannelId channel, double otherwise) {
  std::vector<double> second, first;
  const auto& samples = recording.samples;
  for (std::size_t k = 1; k < samples.size(); ++k) {
    const double step = std::abs(measured(samples[k], channel) - measured(samples[k - 1], channel));
    if (step > 1e-9) first.push_back(step);
    if (k + 1 == samples.size()) continue;
    const double d = measured(samples[k + 1], channel) - 2.0 * measured(samples[k], channel) + measured(samples[k - 1], channel);
    if (!std::isnan(d)) second.push_back(std::abs(d));
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

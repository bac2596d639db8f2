// SPDX-License-Identifier: Apache-2.0
// The three measured channels, and what noise alone does to each.
#pragma once

#include <array>
#include <cmath>
#include <cstddef>
#include <limits>
#include <string_view>

#include "plant/instant.h"
#include "sim/recording.h"

namespace sinew::diagnose {

inline constexpr std::size_t channel_count = 3;

struct Channel {
  std::string_view column;  // in a recording
  std::string_view words;
  std::string_view unit;
  double internal_per_unit;
};
inline constexpr std::array<Channel, channel_count> channels{
    Channel{"temperature_A_degC", "temperature A", "°C", 1.0}, Channel{"temperature_B_degC", "temperature B", "°C", 1.0},
    Channel{"angle_deg", "angle", "°", plant::radians_per_degree}};

// In the units of files; NaN where the sample is missing.
inline double measured(const sim::Sample& sample, std::size_t channel) {
  return channel < 2 ? sample.temperature_degC[channel] : sample.angle_deg;
}
inline double& measured(sim::Sample& sample, std::size_t channel) {
  return channel < 2 ? sample.temperature_degC[channel] : sample.angle_deg;
}
inline void mask(sim::Sample& sample) {
  for (std::size_t c = 0; c < channel_count; ++c) measured(sample, c) = std::numeric_limits<double>::quiet_NaN();
}
inline double shown(const plant::Reading<double>& reading, std::size_t channel) {
  return channel < 2 ? reading.temperature_degC[channel] : reading.angle_rad / plant::radians_per_degree;
}

using PerChannel = std::array<double, channel_count>;

// Standard deviation of each sensor's noise, in the units of files, steps of quantisation included: from second
// differences, which a slow signal and a wrong model leave alone. Never below step/sqrt(12), with the step the smallest
// difference that occurs. Channels that never move, or with fewer than 8 usable triples, get the
// noise of the paper's sensors.
PerChannel noise_of(const sim::Recording& recording);

// Time in samples over which a series of residuals is correlated: 1 + 2 sum of autocorrelations up to the first one
// below 0.05; at least 1. NaN entries are passed over.
double correlation_samples(const std::vector<double>& residual);

}  // namespace sinew::diagnose

// SPDX-License-Identifier: Apache-2.0
// What is measured, channel by channel, and what noise alone does to each.
#pragma once

#include <cmath>
#include <cstddef>
#include <limits>
#include <vector>

#include "plant/system.h"
#include "sim/recording.h"

namespace sinew::diagnose {

// One value, or one series of values (one a sample), for each channel of a System; in the units of files.
using PerChannel = plant::ListOf<plant::ChannelId, double>;
using Series = plant::ListOf<plant::ChannelId, std::vector<double>>;

inline PerChannel per_channel(std::size_t channels, double value = 0.0) { return PerChannel(channels, value); }
inline PerChannel per_channel(const plant::System& system, double value = 0.0) { return per_channel(system.channels().size(), value); }

// In the units of files; NaN where the sample is missing.
inline double measured(const sim::Sample& sample, plant::ChannelId channel) { return sample.channels[channel.index]; }
inline double& measured(sim::Sample& sample, plant::ChannelId channel) { return sample.channels[channel.index]; }
inline void mask(sim::Sample& sample) {
  for (double& value : sample.channels) value = std::numeric_limits<double>::quiet_NaN();
}
// A reading of the integrator in the units of files.
inline double shown(const plant::System& system, const std::vector<double>& readings, plant::ChannelId channel) {
  return readings[channel.index] / system.channels()[channel].unit.internal_per_unit;
}

// The samples in which a channel was measured: in a log in which each reading has a row of its own, few of all.
struct MeasuredRows {
  std::vector<std::size_t> rows = {};
  double period_s = 0.0;  // the median time from one to the next; NaN with fewer than two
};
MeasuredRows measured_rows(const sim::Recording& recording, plant::ChannelId channel);

// Standard deviation of each sensor's noise, in the units of files, steps of quantisation included: from second
// differences, which a slow signal and a wrong model leave alone. Never below step/sqrt(12), with the step the smallest
// difference that occurs. Channels that never move, or with fewer than 8 usable triples, get the
// noise of their usual sensor.
PerChannel noise_of(const plant::System& system, const sim::Recording& recording);

// Time in samples over which a series of residuals is correlated: 1 + 2 sum of autocorrelations up to the first one
// below 0.05; at least 1. NaN entries are passed over.
double correlation_samples(const std::vector<double>& residual);

// From the lowest to the highest of the values that are there.
struct Span {
  double lowest = std::numeric_limits<double>::infinity(), highest = -lowest;
  void include(double value) {
    if (std::isnan(value)) return;
    lowest = std::min(lowest, value);
    highest = std::max(highest, value);
  }
  bool none() const { return highest < lowest; }
  double width() const { return highest - lowest; }
};

}  // namespace sinew::diagnose

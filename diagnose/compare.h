// SPDX-License-Identifier: Apache-2.0
// A plant against a recording: open loop, from the recorded inputs alone.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "diagnose/channels.h"
#include "plant/integrator.h"

namespace sinew::diagnose {

// Errors of one channel over some samples.
struct ChannelError {
  std::size_t samples = 0;
  double rmse = 0.0;             // in the unit of the channel; NaN without samples
  double bias = 0.0;             // mean of model - measured
  double largest = 0.0;          // of |model - measured|
  double more_than_noise = 0.0;  // share of the mean square that is not sensor noise, 0 to 1
};

// Where most of a channel's squared error is.
struct WorstTime {
  double share_of_time = 0.0;                        // the smallest share of the samples, in windows of 5 s, ...
  double share_of_error = 0.0;                       // ... that holds at least half of the squared error
  std::vector<std::pair<double, double>> windows_s;  // merged, in time's order, recording's own time
};

// `residual`: one value a sample, at least one sample; NaN where nothing was measured.
WorstTime worst_of(const std::vector<double>& time_s, const std::vector<double>& residual);

struct Comparison {
  std::shared_ptr<const plant::System> system;  // of the plant that was compared
  std::vector<double> time_s;                   // of the recording
  Series model;                                 // in the units of files
  Series residual;                              // model - measured; NaN where nothing was measured
  PerChannel noise;
  plant::ListOf<plant::ChannelId, ChannelError> fitted, unfitted;  // before and from `fit_until_s`
  plant::ListOf<plant::ChannelId, WorstTime> worst;
  double fit_until_s;
};

// Throws std::runtime_error with the solver's words where the plant cannot be integrated over the recording.
Comparison compare(const plant::Plant& plant, const plant::Start& start, const sim::Recording& recording, const PerChannel& noise,
                   double fit_until_s, const plant::NumericalSettings& numerics);

// The same where the recording has pauses: each part with its own start, one beside the other in the recording's time.
Comparison compare(const plant::Plant& plant, std::span<const plant::Start> starts, std::span<const sim::Recording> parts,
                   const PerChannel& noise, double fit_until_s, const plant::NumericalSettings& numerics);

// Number of samples before `until_s`, in the recording's own time.
std::size_t samples_until(const sim::Recording& recording, double until_s);

}  // namespace sinew::diagnose

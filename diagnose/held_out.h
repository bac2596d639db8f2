// SPDX-License-Identifier: Apache-2.0
// What is held out from the fit: what plants predict of it from duty alone, and whether one does so better than another.
#pragma once

#include <cstdint>

#include "diagnose/open_loop.h"

namespace sinew::diagnose {

// A training recording, and which of it is fitted.
struct Split {
  sim::Recording fitted;       // with what is not to be fitted masked
  std::size_t sample_count;    // the first so many are fitted
  std::vector<bool> held_out;  // of the recording's samples
};

// What comes after `fit_until_s` is held out; where nothing does, and `keep_blocks`, two blocks of the recording are.
Split split(const sim::Recording& gated, double fit_until_s, bool keep_blocks);

// Inputs that training leaves alone, all along at one value, and that the recording drives: its prediction hangs on values of which
// training tells nothing.
std::vector<plant::InputId> driven_more(const plant::System& system, const sim::Recording& recording, const std::vector<FitData>& training);

// Predictions over a recording, open loop from its duty, and which samples were held out.
struct Prediction {
  const sim::Recording* recording = nullptr;
  bool training = false;
  PerChannel noise;  // of the sensors, units of files
  std::vector<double> time_s;
  std::vector<bool> held_out;    // counts in what is said of held-out data
  std::vector<bool> not_fitted;  // of a training recording
  // Units of files; NaN where missing. By the plant as given; with its parameters fitted, as the diagnosis weighs the channels, and as
  // `calibrate` does (each empty where that is not known); by the nearer of these two, channel by channel; repaired.
  Series measured, nominal, fitted, calibrated, before, after;
};

struct HeldOutError {
  // RMSE, units of files, as the series of `Prediction`; of the sensors alone. What a plant is off `before` is the least that it can be
  // without what was added: where it is wrong, one weighting gives up a channel for another, and that is no gain of an effect.
  PerChannel nominal, fitted, calibrated, before, after, noise;
  PerChannel gain, gain_lowest, gain_highest;  // 1 - after/before, with a 95 % block-bootstrap interval
  plant::ListOf<plant::ChannelId, std::size_t> samples;
  // The 95 % block-bootstrap interval of the sum over channels of (before - after) squares in units of noise. Without bounds where
  // there are too few stretches to draw from.
  double lowest_total_gain = 0.0, highest_total_gain = 0.0;
};
HeldOutError error_of(const std::vector<Prediction>& predictions, std::uint64_t seed);

// Makes `before` of each channel the nearer of `fitted` and `calibrated` on what is held out.
void choose_before(std::vector<Prediction>& predictions);

inline constexpr double correlation_lag_s = 0.5;
struct ResidualCorrelation {
  Series before, after;  // of kept-back residuals, at multiples of correlation_lag_s, to the nearest reading
};
ResidualCorrelation correlation_of(const std::vector<Prediction>& predictions);

}  // namespace sinew::diagnose

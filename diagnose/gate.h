// SPDX-License-Identifier: Apache-2.0
// What is odd about a recording before any model sees it, and the recording as a diagnosis uses it.
#pragma once

#include <string>
#include <vector>

#include "diagnose/channels.h"

namespace sinew::diagnose {

struct GateNotes {
  std::string recording;
  std::size_t samples = 0;
  double period_s = 0.0, duration_s = 0.0;
  PerChannel noise, step;                                 // estimated noise; smallest difference that occurs
  plant::ListOf<plant::ChannelId, std::size_t> outliers;  // masked
  plant::ListOf<plant::ChannelId, std::size_t> missing;   // were not there
  PerChannel stuck_share;                                 // share of samples in the longest run of one value while something is driven
  double longest_gap_s = 0.0;
  double largest_input = 0.0;         // of all inputs, as a size
  std::vector<std::string> warnings;  // plain sentences, empty where nothing is odd
};

// The recording with gross errors masked as missing: samples that stand off the median of their six neighbours by more
// than eight times the noise and the range of these neighbours together. `noise`: of the sensors, or null: estimated.
sim::Recording gated(const plant::System& system, const sim::Recording& recording, const PerChannel* noise, GateNotes& notes);

}  // namespace sinew::diagnose

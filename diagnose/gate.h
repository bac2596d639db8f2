// SPDX-License-Identifier: Apache-2.0
// What is odd about a recording before any model sees it, and the recording as a diagnosis uses it.
#pragma once

#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "diagnose/channels.h"

namespace sinew::diagnose {

// A channel that shows one value while it is driven: from a fifth of its samples on.
struct Unresponsive {
  plant::ChannelId channel{};
  double value = 0.0;                  // in the unit of files
  double from_s = 0.0, until_s = 0.0;  // in the recording's own time
  bool throughout = false;             // there is no other value in the whole recording
  std::string words;                   // a sentence without its full stop: "angle stays at 5° all along while it is driven: ..."
};

struct GateNotes {
  std::string recording;
  std::size_t samples = 0;
  double period_s = 0.0, duration_s = 0.0;
  std::optional<double> begins_s;                         // on the clock of recordings that say when they were made
  PerChannel noise, step;                                 // estimated noise; smallest difference that occurs
  PerChannel reading_period_s;                            // median time from one reading to the next
  plant::ListOf<plant::ChannelId, std::size_t> outliers;  // masked
  plant::ListOf<plant::ChannelId, std::size_t> missing;   // rows without a reading
  PerChannel stuck_share;                                 // share of samples in the longest run of one value while something is driven
  std::vector<Unresponsive> unresponsive;                 // at most one a channel, the longest
  std::vector<std::pair<double, double>> pauses_s;        // gaps in which the inputs are not known (sim::parts_between_pauses)
  double longest_gap_s = 0.0;                             // that is no pause
  double largest_input = 0.0;                             // of all inputs, as a size
  std::vector<std::string> warnings;                      // plain sentences, empty where nothing is odd
};

// None where the channel answers, or nothing changes that should move it.
std::optional<Unresponsive> unresponsive(const plant::System& system, const sim::Recording& recording, plant::ChannelId channel);

// The recording with gross errors masked as missing: samples that stand off the median of their six neighbours by more
// than eight times the noise and the range of these neighbours together. `noise`: of the sensors, or null: estimated.
sim::Recording gated(const plant::System& system, const sim::Recording& recording, const PerChannel* noise, GateNotes& notes);

}  // namespace sinew::diagnose

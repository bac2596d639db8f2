// SPDX-License-Identifier: Apache-2.0
// A session's recording with every reading at the time at which it was made.
//
// A row of recording.csv has what telemetry had said last at its tick: an amplifier's reading may be 0.2 s old by then, and how old changes
// from row to row, since amplifiers are read every 105 ms. Where a coil warms by 10 K/s that is 2 K, in a pattern of its own, which no
// physics of the limb explains. Telemetry says how old each reading is; here each row has the line between the readings before and after
// its tick. It takes the future, so it is made when the session is over: for fits, not for control.
#pragma once

#include "hil/limb_parts.h"
#include "hil/session.h"
#include "sim/recording.h"

namespace sinew::hil {

class TimedRecording {
 public:
  explicit TimedRecording(const plant::Plant& limb);
  void add(const SessionView& view);  // tick by tick: SessionSettings::show
  // Rows as in recording.csv. A reading is missing where none was made within `longest_gap_s` to both sides of the tick.
  sim::Recording recording() const;
  static constexpr double longest_gap_s = 0.35;

 private:
  struct Reading {
    double made_s, value;
  };
  plant::Plant limb_;
  LimbParts parts_;
  std::vector<sim::Sample> rows_;
  std::vector<std::vector<Reading>> readings_;  // of each channel, by time
};

}  // namespace sinew::hil

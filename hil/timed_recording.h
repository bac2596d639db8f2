// SPDX-License-Identifier: Apache-2.0
// A session's recording with every reading at the time at which it was made.
//
// A row of recording.csv has what telemetry had said last at its tick: an amplifier's reading may be 0.2 s old by then, and how old changes
// from row to row, since amplifiers are read every 105 ms. Where a coil warms by 10 K/s that is 2 K, in a pattern of its own, which no
// physics of the limb explains. Telemetry says how old each reading is. Here each has a row of its own time, with what was commanded then,
// and ticks have none. (Lines between readings would not do: a coil's temperature has a corner wherever the duty changes.)
#pragma once

#include "hil/limb_parts.h"
#include "hil/session.h"
#include "sim/recording.h"

namespace sinew::hil {

class TimedRecording {
 public:
  explicit TimedRecording(const plant::Plant& limb);
  void add(const SessionView& view);  // tick by tick: SessionSettings::show
  // By time: a row for each tick, and one for each time at which something was read; readings before the first tick are left out.
  sim::Recording recording() const;

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

// SPDX-License-Identifier: Apache-2.0
// What a recording cannot show, whatever is fitted to it, and rows of it that look misread.
#pragma once

#include <string>
#include <vector>

#include "diagnose/channels.h"

namespace sinew::diagnose {

// Sentences without their full stop, the gravest first; empty where the recording is rich enough. Too short; nothing driven, or one part
// alone; inputs that are always equal; a channel that was never measured, that never moves, or that stays at one value (gate.h).
std::vector<std::string> shortcomings(const plant::System& system, const sim::Recording& recording, const PerChannel& noise);

// A channel that moves, stands still for some rows, and then makes up for it in a leap: so does a reading that was not taken, such as a
// logger that wrote its last value again. What sticks and slips can look alike.
struct SuspectedMisreading {
  plant::ChannelId channel{};
  double from_s = 0.0, until_s = 0.0;  // it stands still from the first, and has leapt at the second
  double stands_at = 0.0, leap = 0.0;  // in the unit of files
};
std::vector<SuspectedMisreading> suspected_misreadings(const plant::System& system, const sim::Recording& recording,
                                                       const PerChannel& noise);

}  // namespace sinew::diagnose

// SPDX-License-Identifier: Apache-2.0
// How well the loop of a session keeps its deadlines on this machine, with a board that is not armed: the same backend, the same
// supervisor's work at each tick, commands without duty, which the board drops.
#pragma once

#include <cstdint>
#include <functional>

#include "hil/link.h"

namespace sinew::hil {

struct Punctuality {
  std::int64_t deadlines = 0, within_5_ms = 0;
  std::int64_t median_us = 0, share_99_9_us = 0, most_us = 0;  // from the deadline until the command was written
  std::int64_t without_telemetry = 0;                          // deadlines at which nothing new had come
};

// Throws Refused (session.h) where no board answers, or one with other parts than the paper's limb; LinkLost.
Punctuality measure_punctuality(Link& link, std::uint16_t session, std::int64_t period_us, double duration_s,
                                const std::function<bool()>& should_stop);

}  // namespace sinew::hil

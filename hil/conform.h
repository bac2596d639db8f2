// SPDX-License-Identifier: Apache-2.0
// Whether a board speaks and behaves as docs/protocol.md says: every message, its refusals, the states, the times. A board of somebody
// else's is asked, over its own wire; nothing is heated, for no frame that it may obey has a duty.
#pragma once

#include <functional>
#include <string>

#include "hil/link.h"

namespace sinew::hil {

struct ConformFinding {
  enum class Verdict { good, bad, left_out } verdict;
  std::string what;    // what the page says
  std::string detail;  // what came instead; or why it was left out
};

struct ConformSettings {
  bool clear_trip = false;            // a board that is tripped is cleared first; arming and what follows wants that
  bool coils_disconnected = false;    // then a command of too much duty is tried as well, which a wrong board would obey
  std::function<bool()> should_stop;  // asked while it waits: then the board is disarmed, and nothing more is asked
  std::function<void(const ConformFinding&)> say;
};

struct ConformResult {
  int good = 0, bad = 0, left_out = 0;
  bool stopped = false, brought_to_rest = false;  // `brought_to_rest`: the board answered the last disarm
};

// Throws LinkLost. Some ten seconds of the link's time.
ConformResult conform(Link& link, const ConformSettings& settings);

}  // namespace sinew::hil

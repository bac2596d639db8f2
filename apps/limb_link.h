// SPDX-License-Identifier: Apache-2.0
// What `hil` and `doctor` share: where the emulator and its firmware are (beside this program), and how a session is scheduled.
#pragma once

#include <string>
#include <vector>

namespace sinew::apps {

// Program and arguments. Throws sim::InputError where one is missing.
std::vector<std::string> emulator_command(const std::string& scenario, const std::vector<std::string>& faults);

// Of the thread that keeps the deadlines: SCHED_FIFO, before every ordinary program. Linux allows it to root and up to
// RLIMIT_RTPRIO.
inline constexpr int real_time_priority = 20;

}  // namespace sinew::apps

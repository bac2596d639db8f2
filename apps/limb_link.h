// SPDX-License-Identifier: Apache-2.0
// What `hil` and `doctor` share: where the emulator and its firmware are (beside this program), and how a session is scheduled.
#pragma once

#include <string>
#include <vector>

namespace sinew::apps {

// Program and arguments. Throws sim::InputError where one is missing.
std::vector<std::string> emulator_command(const std::string& scenario, const std::vector<std::string>& faults);

// Throws sim::InputError where no kind of concealed limb has this name.
void check_concealed_kind(const std::string& option, const std::string& name);

// By this machine's clock, to the millisecond: when a session on a limb begins.
double seconds_since_1970();

// Of the thread that keeps the deadlines: SCHED_FIFO, before every ordinary program. Linux allows it to root and up to
// RLIMIT_RTPRIO.
inline constexpr int real_time_priority = 20;
bool take_real_time_priority();  // this thread, and those that it starts from then on; false: not allowed
void give_priority_back();       // this thread
// Nothing of this process is paged out, and what it allocates is there at once. False: not allowed (RLIMIT_MEMLOCK).
bool stay_in_memory();

// A program that is built or installed beside this one. Throws sim::InputError with `advice` where it is not there.
std::string program_beside(const std::string& name, const std::string& advice);

// The board's program on a pseudo-terminal of its own, as a process of ours (sinew-board), until this ends.
class BoardProcess {
 public:
  BoardProcess();
  ~BoardProcess();
  BoardProcess(const BoardProcess&) = delete;
  BoardProcess& operator=(const BoardProcess&) = delete;
  const std::string& port() const { return port_; }

 private:
  int child_ = -1;
  std::string port_;
};

}  // namespace sinew::apps

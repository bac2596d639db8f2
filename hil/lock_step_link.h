// SPDX-License-Identifier: Apache-2.0
// The emulator as a child process, in lock step: its time stands still until this end asks for more, so a session gives the
// same bytes every time. The emulator is GPL and a program of its own.
#pragma once

#include <sys/types.h>
#include <string>

#include "hil/link.h"

namespace sinew::hil {

class LockStepLink : public Link {
 public:
  // Program and arguments; `--lock-step` is added. Throws std::runtime_error where it cannot be started.
  explicit LockStepLink(std::vector<std::string> command);
  ~LockStepLink() override;  // lets it end by itself, so that it writes its trace
  LockStepLink(const LockStepLink&) = delete;
  LockStepLink& operator=(const LockStepLink&) = delete;

  std::int64_t send(std::span<const std::uint8_t> bytes) override;
  // Throws sim::InputError where the emulator refuses its arguments, a fault that is none for instance.
  Received receive_until(std::int64_t deadline_us) override;
  void close();

 private:
  pid_t child_ = -1;
  int status_ = 0;  // with which it ended
  bool has_answered_ = false;
  int to_child_ = -1, from_child_ = -1;
  std::int64_t now_us_ = 0;
  Bytes waiting_;
};

}  // namespace sinew::hil

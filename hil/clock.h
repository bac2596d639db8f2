// SPDX-License-Identifier: Apache-2.0
// The clock of a real-time link is passed in; a session takes the time from its link.
#pragma once

#include <chrono>
#include <cstdint>

namespace sinew::hil {

class Clock {
 public:
  virtual ~Clock() = default;
  virtual std::int64_t now_us() const = 0;  // monotonic
};

class MonotonicClock : public Clock {
 public:
  std::int64_t now_us() const override {
    return std::chrono::duration_cast<std::chrono::microseconds>(std::chrono::steady_clock::now().time_since_epoch()).count();
  }
};

}  // namespace sinew::hil

// SPDX-License-Identifier: Apache-2.0
// The clock of a real-time link is passed in; a session takes the time from its link.
#pragma once

#include <algorithm>
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

// The device's clock on the host's: host = host_0 + (device - device_0) (1 + skew). In the first seconds the line goes through the
// frame that was on its way for the shortest time; from then on it is bent towards what arrives and never stepped. A frame that arrives
// early says that the line lies too late, for nothing arrives before it was sent; one that arrives late says little, for it may have
// waited.
class ClockMap {
 public:
  void begin(std::uint32_t device_us, std::int64_t host_us) {
    last_device_us_ = device_us;
    device_us_ = 0;
    host_us_ = static_cast<double>(host_us);
    skew_ = 0.0;
  }
  // A frame of that device time arrived. Returns the host's time at which it was made, as estimated.
  std::int64_t take(std::uint32_t device_us, std::int64_t arrived_us) {
    const auto passed_us = static_cast<double>(static_cast<std::int32_t>(device_us - last_device_us_));
    if (passed_us > 0.0) {
      last_device_us_ = device_us;
      device_us_ += static_cast<std::int64_t>(passed_us);
      host_us_ += passed_us * (1.0 + skew_);
      const double early_us = host_us_ - static_cast<double>(arrived_us);
      // A first frame that was late would have to be made up for by bending, and the skew would take that for its own.
      if (early_us > 0.0 && device_us_ < settling_us) {
        host_us_ -= early_us;
        return static_cast<std::int64_t>(host_us_);
      }
      const double most = fastest_bend * passed_us;
      // Early by more than nothing pulls at once; late lets the line follow slowly.
      const double bend = early_us > 0.0 ? -std::min(early_us, most) : std::min(-early_us * 0.01, 0.1 * most);
      host_us_ += bend;
      skew_ += 0.02 * bend / passed_us;
    }
    return static_cast<std::int64_t>(host_us_);
  }
  // The device's clock at that time of the host's.
  std::uint32_t device_us(std::int64_t host_us) const {
    const double since = (static_cast<double>(host_us) - host_us_) / (1.0 + skew_);
    return last_device_us_ + static_cast<std::uint32_t>(static_cast<std::int64_t>(since));
  }
  double skew() const { return skew_; }
  std::int64_t device_us_since_begin() const { return device_us_; }

 private:
  static constexpr double fastest_bend = 1e-3;
  static constexpr std::int64_t settling_us = 2'000'000;
  std::uint32_t last_device_us_ = 0;
  std::int64_t device_us_ = 0;
  double host_us_ = 0.0, skew_ = 0.0;
};

}  // namespace sinew::hil

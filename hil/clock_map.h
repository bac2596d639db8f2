// SPDX-License-Identifier: Apache-2.0
// The device's clock on the host's: host = offset + device (1 + skew).
//
// No frame arrives before it was sent, so the line lies under all that came: of the lines under the frames of the last ten seconds the
// one that is highest in their middle, by the lower convex hull (Moon, Skelly, Towsley, INFOCOM 1999). A frame that waited lies above the
// hull and says nothing. The skew is taken from the quarter of the hull that says least of it, and is zero where the two quarters
// differ in sign: what jitter alone can feign is not believed. Resonators of boards are off by 0.5 %; up to 1.2 % is followed.
//
// In the first two seconds the estimate goes where the line is; from then on it is bent towards it, and never stepped.
#pragma once

#include <cstdint>
#include <deque>
#include <vector>

namespace sinew::hil {

class ClockMap {
 public:
  void begin(std::uint32_t device_us, std::int64_t host_us);
  // A frame of that device time arrived. Returns the host's time at which it was made, as estimated.
  std::int64_t take(std::uint32_t device_us, std::int64_t arrived_us);
  // The device's clock at that time of the host's.
  std::uint32_t device_us(std::int64_t host_us) const;
  double skew() const { return skew_; }
  std::int64_t device_us_since_begin() const { return device_us_; }

 private:
  struct Frame {
    double device_us, late_us;  // since begin; late: host's time since begin less device's
  };
  void keep(const Frame& frame);
  // Sets skew_; returns by how much the line is late now.
  double fit();
  std::uint32_t last_device_us_ = 0;
  std::int64_t device_us_ = 0;
  double host_0_us_ = 0.0, host_us_ = 0.0, skew_ = 0.0;
  std::deque<Frame> earliest_;  // the earliest frame of each quarter of a second
  std::vector<Frame> hull_;     // scratch
};

}  // namespace sinew::hil

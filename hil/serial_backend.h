// SPDX-License-Identifier: Apache-2.0
// The physical limb behind the seam of sim/signals.h: a device, over a link.
//
// exchange(command of tick k) sends the command at tick k's deadline, repeats it every 50 ms, and returns at the
// deadline of tick k + 1 what telemetry said last. Deadlines are absolute: begin + k * period.
#pragma once

#include "hil/device.h"
#include "sim/signals.h"

namespace sinew::hil {

class SerialBackend : public sim::Backend {
 public:
  SerialBackend(Device& device, std::int64_t period_us) : device_(device), period_us_(period_us) {}

  sim::Measurement begin() override;
  // A tick without a new telemetry frame is NaN in all channels.
  sim::Measurement exchange(const sim::Command& command) override;

  // Of the last exchange: what the device says is at its pins, and the frame that said so.
  const std::optional<Telemetry>& telemetry() const { return device_.telemetry(); }
  std::int64_t deadline_us(std::int64_t tick) const { return begin_us_ + tick * period_us_; }

 private:
  sim::Measurement measure(std::int64_t tick);
  Device& device_;
  std::int64_t period_us_, begin_us_ = 0, measured_arrival_us_ = -1;
};

// The share of the period in milliseconds that a host asks the device to speak in.
std::uint8_t telemetry_period_ms(std::int64_t period_us);
// How long a command is good for: two periods and a little, within what the device allows.
std::uint16_t time_to_live_ms(std::int64_t period_us);

}  // namespace sinew::hil

// SPDX-License-Identifier: Apache-2.0
// The physical limb behind the seam of sim/signals.h: a device, over a link.
//
// exchange(command of tick k) sends the command at tick k's deadline, repeats it every 50 ms, and returns at the
// deadline of tick k + 1 what telemetry said last. Deadlines are absolute: begin + k * period.
#pragma once

#include "hil/device.h"
#include "hil/limb_parts.h"
#include "sim/signals.h"

namespace sinew::hil {

class SerialBackend : public sim::Backend {
 public:
  // `device` and `parts` must outlive this.
  SerialBackend(Device& device, const LimbParts& parts, std::int64_t period_us) : device_(device), parts_(parts), period_us_(period_us) {}

  sim::Measurement begin() override;
  // A tick without a new telemetry frame is NaN in all channels.
  sim::Measurement exchange(const sim::Command& command) override;

  // Whether the last measurement had a new telemetry frame.
  bool heard() const { return heard_; }
  // Of the last exchange: what the device says is at its pins, and the frame that said so.
  const std::optional<Telemetry>& telemetry() const { return device_.telemetry(); }
  std::int64_t deadline_us(std::int64_t tick) const { return begin_us_ + tick * period_us_; }

 private:
  sim::Measurement measure(std::int64_t tick);
  Device& device_;
  const LimbParts& parts_;
  bool heard_ = false;
  std::int64_t period_us_, begin_us_ = 0, measured_arrival_us_ = -1;
};

// The share of the period in milliseconds that a host asks the device to speak in.
std::uint8_t telemetry_period_ms(std::int64_t period_us);
// How long a command is good for: two periods and a little, within what the device allows.
std::uint16_t time_to_live_ms(std::int64_t period_us);

}  // namespace sinew::hil

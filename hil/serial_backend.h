// SPDX-License-Identifier: Apache-2.0
// The physical limb behind the seam of sim/signals.h: a device, over a link.
//
// exchange(command of tick k) sends the command at a fixed time after tick k's deadline, within which it was computed, repeats it every
// 50 ms or more often, and returns at the deadline of tick k + 1 what telemetry said last. Deadlines are absolute: begin + k * period.
// Before each repetition whoever supervises is asked for the duty, so that neither a signal nor a coil that gets warm waits for a long
// period to end.
#pragma once

#include <algorithm>
#include <functional>

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

  // So long after a deadline, or after the beginning of a part, its command is written: computing takes less, and commands are equally far
  // apart. One that is not ready by then goes at once.
  std::int64_t send_offset_us() const { return std::min<std::int64_t>(period_us_ / 10, 1000); }
  // In how many parts a period is sent, each at most 50 ms long.
  std::int64_t parts_of_period() const;
  // Asked before each repetition, with what was measured since the last (NaN: nothing new): puts the duty of the next part into the
  // command. False: the exchange ends here and now.
  std::function<bool(const sim::Measurement& measured, sim::Command& command)> before_repetition;

  // Whether new telemetry came in the last part.
  bool heard_in_part() const { return heard_in_part_; }
  // Whether the last measurement had a new telemetry frame.
  bool heard() const { return heard_; }
  // Of the last exchange: what the device says is at its pins, and the frame that said so.
  const std::optional<Telemetry>& telemetry() const { return device_.telemetry(); }
  // When the command of the last exchange had been written, the first time.
  std::int64_t written_us() const { return written_us_; }
  std::int64_t deadline_us(std::int64_t tick) const { return begin_us_ + tick * period_us_; }

 private:
  sim::Measurement measure(std::int64_t tick, std::int64_t& last_arrival_us, bool& heard);
  Device& device_;
  const LimbParts& parts_;
  bool heard_ = false, heard_in_part_ = false;
  std::int64_t period_us_, begin_us_ = 0, written_us_ = 0, tick_arrival_us_ = -1, part_arrival_us_ = -1;
};

// The share of the period in milliseconds that a host asks the device to speak in.
std::uint8_t telemetry_period_ms(std::int64_t period_us);

}  // namespace sinew::hil

// SPDX-License-Identifier: Apache-2.0
// A serial port as a link, in real time: opened for this process alone, raw, 500000 Bd 8N1.
//
// A thread of its own waits for bytes, notes when they came, and hands them over through a queue without locks: whoever waits for a
// terminal is woken late when the machine is busy, whoever sleeps until an absolute time is not. The thread has the priority of the one
// that makes the port.
#pragma once

#include <memory>
#include <string>

#include "hil/clock.h"
#include "hil/link.h"

namespace sinew::hil {

class Port : public Link {
 public:
  // Throws sim::InputError with what to do where the port is not there, not allowed, in use or no serial port.
  Port(const std::string& path, const Clock& clock);
  ~Port() override;
  std::int64_t send(std::span<const std::uint8_t> bytes) override;
  Received receive_until(std::int64_t deadline_us) override;
  Received receive_at(std::int64_t deadline_us) override;

 private:
  class Implementation;
  std::unique_ptr<Implementation> implementation_;
};

}  // namespace sinew::hil

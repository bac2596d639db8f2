// SPDX-License-Identifier: Apache-2.0
// The host's end of the protocol: asks, commands, listens. docs/protocol.md.
#pragma once

#include <array>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "hil/clock_map.h"
#include "hil/link.h"
#include "hil/message.h"

namespace sinew::hil {

std::string_view words(trip_cause cause);
std::string_view words(reset_cause cause);
std::string_view words(answer answer);
extern const std::array<std::string_view, DEVICE_COUNTERS> counter_names;

// What a board found wrong with itself when it started: board_setting, in words. Empty: nothing.
std::vector<std::string> words_of_settings(std::uint8_t wrong_settings);

// What of a board's hello the wire cannot carry, with its place in the payload; empty: nothing.
std::string misfit_of(const board_parts& parts);

struct Telemetry {
  message_telemetry said;
  std::int64_t arrived_us;
  std::int64_t made_us;  // by the device's clock, mapped to the host's
};

struct LinkCounters {
  std::int64_t sent = 0, received = 0;
  std::array<std::int64_t, FRAME_FAULTS> refused{};  // frames that came and were not valid
  std::int64_t missing = 0;                          // by the gaps in the device's sequence numbers
  std::int64_t other_session = 0, out_of_order = 0;
};

class Device {
 public:
  Device(Link& link, std::uint16_t session) : link_(link), session_(session) { frame_decoder_start(&decoder_, nullptr); }

  // Begins the session: the device is disarmed. Nothing within 2.4 s: nullopt. Telemetry is heard from a hello with parts that fit on.
  std::optional<message_hello> hello(std::uint8_t telemetry_period_ms);
  // Asked up to nine times, 0.9 s in all, and an answer to any of them is one: a bridge that holds a frame back for 80 ms each way is
  // waited for. Nothing: no answer came.
  std::optional<answer> arm(std::uint32_t firmware_hash, std::uint32_t limits_hash, std::uint8_t flags = ARM_ANGLE_FAULTS_TRIP);
  std::optional<answer> clear_trip(std::uint8_t cause);
  std::optional<answer> disarm();

  // One duty a coil, as many as the hello said.
  std::uint32_t command(std::span<const std::uint16_t> duty, std::uint16_t time_to_live_ms);

  // Handles what comes until then. `stop_at`: returns early after a frame of that type.
  void listen_until(std::int64_t deadline_us, std::uint8_t stop_at = 0);

  std::int64_t now_us() const { return now_us_; }
  const std::optional<Telemetry>& telemetry() const { return telemetry_; }
  const LinkCounters& counters() const { return counters_; }
  const ClockMap& clock() const { return clock_; }
  // A frame that was valid but for its version came: the device speaks another.
  bool other_version() const { return decoder_.refused[FRAME_OTHER_VERSION] > 0; }
  // Times from sending a command until telemetry showed that it was taken.
  std::vector<std::int64_t>& round_trips_us() { return round_trips_us_; }
  // A device that was reset says hello by itself or forgets the session; telemetry then stays away.
  std::int64_t last_heard_us() const { return last_heard_us_; }

 private:
  std::uint32_t send(frame& out);
  std::optional<answer> ask(frame& question);
  bool take(const frame& in);
  Link& link_;
  std::uint16_t session_;
  std::uint32_t sequence_ = 0;
  std::int64_t now_us_ = 0, last_heard_us_ = 0;
  frame_decoder decoder_{};
  std::optional<std::uint32_t> heard_sequence_;
  bool clock_begun_ = false;
  ClockMap clock_;
  std::optional<message_hello> hello_;
  std::optional<message_answer> answer_;
  std::optional<Telemetry> telemetry_;
  LinkCounters counters_;
  std::uint32_t awaited_sequence_ = 0;
  std::int64_t awaited_since_us_ = 0;
  std::vector<std::int64_t> round_trips_us_;
};

}  // namespace sinew::hil

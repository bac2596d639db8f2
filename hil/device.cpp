// SPDX-License-Identifier: Apache-2.0
#include "hil/device.h"

#include <algorithm>

namespace sinew::hil {
namespace {

// Asked again before a device that was armed, and whose answer was lost, takes the wait for silence.
constexpr std::int64_t hello_time_us = 300'000, answer_time_us = 100'000, us_per_byte = 20;
constexpr int tries = 9, hello_tries = 8;  // opening the port resets many boards, whose bootloader takes two seconds

template <std::size_t n>
std::string_view word_of(const std::array<std::string_view, n>& all, std::size_t i) {
  return i < n ? all[i] : std::string_view("unknown");
}

constexpr std::array<std::string_view, TRIP_CAUSES> trip_words{"none",
                                                               "silence",
                                                               "over_temperature",
                                                               "rate_of_rise",
                                                               "sensor_open",
                                                               "sensor_short_to_ground",
                                                               "sensor_short_to_supply",
                                                               "sensor_zeros",
                                                               "sensor_ones",
                                                               "sensor_garbled",
                                                               "sensor_range",
                                                               "sensor_jump",
                                                               "junction",
                                                               "sensor_stuck",
                                                               "not_following",
                                                               "unexpected_heating",
                                                               "on_time",
                                                               "sensor_silent",
                                                               "main_loop",
                                                               "watchdog",
                                                               "brown_out",
                                                               "reset_while_armed",
                                                               "latch_damaged",
                                                               "heat_bound",
                                                               "angle_range",
                                                               "angle_stuck",
                                                               "drain_low",
                                                               "supply_high"};
constexpr std::array<std::string_view, 5> reset_words{"power_on", "external", "brown_out", "watchdog", "unknown"};
constexpr std::array<std::string_view, 8> answer_words{"done",
                                                       "the firmware is another",
                                                       "the limits are others",
                                                       "tripped",
                                                       "a coil is not cool yet",
                                                       "a sensor is not believed",
                                                       "the trip is another",
                                                       "the board is set wrongly"};

}  // namespace

const std::array<std::string_view, DEVICE_COUNTERS> counter_names{"too_long",      "bad_stuffing",  "too_short",  "bad_check",
                                                                  "other_version", "unknown_type",  "bad_length", "stale",
                                                                  "out_of_order",  "other_session", "not_armed",  "too_much_duty",
                                                                  "lost_bytes"};

std::string_view words(trip_cause cause) { return word_of(trip_words, cause); }
std::string_view words(reset_cause cause) { return word_of(reset_words, cause); }
std::string_view words(answer answer) { return word_of(answer_words, answer); }

std::vector<std::string> words_of_settings(std::uint8_t wrong_settings) {
  std::vector<std::string> all;
  if (wrong_settings & SETTING_BROWN_OUT) all.emplace_back("brown-out detection is off, or not at 4.3 V");
  if (wrong_settings & SETTING_WATCHDOG) all.emplace_back("the watchdog is not always on");
  if (const unsigned rest = wrong_settings & ~static_cast<unsigned>(SETTING_BROWN_OUT | SETTING_WATCHDOG); rest != 0)
    all.emplace_back("bits " + std::to_string(rest) + " of the hello's last byte, which this program does not know");
  return all;
}

std::string misfit_of(const board_parts& parts) {
  const auto wrong = [](const char* what, int offset, int count, int least) {
    return "the board's hello, payload byte " + std::to_string(MESSAGE_HELLO_COILS_AT + static_cast<unsigned>(offset)) + ": " +
           std::to_string(count) + " " + what + "; must be " + std::to_string(least) + " to " + std::to_string(BOARD_PARTS_MOST);
  };
  if (parts.coils < 1 || parts.coils > BOARD_PARTS_MOST) return wrong("coils", 0, parts.coils, 1);
  if (parts.thermocouples > BOARD_PARTS_MOST) return wrong("thermocouples", 1, parts.thermocouples, 0);
  if (parts.angles > BOARD_PARTS_MOST) return wrong("angles", 2, parts.angles, 0);
  return "";
}

std::uint32_t Device::send(frame& out) {
  out.version = FRAME_VERSION;
  out.session = session_;
  out.sequence = ++sequence_;
  out.time_us = clock_begun_ ? clock_.device_us(now_us_) : 0;
  // A zero goes before it too, so that what was cut off or garbled ahead of it ends there.
  std::array<std::uint8_t, 1 + FRAME_WIRE_MOST> wire;
  wire[0] = 0;
  const std::size_t count = 1u + frame_encode(&out, wire.data() + 1);
  now_us_ = link_.send({wire.data(), count});
  ++counters_.sent;
  return out.sequence;
}

std::optional<message_hello> Device::hello(std::uint8_t telemetry_period_ms) {
  hello_.reset();
  const message_hello_request request{telemetry_period_ms};
  for (int i = 0; i < hello_tries && !hello_; ++i) {
    frame out{};
    put_hello_request(&out, &request);
    send(out);
    listen_until(now_us_ + hello_time_us, FRAME_HELLO);
  }
  return hello_;
}

// An answer to any of the tries is one: the question is the same.
std::optional<answer> Device::ask(frame& question) {
  answer_.reset();
  std::uint32_t first = 0;
  for (int i = 0; i < tries; ++i) {
    frame out = question;
    const std::uint32_t sequence = send(out);
    if (i == 0) first = sequence;
    const std::int64_t until_us = now_us_ + answer_time_us;
    while (now_us_ < until_us) {
      listen_until(until_us, FRAME_ANSWER);
      if (answer_ && answer_->type == question.type && answer_->sequence - first <= sequence - first)
        return static_cast<enum answer>(answer_->answer);
    }
  }
  return std::nullopt;
}

std::optional<answer> Device::arm(std::uint32_t firmware_hash, std::uint32_t limits_hash, std::uint8_t flags) {
  frame out{};
  const message_arm message{firmware_hash, limits_hash, flags};
  put_arm(&out, &message);
  return ask(out);
}
std::optional<answer> Device::clear_trip(std::uint8_t cause) {
  frame out{};
  const message_clear_trip message{cause};
  put_clear_trip(&out, &message);
  return ask(out);
}
std::optional<answer> Device::disarm() {
  frame out{};
  put_disarm(&out);
  return ask(out);
}

std::uint32_t Device::command(std::span<const std::uint16_t> duty, std::uint16_t time_to_live_ms) {
  frame out{};
  if (duty.size() != decoder_.parts.coils)
    throw std::logic_error(std::to_string(duty.size()) + " duties for a board of " + std::to_string(decoder_.parts.coils) + " coils");
  message_command message{};
  std::copy(duty.begin(), duty.end(), message.duty);
  message.time_to_live_ms = time_to_live_ms;
  put_command(&out, &decoder_.parts, &message);
  awaited_sequence_ = send(out);
  awaited_since_us_ = now_us_;
  return awaited_sequence_;
}

bool Device::take(const frame& in) {
  ++counters_.received;
  if (in.session != session_ || in.type < FRAME_HELLO) {  // of another session, or the line's echo of what was sent
    ++counters_.other_session;
    return false;
  }
  if (heard_sequence_ && static_cast<std::int32_t>(in.sequence - *heard_sequence_) <= 0) {
    // A device that was reset begins at 1 again; within one session a hello is the only frame that may say so.
    if (in.type != FRAME_HELLO) {
      ++counters_.out_of_order;
      return false;
    }
  } else if (heard_sequence_) {
    counters_.missing += in.sequence - *heard_sequence_ - 1;
  }
  heard_sequence_ = in.sequence;
  last_heard_us_ = now_us_;
  // What the wire itself takes is known, and is no latency.
  const std::int64_t left_us = now_us_ - us_per_byte * (in.length + FRAME_HEADER_BYTES + FRAME_CHECK_BYTES + 3);
  if (!clock_begun_) {
    clock_.begin(in.time_us, left_us);
    clock_begun_ = true;
  }
  const std::int64_t made_us = clock_.take(in.time_us, left_us);
  if (in.type == FRAME_HELLO) {
    hello_.emplace();
    get_hello(&in, &*hello_);
    decoder_.parts = board_parts_fit(&hello_->parts) ? hello_->parts : board_parts{};
  } else if (in.type == FRAME_ANSWER) {
    answer_.emplace();
    get_answer(&in, &*answer_);
  } else if (in.type == FRAME_TELEMETRY && board_parts_fit(&decoder_.parts)) {
    telemetry_.emplace();
    get_telemetry(&in, &decoder_.parts, &telemetry_->said);
    telemetry_->arrived_us = now_us_;
    telemetry_->made_us = made_us;
    if (awaited_sequence_ != 0 && telemetry_->said.last_sequence == awaited_sequence_) {
      round_trips_us_.push_back(now_us_ - awaited_since_us_);
      awaited_sequence_ = 0;
    }
  }
  return true;
}

void Device::listen_until(std::int64_t deadline_us, std::uint8_t stop_at) {
  for (;;) {
    const Received received = stop_at == 0 ? link_.receive_at(deadline_us) : link_.receive_until(deadline_us);
    now_us_ = received.now_us;
    bool stop = false;
    for (const std::uint8_t byte : received.bytes) {
      frame in;
      const frame_result result = frame_decoder_take(&decoder_, byte, &in);
      if (result == FRAME_READY && take(in) && in.type == stop_at) stop = true;
    }
    for (std::size_t i = 0; i < FRAME_FAULTS; ++i) counters_.refused[i] = decoder_.refused[i];
    if (stop || now_us_ >= deadline_us) return;
  }
}

}  // namespace sinew::hil

// SPDX-License-Identifier: Apache-2.0
#include "hil/wire_log.h"

#include <algorithm>

#include "sim/input_error.h"

namespace sinew::hil {
namespace {

void append_number(std::string& log, std::uint64_t value) {
  do {
    const auto low = static_cast<char>(value & 0x7f);
    value >>= 7;
    log += value ? static_cast<char>(low | static_cast<char>(0x80)) : low;
  } while (value);
}

constexpr std::string_view heading = "sinew wire 1\n";

}  // namespace

void LoggedLink::record(char kind, std::int64_t now_us, std::span<const std::uint8_t> bytes) {
  log_ += kind;
  append_number(log_, static_cast<std::uint64_t>(std::max<std::int64_t>(0, now_us - last_us_)));
  last_us_ = std::max(last_us_, now_us);
  append_number(log_, bytes.size());
  log_.append(bytes.begin(), bytes.end());
}

std::int64_t LoggedLink::send(std::span<const std::uint8_t> bytes) {
  std::int64_t now_us = 0;
  try {
    now_us = inner_.send(bytes);
  } catch (const LinkLost& lost) {
    const std::string why = lost.what();
    record('L', last_us_, {reinterpret_cast<const std::uint8_t*>(why.data()), why.size()});
    throw;
  }
  record('S', now_us, bytes);
  return last_us_;
}

Received LoggedLink::receive_until(std::int64_t deadline_us) { return received(&Link::receive_until, deadline_us); }
Received LoggedLink::receive_at(std::int64_t deadline_us) { return received(&Link::receive_at, deadline_us); }

// What came while something was sent is logged after it, at its time: time does not go back.
Received LoggedLink::received(Received (Link::*how)(std::int64_t), std::int64_t deadline_us) {
  try {
    Received received = (inner_.*how)(deadline_us);
    record('R', received.now_us, received.bytes);
    received.now_us = last_us_;
    return received;
  } catch (const LinkLost& lost) {
    const std::string why = lost.what();
    record('L', last_us_, {reinterpret_cast<const std::uint8_t*>(why.data()), why.size()});
    throw;
  }
}

ReplayLink::ReplayLink(std::string log, std::string file) : log_(std::move(log)), file_(std::move(file)) {
  if (!log_.starts_with(heading)) throw sim::InputError({.file = file_, .advice = "is no wire log of `sinew hil`"});
  at_ = heading.size();
}

void ReplayLink::damaged() const {
  throw sim::InputError({.file = file_, .key = "byte " + std::to_string(at_), .advice = "the log is cut off or damaged here"});
}

std::uint64_t ReplayLink::number() {
  std::uint64_t value = 0;
  for (unsigned shift = 0; shift < 63; shift += 7) {
    if (at_ == log_.size()) damaged();
    const auto byte = static_cast<std::uint8_t>(log_[at_++]);
    value |= std::uint64_t{byte & 0x7fu} << shift;
    if (byte < 0x80) return value;
  }
  damaged();
}

ReplayLink::Record ReplayLink::next() {
  if (at_ == log_.size()) throw ReplayDiffers("the session went on for longer than the log");
  const char kind = log_[at_++];
  if (kind != 'S' && kind != 'R' && kind != 'L') damaged();
  const std::uint64_t passed_us = number(), count = number();
  if (passed_us > 1'000'000'000'000'000u) damaged();  // thirty years: no time that a clock of this log shows
  now_us_ += static_cast<std::int64_t>(passed_us);
  if (count > log_.size() - at_) damaged();
  const std::span<const std::uint8_t> bytes{reinterpret_cast<const std::uint8_t*>(log_.data()) + at_, count};
  at_ += count;
  if (kind == 'L') throw LinkLost(std::string(bytes.begin(), bytes.end()));
  return {kind, bytes};
}

std::int64_t ReplayLink::send(std::span<const std::uint8_t> bytes) {
  const std::size_t here = at_;
  const Record record = next();
  if (record.kind != 'S' || !std::ranges::equal(record.bytes, bytes))
    throw ReplayDiffers("at byte " + std::to_string(here) + " of the log another frame was sent");
  return now_us_;
}

Received ReplayLink::receive_until(std::int64_t) {
  const std::size_t here = at_;
  const Record record = next();
  if (record.kind != 'R') throw ReplayDiffers("at byte " + std::to_string(here) + " of the log a frame was sent");
  return {now_us_, {record.bytes.begin(), record.bytes.end()}};
}

}  // namespace sinew::hil

// SPDX-License-Identifier: Apache-2.0
#include "hil/link.h"

#include <algorithm>
#include <memory>
#include <utility>

#include "sim/random.h"

namespace sinew::hil {

std::int64_t TamperedLink::send(std::span<const std::uint8_t> bytes) {
  if (!to_device_) return now_us_ = inner_.send(bytes);
  for (const Bytes& one : to_device_({bytes.begin(), bytes.end()}, now_us_)) now_us_ = inner_.send(one);
  return now_us_;
}

Received TamperedLink::receive_until(std::int64_t deadline_us) {
  for (;;) {
    Received received = inner_.receive_until(deadline_us);
    now_us_ = received.now_us;
    if (!from_device_ || received.bytes.empty()) return received;
    Bytes through;
    for (const std::uint8_t byte : received.bytes) {
      coming_.push_back(byte);
      if (byte != 0) continue;
      if (coming_.size() == 1) {
        through.push_back(std::exchange(coming_, {}).front());
        continue;
      }
      for (const Bytes& one : from_device_(std::exchange(coming_, {}), now_us_)) through.insert(through.end(), one.begin(), one.end());
    }
    if (!through.empty() || received.now_us >= deadline_us) return {received.now_us, std::move(through)};
  }
}

void LatentLink::hold(std::deque<Held>& way, Bytes bytes) {
  const double share = sim::RandomStream(seed_, "latency").uniform(count_++);
  const auto held_us = static_cast<std::int64_t>(share * static_cast<double>(latency_.most_us - latency_.least_us));
  const std::int64_t due_us = now_us_ + latency_.least_us + held_us;
  way.push_back({way.empty() ? due_us : std::max(due_us, way.back().due_us), std::move(bytes)});
}

void LatentLink::release() {
  for (; !to_device_.empty() && to_device_.front().due_us <= now_us_; to_device_.pop_front()) inner_.send(to_device_.front().bytes);
}

std::int64_t LatentLink::send(std::span<const std::uint8_t> bytes) {
  hold(to_device_, {bytes.begin(), bytes.end()});
  release();
  return now_us_;
}

Received LatentLink::receive_until(std::int64_t deadline_us) {
  for (bool looked = false;; looked = true) {
    release();
    if (!from_device_.empty() && from_device_.front().due_us <= now_us_) {
      Bytes bytes = std::move(from_device_.front().bytes);
      from_device_.pop_front();
      return {now_us_, std::move(bytes)};
    }
    if (looked && now_us_ >= deadline_us) return {now_us_, {}};
    std::int64_t until_us = deadline_us;
    for (const std::deque<Held>* way : {&to_device_, &from_device_})
      if (!way->empty()) until_us = std::min(until_us, way->front().due_us);
    Received received = inner_.receive_until(until_us);
    now_us_ = received.now_us;
    if (!received.bytes.empty()) hold(from_device_, std::move(received.bytes));
  }
}

Tamper corrupt_share(double share, std::uint64_t seed, const char* stream, std::int64_t& damaged) {
  auto count = std::make_shared<std::uint64_t>(0);
  const sim::RandomStream chance(seed, stream);
  return [=, &damaged](Bytes frame, std::int64_t) -> std::vector<Bytes> {
    const std::uint64_t n = (*count)++;
    if (chance.uniform(2 * n) < share) {
      const auto bit = static_cast<std::size_t>(chance.uniform(2 * n + 1) * 8.0 * static_cast<double>(frame.size()));
      frame[bit / 8] = static_cast<std::uint8_t>(frame[bit / 8] ^ (1u << (bit % 8)));
      ++damaged;
    }
    return {std::move(frame)};
  };
}

}  // namespace sinew::hil

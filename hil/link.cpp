// SPDX-License-Identifier: Apache-2.0
#include "hil/link.h"

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

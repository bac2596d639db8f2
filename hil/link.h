// SPDX-License-Identifier: Apache-2.0
// A way for bytes to the device and back, and the time at which they come. Whoever uses a link takes the time from it and
// from nowhere else; so a session can be played again from what its link gave (replay.h).
#pragma once

#include <cstdint>
#include <deque>
#include <functional>
#include <span>
#include <stdexcept>
#include <vector>

namespace sinew::hil {

using Bytes = std::vector<std::uint8_t>;

// End of file, an I/O error, a hang-up: the link is gone. What comes after is a new session.
class LinkLost : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

struct Received {
  std::int64_t now_us;  // monotonic
  Bytes bytes;
};

class Link {
 public:
  virtual ~Link() = default;
  // All of them, in order. Returns the time. Throws LinkLost.
  virtual std::int64_t send(std::span<const std::uint8_t> bytes) = 0;
  // As soon as bytes have come, or at the deadline, empty. A deadline that has passed still takes what has come. Throws
  // LinkLost.
  virtual Received receive_until(std::int64_t deadline_us) = 0;
  // The same, but not before the deadline: what had come until then, call after call with the times at which it came, and then nothing,
  // with the time. For whoever has to be on time at the deadline and has no use for bytes before it.
  virtual Received receive_at(std::int64_t deadline_us) { return receive_until(deadline_us); }
};

// A frame on its way: what becomes of it. Nothing: it is lost; two: it comes twice; another: it was damaged.
using Tamper = std::function<std::vector<Bytes>(Bytes frame, std::int64_t now_us)>;

// A link on which frames are tampered with. What was sent in one call is taken for one frame; what comes is cut at 0x00, and a
// zero by itself goes through.
class TamperedLink : public Link {
 public:
  TamperedLink(Link& inner, Tamper to_device, Tamper from_device)
      : inner_(inner), to_device_(std::move(to_device)), from_device_(std::move(from_device)) {}
  std::int64_t send(std::span<const std::uint8_t> bytes) override;
  Received receive_until(std::int64_t deadline_us) override;

 private:
  Link& inner_;
  Tamper to_device_, from_device_;
  std::int64_t now_us_ = 0;
  Bytes coming_;
};

// A link that holds back what goes through it, each call's bytes for a time by chance between two; nothing overtakes.
class LatentLink : public Link {
 public:
  struct Latency {
    std::int64_t least_us, most_us;
  };
  LatentLink(Link& inner, Latency latency, std::uint64_t seed) : inner_(inner), latency_(latency), seed_(seed) {}
  std::int64_t send(std::span<const std::uint8_t> bytes) override;
  Received receive_until(std::int64_t deadline_us) override;

 private:
  struct Held {
    std::int64_t due_us;
    Bytes bytes;
  };
  void hold(std::deque<Held>& way, Bytes bytes);
  void release();
  Link& inner_;
  Latency latency_;
  std::uint64_t seed_, count_ = 0;
  std::int64_t now_us_ = 0;
  std::deque<Held> to_device_, from_device_;
};

// One bit of that share of the frames is turned, which and where by chance from the seed. `damaged` counts them.
Tamper corrupt_share(double share, std::uint64_t seed, const char* stream, std::int64_t& damaged);

}  // namespace sinew::hil

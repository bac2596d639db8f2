// SPDX-License-Identifier: Apache-2.0
// All that a session sent and received, in order and with times: enough to play it again without hardware.
//
//   "sinew wire 1\n", then records: 'S' (sent), 'R' (received, possibly nothing) or 'L' (link lost, the bytes are the
//   reason); the time since the record before in microseconds and the number of bytes, each as LEB128; the bytes.
#pragma once

#include <string>

#include "hil/link.h"

namespace sinew::hil {

// Writes down what passes.
class LoggedLink : public Link {
 public:
  explicit LoggedLink(Link& inner) : inner_(inner) {}
  std::int64_t send(std::span<const std::uint8_t> bytes) override;
  Received receive_until(std::int64_t deadline_us) override;
  Received receive_at(std::int64_t deadline_us) override;
  const std::string& log() const { return log_; }
  // So that it need not grow while time matters.
  void reserve(std::size_t bytes) { log_.reserve(bytes); }

 private:
  void record(char kind, std::int64_t now_us, std::span<const std::uint8_t> bytes);
  Received received(Received (Link::*how)(std::int64_t), std::int64_t deadline_us);
  Link& inner_;
  std::int64_t last_us_ = 0;
  std::string log_ = "sinew wire 1\n";
};

// The session did not send what it had sent then: other scenario, other program, damaged log.
class ReplayDiffers : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

// Gives what was received, and insists on what was sent. Throws ReplayDiffers, or sim::InputError for a log that is none.
class ReplayLink : public Link {
 public:
  ReplayLink(std::string log, std::string file);
  std::int64_t send(std::span<const std::uint8_t> bytes) override;
  Received receive_until(std::int64_t deadline_us) override;
  bool at_end() const { return at_ == log_.size(); }

 private:
  struct Record {
    char kind;
    std::span<const std::uint8_t> bytes;
  };
  Record next();
  std::uint64_t number();
  [[noreturn]] void damaged() const;
  std::string log_, file_;
  std::size_t at_ = 0;
  std::int64_t now_us_ = 0;
};

}  // namespace sinew::hil

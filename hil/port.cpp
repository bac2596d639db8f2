// SPDX-License-Identifier: Apache-2.0
#include "hil/port.h"

#include <poll.h>
#include <sys/eventfd.h>
#include <sys/file.h>
#include <sys/ioctl.h>
#include <sys/stat.h>
#include <sys/sysmacros.h>
#include <termios.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <asio/io_context.hpp>
#include <asio/serial_port.hpp>
#include <atomic>
#include <cerrno>
#include <cstring>
#include <ctime>
#include <optional>
#include <thread>

#include "sim/input_error.h"

namespace sinew::hil {
namespace {

constexpr unsigned baud = 500'000;
constexpr std::int64_t longest_write_us = 500'000;

[[noreturn]] void fail(const std::string& path, const std::string& what, const std::string& advice) {
  throw sim::InputError({.key = "--port", .value = path, .advice = what + "\n" + advice});
}

// Its other end holds this one open too, so that hosts may come and go: what TIOCEXCL says of it would outlive the session, and nobody but
// root would open it again. A lock by flock() ends with the process.
bool is_pseudo_terminal(int descriptor) {
  struct stat facts {};
  constexpr unsigned first = 136, last = 143;  // Linux, Documentation/admin-guide/devices.txt: Unix98 PTY slaves
  return ::fstat(descriptor, &facts) == 0 && major(facts.st_rdev) >= first && major(facts.st_rdev) <= last;
}

}  // namespace

class Port::Implementation {
 public:
  Implementation(const std::string& path, const Clock& passed) : clock(passed), port(context) {
    asio::error_code error;
    port.open(path, error);
    if (error.value() == ENOENT) fail(path, "no such port", "is the board plugged in? `ls /dev/serial/by-id` names those that are");
    if (error.value() == EACCES)
      fail(path, "permission denied", "add yourself to the group that owns it: sudo adduser $USER dialout, then log in anew");
    if (error.value() == EBUSY) fail(path, "in use", "another program has the port open: close it");
    if (error) fail(path, error.message(), "must be a serial port");
    if (::flock(port.native_handle(), LOCK_EX | LOCK_NB) != 0 ||
        (!is_pseudo_terminal(port.native_handle()) && ::ioctl(port.native_handle(), TIOCEXCL) != 0))
      fail(path, "in use", "another session has the port: end it first");
    using asio::serial_port_base;
    port.set_option(serial_port_base::baud_rate(baud), error);
    if (!error) port.set_option(serial_port_base::character_size(8), error);
    if (!error) port.set_option(serial_port_base::parity(serial_port_base::parity::none), error);
    if (!error) port.set_option(serial_port_base::stop_bits(serial_port_base::stop_bits::one), error);
    if (!error) port.set_option(serial_port_base::flow_control(serial_port_base::flow_control::none), error);
    if (error) fail(path, error.message(), "the port cannot do 500000 Bd, 8N1");
    ::tcflush(port.native_handle(), TCIOFLUSH);
    wake = ::eventfd(0, EFD_CLOEXEC | EFD_NONBLOCK);
    if (wake < 0) throw std::runtime_error(std::string("eventfd: ") + std::strerror(errno));
    reader = std::thread([this] { read_on(); });
  }
  ~Implementation() {
    const std::uint64_t one = 1;
    [[maybe_unused]] const ssize_t put = ::write(wake, &one, sizeof one);
    reader.join();
    ::close(wake);
  }
  Implementation(const Implementation&) = delete;
  Implementation& operator=(const Implementation&) = delete;

  // The next bytes that came, if any did; throws LinkLost once the reader has said why it ended, and all before that was taken.
  std::optional<Received> next() {
    const bool ended = lost.load(std::memory_order_acquire);
    const std::size_t at = taken.load(std::memory_order_relaxed);
    if (at == filled.load(std::memory_order_acquire)) {
      if (ended) throw LinkLost(why_lost);
      return std::nullopt;
    }
    const Chunk& chunk = chunks[at % chunks.size()];
    Received received{chunk.at_us, {chunk.bytes.begin(), chunk.bytes.begin() + static_cast<std::ptrdiff_t>(chunk.count)}};
    taken.store(at + 1, std::memory_order_release);
    return received;
  }
  void sleep_until(std::int64_t time_us) const {
    timespec until{};
    ::clock_gettime(CLOCK_MONOTONIC, &until);
    const std::int64_t left_us = std::max<std::int64_t>(0, time_us - clock.now_us());
    const std::int64_t ns = until.tv_nsec + left_us % 1'000'000 * 1000;
    until.tv_sec += left_us / 1'000'000 + ns / 1'000'000'000;
    until.tv_nsec = ns % 1'000'000'000;
    while (::clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &until, nullptr) == EINTR) {
    }
  }
  // Bytes that the terminal has, or that the reader is about to hand over. Asked in this order: what was read meanwhile is in the queue.
  bool more_comes() const {
    pollfd look{port.native_handle(), POLLIN, 0};  // FIONREAD does not see what a pseudo-terminal has under way
    return (::poll(&look, 1, 0) > 0 && !lost.load()) || reading.load();
  }

  const Clock& clock;
  asio::io_context context;
  mutable asio::serial_port port;

 private:
  void end(const std::string& why) {
    why_lost = why;
    lost.store(true, std::memory_order_release);
  }
  void read_on() {
    const int descriptor = port.native_handle();
    for (;;) {
      std::array<pollfd, 2> wait{{{descriptor, POLLIN, 0}, {wake, POLLIN, 0}}};
      if (::poll(wait.data(), wait.size(), -1) < 0) {
        if (errno == EINTR) continue;
        return end(std::string("waiting failed: ") + std::strerror(errno));
      }
      if (wait[1].revents) return;
      const std::size_t at = filled.load(std::memory_order_relaxed);
      if (at - taken.load(std::memory_order_acquire) == chunks.size()) {  // nobody takes: the terminal keeps the rest
        sleep_until(clock.now_us() + 1000);
        continue;
      }
      Chunk& chunk = chunks[at % chunks.size()];
      reading.store(true);
      const ssize_t got = ::read(descriptor, chunk.bytes.data(), chunk.bytes.size());
      if (got > 0) {
        chunk.at_us = clock.now_us();
        chunk.count = static_cast<std::size_t>(got);
        filled.store(at + 1, std::memory_order_release);
        reading.store(false);
        continue;
      }
      reading.store(false);
      if (got == 0) return end("the port was closed at the other end");
      if (errno != EAGAIN && errno != EINTR) return end(std::string("reading failed: ") + std::strerror(errno));
      if (wait[0].revents & (POLLHUP | POLLERR | POLLNVAL)) return end("the port hung up");
    }
  }
  struct Chunk {
    std::int64_t at_us;
    std::size_t count;
    std::array<std::uint8_t, 512> bytes;
  };
  std::array<Chunk, 512> chunks;  // a power of two; a second of telemetry at 200 Hz, byte groups as they come
  std::atomic<std::size_t> filled{0}, taken{0};
  std::atomic<bool> lost{false}, reading{false};
  std::string why_lost;
  int wake = -1;
  std::thread reader;
};

Port::Port(const std::string& path, const Clock& clock) : implementation_(std::make_unique<Implementation>(path, clock)) {}
Port::~Port() = default;

std::int64_t Port::send(std::span<const std::uint8_t> bytes) {
  const int descriptor = implementation_->port.native_handle();
  const std::int64_t give_up_us = implementation_->clock.now_us() + longest_write_us;
  while (!bytes.empty()) {
    const ssize_t put = ::write(descriptor, bytes.data(), bytes.size());
    if (put > 0) {
      bytes = bytes.subspan(static_cast<std::size_t>(put));
    } else if (put < 0 && errno == EAGAIN) {
      pollfd wait{descriptor, POLLOUT, 0};
      ::poll(&wait, 1, 10);
      if (implementation_->clock.now_us() > give_up_us) throw LinkLost("the port takes no more bytes");
    } else if (!(put < 0 && errno == EINTR)) {
      throw LinkLost(std::string("writing failed: ") + std::strerror(errno));
    }
  }
  return implementation_->clock.now_us();
}

// In steps, since only who waits for the terminal itself is woken by it.
Received Port::receive_until(std::int64_t deadline_us) {
  constexpr std::int64_t step_us = 500;
  for (;;) {
    if (auto received = implementation_->next()) return *std::move(received);
    const std::int64_t now_us = implementation_->clock.now_us();
    if (now_us >= deadline_us && !implementation_->more_comes()) {
      if (auto received = implementation_->next()) return *std::move(received);
      return {now_us, {}};
    }
    implementation_->sleep_until(now_us >= deadline_us ? now_us + step_us : std::min(deadline_us, now_us + step_us));
  }
}

Received Port::receive_at(std::int64_t deadline_us) {
  if (implementation_->clock.now_us() < deadline_us) implementation_->sleep_until(deadline_us);
  if (auto received = implementation_->next()) return *std::move(received);
  return {implementation_->clock.now_us(), {}};
}

}  // namespace sinew::hil

// SPDX-License-Identifier: Apache-2.0
#include "hil/port.h"

#include <poll.h>
#include <sys/file.h>
#include <sys/ioctl.h>
#include <termios.h>
#include <unistd.h>

#include <array>
#include <asio/io_context.hpp>
#include <asio/serial_port.hpp>
#include <cerrno>
#include <cstring>

#include "sim/input_error.h"

namespace sinew::hil {
namespace {

constexpr unsigned baud = 500'000;
constexpr std::int64_t longest_write_us = 500'000;

[[noreturn]] void fail(const std::string& path, const std::string& what, const std::string& advice) {
  throw sim::InputError({.key = "--port", .value = path, .advice = what + "\n" + advice});
}

}  // namespace

class Port::Implementation {
 public:
  Implementation(const std::string& path, const Clock& given) : clock(given), port(context) {
    asio::error_code error;
    port.open(path, error);
    if (error.value() == ENOENT) fail(path, "no such port", "is the board plugged in? `ls /dev/serial/by-id` names those that are");
    if (error.value() == EACCES)
      fail(path, "permission denied", "add yourself to the group that owns it: sudo adduser $USER dialout, then log in anew");
    if (error.value() == EBUSY) fail(path, "in use", "another program has the port open: close it");
    if (error) fail(path, error.message(), "must be a serial port");
    if (::ioctl(port.native_handle(), TIOCEXCL) != 0 || ::flock(port.native_handle(), LOCK_EX | LOCK_NB) != 0)
      fail(path, "in use", "another session has the port: end it first");
    using asio::serial_port_base;
    port.set_option(serial_port_base::baud_rate(baud), error);
    if (!error) port.set_option(serial_port_base::character_size(8), error);
    if (!error) port.set_option(serial_port_base::parity(serial_port_base::parity::none), error);
    if (!error) port.set_option(serial_port_base::stop_bits(serial_port_base::stop_bits::one), error);
    if (!error) port.set_option(serial_port_base::flow_control(serial_port_base::flow_control::none), error);
    if (error) fail(path, error.message(), "the port cannot do 500000 Bd, 8N1");
    ::tcflush(port.native_handle(), TCIOFLUSH);
  }
  const Clock& clock;
  asio::io_context context;
  asio::serial_port port;
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

Received Port::receive_until(std::int64_t deadline_us) {
  const int descriptor = implementation_->port.native_handle();
  for (;;) {
    const std::int64_t left_us = std::max<std::int64_t>(0, deadline_us - implementation_->clock.now_us());
    const timespec timeout{left_us / 1'000'000, left_us % 1'000'000 * 1000};
    pollfd wait{descriptor, POLLIN, 0};
    const int ready = ::ppoll(&wait, 1, &timeout, nullptr);
    if (ready < 0 && errno != EINTR) throw LinkLost(std::string("waiting failed: ") + std::strerror(errno));
    if (ready > 0) {
      std::array<std::uint8_t, 4096> buffer;
      const ssize_t got = ::read(descriptor, buffer.data(), buffer.size());
      if (got > 0) return {implementation_->clock.now_us(), {buffer.begin(), buffer.begin() + got}};
      if (got == 0) throw LinkLost("the port was closed at the other end");
      if (errno != EAGAIN && errno != EINTR) throw LinkLost(std::string("reading failed: ") + std::strerror(errno));
      if (wait.revents & (POLLHUP | POLLERR | POLLNVAL)) throw LinkLost("the port hung up");
    }
    const std::int64_t now_us = implementation_->clock.now_us();
    if (now_us >= deadline_us) return {now_us, {}};
  }
}

}  // namespace sinew::hil

// SPDX-License-Identifier: Apache-2.0
// The port over a pseudo-terminal, in real time: what the kernel does, not what a fake believes it does.
#include "hil/port.h"

#include <doctest/doctest.h>
#include <fcntl.h>
#include <stdlib.h>
#include <sys/ioctl.h>
#include <unistd.h>

#include <array>
#include <string>
#include <thread>

#include "sim/input_error.h"

namespace hil_port_test {

using namespace sinew::hil;

namespace {

struct Terminal {
  int ours = -1;
  std::string name;
  Terminal() {
    ours = ::posix_openpt(O_RDWR | O_NOCTTY | O_CLOEXEC);
    REQUIRE(ours >= 0);
    REQUIRE(::grantpt(ours) == 0);
    REQUIRE(::unlockpt(ours) == 0);
    name = ::ptsname(ours);
  }
  ~Terminal() { hang_up(); }
  void hang_up() {
    if (ours >= 0) ::close(ours);
    ours = -1;
  }
};

const MonotonicClock monotonic;

std::string error_of(const std::string& path) {
  try {
    Port port(path, monotonic);
  } catch (const sinew::sim::InputError& error) {
    return error.what();
  }
  return "";
}

}  // namespace

TEST_CASE("port: every byte goes through both ways as it is") {
  Terminal terminal;
  Port port(terminal.name, monotonic);
  std::array<std::uint8_t, 256> all;
  for (std::size_t i = 0; i < 256; ++i) all[i] = static_cast<std::uint8_t>(i);
  port.send(all);
  std::array<std::uint8_t, 256> there{};
  std::size_t count = 0;
  while (count < 256) {
    const ssize_t got = ::read(terminal.ours, there.data() + count, 256 - count);
    REQUIRE(got > 0);
    count += static_cast<std::size_t>(got);
  }
  CHECK(there == all);
  REQUIRE(::write(terminal.ours, all.data(), 256) == 256);
  Bytes back;
  while (back.size() < 256) {
    const Received received = port.receive_until(monotonic.now_us() + 1'000'000);
    REQUIRE_FALSE(received.bytes.empty());
    back.insert(back.end(), received.bytes.begin(), received.bytes.end());
  }
  CHECK(std::equal(back.begin(), back.end(), all.begin()));
}

TEST_CASE("port: without bytes it returns at the deadline, not before") {
  Terminal terminal;
  Port port(terminal.name, monotonic);
  const std::int64_t deadline_us = monotonic.now_us() + 30'000;
  const Received received = port.receive_until(deadline_us);
  CHECK(received.bytes.empty());
  CHECK(received.now_us >= deadline_us);
  CHECK(received.now_us < deadline_us + 500'000);  // a busy machine may be late; that it returns is what counts
}

TEST_CASE("port: a deadline that has passed still takes what has come") {
  Terminal terminal;
  Port port(terminal.name, monotonic);
  REQUIRE(::write(terminal.ours, "x", 1) == 1);
  CHECK(port.receive_until(monotonic.now_us() - 1'000'000).bytes.size() == 1);
}

TEST_CASE("port: a second opener is refused while the first has it, and not afterwards") {
  Terminal terminal;
  {
    Port port(terminal.name, monotonic);
    CHECK(error_of(terminal.name).find("in use") != std::string::npos);
  }
  CHECK(error_of(terminal.name).empty());
}

TEST_CASE("port: a pseudo-terminal whose other end holds it open, as sinew-board does, can be opened again by who is not root") {
  Terminal terminal;
  const int theirs = ::open(terminal.name.c_str(), O_RDWR | O_NOCTTY | O_CLOEXEC);
  REQUIRE(theirs >= 0);
  { Port port(terminal.name, monotonic); }
  // Root may open it all the same, so the terminal itself is asked.
  int exclusive = -1;
  CHECK(::ioctl(theirs, TIOCGEXCL, &exclusive) == 0);
  CHECK(exclusive == 0);
  ::close(theirs);
}

TEST_CASE("port: the other end closing is a lost link, for reader and writer") {
  Terminal terminal;
  Port port(terminal.name, monotonic);
  terminal.hang_up();
  CHECK_THROWS_AS(port.receive_until(monotonic.now_us() + 1'000'000), LinkLost);
  const std::array<std::uint8_t, 1> byte{1};
  CHECK_THROWS_AS(port.send(byte), LinkLost);
}

TEST_CASE("port: who does not read for half a second is a lost link, not a host that hangs") {
  Terminal terminal;
  Port port(terminal.name, monotonic);
  const Bytes much(1 << 20, 1);
  CHECK_THROWS_AS(port.send(much), LinkLost);
}

TEST_CASE("port: what is no port says so, with what to do") {
  CHECK(error_of("/dev/serial/by-id/nothing").find("no such port") != std::string::npos);
  CHECK(error_of("/dev/null").find("--port") != std::string::npos);
  CHECK(error_of("/tmp").find("--port") != std::string::npos);
}

}  // namespace hil_port_test

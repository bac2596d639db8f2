// SPDX-License-Identifier: Apache-2.0
#include "hil/frame.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <cstdint>
#include <cstring>
#include <vector>

#include "hil/message.h"
#include "sim/random.h"

namespace {

using Wire = std::vector<std::uint8_t>;

const std::uint8_t all_types[] = {FRAME_HELLO_REQUEST, FRAME_ARM,   FRAME_DISARM, FRAME_COMMAND,
                                  FRAME_CLEAR_TRIP,    FRAME_HELLO, FRAME_ANSWER, FRAME_TELEMETRY};

frame some_frame(std::uint8_t type, std::uint64_t n) {
  const sinew::sim::RandomStream chance(11, "frame_test");
  frame f{};
  f.version = FRAME_VERSION;
  f.type = type;
  f.session = static_cast<std::uint16_t>(chance.bits(100 * n));
  f.sequence = static_cast<std::uint32_t>(chance.bits(100 * n + 1));
  f.time_us = static_cast<std::uint32_t>(chance.bits(100 * n + 2));
  f.length = frame_payload_length(type);
  // A third of the bytes are zeros, which is what stuffing is about.
  for (std::uint8_t i = 0; i < f.length; ++i) {
    const std::uint64_t bits = chance.bits(100 * n + 3 + i);
    f.payload[i] = bits % 3 == 0 ? std::uint8_t{0} : static_cast<std::uint8_t>(bits >> 8);
  }
  return f;
}

Wire encoded(const frame& f) {
  Wire wire(FRAME_WIRE_MOST);
  wire.resize(frame_encode(&f, wire.data()));
  return wire;
}

// Header, payload and CRC as they are given, stuffed by hand: for frames that frame_encode does not make.
Wire stuffed(Wire plain) {
  const std::uint32_t check = frame_crc32(plain.data(), static_cast<std::uint16_t>(plain.size()));
  for (int i = 0; i < 4; ++i) plain.push_back(static_cast<std::uint8_t>(check >> (8 * i)));
  Wire wire{0};
  std::size_t at = 0;
  for (const std::uint8_t byte : plain) {
    if (byte == 0) {
      wire[at] = static_cast<std::uint8_t>(wire.size() - at);
      at = wire.size();
    }
    wire.push_back(byte);
  }
  wire[at] = static_cast<std::uint8_t>(wire.size() - at);
  wire.push_back(0);
  return wire;
}

struct Decoded {
  std::vector<frame> frames;
  frame_decoder decoder{};
  Decoded() { frame_decoder_start(&decoder); }
  explicit Decoded(const Wire& wire) : Decoded() { take(wire); }
  void take(const Wire& wire) {
    for (const std::uint8_t byte : wire) {
      frame f{};
      if (frame_decoder_take(&decoder, byte, &f) == FRAME_READY) frames.push_back(f);
    }
  }
  int refused() const {
    int sum = 0;
    for (const std::uint16_t n : decoder.refused) sum += n;
    return sum;
  }
};

bool same(const frame& a, const frame& b) {
  return a.version == b.version && a.type == b.type && a.session == b.session && a.sequence == b.sequence &&
         a.time_us == b.time_us && a.length == b.length && std::memcmp(a.payload, b.payload, a.length) == 0;
}

}  // namespace

TEST_CASE("frame: the CRC is the one that everybody calls CRC-32") {
  const char digits[] = "123456789";
  CHECK(frame_crc32(reinterpret_cast<const std::uint8_t*>(digits), 9) == 0xcbf43926u);
}

TEST_CASE("frame: a disarm frame is, byte for byte, the one of docs/protocol.md") {
  frame f{};
  f.version = 1;
  f.type = FRAME_DISARM;
  f.session = 0x0102;
  f.sequence = 5;
  f.time_us = 0x01000000;
  // By Python's zlib.crc32 and by hand.
  CHECK(encoded(f) == Wire{0x06, 0x01, 0x03, 0x02, 0x01, 0x05, 0x01, 0x01, 0x01, 0x01, 0x01, 0x06, 0x01, 0x8d, 0x16, 0xfb, 0x55, 0x00});
}

TEST_CASE("frame: what is encoded is decoded, for every type, and has no zero but its last byte") {
  for (const std::uint8_t type : all_types)
    for (std::uint64_t n = 0; n < 200; ++n) {
      const frame f = some_frame(type, n);
      const Wire wire = encoded(f);
      REQUIRE(wire.size() <= FRAME_WIRE_MOST);
      REQUIRE(std::count(wire.begin(), wire.end(), 0) == 1);
      const Decoded decoded(wire);
      REQUIRE(decoded.frames.size() == 1);
      CHECK(same(decoded.frames.front(), f));
      CHECK(decoded.refused() == 0);
    }
}

TEST_CASE("frame: a bit flip at any place is refused, and the frame after the next is taken") {
  for (const std::uint8_t type : all_types) {
    const frame f = some_frame(type, 7);
    const Wire wire = encoded(f);
    for (std::size_t bit = 0; bit < 8 * wire.size(); ++bit) {
      Wire damaged = wire;
      damaged[bit / 8] = static_cast<std::uint8_t>(damaged[bit / 8] ^ (1u << (bit % 8)));
      Decoded decoded(damaged);
      CAPTURE(static_cast<int>(type));
      CAPTURE(bit);
      CHECK(decoded.frames.empty());
      // Where the ending 0x00 was hit, this and the next frame are one.
      decoded.take(wire);
      decoded.take(wire);
      CHECK(decoded.frames.size() >= 1);
      CHECK(decoded.refused() >= 1);
    }
  }
}

TEST_CASE("frame: two and three flipped bits are refused, at places drawn a hundred thousand times") {
  const sinew::sim::RandomStream chance(12, "frame_test.bits");
  const Wire wire = encoded(some_frame(FRAME_TELEMETRY, 3));
  const Wire command = encoded(some_frame(FRAME_COMMAND, 3));
  for (std::uint64_t n = 0; n < 100000; ++n) {
    Wire damaged = n % 2 ? wire : command;
    for (std::uint64_t k = 0; k < 2 + n % 3 / 2; ++k) {
      const auto bit = static_cast<std::size_t>(chance.bits(4 * n + k) % (8 * (damaged.size() - 1)));
      damaged[bit / 8] = static_cast<std::uint8_t>(damaged[bit / 8] ^ (1u << (bit % 8)));
    }
    if (damaged == wire || damaged == command) continue;
    if (!Decoded(damaged).frames.empty()) FAIL("taken in draw " << n);
  }
}

TEST_CASE("frame: cut off anywhere it is refused, and the next one is taken") {
  const Wire wire = encoded(some_frame(FRAME_TELEMETRY, 5)), next = encoded(some_frame(FRAME_COMMAND, 6));
  for (std::size_t length = 1; length + 1 < wire.size(); ++length) {
    Decoded decoded(Wire(wire.begin(), wire.begin() + static_cast<std::ptrdiff_t>(length)));
    decoded.take({0});
    CHECK(decoded.frames.empty());
    CHECK(decoded.refused() == 1);
    decoded.take(next);
    CHECK(decoded.frames.size() == 1);
  }
}

TEST_CASE("frame: each way of refusing has a counter of its own") {
  const auto counted = [](const Wire& wire, frame_fault fault) {
    const Decoded decoded(wire);
    return decoded.frames.empty() && decoded.refused() == 1 && decoded.decoder.refused[fault] == 1;
  };
  const Wire header{1, FRAME_DISARM, 2, 1, 5, 0, 0, 0, 0, 0, 0, 1};
  CHECK(Decoded(stuffed(header)).frames.size() == 1);  // valid as it stands
  Wire longest(FRAME_WIRE_MOST + 40, 1);
  longest.push_back(0);
  CHECK(counted(longest, FRAME_TOO_LONG));
  CHECK(counted({9, 1, 1, 0}, FRAME_BAD_STUFFING));
  CHECK(counted({3, 1, 1, 0}, FRAME_TOO_SHORT));
  Wire other = stuffed(header);
  other[1] = 2;
  CHECK(counted(other, FRAME_BAD_CHECK));
  Wire version = header;
  version[0] = 2;
  CHECK(counted(stuffed(version), FRAME_OTHER_VERSION));
  Wire type = header;
  type[1] = 0x77;
  CHECK(counted(stuffed(type), FRAME_UNKNOWN_TYPE));
  Wire length = header;
  length.push_back(9);
  CHECK(counted(stuffed(length), FRAME_BAD_LENGTH));
}

TEST_CASE("frame: zeros between frames are nothing") {
  Decoded decoded(Wire{0, 0, 0});
  decoded.take(encoded(some_frame(FRAME_ARM, 1)));
  decoded.take({0, 0});
  CHECK(decoded.frames.size() == 1);
  CHECK(decoded.refused() == 0);
}

TEST_CASE("frame: two million bytes of chance are never a frame") {
  const sinew::sim::RandomStream chance(13, "frame_test.fuzz");
  Decoded decoded;
  for (std::uint64_t n = 0; n < 250000; ++n) {
    const std::uint64_t bits = chance.bits(n);
    Wire wire(8);
    // Zeros are as frequent as frames need them to be.
    for (int i = 0; i < 8; ++i) {
      const auto byte = static_cast<std::uint8_t>(bits >> (8 * i));
      wire[static_cast<std::size_t>(i)] = byte < 8 ? std::uint8_t{0} : byte;
    }
    decoded.take(wire);
  }
  CHECK(decoded.frames.empty());
  CHECK(decoded.refused() > 10000);
}

TEST_CASE("message: every payload reads back as it was written") {
  frame f{};
  const message_arm arm{0x12345678u, 0x9abcdef0u};
  put_arm(&f, &arm);
  message_arm arm_back{};
  get_arm(&f, &arm_back);
  CHECK(arm_back.firmware_hash == arm.firmware_hash);
  CHECK(arm_back.limits_hash == arm.limits_hash);

  const message_command command{{6000, 1}, 220};
  put_command(&f, &command);
  CHECK(f.length == MESSAGE_COMMAND_BYTES);
  message_command command_back{};
  get_command(&f, &command_back);
  CHECK(command_back.duty[0] == 6000);
  CHECK(command_back.duty[1] == 1);
  CHECK(command_back.time_to_live_ms == 220);

  const message_hello hello{1, 2, RESET_WATCHDOG, DEVICE_TRIPPED, TRIP_SILENCE};
  put_hello(&f, &hello);
  CHECK(f.length == MESSAGE_HELLO_BYTES);
  message_hello hello_back{};
  get_hello(&f, &hello_back);
  CHECK(hello_back.limits_hash == 2);
  CHECK(hello_back.trip_cause == TRIP_SILENCE);

  const message_answer answered{FRAME_ARM, ANSWER_HOT, 77};
  put_answer(&f, &answered);
  CHECK(f.length == MESSAGE_ANSWER_BYTES);
  message_answer answered_back{};
  get_answer(&f, &answered_back);
  CHECK(answered_back.answer == ANSWER_HOT);
  CHECK(answered_back.sequence == 77);

  message_telemetry telemetry{};
  telemetry.last_sequence = 70000;
  telemetry.temperature_cdegC[1] = -1275;
  telemetry.angle_cdeg = -4475;
  telemetry.thermocouple_raw[0] = 0xfffffff0u;
  telemetry.counters[DEVICE_COUNTERS - 1] = 65535;
  put_telemetry(&f, &telemetry);
  CHECK(f.length == MESSAGE_TELEMETRY_BYTES);
  CHECK(f.length <= FRAME_PAYLOAD_MOST);
  message_telemetry back{};
  get_telemetry(&f, &back);
  CHECK(back.last_sequence == 70000);
  CHECK(back.temperature_cdegC[1] == -1275);
  CHECK(back.angle_cdeg == -4475);
  CHECK(back.thermocouple_raw[0] == 0xfffffff0u);
  CHECK(back.counters[DEVICE_COUNTERS - 1] == 65535);
}

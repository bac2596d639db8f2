// SPDX-License-Identifier: Apache-2.0
#include "hil/frame.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <cstdint>
#include <cstring>
#include <string>
#include <vector>

#include "hil/limits.h"
#include "hil/message.h"
#include "sim/random.h"

namespace hil_frame_test {

namespace {

using Wire = std::vector<std::uint8_t>;

const std::uint8_t all_types[] = {FRAME_HELLO_REQUEST, FRAME_ARM,   FRAME_DISARM, FRAME_COMMAND,
                                  FRAME_CLEAR_TRIP,    FRAME_HELLO, FRAME_ANSWER, FRAME_TELEMETRY};

// Of the board of this repository; and all that the wire carries.
constexpr board_parts two_coils{2, 2, 1}, most_parts{BOARD_PARTS_MOST, BOARD_PARTS_MOST, BOARD_PARTS_MOST};

frame some_frame(std::uint8_t type, std::uint64_t n, const board_parts& parts = two_coils) {
  const sinew::sim::RandomStream chance(11, "frame_test");
  frame f{};
  f.version = FRAME_VERSION;
  f.type = type;
  f.session = static_cast<std::uint16_t>(chance.bits(100 * n));
  f.sequence = static_cast<std::uint32_t>(chance.bits(100 * n + 1));
  f.time_us = static_cast<std::uint32_t>(chance.bits(100 * n + 2));
  f.length = frame_payload_length(type, &parts);
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

std::string hexadecimal(const Wire& wire) {
  std::string text;
  for (const std::uint8_t byte : wire)
    for (const int half : {byte >> 4, byte & 15}) text += "0123456789abcdef"[half];
  return text;
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
  explicit Decoded(const board_parts& parts = two_coils) { frame_decoder_start(&decoder, &parts); }
  explicit Decoded(const Wire& wire, const board_parts& parts = two_coils) : Decoded(parts) { take(wire); }
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
  return a.version == b.version && a.type == b.type && a.session == b.session && a.sequence == b.sequence && a.time_us == b.time_us &&
         a.length == b.length && std::memcmp(a.payload, b.payload, a.length) == 0;
}

}  // namespace

TEST_CASE("frame: the CRC is the one that everybody calls CRC-32") {
  const char digits[] = "123456789";
  CHECK(frame_crc32(reinterpret_cast<const std::uint8_t*>(digits), 9) == 0xcbf43926u);
}

TEST_CASE("frame: a disarm frame is, byte for byte, the one of docs/protocol.md") {
  frame f{};
  f.version = FRAME_VERSION;
  f.type = FRAME_DISARM;
  f.session = 0x0102;
  f.sequence = 5;
  f.time_us = 0x01000000;
  // By Python's zlib.crc32 and by hand.
  CHECK(encoded(f) == Wire{0x06, 0x04, 0x03, 0x02, 0x01, 0x05, 0x01, 0x01, 0x01, 0x01, 0x01, 0x06, 0x01, 0x9d, 0x61, 0x58, 0xcd, 0x00});
}

TEST_CASE("frame: what is encoded is decoded, for every type and any number of parts, and has no zero but its last byte") {
  for (const std::uint8_t type : all_types)
    for (std::uint64_t n = 0; n < 200; ++n) {
      const board_parts parts{static_cast<std::uint8_t>(1 + n % BOARD_PARTS_MOST),
                              static_cast<std::uint8_t>(n / 3 % (BOARD_PARTS_MOST + 1)),
                              static_cast<std::uint8_t>(n / 5 % (BOARD_PARTS_MOST + 1))};
      const frame f = some_frame(type, n, parts);
      const Wire wire = encoded(f);
      REQUIRE(wire.size() <= FRAME_WIRE_MOST);
      REQUIRE(std::count(wire.begin(), wire.end(), 0) == 1);
      const Decoded decoded(wire, parts);
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
  const Wire header{FRAME_VERSION, FRAME_DISARM, 2, 1, 5, 0, 0, 0, 0, 0, 0, 1};
  CHECK(Decoded(stuffed(header)).frames.size() == 1);  // valid as it stands
  Wire longest(FRAME_WIRE_MOST + 40, 1);
  longest.push_back(0);
  CHECK(counted(longest, FRAME_TOO_LONG));
  CHECK(counted({9, 1, 1, 0}, FRAME_BAD_STUFFING));
  CHECK(counted({3, 1, 1, 0}, FRAME_TOO_SHORT));
  Wire other = stuffed(header);
  other[1] ^= 3;
  CHECK(counted(other, FRAME_BAD_CHECK));
  Wire version = header;
  version[0] = 1;
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

TEST_CASE("frame: a command or telemetry for a board with other parts has a bad length") {
  const board_parts boards[] = {{1, 1, 1}, {2, 2, 1}, {4, 4, 2}, {8, 8, 8}, {4, 0, 2}};
  for (const board_parts& sent : boards)
    for (const board_parts& due : boards)
      for (const std::uint8_t type : {FRAME_COMMAND, FRAME_TELEMETRY}) {
        const Decoded decoded(encoded(some_frame(type, 4, sent)), due);
        const bool fits = frame_payload_length(type, &sent) == frame_payload_length(type, &due);
        CHECK(decoded.frames.size() == (fits ? 1 : 0));
        CHECK(decoded.decoder.refused[FRAME_BAD_LENGTH] == (fits ? 0 : 1));
      }
  // The one pair of the above that has commands of one length: four coils, with thermocouples or without.
  CHECK(frame_payload_length(FRAME_COMMAND, &boards[2]) == frame_payload_length(FRAME_COMMAND, &boards[4]));
}

TEST_CASE("frame: as long as the board's parts are not known, telemetry of any board is a whole frame") {
  Decoded decoded(board_parts{});
  for (const board_parts& parts : {board_parts{1, 0, 0}, two_coils, most_parts})
    decoded.take(encoded(some_frame(FRAME_TELEMETRY, 2, parts)));
  CHECK(decoded.frames.size() == 3);
  CHECK(decoded.refused() == 0);
}

TEST_CASE("frame: a command for a board whose parts are not known is a whole frame too, which nobody obeys") {
  Decoded decoded(encoded(some_frame(FRAME_COMMAND, 3)), board_parts{});
  CHECK(decoded.frames.size() == 1);
}

TEST_CASE("frame: counters of what is refused stop at 65535") {
  Decoded decoded;
  decoded.decoder.refused[FRAME_TOO_SHORT] = 65'534;
  for (int k = 0; k < 3; ++k) decoded.take({1, 0});
  CHECK(decoded.decoder.refused[FRAME_TOO_SHORT] == 65'535);
}

TEST_CASE("frame: the wire carries 1 to 8 coils, and at most 8 thermocouples and angles") {
  for (int coils = 0; coils < 256; ++coils) {
    const board_parts parts{static_cast<std::uint8_t>(coils), 0, 0};
    CHECK(board_parts_fit(&parts) == (coils >= 1 && coils <= 8));
  }
  const board_parts thermocouples{8, 9, 8}, angles{8, 8, 9};
  CHECK_FALSE(board_parts_fit(&thermocouples));
  CHECK_FALSE(board_parts_fit(&angles));
  CHECK(board_parts_fit(&most_parts));
  // The longest frame fills its buffers to the last byte, and fits into one length byte before its first zero.
  CHECK(frame_payload_length(FRAME_TELEMETRY, &most_parts) == FRAME_PAYLOAD_MOST);
  CHECK(FRAME_WIRE_MOST < 255);
}

TEST_CASE("message: commands, telemetry and hello of 1, 2, 4 and 8 coils are, byte for byte, what docs/protocol.md says") {
  // By frame_vectors.py, from the page's tables: session 0x0102, sequence 5, time 0x01000000.
  struct {
    board_parts parts;
    const char *command, *telemetry, *hello;
  } const vectors[] = {
      {{1, 1, 1},
       "060404020105010101010103016402dc057ecb04b200",
       "060483020105010101010105017011010201010318640790014006c409010468102a05f01f85ee0102010202020302040205020602070208"
       "0209020a020b020c0588c53f8400",
       "0604810201050101010101150178563412f0debc9a030201010101022f20380c00"},
      {{2, 2, 1},
       "060404020105010101010103016402c802dc0560a5250e00",
       "060483020105010101010105017011010201010401186402c80b9001400690014406c4090103dc050106681069102a05f01f85ee01020102"
       "020203020402050206020702080209020a020b020c05018e02f600",
       "0604810201050101010101150178563412f0debc9a030201020201029831cb1c00"},
      {{4, 4, 2},
       "060404020105010101010103016402c8062c019001dc055d7b677300",
       "060483020105010101010105017011010201010701020318196402c8172c01900190014006900144069001480690014c06c4090103dc0501"
       "03f401010e0cfeffff681069106a106b102a09f01ff11f85ee61f401020102020203020402050206020702080209020a020b020c05889a1c"
       "5c00",
       "0604810201050101010101130178563412f0debc9a030201040402023541021600"},
      {{8, 8, 8},
       "060404020105010101010103016402c80e2c019001f4015802bc022003dc0575ad712c00",
       "06048302010501010101010501701101020101110102030405060718191a1b1c1d1e1f6402c82f2c019001f4015802bc0220039001400690"
       "0144069001480690014c0690015006900154069001580690015c06c4090103dc050103f40101260cfeffff24faffff3cf6ffff54f2ffff6c"
       "eeffff681069106a106b106c106d106e106f102a18f01ff11ff21ff31ff41ff51ff61ff71f85ee61f43dfa1909f505d10bad118917010201"
       "02020203020402050206020702080209020a020b020c057cf8e9d200",
       "0604810201050101010101150178563412f0debc9a0302010808080263ef23af00"},
      {{4, 0, 2},
       "060404020105010101010103016402c8062c019001dc055d7b677300",
       "0604830201050101010101050170110102010418196402c80e2c019001681069106a106b102a09f01ff11f85ee61f4010201020202030204"
       "02050206020702080209020a020b020c0537fbea7600",
       "06048102010501010101010e0178563412f0debc9a03020104070202e9e9091100"},
  };
  for (const auto& [parts, command_hex, telemetry_hex, hello_hex] : vectors) {
    CAPTURE(static_cast<int>(parts.coils));
    frame f{};
    f.version = FRAME_VERSION;
    f.session = 0x0102;
    f.sequence = 5;
    f.time_us = 0x01000000;
    message_command command{};
    for (std::uint16_t j = 0; j < parts.coils; ++j) command.duty[j] = static_cast<std::uint16_t>(100 * (j + 1));
    command.time_to_live_ms = 220;
    put_command(&f, &parts, &command);
    CHECK(f.length == frame_payload_length(FRAME_COMMAND, &parts));
    CHECK(hexadecimal(encoded(f)) == command_hex);

    message_telemetry telemetry{};
    telemetry.last_sequence = 70000;
    telemetry.state = DEVICE_ARMED;
    for (std::uint8_t j = 0; j < parts.coils; ++j) telemetry.duty[j] = command.duty[j];
    for (std::uint8_t k = 0; k < parts.thermocouples; ++k) {
      telemetry.sensor[k] = k;
      telemetry.thermocouple_raw[k] = 0x06400190u + (std::uint32_t{k} << 18);
      telemetry.temperature_cdegC[k] = 2500 - 1000 * k;
    }
    for (std::uint8_t j = 0; j < parts.coils; ++j) telemetry.bound_rise_cK[j] = static_cast<std::uint16_t>(4200 + j);
    telemetry.temperature_age_ms = 42;
    for (std::uint8_t k = 0; k < parts.angles; ++k) {
      telemetry.angle_fault[k] = static_cast<std::uint8_t>(TRIP_ANGLE_RANGE + k);
      telemetry.angle_raw[k] = static_cast<std::uint16_t>(8176 + k);
      telemetry.angle_cdeg[k] = static_cast<std::int16_t>(-4475 + 1500 * k);
    }
    for (std::uint16_t i = 0; i < DEVICE_COUNTERS; ++i) telemetry.counters[i] = i;
    put_telemetry(&f, &parts, &telemetry);
    CHECK(f.length == frame_payload_length(FRAME_TELEMETRY, &parts));
    CHECK(hexadecimal(encoded(f)) == telemetry_hex);

    const message_hello hello{.firmware_hash = 0x12345678u,
                              .limits_hash = 0x9abcdef0u,
                              .reset_cause = RESET_WATCHDOG,
                              .state = DEVICE_TRIPPED,
                              .trip_cause = TRIP_SILENCE,
                              .parts = parts,
                              .wrong_settings = SETTING_WATCHDOG};
    put_hello(&f, &hello);
    CHECK(hexadecimal(encoded(f)) == hello_hex);

    // And back.
    const Decoded decoded(
        [&] {
          Wire all;
          for (const char* hex : {command_hex, telemetry_hex, hello_hex})
            for (const char* at = hex; *at; at += 2) all.push_back(static_cast<std::uint8_t>(std::stoi(std::string(at, 2), nullptr, 16)));
          return all;
        }(),
        parts);
    REQUIRE(decoded.frames.size() == 3);
    message_command command_back{};
    get_command(&decoded.frames[0], &parts, &command_back);
    put_command(&f, &parts, &command_back);
    CHECK(hexadecimal(encoded(f)) == command_hex);
    message_telemetry telemetry_back{};
    get_telemetry(&decoded.frames[1], &parts, &telemetry_back);
    put_telemetry(&f, &parts, &telemetry_back);
    CHECK(hexadecimal(encoded(f)) == telemetry_hex);
    message_hello hello_back{};
    get_hello(&decoded.frames[2], &hello_back);
    CHECK(hello_back.parts.coils == parts.coils);
    CHECK(hello_back.parts.thermocouples == parts.thermocouples);
    CHECK(hello_back.parts.angles == parts.angles);
  }
}

TEST_CASE("limits: their hash is another for another number of coils") {
  for (std::uint8_t coils = 1; coils < BOARD_PARTS_MOST; ++coils)
    CHECK(limits_hash(coils) != limits_hash(static_cast<std::uint8_t>(coils + 1)));
}

TEST_CASE("message: every payload reads back as it was written") {
  frame f{};
  const message_arm arm{0x12345678u, 0x9abcdef0u, ARM_ANGLE_FAULTS_TRIP};
  put_arm(&f, &arm);
  message_arm arm_back{};
  get_arm(&f, &arm_back);
  CHECK(arm_back.firmware_hash == arm.firmware_hash);
  CHECK(arm_back.limits_hash == arm.limits_hash);
  CHECK(arm_back.flags == arm.flags);

  const message_command command{.duty = {6000, 1}, .time_to_live_ms = 220};
  put_command(&f, &two_coils, &command);
  CHECK(f.length == 6);
  message_command command_back{};
  get_command(&f, &two_coils, &command_back);
  CHECK(command_back.duty[0] == 6000);
  CHECK(command_back.duty[1] == 1);
  CHECK(command_back.time_to_live_ms == 220);

  const message_hello hello{1, 2, RESET_WATCHDOG, DEVICE_TRIPPED, TRIP_SILENCE, two_coils, SETTING_WATCHDOG};
  put_hello(&f, &hello);
  CHECK(f.length == MESSAGE_HELLO_BYTES);
  message_hello hello_back{};
  get_hello(&f, &hello_back);
  CHECK(hello_back.limits_hash == 2);
  CHECK(hello_back.trip_cause == TRIP_SILENCE);
  CHECK(hello_back.wrong_settings == SETTING_WATCHDOG);

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
  telemetry.angle_cdeg[0] = -4475;
  telemetry.thermocouple_raw[0] = 0xfffffff0u;
  telemetry.counters[DEVICE_COUNTERS - 1] = 65535;
  put_telemetry(&f, &two_coils, &telemetry);
  CHECK(f.length == MESSAGE_TELEMETRY_BYTES(&two_coils));
  CHECK(f.length <= FRAME_PAYLOAD_MOST);
  message_telemetry back{};
  get_telemetry(&f, &two_coils, &back);
  CHECK(back.last_sequence == 70000);
  CHECK(back.temperature_cdegC[1] == -1275);
  CHECK(back.angle_cdeg[0] == -4475);
  CHECK(back.thermocouple_raw[0] == 0xfffffff0u);
  CHECK(back.counters[DEVICE_COUNTERS - 1] == 65535);
}

}  // namespace hil_frame_test

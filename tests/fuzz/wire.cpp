// SPDX-License-Identifier: Apache-2.0
// Codec, device's supervisor and the reader of wire logs under chance, for as many seconds as it is told. Build it with the
// sanitizers; a finding is a crash, or a line that says what was taken that must not be. Exit code 1 then.
//
//   cmake --build --preset sanitize --target sinew_fuzz_wire && build/sanitize/tests/sinew_fuzz_wire 600
#include <algorithm>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <string>
#include <vector>

#include "firmware/supervisor.h"
#include "hil/frame.h"
#include "hil/message.h"
#include "hil/wire_log.h"
#include "sim/input_error.h"
#include "sim/random.h"

namespace {

using Wire = std::vector<std::uint8_t>;

class Chance {
 public:
  explicit Chance(std::uint64_t seed) : stream_(seed, "fuzz") {}
  std::uint64_t bits() { return stream_.bits(n_++); }
  std::size_t below(std::size_t count) { return static_cast<std::size_t>(bits() % count); }

 private:
  sinew::sim::RandomStream stream_;
  std::uint64_t n_ = 0;
};

constexpr std::uint8_t types[] = {FRAME_HELLO_REQUEST, FRAME_ARM,   FRAME_DISARM, FRAME_COMMAND,
                                  FRAME_CLEAR_TRIP,    FRAME_HELLO, FRAME_ANSWER, FRAME_TELEMETRY};

board_parts some_parts(Chance& chance) {
  return {static_cast<std::uint8_t>(1 + chance.below(BOARD_PARTS_MOST)), static_cast<std::uint8_t>(chance.below(BOARD_PARTS_MOST + 1)),
          static_cast<std::uint8_t>(chance.below(BOARD_PARTS_MOST + 1))};
}

Wire valid_frame(Chance& chance, const board_parts& parts) {
  frame f{};
  f.version = FRAME_VERSION;
  f.type = types[chance.below(sizeof types)];
  f.session = static_cast<std::uint16_t>(chance.bits());
  f.sequence = static_cast<std::uint32_t>(chance.bits());
  f.time_us = static_cast<std::uint32_t>(chance.bits());
  f.length = frame_payload_length(f.type, &parts);
  for (std::uint8_t i = 0; i < f.length; ++i) f.payload[i] = chance.bits() % 3 ? static_cast<std::uint8_t>(chance.bits()) : std::uint8_t{0};
  Wire wire(FRAME_WIRE_MOST);
  wire.resize(frame_encode(&f, wire.data()));
  return wire;
}

void mutate(Wire& wire, Chance& chance) {
  for (std::size_t k = 1 + chance.below(4); k > 0 && !wire.empty(); --k) {
    const std::size_t at = chance.below(wire.size());
    switch (chance.below(4)) {
      case 0:
        wire[at] = static_cast<std::uint8_t>(wire[at] ^ (1u << chance.below(8)));
        break;
      case 1:
        wire[at] = static_cast<std::uint8_t>(chance.bits());
        break;
      case 2:
        wire.erase(wire.begin() + static_cast<std::ptrdiff_t>(at));
        break;
      default:
        wire.insert(wire.begin() + static_cast<std::ptrdiff_t>(at), static_cast<std::uint8_t>(chance.bits()));
        break;
    }
  }
}

void read_payload(const frame& f, const board_parts& parts) {
  message_hello_request a;
  message_arm b;
  message_command c;
  message_clear_trip d;
  message_hello e;
  message_answer g;
  message_telemetry h;
  switch (f.type) {
    case FRAME_HELLO_REQUEST:
      get_hello_request(&f, &a);
      break;
    case FRAME_ARM:
      get_arm(&f, &b);
      break;
    case FRAME_COMMAND:
      get_command(&f, &parts, &c);
      break;
    case FRAME_CLEAR_TRIP:
      get_clear_trip(&f, &d);
      break;
    case FRAME_HELLO:
      get_hello(&f, &e);
      break;
    case FRAME_ANSWER:
      get_answer(&f, &g);
      break;
    case FRAME_TELEMETRY:
      get_telemetry(&f, &parts, &h);
      break;
    default:
      break;
  }
}

}  // namespace

int main(int argc, char** argv) {
  const double seconds = argc > 1 ? std::atof(argv[1]) : 10.0;
  const std::uint64_t seed = argc > 2 ? static_cast<std::uint64_t>(std::atoll(argv[2])) : 1;
  const auto began = std::chrono::steady_clock::now();
  Chance chance(seed);
  std::uint64_t rounds = 0, frames = 0, mutants_taken = 0, logs = 0;
  bool wrong = false;
  frame_decoder decoder;
  frame_decoder_start(&decoder, nullptr);
  supervisor device;
  supervisor_start(&device, TRIP_NONE, 0);
  std::uint32_t now_us = 0;
  for (; std::chrono::duration<double>(std::chrono::steady_clock::now() - began).count() < seconds && !wrong; ++rounds) {
    // Frames, whole and damaged, through one decoder that goes on from one to the next: of a board of some size, which the decoder
    // knows of or not.
    const board_parts parts = some_parts(chance);
    const bool known = chance.below(4);
    decoder.parts = known ? parts : board_parts{};
    for (int k = 0; k < 100; ++k) {
      const Wire whole = valid_frame(chance, parts);
      Wire wire = whole;
      const bool damaged = chance.below(2);
      if (damaged) mutate(wire, chance);
      if (damaged) wire.push_back(0);
      int taken = 0;
      bool another = false;  // than the one that was damaged: what is only set between zeros comes through as it was
      for (const std::uint8_t byte : wire) {
        frame f;
        if (frame_decoder_take(&decoder, byte, &f) != FRAME_READY) continue;
        ++taken;
        ++frames;
        Wire back(FRAME_WIRE_MOST);
        back.resize(frame_encode(&f, back.data()));
        another = another || back != whole;
        if (!known) continue;
        read_payload(f, parts);
        if (f.type == FRAME_COMMAND) {
          message_command command{};
          get_command(&f, &parts, &command);
          supervisor_command(&device, &command, f.time_us, now_us);
        }
      }
      mutants_taken += damaged && another;
      if (!damaged && taken != 1) {
        std::printf("seed %llu, round %llu: a whole frame was taken %d times\n", static_cast<unsigned long long>(seed),
                    static_cast<unsigned long long>(rounds), taken);
        wrong = true;
      }
    }
    // The device's supervisor under words and times of any kind: never more duty than the highest, none unless armed.
    for (int k = 0; k < 100; ++k) {
      now_us += static_cast<std::uint32_t>(chance.bits() % 200000);
      std::uint32_t raw[BOARD_COILS], cool[BOARD_COILS];
      for (std::size_t j = 0; j < BOARD_COILS; ++j) {
        cool[j] = 100u << 18 | 400u << 4;
        raw[j] = j > 0 && chance.below(2) ? cool[j] : static_cast<std::uint32_t>(chance.bits());
      }
      supervisor_reading(&device, chance.below(4) ? cool : raw, now_us);
      const auto angle = static_cast<std::uint16_t>(chance.below(20000));
      supervisor_angles(&device, &angle);
      if (chance.below(3) == 0) supervisor_clear_trip(&device, device.trip_cause);
      if (chance.below(3) == 0) supervisor_arm(&device, now_us);
      message_command command{};
      for (std::size_t j = 0; j < BOARD_COILS; ++j) command.duty[j] = static_cast<std::uint16_t>(chance.bits() % (j == 0 ? 65536 : 8000));
      command.time_to_live_ms = static_cast<std::uint16_t>(chance.bits() % 400);
      supervisor_command(&device, &command, now_us - static_cast<std::uint32_t>(chance.bits() % 300000), now_us);
      supervisor_tick(&device, now_us);
      const std::uint16_t most = *std::max_element(std::begin(device.duty), std::end(device.duty));
      if ((most > 0 && device.state != DEVICE_ARMED) || most > LIMIT_HIGHEST_DUTY) {
        std::printf("seed %llu, round %llu: duty %u in state %u\n", static_cast<unsigned long long>(seed),
                    static_cast<unsigned long long>(rounds), most, device.state);
        wrong = true;
      }
    }
    // Logs of a wire: any bytes are an error or a log, never a crash.
    std::string log = "sinew wire 1\n";
    for (std::size_t k = chance.below(40); k > 0; --k) {
      const std::size_t length = chance.below(20);
      log += "SRLX"[chance.below(4)];
      log += static_cast<char>(chance.bits() % 128);
      log += static_cast<char>(chance.below(8) ? length : chance.bits());
      for (std::size_t i = 0; i < length; ++i) log += static_cast<char>(chance.bits());
    }
    try {
      sinew::hil::ReplayLink link(log, "fuzz");
      while (!link.at_end()) chance.below(3) ? (void)link.receive_until(0) : (void)link.send({});
    } catch (const sinew::hil::ReplayDiffers&) {
    } catch (const sinew::hil::LinkLost&) {
    } catch (const sinew::sim::InputError&) {
    }
    ++logs;
  }
  std::printf("%llu rounds: %llu frames taken, %llu damaged frames taken, %llu logs; %s\n", static_cast<unsigned long long>(rounds),
              static_cast<unsigned long long>(frames), static_cast<unsigned long long>(mutants_taken),
              static_cast<unsigned long long>(logs), wrong ? "FINDING" : "no finding");
  return wrong || mutants_taken > 0;
}

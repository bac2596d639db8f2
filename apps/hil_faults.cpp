// SPDX-License-Identifier: Apache-2.0
// sinew hil-faults: everything that is known to go wrong, made to go wrong on the emulated board, and what came of it.
#include <fcntl.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <map>
#include <memory>
#include <sstream>
#include <utility>

#include "apps/app.h"
#include "apps/limb_link.h"
#include "apps/outputs.h"
#include "hil/limits.h"
#include "hil/lock_step_link.h"
#include "hil/port.h"
#include "hil/session.h"
#include "report/markdown.h"
#include "sim/input_error.h"
#include "sim/parallel.h"
#include "sim/random.h"
#include "sim/text.h"

namespace sinew::apps {
namespace {

using hil::Bytes;

// Coil A is heated through until the end of the fault; the host's supervisor holds it where it must be held.
constexpr const char* scenario_text =
    "# Coil A is heated, so that whatever goes wrong does so while it is hot.\n"
    "format: 1\nseed: 1\nduration_s: 16.0\n"
    "input: { duty_A: { step: { height_fraction: 0.45, from_s: 0.5, until_s: 14.0 } } }\n";
constexpr const char* slow_scenario_text =
    "# Coil A is heated for most of a minute, for what takes its time.\n"
    "format: 1\nseed: 1\nduration_s: 60.0\n"
    "input: { duty_A: { step: { height_fraction: 0.45, from_s: 0.5, until_s: 55.0 } } }\n";
constexpr const char* full_scenario_text =
    "# The same with all the duty that a board takes.\n"
    "format: 1\nseed: 1\nduration_s: 16.0\n"
    "input: { duty_A: { step: { height_fraction: 0.7, from_s: 0.5, until_s: 14.0 } } }\n";
constexpr double onset_s = 6.0, full_onset_s = 4.0;
constexpr double hot_onset_s = 45.0;  // the host has held the coil at the hottest that it allows for half a minute
// The time to zero depends on where between two readings and two commands the fault falls: the worst of these is reported.
constexpr std::array<double, 5> phases_s{0.0, 0.023, 0.047, 0.071, 0.095};
constexpr double afterwards_s = 6.0, after_pair_s = 3.0;  // the board is watched on after the session

enum class Due {
  nothing,    // the session must go on to its end
  trip,       // the device can see it at once: 250 ms
  evidence,   // the device can see it after some heating
  host,       // only the host can see it
  cool,       // perhaps nobody can see it: the session may go on or end, but no coil may pass its limit
  unsavable,  // said, but software cannot open the switch
  refusal,    // it must not be armed
};

struct Row {
  std::string group, name;
  Due due;
  std::vector<std::string> faults;  // with @ for the onset
  std::function<hil::Tamper(double from_s)> to_device, from_device;
  bool relay = false;
  std::string expected;  // trip cause, or causes with | between them, or empty
  bool slow = false;     // a scenario of a minute
  std::optional<hil::LatentLink::Latency> latency{};
  bool dividers = false;  // at the drains of the switches
};

struct FaultOutcome {
  std::string came;  // the trip's cause, or how the session ended
  bool right = true;
  double zero_ms = -1.0;  // -1: never; NaN: there was nothing to wait for
  double peak_degC = 0.0, peak_reading_degC = 0.0;
};

// Rows of the emulator's trace.
struct Trace {
  std::vector<double> time_s;
  std::vector<std::vector<double>> gate, coil_degC, reading_degC;  // [rows][coils]
};

Trace read_trace(const std::filesystem::path& file) {
  Trace trace;
  std::istringstream lines(sim::read_file(file));
  std::string line;
  std::getline(lines, line);
  while (std::getline(lines, line)) {
    // The time, then a gate of each coil, then a temperature of each, then what its amplifier shows.
    std::vector<double> value;
    std::istringstream fields(line);
    std::string field;
    while (std::getline(fields, field, ',')) value.push_back(sim::parse_number(field).value());
    const auto first = value.begin() + 1, second = first + (value.end() - first) / 3, third = second + (second - first);
    trace.time_s.push_back(value.front());
    trace.gate.emplace_back(first, second);
    trace.coil_degC.emplace_back(second, third);
    trace.reading_degC.emplace_back(third, value.end());
  }
  return trace;
}

// From when on all gates are low for good; none: never.
std::optional<double> zero_from_s(const Trace& trace) {
  std::optional<double> zero_s;
  for (std::size_t k = 0; k < trace.time_s.size(); ++k) {
    const bool off = std::all_of(trace.gate[k].begin(), trace.gate[k].end(), [](double gate) { return gate == 0.0; });
    if (!off) zero_s.reset();
    if (off && !zero_s) zero_s = trace.time_s[k];
  }
  return zero_s;
}

hil::Tamper one_in_ten(std::function<std::vector<Bytes>(Bytes)> what) {
  auto count = std::make_shared<int>(0);
  return [count, what = std::move(what)](Bytes frame, std::int64_t) -> std::vector<Bytes> {
    if (++*count % 10 != 0) return {std::move(frame)};
    return what(std::move(frame));
  };
}
hil::Tamper flip_every_byte() {
  auto position = std::make_shared<std::size_t>(0);
  return one_in_ten([=](Bytes frame) -> std::vector<Bytes> {
    const std::size_t at = (*position)++ % frame.size();
    frame[at] = static_cast<std::uint8_t>(frame[at] ^ (1u << (*position % 8)));
    return {std::move(frame)};
  });
}
// From `from_s` on every frame comes `count` frames later; there are two a tick.
hil::Tamper delay(std::size_t count, double from_s) {
  auto held = std::make_shared<std::vector<Bytes>>();
  return [=](Bytes frame, std::int64_t now_us) -> std::vector<Bytes> {
    if (static_cast<double>(now_us) < from_s * 1e6) return {std::move(frame)};
    held->push_back(std::move(frame));
    if (held->size() <= count) return {};
    Bytes out = std::move(held->front());
    held->erase(held->begin());
    return {std::move(out)};
  };
}
hil::Tamper lose_all(double from_s) {
  return [=](Bytes frame, std::int64_t now_us) -> std::vector<Bytes> {
    if (static_cast<double>(now_us) < from_s * 1e6) return {std::move(frame)};
    return {};
  };
}
hil::Tamper exchange_pairs() {
  auto held = std::make_shared<std::optional<Bytes>>();
  auto count = std::make_shared<int>(0);
  return [=](Bytes frame, std::int64_t) -> std::vector<Bytes> {
    if (++*count < 10) return {std::move(frame)};  // hello and arm go through
    if (!held->has_value()) {
      *held = std::move(frame);
      return {};
    }
    Bytes first = std::move(**held);
    held->reset();
    return {std::move(frame), std::move(first)};
  };
}
hil::Tamper garbage_before() {
  auto draw = std::make_shared<std::uint64_t>(0);
  return one_in_ten([=](Bytes frame) -> std::vector<Bytes> {
    const sim::RandomStream chance(3, "garbage");
    Bytes garbage;
    for (int i = 0; i < 300; ++i) garbage.push_back(static_cast<std::uint8_t>(chance.bits((*draw)++)));
    return {std::move(garbage), std::move(frame)};
  });
}
// The frame as it would be if it said something else, with a CRC that is right.
Bytes changed(const Bytes& wire, const std::function<void(frame&)>& change) {
  constexpr board_parts parts{2, 2, 1};
  hil::Bytes out;
  frame_decoder decoder;
  frame_decoder_start(&decoder, &parts);
  frame in;
  for (const std::uint8_t byte : wire)
    if (frame_decoder_take(&decoder, byte, &in) == FRAME_READY) {
      change(in);
      out.resize(FRAME_WIRE_MOST);
      out.resize(frame_encode(&in, out.data()));
    }
  out.insert(out.begin(), 0);
  return out;
}
hil::Tamper other_version() {
  return [](const Bytes& wire, std::int64_t) -> std::vector<Bytes> {
    return {changed(wire, [](frame& in) { in.version = FRAME_VERSION + 1; })};
  };
}
// Another program's commands of all duty among ours, as if it had the port too.
hil::Tamper foreign_commands() {
  return [](const Bytes& wire, std::int64_t) -> std::vector<Bytes> {
    Bytes foreign = changed(wire, [](frame& in) {
      if (in.type != FRAME_COMMAND) return;
      in.session = static_cast<std::uint16_t>(in.session + 1);
      in.sequence += 1000;
      std::uint8_t at = 0;
      put_u16(in.payload, &at, LIMIT_HIGHEST_DUTY);
      put_u16(in.payload, &at, LIMIT_HIGHEST_DUTY);
    });
    return {std::move(foreign), wire};
  };
}
// Once, from then on: the hello of another program.
hil::Tamper foreign_hello(double from_s) {
  auto said = std::make_shared<bool>(false);
  return [=](const Bytes& wire, std::int64_t now_us) -> std::vector<Bytes> {
    if (*said || static_cast<double>(now_us) < from_s * 1e6) return {wire};
    *said = true;
    return {changed(wire,
                    [](frame& in) {
                      const message_hello_request request{20};
                      put_hello_request(&in, &request);
                      in.session = static_cast<std::uint16_t>(in.session + 1);
                    }),
            wire};
  };
}
hil::Tamper replayed() {
  auto past = std::make_shared<std::vector<Bytes>>();
  return [=](Bytes frame, std::int64_t) -> std::vector<Bytes> {
    past->push_back(frame);
    if (past->size() <= 10) return {std::move(frame)};
    return {std::move(frame), (*past)[past->size() - 11]};
  };
}
// Half of every tenth, and its rest with the next one.
hil::Tamper half_then_rest() {
  auto rest = std::make_shared<Bytes>();
  auto count = std::make_shared<int>(0);
  return [=](Bytes frame, std::int64_t) -> std::vector<Bytes> {
    std::vector<Bytes> out;
    if (!rest->empty()) out.push_back(std::exchange(*rest, {}));
    if (++*count % 10 == 0) {
      const auto half = frame.begin() + static_cast<std::ptrdiff_t>(frame.size() / 2);
      rest->assign(half, frame.end());
      frame.erase(half, frame.end());
    }
    out.push_back(std::move(frame));
    return out;
  };
}
// The host stands still for that long at the beginning of every second; what it would have sent meanwhile comes when it goes on.
hil::Tamper paused(std::int64_t pause_us, double from_s) {
  auto held = std::make_shared<std::vector<Bytes>>();
  return [=](Bytes frame, std::int64_t now_us) -> std::vector<Bytes> {
    const std::int64_t since_us = now_us - std::llround(from_s * 1e6);
    held->push_back(std::move(frame));
    if (since_us >= 0 && since_us % 1'000'000 < pause_us) return {};
    return std::exchange(*held, {});
  };
}
hil::Tamper flooded() {
  auto draw = std::make_shared<std::uint64_t>(0);
  return [=](Bytes frame, std::int64_t) -> std::vector<Bytes> {
    const sim::RandomStream chance(4, "flood");
    Bytes flood;
    for (int i = 0; i < 1500; ++i) flood.push_back(static_cast<std::uint8_t>(chance.bits((*draw)++)));
    return {std::move(flood), std::move(frame)};
  };
}

std::vector<Row> all_rows() {
  const auto always = [](hil::Tamper (*make)()) { return [make](double) { return make(); }; };
  const auto lost = [] { return one_in_ten([](const Bytes&) -> std::vector<Bytes> { return {}; }); };
  const auto cut = [] {
    return one_in_ten([](Bytes frame) -> std::vector<Bytes> {
      frame.resize(frame.size() / 2);
      return {std::move(frame)};
    });
  };
  const auto twice = [](const Bytes& frame, std::int64_t) -> std::vector<Bytes> { return {frame, frame}; };
  std::vector<Row> rows;
  const auto link = [&](const std::string& name, Due due, auto to, auto from, const std::string& expected = "") {
    rows.push_back({"link", name, due, {}, to, from, false, expected, false});
  };
  link("a bit flipped at every byte position in turn, one frame in ten, both ways", Due::nothing, always(flip_every_byte),
       always(flip_every_byte));
  link(
      "one frame in ten lost, both ways", Due::nothing, [=](double) { return lost(); }, [=](double) { return lost(); });
  link(
      "every frame twice, both ways", Due::nothing, [=](double) { return hil::Tamper(twice); }, [=](double) { return hil::Tamper(twice); });
  link("commands exchanged in pairs", Due::nothing, always(exchange_pairs), nullptr);
  link(
      "commands come 1 tick late", Due::nothing, [](double from_s) { return delay(2, from_s); }, nullptr);
  link(
      "commands come 3 ticks late", Due::trip, [](double from_s) { return delay(6, from_s); }, nullptr, "silence");
  link(
      "commands come 10 ticks late", Due::trip, [](double from_s) { return delay(20, from_s); }, nullptr, "silence");
  link("300 bytes of garbage before one frame in ten", Due::nothing, always(garbage_before), nullptr);
  link(
      "one frame in ten cut in the middle, both ways", Due::nothing, [=](double) { return cut(); }, [=](double) { return cut(); });
  link(
      "cable pulled, or host killed or stopped: nothing goes through any more", Due::trip, [](double from_s) { return lose_all(from_s); },
      [](double from_s) { return lose_all(from_s); }, "silence");
  link(
      "the device hears nothing, the host still hears it", Due::trip, [](double from_s) { return lose_all(from_s); }, nullptr, "silence");
  for (const auto& [name, latency] :
       {std::pair{"a bridge that holds frames back for 0 to 80 ms each way", hil::LatentLink::Latency{0, 80'000}},
        std::pair{"a bridge that holds frames back for 50 to 80 ms each way", hil::LatentLink::Latency{50'000, 80'000}}}) {
    link(name, Due::nothing, nullptr, nullptr);
    rows.back().latency = latency;
  }
  link("another program's commands of all duty among ours", Due::nothing, always(foreign_commands), nullptr);
  link(
      "another program's hello: it ends the session", Due::trip, [](double from_s) { return foreign_hello(from_s); }, nullptr, "link_lost");
  link("every frame again ten frames later", Due::nothing, always(replayed), always(replayed));
  link("half of one frame in ten, silence, and its rest with the next", Due::nothing, always(half_then_rest), always(half_then_rest));
  link(
      "the host hears nothing, the device still hears it", Due::host, nullptr, [](double from_s) { return lose_all(from_s); }, "link_lost");
  // Commands come up to a period later than the pause is long: whether the board's 200 ms pass hangs on where it falls.
  for (const int pause_ms : {150, 200})
    link(
        "host paused for " + std::to_string(pause_ms) + " ms each second", Due::cool,
        [=](double from_s) { return paused(1000 * pause_ms, from_s); }, nullptr, "finished|silence");
  link(
      "host paused for 240 ms each second", Due::trip, [](double from_s) { return paused(240'000, from_s); }, nullptr, "silence");
  // Each frame is one with the chance that comes before it, so that none is whole: no session begins.
  link("the line to the device flooded: 1500 bytes of chance before each frame", Due::refusal, always(flooded), nullptr, "no answer");
  link("the device speaks another version of the protocol", Due::refusal, nullptr, always(other_version), "another version");
  const auto add = [&](const std::string& group, const std::string& name, Due due, std::vector<std::string> faults,
                       const std::string& expected = "", bool relay = false, bool slow = false) {
    rows.push_back({group, name, due, std::move(faults), nullptr, nullptr, relay, expected, slow});
  };
  add("sensor", "thermocouple open", Due::trip, {"sensor_open:A@"}, "sensor_open");
  add("sensor", "thermocouple shorted to ground", Due::trip, {"sensor_ground:A@"}, "sensor_short_to_ground");
  add("sensor", "thermocouple shorted to supply", Due::trip, {"sensor_supply:A@"}, "sensor_short_to_supply");
  add("sensor", "amplifier dead, all bits 0", Due::trip, {"sensor_zeros:A@"}, "sensor_zeros");
  add("sensor", "data line high, all bits 1", Due::trip, {"sensor_ones:A@"}, "sensor_ones");
  add("sensor", "no valid number (a reserved bit set; the chip has no NaN)", Due::trip, {"sensor_garbled:A@"}, "sensor_garbled");
  add("sensor", "cold junction jumps by 5 K", Due::trip, {"junction_jump:A@=5"}, "junction");
  add("sensor", "thermocouples exchanged while one coil is hot", Due::trip, {"sensors_swapped@"}, "sensor_jump");
  add("sensor", "reading stuck", Due::evidence, {"sensor_stuck:A@"}, "sensor_stuck");
  add("sensor", "reading drifts cold by 5 K/s", Due::evidence, {"sensor_drift:A@=5"}, "not_following");
  add("sensor", "reading drifts cold by 1 K/s", Due::host, {"sensor_drift:A@=1"}, "objected", false, true);
  add("sensor", "reading drifts warm by 5 K/s", Due::evidence, {"sensor_drift:A@=-5"}, "over_temperature|unexpected_heating|objected");
  for (const char* share : {"0.8", "0.6"})
    add("sensor", std::string("both thermocouples show ") + share + " of the rise from the start", Due::cool,
        {std::string("sensor_scale:A@0=") + share, std::string("sensor_scale:B@0=") + share}, "finished|objected", false, true);
  for (const char* noise_K : {"1.5", "3"})
    add("sensor", std::string("noise of ") + noise_K + " K on both thermocouples from the start", Due::nothing,
        {std::string("sensor_noise:A@0=") + noise_K, std::string("sensor_noise:B@0=") + noise_K}, "", false, true);
  add("sensor", "a bit flipped in one SPI word in twenty", Due::evidence, {"sensor_flips:A@=0.05"},
      "sensor_|junction|over_temperature|objected");
  add("sensor", "bend sensor unplugged, or at 0 V", Due::trip, {"bend_low@"}, "angle_range|objected");
  add("sensor", "bend sensor at 5 V", Due::trip, {"bend_high@"}, "angle_range|objected");
  add("sensor", "bend sensor stuck from the start", Due::evidence, {"bend_stuck@0.1"}, "angle_stuck|objected");
  add("device", "hangs while hot, interrupts served", Due::trip, {"hang@"}, "main_loop");
  add("device", "hangs while hot, interrupts off", Due::trip, {"hang_masked@"}, "watchdog");
  add("device", "brown-out", Due::trip, {"brown_out@"}, "brown_out");
  add("device", "brown-out twice within a millisecond", Due::trip, {"brown_out@", "brown_out@+0.0011"}, "brown_out");
  add("device", "five brown-outs, 0.2 s apart", Due::trip,
      {"brown_out@", "brown_out@+0.2", "brown_out@+0.4", "brown_out@+0.6", "brown_out@+0.8"}, "brown_out");
  add("device", "hangs, and is reset again right after the watchdog", Due::trip, {"hang_masked@", "reset@+0.0648"},
      "reset_while_armed|latch_damaged");
  add("device", "reset in the middle of a command", Due::trip, {"reset@"}, "reset_while_armed");
  add("device", "its clock wraps in the session", Due::nothing, {"time_ms@0.05=4288967"});
  add("device", "trips, then is reset: the latch", Due::trip, {"sensor_open:A@", "reset@+0.2"}, "sensor_open");
  add("device", "trips, then power goes off and on: the latch", Due::trip, {"sensor_open:A@", "power_cycle@+0.2"}, "sensor_open");
  // Two bytes of 3.4 ms each: in the first, between the two, in the second, after both.
  for (const char* after_us : {"50", "1700", "3300", "3600", "5600", "7000", "9000"})
    add("device", std::string("trips, and power goes ") + after_us + " us into the storing of the trip", Due::trip,
        {"sensor_open:A@", std::string("power_cut_in_storing@=") + after_us}, "latch_damaged|sensor_open");
  // 0xd9 and 0xff are a new chip's; 0xfd is an Arduino Uno's.
  add("device", "fuses: the watchdog may be turned off", Due::refusal, {"fuse_high@0=217"}, "the watchdog is not always on");
  add("device", "fuses: no brown-out detection", Due::refusal, {"fuse_extended@0=255"}, "brown-out detection is off");
  add("device", "fuses: brown-out detection at 2.7 V", Due::refusal, {"fuse_extended@0=253"}, "brown-out detection is off");
  add("plant", "coil open", Due::evidence, {"coil_open:A@"}, "not_following");
  add("plant", "supply sags to 6 V", Due::nothing, {"supply_V@=6"});
  // The host looks for 30 K: more than a coil loses in the few seconds that are left of the short sessions.
  add("plant", "supply sags to 5 V: as if the thermocouple read cold", Due::host, {"supply_V@=5"}, "objected|not_following", false, true);
  // Two errors that hide each other: the readings look right. Heat goes with the square of the supply: 7.98 V are 1.3 of it.
  add("both", "supply at 8 V from the start, both thermocouples show 0.8 of the rise", Due::cool,
      {"supply_V@0=8", "sensor_scale:A@0=0.8", "sensor_scale:B@0=0.8"}, "finished|objected", false, true);
  add("both", "heat times 1.3 from the start, both thermocouples show 0.7 of the rise", Due::cool,
      {"supply_V@0=7.98", "sensor_scale:A@0=0.7", "sensor_scale:B@0=0.7"}, "finished|objected", false, true);
  add("both", "heat times 1.3 from the start, both thermocouples show 0.6 of the rise", Due::cool,
      {"supply_V@0=7.98", "sensor_scale:A@0=0.6", "sensor_scale:B@0=0.6"}, "finished|objected", false, true);
  for (const char* volts : {"8", "9", "12"}) {
    add("plant", std::string("supply at ") + volts + " V from the start", Due::cool, {std::string("supply_V@0=") + volts},
        "finished|objected|rate_of_rise|unexpected_heating|over_temperature|heat_bound|sensor_jump", false, true);
    add("plant", std::string("supply rises to ") + volts + " V at once", Due::cool, {std::string("supply_V@=") + volts},
        "finished|objected|rate_of_rise|unexpected_heating|over_temperature|heat_bound|sensor_jump");
  }
  add("plant", "supply rises by 0.2 V a second", Due::cool, {"supply_ramp_V_s@=0.2"},
      "finished|objected|over_temperature|unexpected_heating|rate_of_rise");
  add("plant", "gates exchanged from the start", Due::evidence, {"gates_swapped@0"}, "not_following|unexpected_heating|sensor_stuck");
  for (const char* share : {"0.1", "0.2", "0.3"})
    add("plant", std::string("coil B's gate stuck at ") + share + ", with a cut-off relay on PD7", Due::cool,
        {std::string("gate_stuck:B@=") + share}, "finished|unexpected_heating|over_temperature|objected", true);
  add("plant", "switch welded: coil on for good", Due::unsavable, {"coil_welded:A@"}, "unexpected_heating|over_temperature");
  add("plant", "switch welded, with a cut-off relay on PD7", Due::evidence, {"coil_welded:A@"}, "unexpected_heating|over_temperature",
      true);
  const auto with_dividers = [&](const std::string& name, Due due, std::vector<std::string> faults, const std::string& expected = "",
                                 bool slow = false) {
    add("dividers", name + ", with relay and dividers", due, std::move(faults), expected, true, slow);
    rows.back().dividers = true;
  };
  with_dividers("nothing", Due::nothing, {});
  with_dividers("noise of 3 K on both thermocouples from the start", Due::nothing, {"sensor_noise:A@0=3", "sensor_noise:B@0=3"}, "", true);
  with_dividers("switch welded", Due::trip, {"coil_welded:A@"}, "drain_low");
  with_dividers("switch of the coil without duty welded, its reading stuck", Due::trip, {"coil_welded:B@", "sensor_stuck:B@"}, "drain_low");
  with_dividers("switch welded, reading drifts cold by 5 K/s", Due::trip, {"coil_welded:A@", "sensor_drift:A@=5"}, "drain_low");
  with_dividers("coil open", Due::trip, {"coil_open:A@"}, "drain_low");
  with_dividers("coil B's gate stuck at 0.3", Due::trip, {"gate_stuck:B@=0.3"}, "drain_low");
  with_dividers("supply rises to 9 V at once", Due::trip, {"supply_V@=9"}, "supply_high");
  with_dividers("supply at 9 V from the start, both thermocouples show 0.6 of the rise", Due::cool,
                {"supply_V@0=9", "sensor_scale:A@0=0.6", "sensor_scale:B@0=0.6"}, "supply_high", true);
  with_dividers("supply rises by 0.2 V a second", Due::cool, {"supply_ramp_V_s@=0.2"}, "supply_high");
  return rows;
}

// "kind:A@=5" at an onset: "kind:A@6.023=5". A second fault "@+0.2" comes that much later.
std::string at_onset(std::string fault, double from_s) {
  const std::size_t at = fault.find('@') + 1;
  if (at < fault.size() && fault[at] == '+')
    return fault.substr(0, at) + sim::shortest(from_s + sim::parse_number(fault.substr(at + 1)).value());
  if (at < fault.size() && fault[at] != '=') return fault;  // has a time of its own
  return fault.insert(at, sim::shortest(from_s));
}

// Duty, and how hot the coil is when the fault comes.
struct Setting {
  std::string name, scenario, file;
  double onset_s;
  std::size_t phases;
  bool hottest = false;
};
std::vector<Setting> all_settings() {
  return {{"0.45", scenario_text, "scenario.yaml", onset_s, phases_s.size()},
          {"0.7", full_scenario_text, "full.yaml", full_onset_s, 3},
          {"hottest", slow_scenario_text, "slow.yaml", hot_onset_s, 1, true}};
}

// Whether the row's faults come at the onset. Those that have times of their own are the same in every phase.
bool depends_on_onset(const Row& row) {
  return row.to_device || row.from_device || row.latency ||
         std::any_of(row.faults.begin(), row.faults.end(), [](const std::string& fault) { return at_onset(fault, 1.0) != fault; });
}

FaultOutcome run_once(const Row& row, double from_s, const std::filesystem::path& scenario_file, const std::filesystem::path& trace_file,
                      bool hottest = false, double watched_s = afterwards_s) {
  const sim::Scenario scenario = sim::read_scenario(scenario_file);
  std::vector<std::string> faults;
  for (const std::string& one : row.faults) faults.push_back(at_onset(one, from_s));
  std::vector<std::string> command = emulator_command(scenario_file, faults);
  command.insert(command.end(), {"--trace", trace_file});
  if (row.relay) command.push_back("--relay");
  if (row.dividers) command.push_back("--dividers");
  hil::LockStepLink emulator(command);
  std::optional<hil::LatentLink> latent;
  if (row.latency) latent.emplace(emulator, *row.latency, static_cast<std::uint64_t>(std::llround(from_s * 1e6)));
  hil::TamperedLink link(latent ? static_cast<hil::Link&>(*latent) : emulator, row.to_device ? row.to_device(from_s) : nullptr,
                         row.from_device ? row.from_device(from_s) : nullptr);
  FaultOutcome outcome;
  std::int64_t now_us = 0;
  try {
    const hil::SessionResult result = hil::run_session(scenario, link, {});
    outcome.came = std::string(hil::words(result.status));
    // The device's own word is the one that counts; where the host did not hear it, it is asked over a link that works.
    now_us = emulator.receive_until(0).now_us;
    hil::Device anew(emulator, 77);
    anew.listen_until(now_us + 400'000);
    if (const auto hello = anew.hello(100)) {
      if (hello->state == DEVICE_TRIPPED) {
        outcome.came = std::string(hil::words(static_cast<trip_cause>(hello->trip_cause)));
        // A trip must not arm by itself, nor because it is asked nicely.
        const auto armed = anew.arm(hello->firmware_hash, hello->limits_hash);
        outcome.right = armed && *armed == ANSWER_TRIPPED;
      }
      if (hello->state == DEVICE_ARMED) outcome.right = false;
    } else {
      outcome.right = false;
    }
    now_us = anew.now_us();
  } catch (const hil::Refused& refused) {
    outcome.came = refused.what();
    outcome.came.erase(std::min(outcome.came.find('\n'), outcome.came.size()));  // a cell of a table; the rest is advice
    now_us = emulator.receive_until(0).now_us;
  }
  const std::int64_t watched_until_us = now_us + std::llround(watched_s * 1e6);
  while (now_us < watched_until_us) now_us = emulator.receive_until(watched_until_us).now_us;
  emulator.close();

  const Trace trace = read_trace(trace_file);
  for (std::size_t k = 0; k < trace.time_s.size(); ++k) {
    for (const double coil_degC : trace.coil_degC[k]) outcome.peak_degC = std::max(outcome.peak_degC, coil_degC);
    for (const double shown_degC : trace.reading_degC[k]) outcome.peak_reading_degC = std::max(outcome.peak_reading_degC, shown_degC);
  }
  const std::optional<double> zero_s = zero_from_s(trace);
  if (zero_s) outcome.zero_ms = std::max(0.0, (*zero_s - from_s) * 1000.0);
  bool fits = row.due == Due::nothing && outcome.came == "finished";
  for (std::size_t begin = 0, end = 0; row.due != Due::nothing && end != std::string::npos; begin = end + 1) {
    end = row.expected.find('|', begin);
    fits = fits || outcome.came.find(row.expected.substr(begin, end - begin)) != std::string::npos;
  }
  // A coil that is held hot in equilibrium gives no evidence: the session may go on, as long as no coil is too hot.
  if (hottest && (row.due == Due::evidence || row.due == Due::host))
    fits = fits || outcome.came == "finished" || outcome.came == "objected";
  outcome.right = outcome.right && fits;
  if (row.due == Due::refusal) outcome.came = "not armed";
  if (row.group != "pair" && (row.due == Due::nothing || row.due == Due::cool || row.due == Due::refusal)) outcome.zero_ms = std::nan("");
  return outcome;
}

// A pseudo-terminal stands for the port: the second to open it is refused.
FaultOutcome second_opener() {
  const int ours = ::posix_openpt(O_RDWR | O_NOCTTY | O_CLOEXEC);
  if (ours < 0 || ::grantpt(ours) != 0 || ::unlockpt(ours) != 0) throw std::runtime_error("no pseudo-terminal");
  const std::string name = ::ptsname(ours);
  const hil::MonotonicClock clock;
  FaultOutcome outcome{"not refused", false, std::nan(""), std::nan("")};
  {
    const hil::Port first(name, clock);
    try {
      const hil::Port second(name, clock);
    } catch (const sim::InputError&) {
      outcome = {"not armed", true, std::nan(""), std::nan("")};
    }
  }
  ::close(ours);
  return outcome;
}

std::string number(double value, const char* format) {
  if (std::isnan(value)) return "–";
  if (value < 0.0) return "never";
  std::array<char, 32> text{};
  std::snprintf(text.data(), text.size(), format, value);
  return text.data();
}

const char* words(Due due) {
  switch (due) {
    case Due::nothing:
      return "none";
    case Due::trip:
      return "trip";
    case Due::evidence:
      return "trip, after evidence";
    case Due::host:
      return "end, by the host";
    case Due::cool:
      return "a coil within its limit";
    case Due::unsavable:
      return "trip; cannot save";
    case Due::refusal:
      return "no arming";
  }
  return "";
}

bool has_content(const std::filesystem::path& file, std::string_view content) {
  return std::filesystem::is_regular_file(file) && sim::read_file(file) == content;
}

constexpr double most_zero_ms = 250.0, most_degC = LIMIT_COIL_cdegC / 100.0 + 5.0;

// The worst of the row's sessions in a setting.
FaultOutcome worst_of(const Row& row, const Setting& setting, const std::filesystem::path& scenario_file,
                      const std::filesystem::path& trace_file) {
  FaultOutcome worst;
  for (std::size_t phase = 0; phase < setting.phases && (phase == 0 || depends_on_onset(row)); ++phase) {
    if (interrupted()) return worst;
    const FaultOutcome one = run_once(row, setting.onset_s + phases_s[phase], scenario_file, trace_file, setting.hottest);
    if (phase == 0) worst = one;
    if (one.zero_ms < 0.0 || worst.zero_ms < 0.0)
      worst.zero_ms = -1.0;
    else
      worst.zero_ms = std::max(worst.zero_ms, one.zero_ms);
    worst.peak_degC = std::max(worst.peak_degC, one.peak_degC);
    worst.peak_reading_degC = std::max(worst.peak_reading_degC, one.peak_reading_degC);
    if (!one.right && worst.right) worst.came = one.came;
    worst.right = worst.right && one.right;
  }
  return worst;
}

int faults_command(const std::string& out_name, const std::string& only, bool quick, int threads, bool overwrite) {
  Outputs outputs(out_name, {}, overwrite);
  const std::vector<Setting> settings = all_settings();
  for (const Setting& one : settings) outputs.claim({one.file}, has_content(outputs.folder() / one.file, one.scenario));
  if (only.empty()) outputs.claim({"README.md", "faults.csv"});
  std::vector<std::filesystem::path> files;
  for (const Setting& one : settings) files.push_back(outputs.stage(one.file, one.scenario));
  report::Table table, goals;
  table.header = {"", "fault", "due", "came", "PWM zero after [ms]"};
  for (const Setting& one : settings) table.header.push_back("wire, " + one.name + " [°C]");
  table.header.insert(table.header.end(), {"reading [°C]", "as due"});
  std::string csv = "group,fault,due,setting,came,zero_ms,wire_degC,reading_degC,as_due\n";
  int wrong = 0, late = 0, hot = 0, in_all = 0;
  double slowest_ms = 0.0;
  const auto add = [&](const Row& row, const std::vector<std::pair<std::size_t, FaultOutcome>>& outcomes) {
    ++in_all;
    std::string came, as_due = "yes";
    std::vector<std::string> wire(settings.size(), "–");
    double zero_ms = std::nan(""), reading_degC = std::nan("");
    for (const auto& [k, one] : outcomes) {
      const bool is_late = row.due == Due::trip && !(one.zero_ms >= 0.0 && one.zero_ms <= most_zero_ms);
      const bool is_hot = row.due != Due::unsavable && one.peak_degC > most_degC;
      wrong += !one.right;
      late += is_late;
      hot += is_hot;
      if (row.due == Due::trip) slowest_ms = std::max(slowest_ms, one.zero_ms);
      const std::string verdict = !one.right ? "**no**" : is_late ? "**late**" : is_hot ? "**hot**" : "yes";
      if (verdict != "yes") as_due = verdict;
      // Where all settings agree, once.
      if (came.empty())
        came = one.came;
      else if (one.came != outcomes.front().second.came)
        came += ", " + settings[k].name + ": " + one.came;
      if (std::isnan(zero_ms) || one.zero_ms < 0.0 || (zero_ms >= 0.0 && one.zero_ms > zero_ms)) zero_ms = one.zero_ms;
      wire[k] = number(one.peak_degC, "%.1f");
      if (!(one.peak_reading_degC <= reading_degC)) reading_degC = one.peak_reading_degC;
      csv += row.group + ",\"" + row.name + "\",\"" + words(row.due) + "\"," + settings[k].name + "," + one.came + "," +
             number(one.zero_ms, "%.3f") + "," + number(one.peak_degC, "%.3f") + "," + number(one.peak_reading_degC, "%.2f") + "," +
             (verdict == "yes" ? "yes" : "no") + "\n";
      std::printf("%-8s %-75s %-8s %-20s %8s ms %8s degC  %s\n", row.group.c_str(), row.name.c_str(), settings[k].name.c_str(),
                  one.came.c_str(), number(one.zero_ms, "%.0f").c_str(), number(one.peak_degC, "%.1f").c_str(), verdict.c_str());
    }
    std::vector<std::string> cells{row.group, row.name, words(row.due), came, number(zero_ms, "%.0f")};
    cells.insert(cells.end(), wire.begin(), wire.end());
    cells.insert(cells.end(), {number(reading_degC, "%.1f"), as_due});
    table.rows.push_back({cells});
    std::fflush(stdout);
  };
  std::vector<Row> rows;
  for (Row& row : all_rows())
    if (row.name.find(only) != std::string::npos) rows.push_back(std::move(row));
  std::vector<std::vector<std::pair<std::size_t, FaultOutcome>>> outcomes(rows.size());
  std::vector<std::filesystem::path> traces;
  for (std::size_t i = 0; i < rows.size(); ++i) traces.push_back(outputs.scratch("trace_" + std::to_string(i) + ".csv"));
  sim::in_parallel(rows.size(), threads, [&](std::size_t i) {
    const Row& row = rows[i];
    for (std::size_t k = 0; k < settings.size() && !interrupted(); ++k) {
      if (quick && k != (row.slow ? settings.size() - 1 : 0)) continue;
      if (row.slow && !settings[k].hottest) continue;
      // Nothing is heated, or the fault has a time of its own: one setting says all.
      if (k > 0 && !row.slow && (row.due == Due::refusal || !depends_on_onset(row))) continue;
      Setting setting = settings[k];
      // What takes a minute begins at the usual moment.
      if (row.slow) setting.onset_s = onset_s, setting.phases = phases_s.size(), setting.hottest = false;
      outcomes[i].emplace_back(k, worst_of(row, setting, files[k], traces[i]));
    }
  });
  if (interrupted()) return interrupted_exit_code;
  for (std::size_t i = 0; i < rows.size(); ++i) add(rows[i], outcomes[i]);
  if (only.empty())
    add({"link", "a second program opens the port", Due::refusal, {}, nullptr, nullptr, false, "", false}, {{0, second_opener()}});
  goals.header = {"goal", "measured", "reached"};
  goals.rows = {{{"what is due comes, and no trip where none is due",
                  std::to_string(wrong) + " sessions of " + std::to_string(in_all) + " rows otherwise", wrong ? "**no**" : "yes"}},
                {{"PWM zero within 250 ms of a fault that the device can see (due: trip)", "slowest " + number(slowest_ms, "%.0f") + " ms",
                  late ? "**no**" : "yes"}},
                {{"no wire hotter than its limit by more than 5 K, but where software cannot save it", std::to_string(hot) + " hotter",
                  hot ? "**no**" : "yes"}}};
  std::string text =
      "# What goes wrong, and what comes of it\n\n"
      "    sinew hil-faults --out " +
      out_name +
      "\n\n"
      "made this page and `faults.csv`; `tools/hil_results` makes all that is in this folder, this page too. The real firmware in the\n"
      "emulator, the plant behind its pins, in lock step (the same bytes every time). Coil A is heated; the fault comes while it is, in\n"
      "sessions at several places between two readings and two commands, of which the worst is shown: at duty 0.45 after 5.5 s (five\n"
      "places), at duty 0.7 after 3.5 s (three), and at the hottest that the session allows, after 44.5 s (one). What is there from the\n"
      "start is run for a minute. PWM zero: both gates low for good, from the fault on. Wire: the hottest that a coil gets; reading: the\n"
      "hottest that an amplifier shows. A coil's limit is " +
      number(LIMIT_COIL_cdegC / 100.0, "%.0f") + " °C.\n\n" + report::to_markdown(table) + "\n" + report::to_markdown(goals) +
      "\n"
      "*After evidence*: a reading that sticks, or a coil that stays cold, looks like a good one until enough heat has gone in that it\n"
      "must have moved; the time is counted from the fault all the same, and a coil that is held hot in equilibrium gives no such\n"
      "evidence. *By the host*: a thermocouple that drifts slowly cannot be told on the device from a coil that cools; the plant that "
      "runs\n"
      "beside it can. *Cannot save*: with the switch welded no program can take the current away; it says so, and the supply must be cut\n"
      "by hardware (docs/safety.md). *Dividers*: an option of the board, by which it sees its switches and its supply (docs/hardware.md).\n"
      "A port that comes back under another name, and kill -9 of the host, need real time: tests/cli/test_hil.py. A host whose clock\n"
      "stands still is not here: lock step has no other clock than the board's. Brown-out is a reset by the detector; a supply that falls\n"
      "slowly is beyond the emulator. Pairs of faults: [pairs.md](pairs.md); false trips: [false_trips.md](false_trips.md).\n";
  if (only.empty()) {
    outputs.stage("README.md", text);
    outputs.stage("faults.csv", csv);
  }
  outputs.commit();
  std::printf("%d rows: %d not as due, %d late, %d too hot\n", in_all, wrong, late, hot);
  return wrong + late + hot ? 1 : 0;
}

// A part of the board, the limb or the link, and what can be wrong with it: two faults of one part make no pair.
struct Part {
  const char* name;
  std::vector<const char*> faults;  // names of rows
};
const std::vector<Part>& all_parts() {
  static const std::vector<Part> parts{
      {"thermocouple A",
       {"thermocouple open", "amplifier dead, all bits 0", "cold junction jumps by 5 K", "reading stuck", "reading drifts cold by 5 K/s",
        "reading drifts warm by 5 K/s", "a bit flipped in one SPI word in twenty"}},
      {"both thermocouples", {"thermocouples exchanged while one coil is hot"}},
      {"bend sensor", {"bend sensor unplugged, or at 0 V", "bend sensor stuck from the start"}},
      {"processor",
       {"hangs while hot, interrupts served", "hangs while hot, interrupts off", "brown-out", "five brown-outs, 0.2 s apart",
        "reset in the middle of a command"}},
      {"supply", {"supply sags to 5 V: as if the thermocouple read cold", "supply rises to 9 V at once", "supply rises by 0.2 V a second"}},
      {"coil A and its switch", {"coil open", "switch welded, with a cut-off relay on PD7"}},
      {"coil B and its switch", {"coil B's gate stuck at 0.2, with a cut-off relay on PD7"}},
      {"wires of the gates", {"gates exchanged from the start"}},
      {"link",
       {"a bit flipped at every byte position in turn, one frame in ten, both ways", "one frame in ten lost, both ways",
        "cable pulled, or host killed or stopped: nothing goes through any more", "the device hears nothing, the host still hears it",
        "another program's hello: it ends the session", "a bridge that holds frames back for 50 to 80 ms each way"}}};
  return parts;
}

int pairs_command(const std::string& out_name, int threads, bool overwrite) {
  Outputs outputs(out_name, {}, overwrite);
  const Setting setting = all_settings().front();
  outputs.claim({setting.file}, has_content(outputs.folder() / setting.file, setting.scenario));
  outputs.claim({"pairs.md", "pairs.csv"});
  const std::filesystem::path file = outputs.stage(setting.file, setting.scenario);
  std::map<std::string, Row> rows;
  for (const Row& row : all_rows()) rows.emplace(row.name, row);
  std::string csv = "first_part,first,second_part,second,came,zero_ms,wire_degC,reading_degC,as_due\n";
  report::Table hottest, bad, with_dividers;
  hottest.header = bad.header =
      with_dividers.header = {"part", "fault", "part", "fault", "came", "PWM zero after [ms]", "wire [°C]", "reading [°C]"};
  std::vector<std::pair<double, report::Row>> by_heat;
  int count = 0, hot = 0, late = 0, hot_fitted = 0;
  double slowest_ms = 0.0;
  const std::vector<Part>& parts = all_parts();
  struct Pair {
    std::size_t p, q;
    const char *first_name, *second_name;
    Row both;
    std::filesystem::path trace;
    FaultOutcome outcome{};
    std::optional<FaultOutcome> with_dividers{};  // of a pair that is not as due without them
  };
  std::vector<Pair> pairs;
  for (std::size_t p = 0; p < parts.size(); ++p)
    for (std::size_t q = p + 1; q < parts.size(); ++q)
      for (const char* first_name : parts[p].faults)
        for (const char* second_name : parts[q].faults) {
          const Row &first = rows.at(first_name), &second = rows.at(second_name);
          Row both{"pair", "", Due::cool, first.faults, first.to_device, first.from_device, true, "", false, first.latency};
          both.faults.insert(both.faults.end(), second.faults.begin(), second.faults.end());
          if (second.to_device) both.to_device = second.to_device;
          if (second.from_device) both.from_device = second.from_device;
          if (second.latency) both.latency = second.latency;
          pairs.push_back({p, q, first_name, second_name, both, outputs.scratch("trace_" + std::to_string(pairs.size()) + ".csv")});
        }
  // What the board can see of one of the two it must see of both.
  const auto seen = [&](const Pair& pair, const FaultOutcome& one) {
    return (rows.at(pair.first_name).due == Due::trip || rows.at(pair.second_name).due == Due::trip) &&
           one.came.find("arming") == std::string::npos;
  };
  // Of faults that are there from the start the time is that of the other one, or there was no duty at all.
  const auto late_one = [&](const Pair& pair, const FaultOutcome& one) {
    const double zero_ms = one.zero_ms < 0.0 ? HUGE_VAL : one.zero_ms;
    return seen(pair, one) && !(zero_ms <= most_zero_ms);
  };
  sim::in_parallel(pairs.size(), threads, [&](std::size_t i) {
    Pair& pair = pairs[i];
    const auto run = [&] { return run_once(pair.both, setting.onset_s, file, pair.trace, false, after_pair_s); };
    if (!interrupted()) pair.outcome = run();
    if (!interrupted() && (pair.outcome.peak_degC > most_degC || late_one(pair, pair.outcome))) {
      pair.both.dividers = true;
      pair.with_dividers = run();
    }
    std::filesystem::remove(pair.trace);
  });
  if (interrupted()) return interrupted_exit_code;
  for (const Pair& pair : pairs) {
    const auto& [p, q, first_name, second_name, both, trace, one, fitted] = pair;
    const bool sees = seen(pair, one), is_late = late_one(pair, one), is_hot = one.peak_degC > most_degC;
    ++count;
    late += is_late;
    hot += is_hot;
    if (sees) slowest_ms = std::max(slowest_ms, one.zero_ms < 0.0 ? HUGE_VAL : one.zero_ms);
    std::string came = one.came;
    std::replace(came.begin(), came.end(), ',', ';');
    csv += std::string(parts[p].name) + ",\"" + first_name + "\"," + parts[q].name + ",\"" + second_name + "\"," + came + "," +
           number(one.zero_ms, "%.3f") + "," + number(one.peak_degC, "%.3f") + "," + number(one.peak_reading_degC, "%.2f") + "," +
           (is_late || is_hot ? "no" : "yes") + "\n";
    report::Row row{{parts[p].name, first_name, parts[q].name, second_name, came, number(one.zero_ms, "%.0f"),
                     number(one.peak_degC, "%.1f"), number(one.peak_reading_degC, "%.1f")}};
    if (is_late || is_hot) bad.rows.push_back(row);
    if (fitted) {
      report::Row again = row;
      again.cells[4] = fitted->came;
      again.cells[5] = number(fitted->zero_ms, "%.0f");
      again.cells[6] = number(fitted->peak_degC, "%.1f");
      again.cells[7] = number(fitted->peak_reading_degC, "%.1f");
      hot_fitted += fitted->peak_degC > most_degC || late_one(pair, *fitted);
      with_dividers.rows.push_back(again);
    }
    by_heat.emplace_back(one.peak_degC, std::move(row));
    std::printf("%-55.55s %-55.55s %-20.20s %8s ms %6.1f degC %s\n", first_name, second_name, came.c_str(),
                number(one.zero_ms, "%.0f").c_str(), one.peak_degC,
                is_hot    ? "HOT"
                : is_late ? "LATE"
                          : "");
    std::fflush(stdout);
  }
  std::stable_sort(by_heat.begin(), by_heat.end(), [](const auto& a, const auto& b) { return a.first > b.first; });
  for (std::size_t k = 0; k < std::min<std::size_t>(20, by_heat.size()); ++k) hottest.rows.push_back(by_heat[k].second);
  report::Table goals;
  goals.header = {"goal", "measured", "reached"};
  goals.rows = {{{"no wire hotter than its limit by more than 5 K, with the relay alone",
                  std::to_string(hot) + " of " + std::to_string(count) + " pairs hotter", hot ? "**no**" : "yes"}},
                {{"PWM zero within 250 ms where one of the two is a fault that the board can see at once",
                  std::to_string(late) + " later, slowest " + number(slowest_ms, "%.0f") + " ms", late ? "**no**" : "yes"}}};
  outputs.stage("pairs.md",
                "# Every pair of faults\n\n    sinew hil-faults --pairs --out " + out_name +
                    "\n\nmade this page and `pairs.csv`: " + std::to_string(count) +
                    " pairs of faults of different parts, both at the same moment, while coil A is heated at\n"
                    "duty 0.45 (but for those that are there from the start), the firmware in the emulator, in lock step. The relay of\n"
                    "docs/hardware.md is fitted: without it no program opens a welded switch.\n\n" +
                    report::to_markdown(goals) + "\nThe twenty hottest:\n\n" + report::to_markdown(hottest) +
                    (bad.rows.empty() ? std::string()
                                      : "\nNot as due:\n\n" + report::to_markdown(bad) +
                                            "\nThe same with the dividers at the drains (docs/hardware.md), " + std::to_string(hot_fitted) +
                                            " not as due:\n\n" + report::to_markdown(with_dividers)));
  outputs.stage("pairs.csv", csv);
  outputs.commit();
  std::printf("%d pairs: %d late, %d too hot\n", count, late, hot);
  return late + hot ? 1 : 0;
}

}  // namespace

void add_hil_faults(CLI::App& program, int& exit_code) {
  auto out = std::make_shared<std::string>();
  auto only = std::make_shared<std::string>();
  auto quick = std::make_shared<bool>(false), pairs = std::make_shared<bool>(false);
  auto threads = std::make_shared<int>(1);
  auto overwrite = std::make_shared<bool>(false);
  CLI::App* command =
      program.add_subcommand("hil-faults", "Make everything go wrong on the emulated limb, and write down what came of it.");
  command->add_option("--out", *out, "folder for README.md, faults.csv and the scenarios")->required();
  command->add_option("--only", *only, "rows whose name has this in it; nothing but the scenarios is written then");
  command->add_option("--threads", *threads, "sessions at a time; the result is the same")
      ->check(CLI::Range(1, 256))
      ->capture_default_str();
  command->add_flag("--quick", *quick, "the usual setting alone: duty 0.45, the fault after 5.5 s");
  command->add_flag("--pairs", *pairs, "every pair of faults of different parts instead: pairs.md, pairs.csv");
  add_overwrite(*command, *overwrite);
  command->footer("Example:\n  sinew hil-faults --out results/hil");
  command->callback([out, only, quick, pairs, threads, overwrite, &exit_code] {
    if (*pairs && (*quick || !only->empty()))
      throw sim::InputError({.key = "--pairs", .advice = "takes neither --only nor --quick: there is one list of pairs"});
    if (*quick && only->empty()) throw sim::InputError({.key = "--quick", .advice = "wants --only: the page is of all settings"});
    exit_code = *pairs ? pairs_command(*out, *threads, *overwrite) : faults_command(*out, *only, *quick, *threads, *overwrite);
  });
}

}  // namespace sinew::apps

// SPDX-License-Identifier: Apache-2.0
// sinew hil-faults: everything that is known to go wrong, made to go wrong on the emulated board, and what came of it.
#include <fcntl.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <memory>
#include <sstream>

#include "apps/app.h"
#include "apps/limb_link.h"
#include "apps/outputs.h"
#include "hil/limits.h"
#include "hil/lock_step_link.h"
#include "hil/port.h"
#include "hil/session.h"
#include "report/markdown.h"
#include "sim/input_error.h"
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
constexpr double onset_s = 6.0;
// The time to zero depends on where between two readings and two commands the fault falls: the worst of these is reported.
constexpr std::array<double, 5> phases_s{0.0, 0.023, 0.047, 0.071, 0.095};
constexpr double afterwards_s = 6.0;  // the board is watched on after the session

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
};

struct FaultOutcome {
  std::string came;  // the trip's cause, or how the session ended
  bool right = true;
  double zero_ms = -1.0;  // -1: never; NaN: there was nothing to wait for
  double peak_degC = 0.0;
};

// Rows of the emulator's trace.
struct Trace {
  std::vector<double> time_s;
  std::vector<std::vector<double>> gate, coil_degC;  // [rows][coils]
};

Trace read_trace(const std::filesystem::path& file) {
  Trace trace;
  std::istringstream lines(sim::read_file(file));
  std::string line;
  std::getline(lines, line);
  while (std::getline(lines, line)) {
    // The time, then a gate of each coil, then a temperature of each.
    std::vector<double> value;
    std::istringstream fields(line);
    std::string field;
    while (std::getline(fields, field, ',')) value.push_back(sim::parse_number(field).value());
    const auto first = value.begin() + 1, half = first + (value.end() - first) / 2;
    trace.time_s.push_back(value.front());
    trace.gate.emplace_back(first, half);
    trace.coil_degC.emplace_back(half, value.end());
  }
  return trace;
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
// Another version, with a CRC that is right: bytes 1 and the CRC's of an unstuffed frame.
hil::Tamper other_version() {
  return [](const Bytes& wire, std::int64_t) -> std::vector<Bytes> {
    hil::Bytes out;
    frame_decoder decoder;
    frame_decoder_start(&decoder, nullptr);
    frame in;
    for (const std::uint8_t byte : wire)
      if (frame_decoder_take(&decoder, byte, &in) == FRAME_READY) {
        in.version = FRAME_VERSION + 1;
        out.resize(FRAME_WIRE_MOST);
        out.resize(frame_encode(&in, out.data()));
      }
    return {std::move(out)};
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
  add("sensor", "bend sensor unplugged, or at 0 V", Due::trip, {"bend_low@"}, "angle_range|objected");
  add("sensor", "bend sensor at 5 V", Due::trip, {"bend_high@"}, "angle_range|objected");
  add("sensor", "bend sensor stuck from the start", Due::evidence, {"bend_stuck@0.1"}, "angle_stuck|objected");
  add("device", "hangs while hot, interrupts served", Due::trip, {"hang@"}, "main_loop");
  add("device", "hangs while hot, interrupts off", Due::trip, {"hang_masked@"}, "watchdog");
  add("device", "brown-out", Due::trip, {"brown_out@"}, "brown_out");
  add("device", "brown-out twice within a millisecond", Due::trip, {"brown_out@", "brown_out@+0.0011"}, "brown_out");
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
  add("plant", "supply sags to 5 V: as if the thermocouple read cold", Due::host, {"supply_V@=5"}, "objected|not_following");
  // Two errors that hide each other: the readings look right. Heat goes with the square of the supply: 7.98 V are 1.3 of it.
  add("both", "supply at 8 V from the start, both thermocouples show 0.8 of the rise", Due::cool,
      {"supply_V@0=8", "sensor_scale:A@0=0.8", "sensor_scale:B@0=0.8"}, "finished|objected", false, true);
  add("both", "heat times 1.3 from the start, both thermocouples show 0.7 of the rise", Due::cool,
      {"supply_V@0=7.98", "sensor_scale:A@0=0.7", "sensor_scale:B@0=0.7"}, "finished|objected", false, true);
  add("both", "heat times 1.3 from the start, both thermocouples show 0.6 of the rise", Due::cool,
      {"supply_V@0=7.98", "sensor_scale:A@0=0.6", "sensor_scale:B@0=0.6"}, "finished|objected", false, true);
  add("plant", "supply at 8 V from the start", Due::cool, {"supply_V@0=8"}, "finished|objected", false, true);
  add("plant", "switch welded: coil on for good", Due::unsavable, {"coil_welded:A@"}, "unexpected_heating|over_temperature");
  add("plant", "switch welded, with a cut-off relay on PD7", Due::evidence, {"coil_welded:A@"}, "unexpected_heating|over_temperature",
      true);
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

// Whether the row's faults come at the onset. Those that have times of their own are the same in every phase.
bool depends_on_onset(const Row& row) {
  return row.to_device || row.from_device || row.latency ||
         std::any_of(row.faults.begin(), row.faults.end(), [](const std::string& fault) { return at_onset(fault, 1.0) != fault; });
}

FaultOutcome run_once(const Row& row, double from_s, const std::filesystem::path& scenario_file, const std::filesystem::path& trace_file) {
  const sim::Scenario scenario = sim::read_scenario(scenario_file);
  std::vector<std::string> faults;
  for (const std::string& one : row.faults) faults.push_back(at_onset(one, from_s));
  std::vector<std::string> command = emulator_command(scenario_file, faults);
  command.insert(command.end(), {"--trace", trace_file});
  if (row.relay) command.push_back("--relay");
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
    now_us = emulator.receive_until(0).now_us;
  }
  const std::int64_t watched_until_us = now_us + std::llround(afterwards_s * 1e6);
  while (now_us < watched_until_us) now_us = emulator.receive_until(watched_until_us).now_us;
  emulator.close();

  const Trace trace = read_trace(trace_file);
  std::optional<double> zero_s;
  for (std::size_t k = 0; k < trace.time_s.size(); ++k) {
    for (const double coil_degC : trace.coil_degC[k]) outcome.peak_degC = std::max(outcome.peak_degC, coil_degC);
    const bool off = std::all_of(trace.gate[k].begin(), trace.gate[k].end(), [](double gate) { return gate == 0.0; });
    if (!off) zero_s.reset();
    if (off && !zero_s) zero_s = trace.time_s[k];
  }
  if (zero_s) outcome.zero_ms = std::max(0.0, (*zero_s - from_s) * 1000.0);
  bool fits = row.due == Due::nothing && outcome.came == "finished";
  for (std::size_t begin = 0, end = 0; row.due != Due::nothing && end != std::string::npos; begin = end + 1) {
    end = row.expected.find('|', begin);
    fits = fits || outcome.came.find(row.expected.substr(begin, end - begin)) != std::string::npos;
  }
  outcome.right = outcome.right && fits;
  if (row.due == Due::refusal) outcome.came = "not armed";
  if (row.due == Due::nothing || row.due == Due::cool || row.due == Due::refusal) outcome.zero_ms = std::nan("");
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

int faults_command(const std::string& out_name, const std::string& only, bool overwrite) {
  Outputs outputs(out_name, {}, overwrite);
  for (const auto& [name, text] : {std::pair{"scenario.yaml", scenario_text}, std::pair{"slow.yaml", slow_scenario_text}})
    outputs.claim({name}, has_content(outputs.folder() / name, text));
  if (only.empty()) outputs.claim({"README.md", "faults.csv"});
  const std::filesystem::path scenario_file = outputs.stage("scenario.yaml", scenario_text),
                              slow_file = outputs.stage("slow.yaml", slow_scenario_text), trace_file = outputs.scratch("trace.csv");
  report::Table table, goals;
  table.header = {"", "fault", "due", "came", "PWM zero after [ms]", "hottest coil [°C]", "as due"};
  std::string csv = "group,fault,due,came,zero_ms,peak_degC,as_due\n";
  int wrong = 0, late = 0, hot = 0, in_all = 0;
  double slowest_ms = 0.0;
  constexpr double most_ms = 250.0, most_degC = LIMIT_COIL_cdegC / 100.0 + 5.0;
  const auto add = [&](const Row& row, const FaultOutcome& worst) {
    ++in_all;
    const bool is_late = row.due == Due::trip && !(worst.zero_ms >= 0.0 && worst.zero_ms <= most_ms);
    const bool is_hot = row.due != Due::unsavable && worst.peak_degC > most_degC;
    wrong += !worst.right;
    late += is_late;
    hot += is_hot;
    if (row.due == Due::trip) slowest_ms = std::max(slowest_ms, worst.zero_ms);
    const std::string as_due = !worst.right ? "**no**" : is_late ? "**late**" : is_hot ? "**hot**" : "yes";
    table.rows.push_back(
        {{row.group, row.name, words(row.due), worst.came, number(worst.zero_ms, "%.0f"), number(worst.peak_degC, "%.1f"), as_due}});
    csv += row.group + ",\"" + row.name + "\"," + "\"" + words(row.due) + "\"," + worst.came + "," + number(worst.zero_ms, "%.3f") + "," +
           number(worst.peak_degC, "%.3f") + "," + (worst.right && !is_late && !is_hot ? "yes" : "no") + "\n";
    std::printf("%-8s %-75s %-20s %8s ms %8s degC  %s\n", row.group.c_str(), row.name.c_str(), worst.came.c_str(),
                number(worst.zero_ms, "%.0f").c_str(), number(worst.peak_degC, "%.1f").c_str(), as_due.c_str());
    std::fflush(stdout);
  };
  for (const Row& row : all_rows()) {
    if (!only.empty() && row.name.find(only) == std::string::npos) continue;
    FaultOutcome worst;
    bool first = true;
    for (const double phase_s : phases_s) {
      if (interrupted()) return interrupted_exit_code;
      if (!first && !depends_on_onset(row)) break;
      const FaultOutcome one = run_once(row, onset_s + phase_s, row.slow ? slow_file : scenario_file, trace_file);
      if (first) worst = one;
      if (one.zero_ms < 0.0 || worst.zero_ms < 0.0)
        worst.zero_ms = -1.0;
      else
        worst.zero_ms = std::max(worst.zero_ms, one.zero_ms);
      worst.peak_degC = std::max(worst.peak_degC, one.peak_degC);
      if (!one.right && worst.right) worst.came = one.came;
      worst.right = worst.right && one.right;
      first = false;
    }
    add(row, worst);
  }
  if (only.empty()) add({"link", "a second program opens the port", Due::refusal, {}, nullptr, nullptr, false, "", false}, second_opener());
  goals.header = {"goal", "measured", "reached"};
  goals.rows = {{{"what is due comes, and no trip where none is due",
                  std::to_string(in_all - wrong) + " of " + std::to_string(in_all) + " rows", wrong ? "**no**" : "yes"}},
                {{"PWM zero within 250 ms of a fault that the device can see (due: trip)", "slowest " + number(slowest_ms, "%.0f") + " ms",
                  late ? "**no**" : "yes"}},
                {{"no coil hotter than its limit by more than 5 K, but where software cannot save it", std::to_string(hot) + " rows hotter",
                  hot ? "**no**" : "yes"}}};
  std::string text =
      "# What goes wrong, and what comes of it\n\n"
      "    sinew hil-faults --out " +
      out_name +
      "\n\n"
      "made this page and `faults.csv`: the real firmware in the emulator, the plant behind its pins, in lock step (the same bytes every\n"
      "time). Coil A is heated at duty 0.45; the fault comes at 6 s, in five sessions at five places between two readings and two\n"
      "commands; the worst of the five is shown. PWM zero: both gates low for good, from the fault on. The coil's limit is " +
      number(LIMIT_COIL_cdegC / 100.0, "%.0f") + " °C.\n\n" + report::to_markdown(table) + "\n" + report::to_markdown(goals) +
      "\n"
      "*After evidence*: a reading that sticks, or a coil that stays cold, looks like a good one until enough heat has gone in that it\n"
      "must have moved; the time is counted from the fault all the same. *By the host*: a thermocouple that drifts slowly cannot be told\n"
      "on the device from a coil that cools; the plant that runs beside it can. *Cannot save*: with the switch welded no program can take "
      "the\n"
      "current away; it says so, and the supply must be cut by hardware (docs/safety.md). A port that comes back under another name, and\n"
      "kill -9 of the host, need real time: tests/cli/test_hil.py.\n";
  if (only.empty()) {
    outputs.stage("README.md", text);
    outputs.stage("faults.csv", csv);
  }
  outputs.commit();
  std::printf("%d rows: %d not as due, %d late, %d too hot\n", in_all, wrong, late, hot);
  return wrong + late + hot ? 1 : 0;
}

}  // namespace

void add_hil_faults(CLI::App& program, int& exit_code) {
  auto out = std::make_shared<std::string>();
  auto only = std::make_shared<std::string>();
  auto overwrite = std::make_shared<bool>(false);
  CLI::App* command =
      program.add_subcommand("hil-faults", "Make everything go wrong on the emulated limb, and write down what came of it.");
  command->add_option("--out", *out, "folder for README.md, faults.csv, scenario.yaml")->required();
  command->add_option("--only", *only, "rows whose name has this in it; nothing but the scenario is written then");
  add_overwrite(*command, *overwrite);
  command->footer("Example:\n  sinew hil-faults --out results/hil");
  command->callback([out, only, overwrite, &exit_code] { exit_code = faults_command(*out, *only, *overwrite); });
}

}  // namespace sinew::apps

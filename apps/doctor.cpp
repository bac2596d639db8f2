// SPDX-License-Identifier: Apache-2.0
// sinew doctor: looks at a port and at the board behind it, and says what is wrong and what to do. It never arms. With --real-time it
// measures whether the loop of a session is on time on this machine.
#include <grp.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <optional>

#include "apps/app.h"
#include "apps/limb_link.h"
#include "firmware_hash.h"
#include "hil/device.h"
#include "hil/limits.h"
#include "hil/port.h"
#include "hil/punctuality.h"
#include "hil/session.h"
#include "sim/input_error.h"
#include "sim/text.h"

namespace sinew::apps {
namespace {

namespace fs = std::filesystem;

class Findings {
 public:
  void good(const std::string& what) { std::printf("ok    %s\n", what.c_str()); }
  void warn(const std::string& what, const std::string& advice) { std::printf("warn  %s\n      %s\n", what.c_str(), advice.c_str()); }
  void bad(const std::string& what, const std::string& advice) {
    std::printf("FAIL  %s\n      %s\n", what.c_str(), advice.c_str());
    any_bad_ = true;
  }
  bool any_bad() const { return any_bad_; }

 private:
  bool any_bad_ = false;
};

std::vector<fs::path> boards() {
  std::vector<fs::path> all;
  std::error_code none;
  for (const auto& entry : fs::directory_iterator("/dev/serial/by-id", none)) all.push_back(entry.path());
  std::sort(all.begin(), all.end());
  return all;
}

// False: there is nothing to open.
bool look_at_file(const std::string& port, Findings& findings) {
  struct stat facts {};
  if (::stat(port.c_str(), &facts) != 0) {
    std::string there;
    for (const auto& one : boards()) there += "\n        " + one.string();
    findings.bad(port + ": not there",
                 there.empty() ? "no USB serial device is plugged in (nothing in /dev/serial/by-id)" : "there are:" + there);
    return false;
  }
  if (!S_ISCHR(facts.st_mode)) {
    findings.bad(port + ": is no device", "must be a serial port, as /dev/serial/by-id/... or /dev/ttyACM0");
    return false;
  }
  if (::access(port.c_str(), R_OK | W_OK) != 0) {
    const group* owner = ::getgrgid(facts.st_gid);
    const std::string name = owner ? owner->gr_name : std::to_string(facts.st_gid);
    findings.bad(port + ": may not be read and written by you",
                 "it belongs to the group " + name + ": sudo adduser $USER " + name + ", then log in anew");
    return false;
  }
  findings.good("may be read and written");
  const fs::path real = fs::canonical(port);
  if (real.string().starts_with("/dev/tty") && !port.starts_with("/dev/serial/"))
    findings.warn(port + " is a name that another board may have tomorrow", "use its name in /dev/serial/by-id");
  const fs::path latency = fs::path("/sys/bus/usb-serial/devices") / real.filename() / "latency_timer";
  if (fs::exists(latency)) {
    const std::string text(sim::trimmed(sim::read_file(latency)));
    const int ms = std::atoi(text.c_str());
    if (ms > 1)
      findings.warn("its USB chip holds bytes back for up to " + std::to_string(ms) + " ms", "echo 1 | sudo tee " + latency.string());
    else
      findings.good("latency timer: 1 ms");
  }
  return true;
}

// Whether the loop of `sinew hil` may go before other programs.
void look_at_priority(Findings& findings) {
  rlimit most{};
  if (::geteuid() == 0 || (::getrlimit(RLIMIT_RTPRIO, &most) == 0 && most.rlim_cur >= real_time_priority))
    findings.good("sessions may go before other programs");
  else
    findings.warn("sessions may not go before other programs: deadlines wait for what else runs here",
                  "a line `YOUR-NAME - rtprio " + std::to_string(real_time_priority) +
                      "` in /etc/security/limits.d/sinew.conf, then log in anew");
}

void look_at_board(const std::string& port, Findings& findings) {
  const hil::MonotonicClock clock;
  std::unique_ptr<hil::Port> link;
  try {
    link = std::make_unique<hil::Port>(port, clock);
  } catch (const sim::InputError& error) {
    findings.bad("cannot be opened", error.advice);
    return;
  }
  findings.good("opened for this program alone, 500000 Bd 8N1");
  hil::Device device(*link, static_cast<std::uint16_t>(1 + clock.now_us() / 1000 % 65000));
  // A board that is reset by opening its port needs its time.
  device.listen_until(clock.now_us() + 500'000);
  const auto hello = device.hello(20);
  const auto& refused = device.counters().refused;
  if (!hello) {
    if (device.other_version())
      findings.bad("speaks another version of the protocol than " + std::to_string(FRAME_VERSION),
                   "flash the firmware that belongs to this program: docs/hardware.md");
    else if (std::any_of(refused.begin(), refused.end(), [](std::int64_t n) { return n > 0; }))
      findings.bad("sends bytes, and no valid frame among them", "another device, or other firmware: docs/hardware.md says how to flash");
    else
      findings.bad("does not answer", "another device, a board without power, or one that hangs in its bootloader: push its reset button");
    return;
  }
  findings.good("answers, protocol version " + std::to_string(FRAME_VERSION));
  char text[96];
  if (const std::string misfit = hil::misfit_of(hello->parts); !misfit.empty()) {
    findings.bad(misfit, "flash the firmware that belongs to this program: docs/hardware.md");
    return;
  }
  std::snprintf(text, sizeof text, "coils: %u, thermocouples: %u, angles: %u", hello->parts.coils, hello->parts.thermocouples,
                hello->parts.angles);
  findings.good(text);
  if (hello->firmware_hash == SINEW_FIRMWARE_HASH) {
    findings.good("firmware is this program's");
  } else {
    std::snprintf(text, sizeof text, "firmware %08x, this program's is %08x", static_cast<unsigned>(hello->firmware_hash),
                  static_cast<unsigned>(SINEW_FIRMWARE_HASH));
    findings.bad(text, "flash the firmware that belongs to this program: docs/hardware.md");
  }
  if (hello->limits_hash == limits_hash(hello->parts.coils))
    findings.good("limits are this program's");
  else
    findings.bad("limits are not this program's", "build and flash both from the same hil/limits.h");
  for (const std::string& wrong : hil::words_of_settings(hello->wrong_settings))
    findings.bad("fuses: " + wrong, "set them once, by a programmer; until then it does not arm: docs/hardware.md, Fuses");
  if (hello->wrong_settings == 0) findings.good("fuses: brown-out detection and watchdog as they must be");
  const std::string cause{hil::words(static_cast<reset_cause>(hello->reset_cause))};
  if (hello->reset_cause == RESET_WATCHDOG || hello->reset_cause == RESET_BROWN_OUT)
    findings.warn("last reset: " + cause, hello->reset_cause == RESET_WATCHDOG ? "its program hung; tell us how it came to that"
                                                                               : "its 5 V sag: a better supply, or a shorter cable");
  else
    findings.good("last reset: " + cause);
  if (hello->state == DEVICE_TRIPPED)
    findings.bad("tripped: " + std::string(hil::words(static_cast<trip_cause>(hello->trip_cause))),
                 "find out why, let the coils cool, then `sinew hil ... --clear-trip`");
  else
    findings.good("not tripped");
  const std::int64_t before = device.counters().received, missing_before = device.counters().missing, began_us = device.now_us();
  device.listen_until(began_us + 2'000'000);
  const std::int64_t frames = device.counters().received - before, missing = device.counters().missing - missing_before;
  if (frames < 80 || missing > 0) {
    std::snprintf(text, sizeof text, "%lld of 100 telemetry frames in 2 s, %lld missing", static_cast<long long>(frames),
                  static_cast<long long>(missing));
    findings.bad(text, "cable, hub or a machine that is too busy");
    if (frames == 0) return;
  } else {
    std::snprintf(text, sizeof text, "telemetry: %lld frames in 2 s, none missing", static_cast<long long>(frames));
    findings.good(text);
  }
  const message_telemetry& said = device.telemetry()->said;
  for (std::size_t j = 0; j < hello->parts.thermocouples; ++j) {
    const std::string name = std::string("thermocouple ") + static_cast<char>('A' + j);
    if (said.sensor[j] == TRIP_NONE) {
      std::snprintf(text, sizeof text, "%s: %.2f degC", name.c_str(), said.temperature_cdegC[j] / 100.0);
      findings.good(text);
    } else {
      findings.bad(name + ": " + std::string(hil::words(static_cast<trip_cause>(said.sensor[j]))),
                   "wiring of thermocouple and amplifier: docs/hardware.md");
    }
  }
  for (std::size_t k = 0; k < hello->parts.angles; ++k) {
    const std::string name = hello->parts.angles == 1 ? "bend sensor" : "bend sensor " + std::to_string(k + 1);
    std::snprintf(text, sizeof text, "%s: %.2f deg", name.c_str(), said.angle_cdeg[k] / 100.0);
    if (said.angle_raw[k] < 160 || said.angle_raw[k] > 16208)
      findings.bad(text, "at the end of its range: a wire is off");
    else
      findings.good(text);
  }
}

// The rates of a session that people use, and the fastest.
void look_at_deadlines(const std::string& given, double duration_s, Findings& findings) {
  std::optional<BoardProcess> board;
  if (given.empty()) board.emplace();
  if (stay_in_memory())
    findings.good("memory stays where it is");
  else
    findings.warn("memory may be paged out: deadlines may wait for a disk",
                  "a line `YOUR-NAME - memlock unlimited` in /etc/security/limits.d/sinew.conf, then log in anew");
  const bool first = take_real_time_priority();
  const hil::MonotonicClock clock;
  for (const std::int64_t period_us : {100'000, 5'000}) {
    hil::Punctuality seen;
    try {
      hil::Port link(board ? board->port() : given, clock);
      seen = hil::measure_punctuality(link, static_cast<std::uint16_t>(1 + clock.now_us() / 1000 % 65000), period_us, duration_s,
                                      [] { return interrupted(); });
    } catch (const hil::Refused& refused) {
      findings.bad(refused.what(), "`sinew doctor --port ...` looks further");
      break;
    } catch (const hil::LinkLost& lost) {
      findings.bad(std::string("the link was lost: ") + lost.what(), "is the cable in?");
      break;
    }
    const double share = seen.deadlines > 0 ? static_cast<double>(seen.within_5_ms) / static_cast<double>(seen.deadlines) : 0.0;
    char text[200];
    std::snprintf(
        text, sizeof text,
        "%lld Hz: %.3f %% of %lld commands written within 5 ms of their deadline; median %.2f ms, 99.9 %% within %.2f ms, latest %.2f "
        "ms; %lld without telemetry",
        static_cast<long long>(1'000'000 / period_us), 100.0 * share, static_cast<long long>(seen.deadlines),
        static_cast<double>(seen.median_us) / 1e3, static_cast<double>(seen.share_99_9_us) / 1e3, static_cast<double>(seen.most_us) / 1e3,
        static_cast<long long>(seen.without_telemetry));
    if (share >= 0.9999)
      findings.good(text);
    else if (share >= 0.999)
      findings.warn(text, "the goal is 99.99 % on an idle machine, 99.9 % on a busy one");
    else
      findings.bad(text, first ? "the machine is late by itself: another kernel (PREEMPT_RT), or no virtual machine"
                               : "let sessions go before other programs, as said above");
    if (interrupted()) break;
  }
  if (first) give_priority_back();
}

int doctor_command(const std::string& port, double real_time_s) {
  Findings findings;
  if (real_time_s > 0.0) {
    look_at_priority(findings);
    if (port.empty() || look_at_file(port, findings)) look_at_deadlines(port, real_time_s, findings);
    return interrupted() ? interrupted_exit_code : findings.any_bad() ? 1 : 0;
  }
  if (port.empty()) {
    const auto all = boards();
    if (all.empty()) {
      findings.bad("no USB serial device is plugged in", "nothing in /dev/serial/by-id");
      return 1;
    }
    for (const auto& one : all) std::printf("%s\n", one.c_str());
    return 0;
  }
  look_at_priority(findings);
  if (look_at_file(port, findings)) look_at_board(port, findings);
  return findings.any_bad() ? 1 : 0;
}

}  // namespace

void add_doctor(CLI::App& program, int& exit_code) {
  auto port = std::make_shared<std::string>();
  auto real_time_s = std::make_shared<double>(0.0);
  CLI::App* command = program.add_subcommand("doctor", "Look at a port and the limb's board behind it; says what to do. Never arms.");
  command->add_option("--port", *port, "the limb's serial port; without it, those that are there are listed");
  command
      ->add_option(
          "--real-time", *real_time_s,
          "seconds each at 10 and 200 Hz: how many commands of a session's loop are written in time, to the board at --port, not armed, "
          "or without it to the board's program on this machine")
      ->check(CLI::Range(1.0, 86400.0));
  command->footer("Examples:\n  sinew doctor --port /dev/serial/by-id/usb-...\n  sinew doctor --real-time 60");
  command->callback([port, real_time_s, &exit_code] { exit_code = doctor_command(*port, *real_time_s); });
}

}  // namespace sinew::apps

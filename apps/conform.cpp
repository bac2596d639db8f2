// SPDX-License-Identifier: Apache-2.0
// sinew conform: whether somebody else's board does what docs/protocol.md says. Nothing is heated.
#include "hil/conform.h"

#include <sys/mman.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <cstring>
#include <memory>
#include <optional>
#include <string_view>

#include "apps/app.h"
#include "apps/limb_link.h"
#include "hil/lock_step_link.h"
#include "hil/port.h"
#include "sim/input_error.h"

namespace sinew::apps {
namespace {

// A scenario for the emulator, which is told of it by name: a limb at rest. It stands in memory alone, so that nothing stays behind,
// however this ends.
class ScenarioInMemory {
 public:
  ScenarioInMemory() {
    constexpr std::string_view text =
        "format: 1\nseed: 1\nduration_s: 60.0\ninput: { duty_A: { step: { height_fraction: 0.0, from_s: 1.0, until_s: 2.0 } } }\n";
    file_ = ::memfd_create("sinew_conform", 0);  // and the emulator inherits it
    if (file_ < 0 || ::write(file_, text.data(), text.size()) != static_cast<ssize_t>(text.size()))
      throw std::runtime_error(std::string("a file in memory: ") + std::strerror(errno));
  }
  ~ScenarioInMemory() { ::close(file_); }
  ScenarioInMemory(const ScenarioInMemory&) = delete;
  ScenarioInMemory& operator=(const ScenarioInMemory&) = delete;
  std::string path() const { return "/proc/self/fd/" + std::to_string(file_); }

 private:
  int file_ = -1;
};

int conform_command(const std::string& port, bool emulate, bool clear_trip, bool coils_disconnected) {
  if (emulate == !port.empty())
    throw sim::InputError({.key = "--port, --emulate", .advice = "one of the two: a board at a port, or the firmware in the emulator"});
  const hil::MonotonicClock clock;
  std::optional<ScenarioInMemory> scenario;
  std::unique_ptr<hil::Link> link;
  if (emulate)
    link = std::make_unique<hil::LockStepLink>(emulator_command(scenario.emplace().path(), {}));
  else
    link = std::make_unique<hil::Port>(port, clock);
  hil::ConformSettings settings;
  settings.clear_trip = clear_trip;
  settings.coils_disconnected = coils_disconnected;
  settings.should_stop = [] { return interrupted(); };
  settings.say = [](const hil::ConformFinding& finding) {
    using Verdict = hil::ConformFinding::Verdict;
    std::string detail;
    for (const char c : finding.detail) detail += c == '\n' ? std::string("\n      ") : std::string(1, c);
    std::printf("%s  %s\n",
                finding.verdict == Verdict::good  ? "ok  "
                : finding.verdict == Verdict::bad ? "FAIL"
                                                  : "left",
                finding.what.c_str());
    if (!detail.empty()) std::printf("      %s\n", detail.c_str());
    std::fflush(stdout);
  };
  try {
    const hil::ConformResult result = hil::conform(*link, settings);
    std::printf("%d as the page says, %d not, %d left out\n", result.good, result.bad, result.left_out);
    if (result.stopped) {
      std::fprintf(stderr, result.brought_to_rest ? "stopped by request; the board says that it is disarmed\n"
                                                  : "stopped by request; the board did not confirm that it is disarmed\n");
      return interrupted_exit_code;
    }
    return result.bad > 0 || result.good == 0 ? 1 : 0;
  } catch (const hil::LinkLost& lost) {
    std::fprintf(stderr, "the link was lost: %s\n", lost.what());
    return 1;
  }
}

}  // namespace

void add_conform(CLI::App& program, int& exit_code) {
  auto port = std::make_shared<std::string>();
  auto emulate = std::make_shared<bool>(false), clear_trip = std::make_shared<bool>(false),
       coils_disconnected = std::make_shared<bool>(false);
  CLI::App* command =
      program.add_subcommand("conform", "Ask a board whether it does what docs/protocol.md says: messages, refusals, states, times.");
  command->add_option("--port", *port, "the board's serial port");
  command->add_flag("--emulate", *emulate, "this program's firmware in the emulator, in lock step");
  command->add_flag("--clear-trip", *clear_trip, "clear the trip that it is found with; arming is left out otherwise");
  command->add_flag("--coils-disconnected", *coils_disconnected, "try a command of too much duty too: a board that is wrong would heat");
  command->footer("Examples:\n  sinew conform --port /dev/serial/by-id/usb-... --coils-disconnected\n  sinew conform --emulate");
  command->callback([port, emulate, clear_trip, coils_disconnected, &exit_code] {
    exit_code = conform_command(*port, *emulate, *clear_trip, *coils_disconnected);
  });
}

}  // namespace sinew::apps

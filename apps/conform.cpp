// SPDX-License-Identifier: Apache-2.0
// sinew conform: whether somebody else's board does what docs/protocol.md says. Nothing is heated.
#include "hil/conform.h"

#include <unistd.h>

#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <memory>
#include <optional>

#include "apps/app.h"
#include "apps/limb_link.h"
#include "hil/lock_step_link.h"
#include "hil/port.h"
#include "sim/input_error.h"
#include "sim/text.h"

namespace sinew::apps {
namespace {

// A scenario for the emulator: a limb at rest.
class ScenarioFile {
 public:
  ScenarioFile() {
    std::string name = std::filesystem::temp_directory_path() / "sinew_conform_XXXXXX";
    const int file = ::mkstemp(name.data());
    if (file < 0) throw std::runtime_error(name + ": cannot be made");
    ::close(file);
    path_ = name;
    sim::write_file_whole(
        path_, "format: 1\nseed: 1\nduration_s: 60.0\ninput: { duty_A: { step: { height_fraction: 0.0, from_s: 1.0, until_s: 2.0 } } }\n");
  }
  ~ScenarioFile() { std::filesystem::remove(path_); }
  ScenarioFile(const ScenarioFile&) = delete;
  ScenarioFile& operator=(const ScenarioFile&) = delete;
  const std::filesystem::path& path() const { return path_; }

 private:
  std::filesystem::path path_;
};

int conform_command(const std::string& port, bool emulate, bool clear_trip, bool coils_disconnected) {
  if (emulate == !port.empty())
    throw sim::InputError({.key = "--port, --emulate", .advice = "one of the two: a board at a port, or the firmware in the emulator"});
  const hil::MonotonicClock clock;
  std::optional<ScenarioFile> scenario;
  std::unique_ptr<hil::Link> link;
  if (emulate)
    link = std::make_unique<hil::LockStepLink>(emulator_command(scenario.emplace().path(), {}));
  else
    link = std::make_unique<hil::Port>(port, clock);
  hil::ConformSettings settings;
  settings.clear_trip = clear_trip;
  settings.coils_disconnected = coils_disconnected;
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

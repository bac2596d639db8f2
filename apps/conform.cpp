// SPDX-License-Identifier: Apache-2.0
// sinew conform: whether somebody else's board does what docs/protocol.md says. Nothing is heated.
#include "hil/conform.h"

#include <cstdio>
#include <memory>

#include "apps/app.h"
#include "hil/port.h"
#include "sim/input_error.h"

namespace sinew::apps {
namespace {

int conform_command(const std::string& port, bool clear_trip, bool coils_disconnected) {
  const hil::MonotonicClock clock;
  hil::Port link(port, clock);
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
    const hil::ConformResult result = hil::conform(link, settings);
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
  auto clear_trip = std::make_shared<bool>(false), coils_disconnected = std::make_shared<bool>(false);
  CLI::App* command =
      program.add_subcommand("conform", "Ask a board whether it does what docs/protocol.md says: messages, refusals, states, times.");
  command->add_option("--port", *port, "the board's serial port")->required();
  command->add_flag("--clear-trip", *clear_trip, "clear the trip that it is found with; arming is left out otherwise");
  command->add_flag("--coils-disconnected", *coils_disconnected, "try a command of too much duty too: a board that is wrong would heat");
  command->footer("Example:\n  sinew conform --port /dev/serial/by-id/usb-...");
  command->callback(
      [port, clear_trip, coils_disconnected, &exit_code] { exit_code = conform_command(*port, *clear_trip, *coils_disconnected); });
}

}  // namespace sinew::apps

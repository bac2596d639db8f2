// SPDX-License-Identifier: GPL-3.0-or-later
// sinew-emulator: the real firmware on an emulated board with the simulated limb behind its pins.
//
// GPL, because simavr is: a program of its own, which `sinew` starts and talks to over pipes or a pseudo-terminal.
#include <fcntl.h>
#include <poll.h>
#include <pty.h>
#include <termios.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <cerrno>
#include <chrono>
#include <cmath>
#include <csignal>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <thread>

#include "emulator/board.h"
#include "emulator/limb.h"
#include "sim/input_error.h"
#include "sim/text.h"

namespace {

using namespace sinew;
using namespace sinew::emulator;

volatile std::sig_atomic_t stop = 0;

struct Arguments {
  std::string scenario, firmware, trace, link, goes_on_from, leaves;
  std::vector<std::string> faults;
  std::int64_t seed = -1;
  Concealed concealed;
  double pause_s = 60.0;
  bool lock_step = false, relay = false, dividers = false, new_board = false, measure = false;
};

// Board and limb in time together.
class Emulation {
 public:
  Emulation(const Arguments& arguments, const sim::Scenario& scenario, const std::vector<Fault>& faults)
      : limb_(scenario, faults, !arguments.trace.empty(), body_of(arguments, scenario)),
        board_(arguments.firmware, limb_, arguments.new_board, arguments.dividers),
        faults_(faults),
        relay_(arguments.relay) {}

  void run(std::int64_t until_us, bool stop_at_frame_end) {
    while (board_.now_us() < until_us) {
      for (Fault& fault : faults_)
        if (fault.from_us <= board_.now_us()) strike(fault);
      std::int64_t next_us = std::min(until_us, limb_.next_us());
      for (const Fault& fault : faults_)
        if (fault.from_us > board_.now_us()) next_us = std::min(next_us, fault.from_us);
      if (cut_in_storing_) next_us = std::min(next_us, board_.now_us() + 50);
      board_.run(next_us, stop_at_frame_end);
      if (cut_in_storing_ && board_.writing_since_us() >= cut_in_storing_->from_us) {
        cut_in_storing_->begun_us = cut_in_storing_->begun_us.value_or(board_.writing_since_us());
        if (board_.now_us() >= *cut_in_storing_->begun_us + cut_in_storing_->after_us) {
          board_.reset(Reset::power_on);
          cut_in_storing_.reset();
        }
      }
      if (relay_) limb_.relay(board_.now_us(), board_.relay());
      if (board_.now_us() >= limb_.next_us()) limb_.advance(board_.now_us());
      if (stop_at_frame_end && board_.something_sent()) break;
    }
  }
  Board& board() { return board_; }
  Limb& limb() { return limb_; }

 private:
  static std::unique_ptr<Body> body_of(const Arguments& arguments, const sim::Scenario& scenario) {
    std::optional<Left> before;
    if (!arguments.goes_on_from.empty()) before = read_left(arguments.goes_on_from);
    return arguments.concealed.kind.empty() ? plant_body(scenario, before) : concealed_body(arguments.concealed, scenario, before);
  }
  // What happens to the processor happens once; what lasts is the limb's business.
  void strike(Fault& fault) {
    switch (fault.kind) {
      case FaultKind::hang:
        board_.hang(true);
        break;
      case FaultKind::hang_masked:
        board_.hang(false);
        break;
      case FaultKind::brown_out:
        board_.reset(Reset::brown_out);
        break;
      case FaultKind::reset:
        board_.reset(Reset::external);
        break;
      case FaultKind::power_cycle:
        board_.reset(Reset::power_on);
        break;
      case FaultKind::power_cut_in_storing:
        cut_in_storing_ = CutInStoring{fault.from_us, std::llround(fault.value), std::nullopt};
        break;
      case FaultKind::fuse_high:
        board_.set_fuse(Fuse::high, static_cast<std::uint8_t>(fault.value));
        break;
      case FaultKind::fuse_extended:
        board_.set_fuse(Fuse::extended, static_cast<std::uint8_t>(fault.value));
        break;
      case FaultKind::time_ms:
        board_.set_time_ms(static_cast<std::uint32_t>(fault.value));
        break;
      default:
        break;
    }
    fault.from_us = std::numeric_limits<std::int64_t>::max();
  }
  Limb limb_;
  Board board_;
  std::vector<Fault> faults_;
  bool relay_;
  struct CutInStoring {
    std::int64_t from_us, after_us;
    std::optional<std::int64_t> begun_us;  // the write that is cut, or the one after it
  };
  std::optional<CutInStoring> cut_in_storing_;
};

bool read_all(int descriptor, void* to, std::size_t count) {
  for (auto* at = static_cast<char*>(to); count > 0;) {
    const ssize_t got = ::read(descriptor, at, count);
    if (got < 0 && errno == EINTR && !stop) continue;
    if (got <= 0) return false;
    at += got;
    count -= static_cast<std::size_t>(got);
  }
  return true;
}
bool write_all(int descriptor, const void* from, std::size_t count) {
  for (auto* at = static_cast<const char*>(from); count > 0;) {
    const ssize_t put = ::write(descriptor, at, count);
    if (put < 0 && errno == EINTR && !stop) continue;
    if (put <= 0) return false;
    at += put;
    count -= static_cast<std::size_t>(put);
  }
  return true;
}

// Asked: until when (u64 us), how many bytes (u32), bytes to the device. Answered: what time it is, how many, bytes from the
// device. It stops early where the device ends a frame. Until the other side closes the pipe.
void lock_step(Emulation& emulation) {
  std::vector<std::uint8_t> bytes;
  for (;;) {
    std::uint64_t until_us;
    std::uint32_t count;
    if (!read_all(STDIN_FILENO, &until_us, 8) || !read_all(STDIN_FILENO, &count, 4)) return;
    bytes.resize(count);
    if (!read_all(STDIN_FILENO, bytes.data(), count)) return;
    emulation.board().send(bytes);
    emulation.run(static_cast<std::int64_t>(until_us), true);
    const std::vector<std::uint8_t> sent = emulation.board().take_sent();
    std::string answer;
    const auto now_us = static_cast<std::uint64_t>(emulation.board().now_us());
    count = static_cast<std::uint32_t>(sent.size());
    answer.append(reinterpret_cast<const char*>(&now_us), 8).append(reinterpret_cast<const char*>(&count), 4);
    answer.append(sent.begin(), sent.end());
    if (!write_all(STDOUT_FILENO, answer.data(), answer.size())) return;
  }
}

// In real time on a pseudo-terminal. This end keeps the other one open too, so that a host may come and go.
void real_time(Emulation& emulation, const std::string& link) {
  int ours = -1, theirs = -1;
  std::array<char, 256> name{};
  termios raw{};
  cfmakeraw(&raw);
  if (openpty(&ours, &theirs, name.data(), &raw, nullptr) != 0) throw std::runtime_error(std::string("openpty: ") + std::strerror(errno));
  ::fcntl(ours, F_SETFL, O_NONBLOCK);
  if (!link.empty()) {
    // A link of one before, which was killed, goes; what anybody wrote stays.
    if (std::filesystem::is_symlink(link)) std::filesystem::remove(link);
    std::error_code error;
    std::filesystem::create_symlink(name.data(), link, error);
    if (error) throw sim::InputError({.key = "--link", .value = link, .advice = "cannot be made: " + error.message()});
  }
  std::printf("%s\n", link.empty() ? name.data() : link.c_str());
  std::fflush(stdout);
  using Clock = std::chrono::steady_clock;
  const auto began = Clock::now();
  constexpr std::int64_t slice_us = 1000;
  for (std::int64_t slice = 1; !stop; ++slice) {
    std::array<std::uint8_t, 4096> buffer;
    if (const ssize_t got = ::read(ours, buffer.data(), buffer.size()); got > 0)
      emulation.board().send({buffer.begin(), buffer.begin() + got});
    emulation.run(slice * slice_us, false);
    if (const auto sent = emulation.board().take_sent(); !sent.empty()) [[maybe_unused]]
      const ssize_t put = ::write(ours, sent.data(), sent.size());  // nobody listens: lost, as on a wire
    std::this_thread::sleep_until(began + std::chrono::microseconds(slice * slice_us));
  }
  if (!link.empty()) std::filesystem::remove(link);
  ::close(theirs);
  ::close(ours);
}

// On standard error: in lock step the other is the wire.
void print(const Usage& usage) {
  const int left = usage.ram_bytes - usage.static_bytes - usage.stack_most_bytes;
  std::fprintf(stderr, "stack: at most %d bytes; with %d of variables that leaves %d of %d\n", usage.stack_most_bytes, usage.static_bytes,
               left, usage.ram_bytes);
  for (const Usage::Interrupt& one : usage.interrupts) {
    std::fprintf(stderr, "interrupt, %s: at most %.1f us", one.name, one.longest_us);
    if (one.longest_wait_us > 0.0) std::fprintf(stderr, ", after a wait of at most %.1f us", one.longest_wait_us);
    std::fprintf(stderr, "; %lld times\n", static_cast<long long>(one.count));
  }
  std::fprintf(stderr, "main loop: away for at most %d ms\n", usage.most_ms_since_round);
}

int emulate(const Arguments& arguments) {
  sim::Scenario scenario = sim::read_scenario(arguments.scenario);
  if (arguments.seed >= 0) scenario.seed = arguments.seed;
  std::vector<std::string> coils;
  for (const plant::InputInfo& input : scenario.plant.system().inputs()) coils.push_back(input.name);
  std::vector<Fault> faults;
  for (const std::string& text : arguments.faults) faults.push_back(parse_fault(text, coils));
  Emulation emulation(arguments, scenario, faults);
  if (arguments.lock_step)
    lock_step(emulation);
  else
    real_time(emulation, arguments.link);
  if (arguments.measure) print(emulation.board().usage());
  if (!arguments.trace.empty()) sim::write_file_whole(arguments.trace, emulation.limb().trace_csv());
  if (!arguments.leaves.empty())
    sim::write_file_whole(arguments.leaves, to_text(emulation.limb().left_after(emulation.board().now_us(), arguments.pause_s)));
  return 0;
}

void note_signal(int) { stop = 1; }

}  // namespace

int main(int argc, char** argv) {
  CLI::App program{"Runs the board's firmware in simavr, with the simulated limb behind its pins."};
  Arguments arguments;
  program.add_option("scenario", arguments.scenario, "scenario in YAML: plant, start, sensors and seed are used")->required();
  program.add_option("--firmware", arguments.firmware, "the firmware's .elf")->required();
  program.add_option("--fault", arguments.faults, fault_help());
  program.add_option("--seed", arguments.seed, "instead of the scenario's own")->check(CLI::NonNegativeNumber);
  program.add_option("--concealed", arguments.concealed.kind,
                     "a limb of the generator of `sinew prove` behind the pins, instead of the scenario's plant");
  program.add_option("--concealed-seed", arguments.concealed.seed, "which one of that kind")->check(CLI::NonNegativeNumber);
  program.add_option("--concealed-strength", arguments.concealed.strength, "of what it conceals; 1: as usual")
      ->check(CLI::Range(0.05, 4.0));
  program.add_option("--concealed-recording", arguments.concealed.recording, "chooses how the air moves")->check(CLI::NonNegativeNumber);
  program.add_option("--goes-on-from", arguments.goes_on_from, "the limb as an earlier session left it (--leaves)");
  program.add_option("--leaves", arguments.leaves, "file for the limb as it is left, from which another session can go on");
  program.add_option("--pause", arguments.pause_s, "seconds without duty after this session, of the limb that is left")
      ->check(CLI::Range(0.0, 1e5))
      ->capture_default_str();
  program.add_option("--trace", arguments.trace, "file for gates and coil temperatures");
  program.add_option("--link", arguments.link, "name for the pseudo-terminal: a symbolic link");
  program.add_flag("--lock-step", arguments.lock_step, "time goes on as asked over standard input and output");
  program.add_flag("--new-board", arguments.new_board, "its EEPROM was never written");
  program.add_flag("--measure", arguments.measure, "at the end, on standard error: stack, interrupts and main loop of the program");
  program.add_flag("--relay", arguments.relay, "a relay behind a charge pump on PD7 sits in the coils' supply");
  program.add_flag("--dividers", arguments.dividers, "dividers show the board the drains of its switches");
  program.footer("Example:\n  sinew-emulator scenarios/babble_bidirectional.yaml --firmware build/release/firmware.elf --link /tmp/limb");
  struct sigaction action {};
  action.sa_handler = note_signal;  // without SA_RESTART: a read ends
  sigaction(SIGINT, &action, nullptr);
  sigaction(SIGTERM, &action, nullptr);
  std::signal(SIGPIPE, SIG_IGN);
  try {
    program.parse(argc, argv);
    return emulate(arguments);
  } catch (const CLI::ParseError& e) {
    return program.exit(e) == 0 ? 0 : 2;
  } catch (const sim::InputError& e) {
    std::fprintf(stderr, "%s\n", e.what());
    return 2;
  } catch (const std::exception& e) {
    std::fprintf(stderr, "sinew-emulator: %s\n", e.what());
    return 1;
  }
}

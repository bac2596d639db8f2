// SPDX-License-Identifier: Apache-2.0
#include "apps/app.h"

#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <charconv>
#include <chrono>
#include <cmath>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <new>

#include "apps/terminal.h"
#include "diagnose/calibrate.h"
#include "model/train.h"
#include "plant/contains.h"
#include "sim/input_error.h"
#include "sim/plain_text.h"

namespace sinew::apps {
namespace {

volatile std::sig_atomic_t signals_seen = 0;

void note_signal(int number) {
  signals_seen = signals_seen + 1;
  if (signals_seen > 1) {
    std::signal(number, SIG_DFL);
    std::raise(number);
  }
}

double seconds_now() { return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count(); }

}  // namespace

bool may_move_cursor() {
  const char *kind = std::getenv("TERM"), *plain = std::getenv("NO_COLOR");
  return isatty(STDERR_FILENO) == 1 && kind != nullptr && std::string_view(kind) != "dumb" && (plain == nullptr || *plain == '\0');
}

void check_folder(const std::filesystem::path& out) {
  std::filesystem::path there = std::filesystem::absolute(out);
  while (!std::filesystem::exists(there) && there.has_parent_path() && there.parent_path() != there) there = there.parent_path();
  const auto refuse = [&](const std::string& advice) {
    throw sim::InputError({.file = "", .key = "--out", .value = out.string(), .advice = advice});
  };
  if (!std::filesystem::is_directory(there))
    refuse((there == std::filesystem::absolute(out) ? "" : there.string() + " ") + "is a file; a folder is needed");
  // Whether it can be written to is found by writing: what the right to do so says does not hold for /proc, or for root.
  std::string probe = (there / ".sinew-XXXXXX").string();
  const int descriptor = mkstemp(probe.data());
  if (descriptor < 0) refuse("nothing can be written in " + there.string() + ": " + std::strerror(errno));
  close(descriptor);
  unlink(probe.c_str());
}

bool interrupted() { return signals_seen > 0; }

int say_what_was_thrown() {
  constexpr const char* stopped_words = "stopped; nothing was written\n";
  try {
    throw;
  } catch (const diagnose::Stopped&) {
    std::fputs(stopped_words, stderr);
    return interrupted_exit_code;
  } catch (const model::Stopped&) {
    std::fputs(stopped_words, stderr);
    return interrupted_exit_code;
  } catch (const sim::InputError& e) {
    std::fprintf(stderr, "%s\n", e.what());
    return 2;
  } catch (const std::filesystem::filesystem_error& e) {  // a path that cannot be followed
    std::fprintf(stderr, "%s: %s\n", sim::printable(e.path1().string()).c_str(), e.code().message().c_str());
    return 2;
  } catch (const std::bad_alloc&) {
    std::fputs("sinew: out of memory; nothing was written\n", stderr);
    return 2;
  } catch (const std::exception& e) {
    std::fprintf(stderr, "sinew: %s\n", e.what());
    return 1;
  } catch (...) {
    std::fputs("sinew: stopped by an error without words\n", stderr);
    return 1;
  }
}

void watch_for_interrupts() {
  std::signal(SIGINT, note_signal);
  std::signal(SIGTERM, note_signal);
  if (std::signal(SIGHUP, note_signal) == SIG_IGN) std::signal(SIGHUP, SIG_IGN);  // as `nohup` wants it
}

namespace {

CLI::Validator number_that(bool (*is_right)(double), const char* words) {
  return CLI::Validator(
      [=](const std::string& text) {
        double value = 0.0;
        return CLI::detail::lexical_cast(text, value) && is_right(value) ? std::string() : text + " is not " + words;
      },
      "");
}

}  // namespace

void add_rules_for_all(CLI::App& program) {
  const CLI::Validator not_empty([](std::string& text) { return text.empty() ? std::string("must not be empty") : std::string(); }, "");
  const CLI::Validator seed(
      [](std::string& text) {
        std::int64_t value = 0;
        const auto read = std::from_chars(text.data(), text.data() + text.size(), value);
        const bool whole = read.ec == std::errc{} && read.ptr == text.data() + text.size() && value >= 0;
        return whole ? std::string() : text + " is not a whole number from 0 to 9223372036854775807";
      },
      "");
  // What is given is written down: in YAML, in JSON, in comments. A file of another name must be renamed first.
  const CLI::Validator plain(
      [](std::string& text) {
        return sim::is_plain_text(text)
                   ? std::string()
                   : sim::printable(text, 200) + " is not UTF-8 without control characters; give the file a name that is";
      },
      "");
  for (CLI::App* command : program.get_subcommands([](CLI::App*) { return true; }))
    for (CLI::Option* option : command->get_options()) {
      if (option->get_items_expected_max() == 0) continue;
      option->check(not_empty);
      option->check(plain);
      if (option->get_type_name().starts_with("FLOAT"))
        option->check(number_that([](double value) { return std::isfinite(value); }, "a finite number"));
      for (const std::string& name : option->get_lnames())
        if (name.ends_with("seed")) option->check(seed);
    }
}

std::string command_meant(const CLI::App& program, int argc, const char* const* argv) {
  if (argc < 2) return "";
  const std::string given = argv[1];
  std::vector<std::string> names;
  for (const CLI::App* command : program.get_subcommands([](const CLI::App*) { return true; })) names.push_back(command->get_name());
  if (given.starts_with("-") || contains(names, given)) return "";
  const std::string near = given == "help" || given == "version" ? "--" + given : sim::nearest(given, names);
  return sim::printable(given) + " is no command; " + (near.empty() ? "`sinew --help` lists them" : "did you mean " + near + "?");
}

CLI::Validator positive_number() {
  return number_that([](double value) { return std::isfinite(value) && value > 0.0; }, "a positive number");
}

Progress::Progress(std::string what) : what_(std::move(what)), on_(may_move_cursor()), began_s_(seconds_now()) {}

Progress::~Progress() {
  if (shown_) std::fputs("\r\033[K", stderr);
}

void Progress::show(double done_share, const std::string& detail) {
  if (!on_) return;
  done_share = shown_share_ = std::max(done_share, shown_share_);
  const double spent_s = seconds_now() - began_s_;
  const double left_s = done_share > 0.0 ? spent_s * (1.0 - done_share) / done_share : 0.0;
  std::fprintf(stderr, "\r\033[K%s: %3.0f %%, about %.0f s left  %s", what_.c_str(), 100.0 * done_share, left_s, detail.c_str());
  std::fflush(stderr);
  shown_ = true;
}

}  // namespace sinew::apps

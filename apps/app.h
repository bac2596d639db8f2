// SPDX-License-Identifier: Apache-2.0
// What every subcommand of `sinew` shares: how it is registered, and how it speaks to the terminal.
#pragma once

#include <CLI/CLI.hpp>
#include <filesystem>
#include <string>

namespace sinew::apps {

// Each adds one subcommand; its callback returns by throwing or by setting `exit_code`.
void add_run(CLI::App& program, int& exit_code);
void add_calibrate(CLI::App& program, int& exit_code);
void add_diagnose(CLI::App& program, int& exit_code);
void add_compare(CLI::App& program, int& exit_code);
void add_effects(CLI::App& program, int& exit_code);
void add_convert(CLI::App& program, int& exit_code);
void add_export_fmu(CLI::App& program, int& exit_code);
void add_prove(CLI::App& program, int& exit_code);
void add_dataset(CLI::App& program, int& exit_code);
void add_train(CLI::App& program, int& exit_code);
void add_rollout(CLI::App& program, int& exit_code);
void add_evaluate(CLI::App& program, int& exit_code);
void add_paper_table(CLI::App& program, int& exit_code);
void add_hil(CLI::App& program, int& exit_code);
void add_replay(CLI::App& program, int& exit_code);
void add_hil_faults(CLI::App& program, int& exit_code);
void add_hil_false_trips(CLI::App& program, int& exit_code);
void add_investigate(CLI::App& program, int& exit_code);
void add_doctor(CLI::App& program, int& exit_code);
void add_conform(CLI::App& program, int& exit_code);
void add_schema(CLI::App& program, int& exit_code);
void add_completion(CLI::App& program, int& exit_code);
void add_man(CLI::App& program, int& exit_code);

// Throws InputError where `out` is not a folder and cannot become one, so that this is known before the work, not after.
void check_folder(const std::filesystem::path& out);

// Rules that hold for every command, put upon all that have been added: no option is given an empty value, or one that is not UTF-8 without
// control characters, a number is finite, and a seed is a whole number from 0 to 2^63 - 1, not one that is cut to fit.
void add_rules_for_all(CLI::App& program);
// "did you mean diagnose?" where the first argument is nearly a command; empty otherwise.
std::string command_meant(const CLI::App& program, int argc, const char* const* argv);

// What an option may be: finite, and above zero.
CLI::Validator positive_number();

// A line on standard error that overwrites itself, only where that is a terminal: what is done, share, time left.
class Progress {
 public:
  explicit Progress(std::string what);
  ~Progress();
  void show(double done_share, const std::string& detail = "");

 private:
  std::string what_;
  bool on_;
  double began_s_;
  double shown_share_ = 0.0;  // never less than before: threads may tell of what they did out of order
  bool shown_ = false;
};

// True once Ctrl-C or SIGTERM has come. A second one ends the program at once.
bool interrupted();
void watch_for_interrupts();
inline constexpr int interrupted_exit_code = 130;

// Within a handler: says on standard error what was thrown; the exit code.
int say_what_was_thrown();

}  // namespace sinew::apps

// SPDX-License-Identifier: Apache-2.0
#include <glog/logging.h>
#include <poll.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <cstring>
#include <iostream>
#include <sstream>

#include "apps/app.h"
#include "sim/input_error.h"
#include "sim/manifest.h"

namespace {

// Whether standard output is a pipe from which nobody reads any more, as of `sinew effects | head`.
bool nobody_reads() {
  pollfd out{STDOUT_FILENO, POLLOUT, 0};
  return poll(&out, 1, 0) == 1 && (out.revents & POLLERR) != 0;
}

// What was printed must have arrived: a full disk behind `> file` is told of when the last of it is written. That whoever read along has
// gone away is no failure.
int written(int exit_code) {
  std::cout.flush();
  if ((std::fflush(stdout) == 0 && std::ferror(stdout) == 0 && std::cout.good()) || nobody_reads()) return exit_code;
  std::fprintf(stderr, "standard output: %s\n", errno != 0 ? std::strerror(errno) : "could not be written");
  return 2;
}

}  // namespace

int main(int argc, char** argv) {
  using namespace sinew;
  CLI::App program{"Simulates soft limbs bent by shape memory alloy, and explains recordings of them."};
  program.set_version_flag("--version", "sinew " + sim::this_build().version + " (" + sim::this_build().commit + ")");
  program.require_subcommand(1);
  program.footer(
      "Examples:\n"
      "  sinew run scenarios/babble_bidirectional.yaml --out results/babble --seed 7\n"
      "  sinew calibrate recording.csv --plant plant/limbs/paper_limb.yaml --fit-until 120 --out results/mine\n"
      "  sinew diagnose --train recording.csv --plant plant/limbs/paper_limb.yaml --out results/diagnosis\n"
      "  sinew compare recording.csv --plant results/mine/plant.yaml\n"
      "  sinew train results/set --case 3 --out results/lstm3\n"
      "  sinew hil scenarios/babble_bidirectional.yaml --emulate\n"
      "  sinew investigate --plant plant/limbs/paper_limb_on_board.yaml --emulate --budget 30min --out results/asked\n"
      "  sinew effects");
  FLAGS_minloglevel = google::GLOG_FATAL;  // Ceres says its failures in its summary
  int exit_code = 0;
  apps::add_run(program, exit_code);
  apps::add_calibrate(program, exit_code);
  apps::add_diagnose(program, exit_code);
  apps::add_compare(program, exit_code);
  apps::add_effects(program, exit_code);
  apps::add_convert(program, exit_code);
  apps::add_export_fmu(program, exit_code);
  apps::add_prove(program, exit_code);
  apps::add_dataset(program, exit_code);
  apps::add_train(program, exit_code);
  apps::add_rollout(program, exit_code);
  apps::add_evaluate(program, exit_code);
  apps::add_paper_table(program, exit_code);
  apps::add_hil(program, exit_code);
  apps::add_replay(program, exit_code);
  apps::add_hil_faults(program, exit_code);
  apps::add_hil_false_trips(program, exit_code);
  apps::add_investigate(program, exit_code);
  apps::add_doctor(program, exit_code);
  apps::add_conform(program, exit_code);
  apps::add_schema(program, exit_code);
  apps::add_completion(program, exit_code);
  apps::add_man(program, exit_code);
  apps::add_rules_for_all(program);
  apps::watch_for_interrupts();
  try {
    program.parse(argc, argv);
  } catch (const CLI::ParseError& e) {
    if (const std::string meant = apps::command_meant(program, argc, argv); !meant.empty()) {
      std::fprintf(stderr, "%s\n", meant.c_str());
      return 2;
    }
    std::stringstream wrong;
    const int code = program.exit(e, std::cout, wrong);
    for (std::string line; std::getline(wrong, line);)  // may quote an argument, with whatever is in it
      std::fprintf(stderr, "%s\n", sim::printable(line, std::string::npos).c_str());
    return code == 0 ? written(0) : 2;
  } catch (...) {
    return apps::say_what_was_thrown();
  }
  return written(exit_code);
}

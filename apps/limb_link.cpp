// SPDX-License-Identifier: Apache-2.0
#include "apps/limb_link.h"

#include <fcntl.h>
#include <malloc.h>
#include <pthread.h>
#include <sys/mman.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <chrono>
#include <csignal>
#include <cstring>
#include <filesystem>
#include <stdexcept>

#include "apps/words.h"
#include "plant/contains.h"
#include "prove/generator.h"
#include "sim/input_error.h"

namespace sinew::apps {

std::string program_beside(const std::string& name, const std::string& advice) {
  // Beside the program, or where it is installed.
  const std::filesystem::path bin = std::filesystem::read_symlink("/proc/self/exe").parent_path();
  const std::filesystem::path installed = bin.parent_path() / "lib/sinew";
  for (const std::filesystem::path& folder : {bin, installed})
    if (std::filesystem::exists(folder / name)) return folder / name;
  throw sim::InputError({.file = (bin / name).string(), .advice = "is not there; " + advice});
}

std::vector<std::string> emulator_command(const std::string& scenario, const std::vector<std::string>& faults) {
  constexpr const char* advice = "it is built where gcc-avr, avr-libc and libsimavr-dev are installed";
  std::vector<std::string> command{program_beside("sinew-emulator", advice), scenario, "--firmware",
                                   program_beside("firmware.elf", advice)};
  for (const std::string& fault : faults) command.insert(command.end(), {"--fault", fault});
  return command;
}

void check_concealed_kind(const std::string& option, const std::string& name) {
  std::vector<std::string> all;
  for (const auto& kinds : {prove::kinds(), prove::unlike_kinds()})
    for (const prove::Kind& kind : kinds) all.push_back(kind.name);
  if (!contains(all, name))
    throw sim::InputError(
        {.key = option, .value = name, .advice = "no such kind" + sim::did_you_mean(name, all) + "\nthere are " + listed(all)});
}

double seconds_since_1970() {
  using namespace std::chrono;
  return static_cast<double>(duration_cast<milliseconds>(system_clock::now().time_since_epoch()).count()) / 1e3;
}

bool take_real_time_priority() {
  sched_param wanted{};
  wanted.sched_priority = real_time_priority;
  return pthread_setschedparam(pthread_self(), SCHED_FIFO, &wanted) == 0;
}

void give_priority_back() {
  const sched_param ordinary{};
  pthread_setschedparam(pthread_self(), SCHED_OTHER, &ordinary);
}

bool stay_in_memory() {
  // With a limit the lock would hold now, and an allocation fail later.
  rlimit most{};
  if (::geteuid() != 0 && (::getrlimit(RLIMIT_MEMLOCK, &most) != 0 || most.rlim_cur != RLIM_INFINITY)) return false;
  if (::mlockall(MCL_CURRENT | MCL_FUTURE) != 0) return false;
  // What is freed is kept, and large blocks too come from there: no system call while time matters.
  ::mallopt(M_TRIM_THRESHOLD, -1);
  ::mallopt(M_MMAP_MAX, 0);
  return true;
}

BoardProcess::BoardProcess() {
  const std::string program = program_beside("sinew-board", "it is built with the rest");
  std::array<int, 2> said{};
  if (::pipe2(said.data(), O_CLOEXEC) != 0) throw std::runtime_error(std::string("pipe: ") + std::strerror(errno));
  child_ = ::fork();
  if (child_ < 0) throw std::runtime_error(std::string("fork: ") + std::strerror(errno));
  if (child_ == 0) {
    ::setpgid(0, 0);
    ::prctl(PR_SET_PDEATHSIG, SIGTERM);  // not to outlive us, whatever ends us
    ::dup2(said[1], STDOUT_FILENO);
    ::execl(program.c_str(), program.c_str(), static_cast<char*>(nullptr));
    ::_exit(127);
  }
  ::close(said[1]);
  char letter = 0;
  while (::read(said[0], &letter, 1) == 1 && letter != '\n') port_ += letter;
  ::close(said[0]);
  if (letter != '\n') throw std::runtime_error(program + " ended at once");
}

BoardProcess::~BoardProcess() {
  ::kill(child_, SIGTERM);
  while (::waitpid(child_, nullptr, 0) < 0 && errno == EINTR) {
  }
}

}  // namespace sinew::apps

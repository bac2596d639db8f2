// SPDX-License-Identifier: Apache-2.0
#include "hil/lock_step_link.h"

#include <fcntl.h>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <utility>

#include "sim/input_error.h"

namespace sinew::hil {
namespace {

constexpr int refused_input = 2;  // exit code of the emulator, as of all our programs

bool write_all(int descriptor, const void* from, std::size_t count) {
  for (auto* at = static_cast<const char*>(from); count > 0;) {
    const ssize_t put = ::write(descriptor, at, count);
    if (put < 0 && errno == EINTR) continue;
    if (put <= 0) return false;
    at += put;
    count -= static_cast<std::size_t>(put);
  }
  return true;
}
bool read_all(int descriptor, void* to, std::size_t count) {
  for (auto* at = static_cast<char*>(to); count > 0;) {
    const ssize_t got = ::read(descriptor, at, count);
    if (got < 0 && errno == EINTR) continue;
    if (got <= 0) return false;
    at += got;
    count -= static_cast<std::size_t>(got);
  }
  return true;
}

}  // namespace

LockStepLink::LockStepLink(std::vector<std::string> command) {
  command.push_back("--lock-step");
  std::vector<char*> arguments;
  for (std::string& one : command) arguments.push_back(one.data());
  arguments.push_back(nullptr);
  std::array<int, 2> down{}, up{};
  if (::pipe2(down.data(), O_CLOEXEC) != 0 || ::pipe2(up.data(), O_CLOEXEC) != 0)
    throw std::runtime_error(std::string("pipe: ") + std::strerror(errno));
  child_ = ::fork();
  if (child_ < 0) throw std::runtime_error(std::string("fork: ") + std::strerror(errno));
  if (child_ == 0) {
    ::setpgid(0, 0);  // Ctrl-C is for the session, which then brings the limb to rest
    ::dup2(down[0], STDIN_FILENO);
    ::dup2(up[1], STDOUT_FILENO);
    ::execvp(arguments[0], arguments.data());
    ::_exit(127);
  }
  ::close(down[0]);
  ::close(up[1]);
  to_child_ = down[1];
  from_child_ = up[0];
  ::signal(SIGPIPE, SIG_IGN);
}

LockStepLink::~LockStepLink() { close(); }

void LockStepLink::close() {
  if (to_child_ >= 0) ::close(std::exchange(to_child_, -1));
  if (from_child_ >= 0) ::close(std::exchange(from_child_, -1));
  if (child_ > 0) {
    while (::waitpid(child_, &status_, 0) < 0 && errno == EINTR) {
    }
    child_ = -1;
  }
}

std::int64_t LockStepLink::send(std::span<const std::uint8_t> bytes) {
  waiting_.insert(waiting_.end(), bytes.begin(), bytes.end());
  return now_us_;
}

Received LockStepLink::receive_until(std::int64_t deadline_us) {
  const auto until = static_cast<std::uint64_t>(std::max(deadline_us, now_us_));
  auto count = static_cast<std::uint32_t>(waiting_.size());
  Bytes question(12 + waiting_.size());
  std::memcpy(question.data(), &until, 8);
  std::memcpy(question.data() + 8, &count, 4);
  std::copy(waiting_.begin(), waiting_.end(), question.begin() + 12);
  waiting_.clear();
  std::uint64_t now = 0;
  Bytes bytes;
  const bool answered = write_all(to_child_, question.data(), question.size()) && read_all(from_child_, &now, 8) &&
                        read_all(from_child_, &count, 4) && (bytes.resize(count), read_all(from_child_, bytes.data(), count));
  if (!answered) {
    close();
    if (!has_answered_ && WIFEXITED(status_) && WEXITSTATUS(status_) == refused_input)
      throw sim::InputError({.file = "", .key = "--emulate", .advice = "the emulator refuses what it is to do; it says why above"});
    throw LinkLost("the emulator ended");
  }
  has_answered_ = true;
  now_us_ = static_cast<std::int64_t>(now);
  return {now_us_, std::move(bytes)};
}

}  // namespace sinew::hil

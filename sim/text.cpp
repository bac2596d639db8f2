// SPDX-License-Identifier: Apache-2.0
#include "sim/text.h"

#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <charconv>
#include <cmath>
#include <cstring>
#include <limits>
#include <system_error>
#include <utility>

#include "sim/input_error.h"

namespace sinew::sim {
namespace {

[[noreturn]] void fail(const std::filesystem::path& path, std::string_view what, int error_number) {
  throw InputError({.file = path.string(), .key = std::string(what), .advice = std::strerror(error_number)});
}

class Descriptor {
 public:
  Descriptor(const std::filesystem::path& path, int flags, mode_t mode = 0) : number_(::open(path.c_str(), flags | O_CLOEXEC, mode)) {}
  Descriptor(Descriptor&& other) noexcept : number_(std::exchange(other.number_, -1)) {}
  Descriptor(const Descriptor&) = delete;
  Descriptor& operator=(const Descriptor&) = delete;
  ~Descriptor() {
    if (number_ >= 0) ::close(number_);
  }

  bool open() const { return number_ >= 0; }
  int number() const { return number_; }
  bool close() { return ::close(std::exchange(number_, -1)) == 0; }

 private:
  int number_;
};

bool write_all(int descriptor, std::string_view content) {
  while (!content.empty()) {
    const ssize_t written = ::write(descriptor, content.data(), content.size());
    if (written >= 0) {
      content.remove_prefix(static_cast<std::size_t>(written));
    } else if (errno != EINTR) {
      return false;
    }
  }
  return true;
}

constexpr std::string_view half_written_begin = ".", half_written_end = ".sinew.partial";

// Empty, locked against other processes, and a file of its own: neither a link nor another name of one. `path` is for messages.
Descriptor open_half_written(const std::filesystem::path& partial, const std::filesystem::path& path) {
  for (;;) {
    Descriptor file(partial, O_WRONLY | O_CREAT | O_NOFOLLOW, 0666);
    if (!file.open() && errno == ELOOP && ::unlink(partial.c_str()) == 0) continue;
    if (!file.open()) fail(path, "cannot write", errno);
    if (::flock(file.number(), LOCK_EX | LOCK_NB) != 0 && errno == EWOULDBLOCK)  // a file system without locks has no such refusal
      throw InputError({.file = path.string(), .key = "cannot write", .advice = "another command is writing this file"});
    struct stat ours {
    }, there{};
    if (::fstat(file.number(), &ours) != 0) fail(path, "cannot write", errno);
    if (::lstat(partial.c_str(), &there) != 0 || there.st_dev != ours.st_dev || there.st_ino != ours.st_ino) continue;  // moved meanwhile
    if (ours.st_nlink > 1) {
      if (::unlink(partial.c_str()) != 0) fail(path, "cannot write", errno);
      continue;
    }
    if (::ftruncate(file.number(), 0) != 0) fail(path, "cannot write", errno);
    return file;
  }
}

bool is_nan_word(std::string_view word) {
  return word.size() == 3 && (word[0] == 'n' || word[0] == 'N') && (word[1] == 'a' || word[1] == 'A') && (word[2] == 'n' || word[2] == 'N');
}

}  // namespace

std::string shortest(double value) {
  std::string text;
  append_shortest(text, value);
  return text;
}

void append_shortest(std::string& text, double value) {
  if (std::isnan(value)) {
    text += "nan";
    return;
  }
  std::array<char, 32> digits;  // the longest is of 24 characters: -2.2250738585072014e-308
  const auto result = std::to_chars(digits.data(), digits.data() + digits.size(), value);
  text.append(digits.data(), result.ptr);
}

std::string_view trimmed(std::string_view text) {
  const auto is_space = [](char c) { return c == ' ' || c == '\t'; };
  while (!text.empty() && is_space(text.front())) text.remove_prefix(1);
  while (!text.empty() && is_space(text.back())) text.remove_suffix(1);
  return text;
}

std::string lower_case(std::string_view text) {
  std::string lower(text);
  for (char& c : lower) {
    if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
  }
  return lower;
}

std::optional<double> parse_number(std::string_view token) {
  token = trimmed(token);
  std::string_view digits = token;
  if (!digits.empty() && (digits.front() == '+' || digits.front() == '-')) digits.remove_prefix(1);
  if (digits.empty()) return std::nullopt;
  if (is_nan_word(digits)) return std::numeric_limits<double>::quiet_NaN();
  // from_chars reads words too ("inf", "nan(1)") and would take a second sign.
  const bool starts_a_number = digits.front() == '.' || (digits.front() >= '0' && digits.front() <= '9');
  if (!starts_a_number) return std::nullopt;
  if (token.front() == '+') token.remove_prefix(1);
  double value = 0.0;
  const auto [end, error] = std::from_chars(token.data(), token.data() + token.size(), value);
  if (error != std::errc() || end != token.data() + token.size()) return std::nullopt;
  return value;
}

std::string read_file(const std::filesystem::path& path) {
  constexpr std::size_t least_room = 1 << 16, most_bytes = std::size_t{1} << 30;
  const auto too_large = [&] {
    throw InputError({.file = path.string(), .key = "size", .advice = "is larger than 1 GiB; cut it into parts"});
  };
  const Descriptor file(path, O_RDONLY);
  if (!file.open()) fail(path, "cannot read", errno);
  struct stat facts {};
  std::string content;
  // One byte more than the size, so that the end of the file is met without growing.
  if (::fstat(file.number(), &facts) == 0 && facts.st_size > 0) {
    if (static_cast<std::size_t>(facts.st_size) > most_bytes) too_large();
    content.resize(static_cast<std::size_t>(facts.st_size) + 1);
  }
  for (std::size_t length = 0;;) {
    if (length == content.size()) content.resize(std::clamp(2 * length, least_room, most_bytes + 1));
    const ssize_t got = ::read(file.number(), content.data() + length, content.size() - length);
    if (got < 0 && errno == EINTR) continue;
    if (got < 0) fail(path, "cannot read", errno);
    length += static_cast<std::size_t>(got);
    if (length > most_bytes) too_large();
    if (got == 0) {
      content.resize(length);
      return content;
    }
  }
}

void write_file_whole(const std::filesystem::path& path, std::string_view content) {
  namespace fs = std::filesystem;
  std::error_code ignored;
  const fs::file_status status = fs::status(path, ignored);
  if (fs::exists(status) && !fs::is_regular_file(status)) {
    Descriptor file(path, O_WRONLY);
    if (!file.open() || !write_all(file.number(), content) || !file.close()) fail(path, "cannot write", errno);
    return;
  }
  const fs::path target = fs::exists(status) ? fs::canonical(path) : path;
  const fs::path partial = half_written(target);
  Descriptor file = open_half_written(partial, path);
  const bool written =
      write_all(file.number(), content) && ::fsync(file.number()) == 0 && ::rename(partial.c_str(), target.c_str()) == 0 && file.close();
  if (!written) {
    const int reason = errno;
    ::unlink(partial.c_str());
    fail(path, "cannot write", reason);
  }
}

std::filesystem::path half_written(const std::filesystem::path& path) {
  return path.parent_path() / (std::string(half_written_begin) + path.filename().string() + std::string(half_written_end));
}

bool is_half_written(const std::filesystem::path& path) {
  const std::string name = path.filename().string();
  return name.size() > half_written_begin.size() + half_written_end.size() && name.starts_with(half_written_begin) &&
         name.ends_with(half_written_end);
}

}  // namespace sinew::sim

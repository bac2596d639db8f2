// SPDX-License-Identifier: Apache-2.0
#include "sim/text.h"

#include <doctest/doctest.h>
#include <fcntl.h>
#include <sys/file.h>
#include <unistd.h>

#include <bit>
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <filesystem>
#include <iterator>
#include <limits>
#include <random>
#include <string>
#include <vector>

#include "sim/input_error.h"

namespace sim_text_test {

namespace fs = std::filesystem;
using namespace sinew::sim;

namespace {

// A folder of its own, removed at the end.
class Folder {
 public:
  Folder() {
    std::string name = (fs::temp_directory_path() / "sinew_text_test_XXXXXX").string();
    REQUIRE(mkdtemp(name.data()) != nullptr);
    path = name;
  }
  Folder(const Folder&) = delete;
  Folder& operator=(const Folder&) = delete;
  ~Folder() { fs::remove_all(path); }

  std::size_t entries() const { return static_cast<std::size_t>(std::distance(fs::directory_iterator(path), fs::directory_iterator())); }

  fs::path path;
};

template <class Call>
std::string message_of(Call&& call) {
  try {
    call();
  } catch (const InputError& error) {
    return error.what();
  }
  return "nothing was thrown";
}

}  // namespace

TEST_CASE("shortest: the shortest decimal form, worked by hand") {
  CHECK(shortest(0.1) == "0.1");
  CHECK(shortest(0.1 + 0.2) == "0.30000000000000004");
  CHECK(shortest(60.0) == "60");
  CHECK(shortest(-37.28125) == "-37.28125");
  CHECK(shortest(2.0e-5) == "2e-05");
  CHECK(shortest(0.0) == "0");
  CHECK(shortest(-0.0) == "-0");
  CHECK(shortest(std::numeric_limits<double>::quiet_NaN()) == "nan");
  CHECK(shortest(-std::numeric_limits<double>::quiet_NaN()) == "nan");
  CHECK(shortest(std::numeric_limits<double>::infinity()) == "inf");
  CHECK(shortest(-std::numeric_limits<double>::infinity()) == "-inf");
}

TEST_CASE("shortest and parse_number: every finite double comes back to the last bit") {
  std::vector<double> values{0.0,
                             -0.0,
                             std::numeric_limits<double>::denorm_min(),
                             std::numeric_limits<double>::min(),
                             std::numeric_limits<double>::max(),
                             std::numeric_limits<double>::lowest()};
  std::mt19937_64 random(4711);
  while (values.size() < 20000) {
    const double value = std::bit_cast<double>(random());
    if (std::isfinite(value)) values.push_back(value);
  }
  std::size_t different = 0;
  for (const double value : values) {
    const auto back = parse_number(shortest(value));
    if (!back || std::bit_cast<std::uint64_t>(*back) != std::bit_cast<std::uint64_t>(value)) ++different;
  }
  CHECK(different == 0);
}

TEST_CASE("parse_number: the whole token, spaces aside, or nothing") {
  CHECK(parse_number(" \t3.5 ") == 3.5);
  CHECK(parse_number("+1.25") == 1.25);
  CHECK(parse_number("-1e-3") == -0.001);
  CHECK(parse_number(".5") == 0.5);
  CHECK(parse_number("5.") == 5.0);
  for (const std::string_view word : {"nan", "NaN", "NAN", "-nan", " nan "}) {
    CAPTURE(word);
    REQUIRE(parse_number(word).has_value());
    CHECK(std::isnan(*parse_number(word)));
  }
  for (const std::string_view word : {"",     " ",   "+",    "-",    "+-1",      "-+1",    "--1",  "++1",   "1 2",    "1,5", "1.2.3", "1e",
                                      "0x10", "inf", "-inf", "+inf", "infinity", "nan(1)", "nano", "1e999", "twelve", "1s",  "."}) {
    CAPTURE(word);
    CHECK_FALSE(parse_number(word).has_value());
  }
}

TEST_CASE("write_file_whole: the content, byte by byte, in place of the old, and no partial file") {
  const Folder folder;
  const fs::path file = folder.path / "a.csv";
  write_file_whole(file, "old and longer than the new content");
  const std::string content("a\0b\r\n\xff", 6);
  write_file_whole(file, content);
  CHECK(read_file(file) == content);
  write_file_whole(file, "");
  CHECK(read_file(file).empty());
  CHECK(folder.entries() == 1);
}

TEST_CASE("read_file: files larger than one read come back whole") {
  const Folder folder;
  const fs::path file = folder.path / "large";
  std::string content;
  for (int i = 0; i < 100000; ++i) content += std::to_string(i) + '\n';
  write_file_whole(file, content);
  CHECK(read_file(file) == content);
}

TEST_CASE("write_file_whole: a symbolic link stays one, and what it points to is written") {
  const Folder folder;
  fs::create_symlink(folder.path / "target", folder.path / "link");
  write_file_whole(folder.path / "target", "old");
  write_file_whole(folder.path / "link", "new");
  CHECK(fs::is_symlink(folder.path / "link"));
  CHECK(read_file(folder.path / "target") == "new");
}

TEST_CASE("write_file_whole: a device is written to, not replaced") {
  write_file_whole("/dev/null", "content");
  CHECK(fs::is_character_file("/dev/null"));
}

TEST_CASE("write_file_whole: a failure names the path and the reason, and leaves nothing behind") {
  const Folder folder;
  const fs::path nowhere = folder.path / "no" / "such" / "a.csv";
  CHECK(message_of([&] { write_file_whole(nowhere, "x"); }) == nowhere.string() + ": cannot write\n  No such file or directory");
  CHECK(message_of([&] { write_file_whole(folder.path, "x"); }) == folder.path.string() + ": cannot write\n  Is a directory");
  // A folder in the place of the partial file.
  fs::create_directory(half_written(folder.path / "b.csv"));
  CHECK(message_of([&] { write_file_whole(folder.path / "b.csv", "x"); }) ==
        (folder.path / "b.csv").string() + ": cannot write\n  Is a directory");
  CHECK_FALSE(fs::exists(folder.path / "b.csv"));
}

TEST_CASE("write_file_whole: on its way it touches no other file, and nothing that a link in the place of the half-written one leads to") {
  const Folder folder;
  const fs::path file = folder.path / "a.csv", mine = folder.path / "a.csv.partial", other = folder.path / "other";
  CHECK(half_written(file) == folder.path / ".a.csv.sinew.partial");
  CHECK(is_half_written(half_written(file)));
  CHECK_FALSE(is_half_written(mine));
  write_file_whole(mine, "mine");
  write_file_whole(other, "another's");
  fs::create_symlink("other", half_written(file));
  write_file_whole(file, "by a symbolic link");
  CHECK(fs::is_regular_file(fs::symlink_status(file)));
  CHECK(read_file(file) == "by a symbolic link");
  fs::create_hard_link(other, half_written(file));
  write_file_whole(file, "by a hard link");
  CHECK(read_file(file) == "by a hard link");
  CHECK(read_file(other) == "another's");
  CHECK(read_file(mine) == "mine");
  CHECK(folder.entries() == 3);
}

TEST_CASE("write_file_whole: what was left half-written is taken over, what another is writing is not") {
  const Folder folder;
  const fs::path file = folder.path / "a.csv";
  const int other = ::open(half_written(file).c_str(), O_WRONLY | O_CREAT, 0666);
  REQUIRE(other >= 0);
  REQUIRE(::flock(other, LOCK_EX) == 0);
  REQUIRE(::write(other, "longer than the new content", 27) == 27);
  CHECK(message_of([&] { write_file_whole(file, "new"); }) == file.string() + ": cannot write\n  another command is writing this file");
  CHECK(fs::file_size(half_written(file)) == 27);
  ::close(other);
  write_file_whole(file, "new");
  CHECK(read_file(file) == "new");
  CHECK(folder.entries() == 1);
}

TEST_CASE("read_file: a missing file or a folder is an error with its path") {
  const Folder folder;
  const fs::path missing = folder.path / "missing.csv";
  CHECK(message_of([&] { read_file(missing); }) == missing.string() + ": cannot read\n  No such file or directory");
  CHECK(message_of([&] { read_file(folder.path); }) == folder.path.string() + ": cannot read\n  Is a directory");
}

TEST_CASE("input error: place, key and value on the first line, advice indented below") {
  const InputError whole({.file = "scenarios/step.yaml",
                          .line = 10,
                          .column = 42,
                          .key = "plant.effects.thermocouple_lag.time_constant_s",
                          .value = "-1.2",
                          .advice = "must lie in [0, 30]; 0 turns thermocouple_lag off\nsee docs\n"});
  CHECK(std::string(whole.what()) ==
        "scenarios/step.yaml:10:42: plant.effects.thermocouple_lag.time_constant_s = -1.2\n"
        "  must lie in [0, 30]; 0 turns thermocouple_lag off\n"
        "  see docs");
  CHECK(whole.file == "scenarios/step.yaml");
  CHECK(whole.line == 10);
  CHECK(whole.column == 42);
  CHECK(whole.value == "-1.2");
  CHECK(std::string(InputError({.file = "a.csv", .line = 3, .key = "no header"}).what()) == "a.csv:3: no header");
  CHECK(std::string(InputError({.key = "--seed", .value = "x", .advice = "a number"}).what()) == "--seed = x\n  a number");
  CHECK(std::string(InputError({.file = "a.csv"}).what()) == "a.csv");
  // What a file holds cannot send commands to the terminal.
  CHECK(std::string(InputError({.file = "a", .key = "k", .value = "\x1b[2J\n"}).what()) == "a: k = \\x1b[2J\\x0a");
}

TEST_CASE("printable: long text is cut between characters") {
  CHECK(printable("abcdef", 3) == "abc...");
  CHECK(printable("abcdef", 6) == "abcdef");
  CHECK(printable("ab\xc3\xa4", 3) == "ab...");
}

TEST_CASE("nearest: the closest spelling, or none") {
  const std::vector<std::string_view> names{"thermocouple_lag", "thermocouple_heat_sink", "cross_heating", "fatigue"};
  CHECK(nearest("thermocuple_lag", names) == "thermocouple_lag");   // a letter left out
  CHECK(nearest("thermocoulpe_lag", names) == "thermocouple_lag");  // two letters swapped
  CHECK(nearest("Cross_Heating", names) == "cross_heating");        // letter case
  CHECK(nearest("fatige", names) == "fatigue");
  CHECK(nearest("gravity_load", names).empty());
  CHECK(nearest("", names).empty());
  // Of two letters none is left: two replacements are no likeness.
  CHECK(nearest("Bl", std::vector<std::string>{"Tr"}).empty());
  // A swap of neighbours is one edit: with it "ba" is nearer to "ab" than to "bcc".
  CHECK(nearest("ba", std::vector<std::string>{"bcc", "ab"}) == "ab");
  // Case decides between equals.
  CHECK(nearest("tx", std::vector<std::string>{"Tr", "tr"}) == "tr");
  // Nine letters allow three edits, eight allow two.
  CHECK(nearest("abcdefghi", std::vector<std::string>{"abcdef"}) == "abcdef");
  CHECK(nearest("abcdefgh", std::vector<std::string>{"abcde"}).empty());
  CHECK(nearest("anything", std::vector<std::string>{}).empty());
}

}  // namespace sim_text_test

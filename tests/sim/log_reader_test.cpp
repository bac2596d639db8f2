// SPDX-License-Identifier: Apache-2.0
#include "sim/log_reader.h"

#include <doctest/doctest.h>
#include <matio.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <string>

#include "model/hdf5_file.h"
#include "sim/hdf5_log.h"
#include "sim/input_error.h"
#include "sim/mat_log.h"
#include "sim/text.h"

namespace sim_log_reader_test {

namespace fs = std::filesystem;
using namespace sinew::sim;

namespace {

Log parse(const std::string& text, const LogLayout& layout = {}) { return parse_text_log(text, "log.csv", layout); }

template <class Action>
std::string error_of(Action action) {
  try {
    action();
  } catch (const InputError& error) {
    return error.what();
  }
  return "nothing was thrown";
}
std::string error_of_text(const std::string& text, const LogLayout& layout = {}) {
  return error_of([&] { parse(text, layout); });
}

struct Folder {
  fs::path path = fs::temp_directory_path() / ("sinew_log_reader_test_" + std::to_string(::getpid()));
  Folder() { fs::create_directories(path); }
  ~Folder() { fs::remove_all(path); }
};

void add_variable(mat_t* file, const char* name, std::size_t rows, std::size_t columns, double* values) {
  std::array<std::size_t, 2> extents{rows, columns};
  matvar_t* variable = Mat_VarCreate(name, MAT_C_DOUBLE, MAT_T_DOUBLE, 2, extents.data(), values, 0);
  REQUIRE(Mat_VarWrite(file, variable, MAT_COMPRESSION_NONE) == 0);
  Mat_VarFree(variable);
}

}  // namespace

TEST_CASE("log: a header, then rows; names are without spaces and quotes") {
  const Log log = parse("t, \"pwm, left\" ,T\n0,0.5,20\n1,,nan\n");
  CHECK(log.names == std::vector<std::string>{"t", "pwm, left", "T"});
  CHECK(log.header_line() == 1);
  REQUIRE(log.rows(0) == 2);
  CHECK(log.number(0, 1) == 0.5);
  CHECK(std::isnan(*log.number(1, 1)));
  CHECK(std::isnan(*log.number(1, 2)));
  CHECK(log.line_of(1) == 3);
  CHECK(log.notes.summary().empty());
}

TEST_CASE("log: lines before the header are kept as comments") {
  const Log log = parse("logger 7\n\n# of Tuesday\nt,x\n0,1\n", {.lines_before = 3});
  CHECK(log.comments == std::vector<std::string>{"logger 7", "of Tuesday"});
  CHECK(log.names == std::vector<std::string>{"t", "x"});
}

TEST_CASE("log: a header that is looked for is the line with most of the wanted names") {
  const std::vector<std::string> wanted{"t", "pwm"};
  const Log log = parse_text_log("t of start,12\nt\nT,PWM\n0,1\n", "log.csv", {.lines_before = std::nullopt}, wanted);
  CHECK(log.names == std::vector<std::string>{"T", "PWM"});
  CHECK(error_of([&] { parse_text_log("a,b\n0,1\n", "log.csv", {.lines_before = std::nullopt}, wanted); }) ==
        "log.csv: no header\n  none of the names of the map stands in the first 30 lines: the map matches nothing here\n"
        "  its names are: t, pwm");
}

TEST_CASE("log: delimiters, and the decimal comma") {
  CHECK(parse("t;x\n0;1,5\n", {.delimiter = ';', .decimal_comma = true}).number(0, 1) == 1.5);
  CHECK(parse("t\tx\n0\t-2\n", {.delimiter = '\t'}).number(0, 1) == -2.0);
  CHECK(parse("t   x\n 0 \t 7  \n", {.delimiter = ' '}).number(0, 1) == 7.0);
  CHECK(parse("t|x\n0| 3\n", {.delimiter = '|'}).number(0, 1) == 3.0);
  CHECK_FALSE(parse("t;x\n0;1.000,5\n", {.delimiter = ';', .decimal_comma = true}).number(0, 1).has_value());
}

TEST_CASE("log: without a header, columns have numbers") {
  const Log log = parse("0,1,2\n1,1,2\n", {.header = false});
  CHECK(log.columns() == 3);
  CHECK(log.rows(0) == 2);
  CHECK(log.header_line() == 0);
  CHECK(log.title(2) == "column 3");
}

TEST_CASE("log: lines of text between the rows are passed over and counted, where the layout says so") {
  const std::string text = "waiting...\n5057.00,-5.27,-13.50,20\nactivating x, 5, -2.12\n2, -114.90\n5109.00,-7.83,-20.46,20\n";
  const Log log = parse(text, {.header = false, .ignore_text = true});
  CHECK(log.rows(0) == 2);
  CHECK(log.columns() == 4);
  CHECK(log.number(1, 1) == -7.83);
  CHECK(log.notes.summary() == "3 lines of text between the rows, passed over (first on line 1)\n");
  // By pattern, and nothing beyond the patterns.
  const std::string with_header = "t,x\n0,1\nstate 3\n1,2\n";
  CHECK(parse(with_header, {.ignore = {"state *"}}).rows(0) == 2);
  CHECK(error_of_text(with_header, {.ignore = {"status*"}}) ==
        "log.csv:3: fields in this row = 1\n  the header has 2\n"
        "  where lines of text stand between the rows, the map says `text_lines: ignore` under `file`");
}

TEST_CASE("log: where every line is passed over as text, the error says so") {
  CHECK(error_of_text("name,x\na,1\nb,2\n", {.ignore_text = true}) ==
        "log.csv: rows = 0\n  2 lines were taken for text between the rows: see `text_lines` in the map");
}

TEST_CASE("log: what is odd about a file is counted") {
  const Log log = parse("\xef\xbb\xbft,x\r\n0,1\r\n\r\n# late\r\n1,2,\r\n2,3\r\n3,");
  CHECK(log.rows(0) == 4);
  CHECK(log.notes.summary() ==
        "1 byte-order mark, passed over (line 1)\n"
        "6 lines end as on Windows, CR LF (first on line 1)\n"
        "1 blank line, passed over (line 3)\n"
        "1 comment below the first row, kept with those above it (line 4)\n"
        "1 row ends in a delimiter, taken for none (line 5)\n");
}

TEST_CASE("log: a last line cut off in its middle is dropped") {
  CHECK(parse("t,x,y\n0,1,2\n1,2").notes.cut_off_last_line.count == 1);
  CHECK(parse("t,x,y\n0,1,2\n1,2,-").rows(0) == 1);
  CHECK(parse("t,x,y\n0,1,2\n1,2,3").rows(0) == 2);
}

TEST_CASE("log: what is no text, and what has no rows, is an error") {
  CHECK(error_of_text("") == "log.csv: the file is empty\n  expected rows of numbers");
  CHECK(error_of_text("\xff\xfet") == "log.csv: text in UTF-16\n  save it as UTF-8");
  CHECK(error_of_text(std::string("t,x\n0,\0\n", 8)) == "log.csv:2: a NUL byte\n  this is not a text file, or it is damaged");
  CHECK(error_of_text("t,x\r0,1\r") == "log.csv:1: line ends = CR alone\n  save the file with LF or CR LF at the end of each line");
  CHECK(error_of_text("t,x\n") == "log.csv: rows = 0\n  there is nothing below the header");
  CHECK(error_of_text("t,x\n0,1\n", {.lines_before = 9}) == "log.csv: lines = 2\n  the map says that 9 stand before the header");
  CHECK(error_of_text("t,x\n0,1,2,3\n").starts_with("log.csv:2: fields in this row = 4\n  the header has 2\n"));
}

TEST_CASE("log: patterns") {
  CHECK(matches_pattern("activating x, 5", "activating*"));
  CHECK(matches_pattern("2, -114.90", "?, *"));
  CHECK_FALSE(matches_pattern("20, 1", "?, *"));
  CHECK(matches_pattern("abcbd", "a*b?"));
  CHECK_FALSE(matches_pattern("", "?"));
  CHECK(matches_pattern("", "**"));
}

TEST_CASE("log: the variables of a MATLAB file, matrices by their columns, structures by their fields") {
  const Folder folder;
  for (const auto& [version, name] : {std::pair{MAT_FT_MAT5, "five.mat"}, std::pair{MAT_FT_MAT73, "seven.mat"}}) {
    CAPTURE(name);
    const std::string path = (folder.path / name).string();
    mat_t* file = Mat_CreateVer(path.c_str(), nullptr, version);
    REQUIRE(file != nullptr);
    std::array<double, 3> t{0.0, 0.5, 1.0};
    std::array<double, 6> tags{1, 2, 3, 4, 5, 6};  // by columns
    add_variable(file, "t", 3, 1, t.data());
    add_variable(file, "row", 1, 3, t.data());
    add_variable(file, "tags", 3, 2, tags.data());
    add_variable(file, "wide", 2, 3, tags.data());
    std::array<std::size_t, 2> text_extents{1, 4};
    matvar_t* text = Mat_VarCreate("note", MAT_C_CHAR, MAT_T_UTF8, 2, text_extents.data(), const_cast<char*>("cold"), 0);
    Mat_VarWrite(file, text, MAT_COMPRESSION_NONE);
    Mat_VarFree(text);
    std::array<std::size_t, 2> one{1, 1}, three{3, 1};
    const char* fields[] = {"angle"};
    matvar_t* run = Mat_VarCreateStruct("run", 2, one.data(), fields, 1);
    Mat_VarSetStructFieldByName(run, "angle", 0, Mat_VarCreate(nullptr, MAT_C_DOUBLE, MAT_T_DOUBLE, 2, three.data(), t.data(), 0));
    Mat_VarWrite(file, run, MAT_COMPRESSION_NONE);
    Mat_VarFree(run);
    Mat_Close(file);
    CHECK(kind_of_log(path) == LogKind::mat);
    const Log log = read_log(path, {});
    std::vector<std::string> names = log.names;
    std::sort(names.begin(), names.end());
    CHECK(names == std::vector<std::string>{"row", "run.angle", "t", "tags[1]", "tags[2]", "wide[1]", "wide[2]"});
    const auto values = [&](const std::string& wanted) {
      const auto at = static_cast<std::size_t>(std::find(log.names.begin(), log.names.end(), wanted) - log.names.begin());
      std::vector<double> all;
      for (std::size_t i = 0; i < log.rows(at); ++i) all.push_back(*log.number(i, at));
      return all;
    };
    CHECK(values("tags[2]") == std::vector<double>{4, 5, 6});
    CHECK(values("wide[2]") == std::vector<double>{2, 4, 6});
    CHECK(values("run.angle") == std::vector<double>{0.0, 0.5, 1.0});
    // Damaged: cut anywhere, it is an error or other numbers, never the end of the program.
    const std::string bytes = read_file(path);
    for (std::size_t length = 0; length < bytes.size(); length += 37) {
      const fs::path cut = folder.path / "cut.mat";
      write_file_whole(cut, bytes.substr(0, length));
      error_of([&] { read_mat(cut); });
    }
  }
  write_file_whole(folder.path / "none.mat", "t,x\n0,1\n");
  CHECK(error_of([&] { read_log(folder.path / "none.mat", {}); }).find("none.mat\n  ") != std::string::npos);
}

TEST_CASE("log: the arrays of an HDF5 file by path") {
  const Folder folder;
  sinew::model::Hdf5File file;
  file.arrays["/t"] = {{3}, {0.0, 0.5, 1.0}, false};
  file.arrays["/run/tags"] = {{3, 2}, {1, 4, 2, 5, 3, 6}, false};
  const fs::path path = folder.path / "log.h5";
  write_file_whole(path, sinew::model::to_bytes(file));
  CHECK(kind_of_log(path) == LogKind::hdf5);
  const Log log = read_log(path, {});
  CHECK(log.names == std::vector<std::string>{"run/tags[1]", "run/tags[2]", "t"});
  CHECK(log.number(1, 1) == 5.0);
  write_file_whole(path, read_file(path).substr(0, 700));
  CHECK(error_of([&] { read_log(path, {}); }) == path.string() + "\n  is not an HDF5 file that can be read, or it is damaged");
}

}  // namespace sim_log_reader_test

// SPDX-License-Identifier: Apache-2.0
// The file of any logger, before a map says what its columns mean: lines of text with a delimiter, or the variables of a
// MATLAB or an HDF5 file. Nothing is passed over without a count.
#pragma once

#include <cstddef>
#include <filesystem>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace sinew::sim {

// How often something odd was met, and where first.
struct Tally {
  std::size_t count = 0;
  int first_line = 0;  // of the file, from 1; 0 while the count is 0, and where a file has no lines
  void add(int line) {
    if (count++ == 0) first_line = line;
  }
};

// How a text log is written.
struct LogLayout {
  std::optional<std::size_t> lines_before = 0;  // above the header, or above the first row; none: the header is looked for
  bool header = true;
  char delimiter = ',';        // ' ': any number of spaces and tabs
  bool decimal_comma = false;  // 1,5 for 1.5
  // Lines that are no rows: `ignore_text` passes over every line with another number of fields than the header (the
  // first row, where there is no header), or whose first field begins with a letter; `ignore` passes over the lines
  // that match a pattern (* any characters, ? one). Else such a line is an error.
  bool ignore_text = false;
  std::vector<std::string> ignore{};
};

// Bytes of a line of text, in logs and recordings alike: a longer one is no row, and its fields could fill the memory.
inline constexpr std::size_t longest_line = 1 << 20;
// How far a header is looked for.
inline constexpr std::size_t header_search_lines = 30;

struct LogNotes {
  Tally byte_order_mark, windows_line_ends, blank_lines, late_comments, ignored_lines, trailing_delimiters, cut_off_last_line;
  std::string summary() const;
};

// A sentence of `notes`: "3 blank lines, passed over (first on line 7)\n"; nothing where the count is 0.
std::string counted(const Tally& oddity, std::string_view one, std::string_view many, std::string_view rest);

// A series of numbers from a file that is no text.
struct LogArray {
  std::string name;  // `matrix[k]` for the k-th column of a matrix, from 1
  std::vector<double> values;
};

class Log {
 public:
  std::string file;                   // as messages say it
  std::vector<std::string> names;     // of the columns; empty ones where the file has no header
  std::vector<std::string> comments;  // lines above the header, and those that begin with '#'
  LogNotes notes{};

  bool is_text() const { return text_ != nullptr; }
  std::size_t columns() const { return names.size(); }
  // Of a text log; of another, of that column.
  std::size_t rows(std::size_t column) const { return is_text() ? rows_.size() : arrays_[column].values.size(); }
  // As it stands in the file, without spaces and quotes around it. Text logs alone.
  std::string_view field(std::size_t row, std::size_t column) const;
  // The number; none where the field is text. An empty field is NaN.
  std::optional<double> number(std::size_t row, std::size_t column) const;
  int line_of(std::size_t row) const { return is_text() ? lines_[row] : 0; }
  int header_line() const { return header_line_; }  // 0 where there is none
  // Name of the column for messages: "pwm_0", or "column 3".
  std::string title(std::size_t column) const;
  // An error at a row's field.
  [[noreturn]] void fail_at(std::size_t row, std::size_t column, const std::string& value, const std::string& advice) const;
  // A row by number where it has no line.
  [[noreturn]] void fail_in_row(std::size_t row, const std::string& key, const std::string& value, const std::string& advice) const;

  // `wanted`: names by which a header that is looked for is known.
  friend Log parse_text_log(std::string text, std::string file, const LogLayout& layout, std::span<const std::string> wanted);
  friend Log array_log(std::vector<LogArray> arrays, std::string file);

 private:
  LogLayout layout_{};
  std::shared_ptr<const std::string> text_;
  std::vector<std::string_view> rows_;
  std::vector<int> lines_;
  int header_line_ = 0;
  std::vector<LogArray> arrays_;
};

Log parse_text_log(std::string text, std::string file, const LogLayout& layout, std::span<const std::string> wanted = {});
Log array_log(std::vector<LogArray> arrays, std::string file);

enum class LogKind { text, mat, hdf5 };
// By the first bytes; a MATLAB file of version 4, which has no mark, by its name.
LogKind kind_of_log(const std::filesystem::path& path);
// `layout` and `wanted` are for text alone.
Log read_log(const std::filesystem::path& path, const LogLayout& layout, std::span<const std::string> wanted = {});

// The fields of a line.
std::vector<std::string_view> split_fields(std::string_view line, char delimiter);
// The number that a field is, with the decimal point or comma as told.
std::optional<double> parse_field(std::string_view field, bool decimal_comma);
// Whether the text matches the pattern: * is any characters, ? is one.
bool matches_pattern(std::string_view text, std::string_view pattern);

}  // namespace sinew::sim

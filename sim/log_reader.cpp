// SPDX-License-Identifier: Apache-2.0
#include "sim/log_reader.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>
#include <fstream>
#include <utility>

#include "sim/hdf5_log.h"
#include "sim/input_error.h"
#include "sim/mat_log.h"
#include "sim/text.h"

namespace sinew::sim {
namespace {

std::string_view unquoted(std::string_view field) {
  field = trimmed(field);
  if (field.size() >= 2 && field.front() == '"' && field.back() == '"') {
    field = trimmed(field.substr(1, field.size() - 2));
  }
  return field;
}

bool begins_with_letter(std::string_view field) {
  if (field.empty() || parse_number(field)) return false;  // nan is a number
  return std::isalpha(static_cast<unsigned char>(field.front())) != 0 || (static_cast<unsigned char>(field.front()) & 0x80u) != 0;
}

std::string comment_of(std::string_view line) {
  if (line.starts_with('#')) line.remove_prefix(1);
  if (line.starts_with(' ')) line.remove_prefix(1);
  return std::string(line);
}

bool same_name(std::string_view a, std::string_view b) {
  return std::equal(a.begin(), a.end(), b.begin(), b.end(), [](char x, char y) {
    return std::tolower(static_cast<unsigned char>(x)) == std::tolower(static_cast<unsigned char>(y));
  });
}

struct Line {
  std::string_view text;
  int number;
  bool ended;  // by a line feed
};

// The lines of the file; what is no text at all is an error.
std::vector<Line> lines_of(std::string_view text, const std::string& file, LogNotes& notes) {
  const auto fail = [&](std::string key, int line, std::string value, std::string advice) {
    throw InputError({.file = file, .line = line, .key = std::move(key), .value = std::move(value), .advice = std::move(advice)});
  };
  if (text.empty()) fail("the file is empty", 0, "", "expected rows of numbers");
  if (text.starts_with("\xff\xfe") || text.starts_with("\xfe\xff")) fail("text in UTF-16", 0, "", "save it as UTF-8");
  if (text.starts_with("\xef\xbb\xbf")) {
    text.remove_prefix(3);
    notes.byte_order_mark = {1, 1};
  }
  if (const std::size_t zero = text.find('\0'); zero != std::string_view::npos) {
    fail("a NUL byte", 1 + static_cast<int>(std::count(text.begin(), text.begin() + static_cast<std::ptrdiff_t>(zero), '\n')), "",
         "this is not a text file, or it is damaged");
  }
  if (text.find('\n') == std::string_view::npos && text.find('\r') < text.size() - 1) {
    fail("line ends", 1, "CR alone", "save the file with LF or CR LF at the end of each line");
  }
  std::vector<Line> lines;
  for (int number = 1; !text.empty(); ++number) {
    const std::size_t end = text.find('\n');
    const bool ended = end != std::string_view::npos;
    std::string_view line = text.substr(0, end);
    text.remove_prefix(ended ? end + 1 : text.size());
    if (line.ends_with('\r')) {
      line.remove_suffix(1);
      notes.windows_line_ends.add(number);
    }
    if (line.size() > longest_line)
      fail("bytes in this line", number, std::to_string(line.size()), "a line has at most " + std::to_string(longest_line));
    lines.push_back({line, number, ended});
  }
  return lines;
}

// The line in which most of the wanted names stand; none where no name stands in any.
std::optional<std::size_t> likeliest_header(std::span<const Line> lines, char delimiter, std::span<const std::string> wanted) {
  std::optional<std::size_t> best;
  std::size_t most = 0;
  for (std::size_t i = 0; i < std::min(lines.size(), header_search_lines); ++i) {
    const auto fields = split_fields(lines[i].text, delimiter);
    const auto found = static_cast<std::size_t>(std::count_if(wanted.begin(), wanted.end(), [&](const std::string& name) {
      return std::any_of(fields.begin(), fields.end(), [&](std::string_view f) { return same_name(unquoted(f), name); });
    }));
    if (found > most) most = found, best = i;
  }
  return best;
}

}  // namespace

std::string counted(const Tally& tally, std::string_view one, std::string_view many, std::string_view rest) {
  if (tally.count == 0) return "";
  std::string text = std::to_string(tally.count);
  text.append(1, ' ').append(tally.count == 1 ? one : many).append(rest);
  if (tally.first_line > 0) {
    text.append(tally.count == 1 ? " (line " : " (first on line ").append(std::to_string(tally.first_line)).append(1, ')');
  }
  return text + '\n';
}

std::string LogNotes::summary() const {
  return counted(byte_order_mark, "byte-order mark", "", ", passed over") +
         counted(windows_line_ends, "line ends", "lines end", " as on Windows, CR LF") +
         counted(blank_lines, "blank line", "blank lines", ", passed over") +
         counted(late_comments, "comment", "comments", " below the first row, kept with those above it") +
         counted(ignored_lines, "line", "lines", " of text between the rows, passed over") +
         counted(trailing_delimiters, "row ends", "rows end", " in a delimiter, taken for none") +
         counted(cut_off_last_line, "last line", "", " cut off in its middle; dropped");
}

std::vector<std::string_view> split_fields(std::string_view line, char delimiter) {
  std::vector<std::string_view> fields;
  const bool any_space = delimiter == ' ';
  if (any_space) line = trimmed(line);
  const auto is_delimiter = [&](char c) { return any_space ? c == ' ' || c == '\t' : c == delimiter; };
  for (std::size_t start = 0;;) {
    std::size_t at = start;
    while (at < line.size() && (line[at] == ' ' || line[at] == '\t') && !is_delimiter(line[at])) ++at;
    if (at < line.size() && line[at] == '"') {  // a quoted field may hold delimiters
      const std::size_t closing = line.find('"', at + 1);
      if (closing != std::string_view::npos) at = closing;
    }
    while (at < line.size() && !is_delimiter(line[at])) ++at;
    fields.push_back(line.substr(start, at - start));
    if (at >= line.size()) return fields;
    start = at + 1;
    while (any_space && start < line.size() && is_delimiter(line[start])) ++start;
  }
}

std::optional<double> parse_field(std::string_view field, bool decimal_comma) {
  if (!decimal_comma || field.find(',') == std::string_view::npos) return parse_number(field);
  if (field.find('.') != std::string_view::npos) return std::nullopt;
  std::string with_point(field);
  with_point[with_point.find(',')] = '.';
  return parse_number(with_point);
}

bool matches_pattern(std::string_view text, std::string_view pattern) {
  std::size_t t = 0, p = 0, star = std::string_view::npos, after_star = 0;
  while (t < text.size()) {
    if (p < pattern.size() && pattern[p] == '*') {
      star = p++;
      after_star = t;
    } else if (p < pattern.size() && (pattern[p] == '?' || pattern[p] == text[t])) {
      ++p, ++t;
    } else if (star != std::string_view::npos) {
      p = star + 1;
      t = ++after_star;
    } else {
      return false;
    }
  }
  while (p < pattern.size() && pattern[p] == '*') ++p;
  return p == pattern.size();
}

std::string_view Log::field(std::size_t row, std::size_t column) const {
  return unquoted(split_fields(rows_[row], layout_.delimiter)[column]);
}

std::optional<double> Log::number(std::size_t row, std::size_t column) const {
  if (!is_text()) return arrays_[column].values[row];
  const std::string_view text = field(row, column);
  return text.empty() ? not_a_number : parse_field(text, layout_.decimal_comma);
}

std::string Log::title(std::size_t column) const { return names[column].empty() ? "column " + std::to_string(column + 1) : names[column]; }

void Log::fail_at(std::size_t row, std::size_t column, const std::string& value, const std::string& advice) const {
  if (!is_text()) fail_in_row(row, title(column), value, advice);
  int at = 1;  // in characters: bytes that continue one in UTF-8 do not count
  const char* const begin = rows_[row].data();
  for (const char* p = begin; p < field(row, column).data(); ++p) at += (static_cast<unsigned char>(*p) & 0xC0u) != 0x80u;
  throw InputError({.file = file, .line = lines_[row], .column = at, .key = title(column), .value = value, .advice = advice});
}

void Log::fail_in_row(std::size_t row, const std::string& key, const std::string& value, const std::string& advice) const {
  const std::string where = is_text() ? key : key + ", sample " + std::to_string(row + 1);
  throw InputError({.file = file, .line = line_of(row), .key = where, .value = value, .advice = advice});
}

Log parse_text_log(std::string text, std::string file, const LogLayout& layout, std::span<const std::string> wanted) {
  Log log;
  log.file = std::move(file);
  log.layout_ = layout;
  log.text_ = std::make_shared<const std::string>(std::move(text));
  const std::vector<Line> lines = lines_of(*log.text_, log.file, log.notes);
  const auto fail = [&](int line, std::string key, std::string value, std::string advice) {
    throw InputError({.file = log.file, .line = line, .key = std::move(key), .value = std::move(value), .advice = std::move(advice)});
  };

  std::size_t next = 0;
  if (layout.lines_before) {
    next = *layout.lines_before;
    if (next >= lines.size())
      fail(0, "lines", std::to_string(lines.size()), "the map says that " + std::to_string(next) + " stand before the header");
  } else if (layout.header) {
    const auto found = likeliest_header(lines, layout.delimiter, wanted);
    if (!found) {
      std::string names;
      for (const std::string& name : wanted) names += (names.empty() ? "" : ", ") + name;
      fail(0, "no header", "",
           "none of the names of the map stands in the first " + std::to_string(header_search_lines) +
               " lines: the map matches nothing here\nits names are: " + names);
    }
    next = *found;
  }
  for (std::size_t i = 0; i < next; ++i) {
    if (!trimmed(lines[i].text).empty()) log.comments.push_back(comment_of(lines[i].text));
  }

  std::size_t expected = 0;
  for (; next < lines.size(); ++next) {
    const auto& [line, number, ended] = lines[next];
    if (trimmed(line).empty()) {
      log.notes.blank_lines.add(number);
      continue;
    }
    const bool in_header = layout.header && expected == 0;
    if (line.front() == '#' && !(in_header && layout.lines_before && *layout.lines_before == next && next > 0)) {
      if (expected > 0 && !log.rows_.empty()) log.notes.late_comments.add(number);
      log.comments.push_back(comment_of(line));
      continue;
    }
    if (std::any_of(layout.ignore.begin(), layout.ignore.end(), [row = line](const std::string& p) { return matches_pattern(row, p); })) {
      log.notes.ignored_lines.add(number);
      continue;
    }
    std::vector<std::string_view> fields = split_fields(line, layout.delimiter);
    if (in_header) {
      expected = fields.size();
      log.header_line_ = number;
      for (const std::string_view f : fields) log.names.emplace_back(unquoted(f));
      continue;
    }
    const bool is_text = begins_with_letter(unquoted(fields.front()));
    if (expected == 0 && !(layout.ignore_text && is_text)) {
      expected = fields.size();
      log.names.resize(expected);
    }
    if (fields.size() == expected + 1 && unquoted(fields.back()).empty()) {
      log.notes.trailing_delimiters.add(number);
      fields.pop_back();
    }
    const bool fits = fields.size() == expected;
    const bool cut_number = fits && !ended && !log.rows_.empty() && !parse_field(unquoted(fields.back()), layout.decimal_comma) &&
                            !unquoted(fields.back()).empty() && log.number(log.rows_.size() - 1, expected - 1).has_value();
    if (!ended && !log.rows_.empty() && (cut_number || (fields.size() < expected && !(layout.ignore_text && is_text)))) {
      log.notes.cut_off_last_line.add(number);
      continue;
    }
    if (layout.ignore_text && (!fits || is_text)) {
      log.notes.ignored_lines.add(number);
      continue;
    }
    if (!fits) {
      fail(number, "fields in this row", std::to_string(fields.size()),
           (layout.header ? "the header has " : "the first row has ") + std::to_string(expected) +
               "\nwhere lines of text stand between the rows, the map says `text_lines: ignore` under `file`");
    }
    log.rows_.push_back(line);
    log.lines_.push_back(number);
  }
  if (log.rows_.empty()) {
    std::string advice = "there is nothing below the header";
    if (log.notes.ignored_lines.count > 0)
      advice = std::to_string(log.notes.ignored_lines.count) + " lines were taken for text between the rows: see `text_lines` in the map";
    fail(0, "rows", "0", advice);
  }
  return log;
}

Log array_log(std::vector<LogArray> arrays, std::string file) {
  Log log;
  log.file = std::move(file);
  for (const LogArray& array : arrays) log.names.push_back(array.name);
  log.arrays_ = std::move(arrays);
  return log;
}

LogKind kind_of_log(const std::filesystem::path& path) {
  std::array<char, 16> first{};
  std::ifstream stream(path, std::ios::binary);
  stream.read(first.data(), static_cast<std::streamsize>(first.size()));
  const std::string_view mark(first.data(), static_cast<std::size_t>(stream.gcount()));
  if (mark.starts_with("\x89HDF\r\n\x1a\n")) return LogKind::hdf5;
  if (mark.starts_with("MATLAB 5.0") || mark.starts_with("MATLAB 7.")) return LogKind::mat;
  return same_name(path.extension().string(), ".mat") ? LogKind::mat : LogKind::text;
}

Log read_log(const std::filesystem::path& path, const LogLayout& layout, std::span<const std::string> wanted) {
  switch (kind_of_log(path)) {
    case LogKind::mat:
      return array_log(read_mat(path), path.string());
    case LogKind::hdf5:
      return array_log(read_hdf5(path), path.string());
    case LogKind::text:
      break;
  }
  return parse_text_log(read_file(path), path.string(), layout, wanted);
}

}  // namespace sinew::sim

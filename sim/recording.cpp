// SPDX-License-Identifier: Apache-2.0
#include "sim/recording.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <cstring>
#include <optional>
#include <span>
#include <utility>

#include "plant/contains.h"
#include "plant/systems.h"
#include "sim/input_error.h"
#include "sim/log_reader.h"
#include "sim/table.h"
#include "sim/text.h"

namespace sinew::sim {
namespace {

constexpr double uneven_share = 0.1;            // of the median period
constexpr double gap_periods = 2.5;             // a longer step is a gap
constexpr double backward_periods = 10.0;       // time that goes back by less is a row out of order
constexpr double most_out_of_order = 0.05;      // share of the rows, and
constexpr std::size_t least_out_of_order = 10;  // rows: fewer are slips of the logger
constexpr double periods_averaged = 10.0;       // a step of more than ten blocks of the diagnosis shows nothing of the motion
constexpr double latest_time_s = 1e10;          // beyond it, seconds no longer resolve a sample well
constexpr double day_ms = 86'400'000.0;
constexpr std::size_t logger_preamble_lines = 2;
constexpr std::size_t preamble_search_lines = 10;
constexpr std::size_t listed_names = 30;

constexpr std::string_view time_column = "time_s";
constexpr std::string_view time_zero_key = "time_zero_s:";
constexpr std::size_t no_role = static_cast<std::size_t>(-1), time_role = 0;

// A kind of file: the name of the column for each role (the time, the inputs, the channels), and what else it may hold.
struct Format {
  std::vector<std::string> names;
  bool case_matters = true;
  bool milliseconds_of_day = false;
  std::vector<std::string_view> known_names{};  // columns that are expected and not used
  std::string_view logger_clock{};              // of the logger that is taken for a recording by mistake; empty: none is known
};

Format recording_format(const Columns& columns) {
  Format format;
  format.names.emplace_back(time_column);
  for (const Column& column : columns.inputs) format.names.push_back(column.name);
  for (const Column& column : columns.channels) format.names.push_back(column.name);
  return format;
}

Format logger_format(const plant::LoggerFormat& logger, const Columns& columns) {
  Format format = recording_format(columns);
  format.names[time_role] = logger.clock_column;
  for (auto& name : format.names)
    for (const auto& [theirs, ours] : logger.columns)
      if (name == ours) {
        name = theirs;
        break;
      }
  format.case_matters = false;
  format.milliseconds_of_day = true;
  format.known_names = logger.unused;
  return format;
}

bool same_name(std::string_view a, std::string_view b, bool case_matters) {
  if (case_matters) return a == b;
  const auto lower = [](char c) { return c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c; };
  return std::equal(a.begin(), a.end(), b.begin(), b.end(), [&](char x, char y) { return lower(x) == lower(y); });
}

// Calls `use` with each field of the line, spaces around it included.
template <class Use>
void for_each_field(std::string_view line, Use&& use) {
  const char* start = line.data();
  const char* const end = start + line.size();
  for (;;) {
    const void* comma = start == end ? nullptr : std::memchr(start, ',', static_cast<std::size_t>(end - start));
    const char* const stop = comma == nullptr ? end : static_cast<const char*>(comma);
    use(std::string_view(start, static_cast<std::size_t>(stop - start)));
    if (comma == nullptr) return;
    start = stop + 1;
  }
}

std::string_view first_field(std::string_view line) { return trimmed(line.substr(0, line.find(','))); }

template <class Names>
std::string list(const Names& names) {
  std::string text;
  for (std::size_t i = 0; i < std::min(names.size(), listed_names); ++i) {
    if (i > 0) text += ", ";
    text += names[i].empty() ? "(no name)" : printable(names[i]);
  }
  if (names.size() > listed_names) text += " and " + std::to_string(names.size() - listed_names) + " more";
  return text;
}

// The text of a file, line by line; knows the place of everything in it, which is worked out only for messages.
class Lines {
 public:
  Lines(std::string_view text, const std::string& name, ReadingNotes& notes) : text_(text), name_(name), notes_(notes) {
    if (text.empty()) fail("the file is empty", "", "expected a header and at least two rows");
    if (text.starts_with("\xff\xfe") || text.starts_with("\xfe\xff")) fail("text in UTF-16", "", "save it as UTF-8");
    if (text.starts_with("\xef\xbb\xbf")) {
      text_.remove_prefix(3);
      count(notes_.byte_order_mark, text_.data());
    }
    if (const std::size_t zero = text_.find('\0'); zero != std::string_view::npos) {
      fail_at(text_.data() + zero, "a NUL byte", "", "this is not a text file, or it is damaged");
    }
    if (text_.find('\n') == std::string_view::npos && text_.find('\r') < text_.size() - 1) {
      fail_on_line(text_.data(), "line ends", "CR alone", "save the file with LF or CR LF at the end of each line");
    }
    rest_ = text_;
  }

  // Moves on to the next line; false at the end of the file.
  bool next() {
    if (rest_.empty()) return false;
    const std::size_t end = rest_.find('\n');
    ended_ = end != std::string_view::npos;
    line_ = rest_.substr(0, end);
    rest_.remove_prefix(ended_ ? end + 1 : rest_.size());
    if (line_.ends_with('\r')) {
      line_.remove_suffix(1);
      count(notes_.windows_line_ends, line_.data());
    }
    if (line_.size() > longest_line)
      fail_on_line(line_.data(), "bytes in this line", std::to_string(line_.size()), "a line has at most " + std::to_string(longest_line));
    return true;
  }

  std::string_view line() const { return line_; }  // without its end
  bool ended() const { return ended_; }            // by a line feed: only the last line may lack it
  std::string_view text() const { return text_; }

  void count(Oddity& oddity, const char* at) const {
    if (oddity.count++ == 0) oddity.first_line = line_number(at);
  }

  [[noreturn]] void fail(std::string key, std::string_view value, std::string advice) const {
    throw InputError({.file = name_, .key = std::move(key), .value = std::string(value), .advice = std::move(advice)});
  }
  [[noreturn]] void fail_on_line(const char* at, std::string key, std::string_view value, std::string advice) const {
    throw InputError(
        {.file = name_, .line = line_number(at), .key = std::move(key), .value = std::string(value), .advice = std::move(advice)});
  }
  [[noreturn]] void fail_at(const char* at, std::string key, std::string_view value, std::string advice) const {
    throw InputError({.file = name_,
                      .line = line_number(at),
                      .column = column_number(at),
                      .key = std::move(key),
                      .value = std::string(value),
                      .advice = std::move(advice)});
  }

  int line_number(const char* at) const { return 1 + static_cast<int>(std::count(text_.data(), at, '\n')); }

 private:
  // In characters: bytes that continue one in UTF-8 do not count.
  int column_number(const char* at) const {
    int column = 1;
    for (const char* p = at; p != text_.data() && *(p - 1) != '\n'; --p) {
      if ((static_cast<unsigned char>(*(p - 1)) & 0xC0u) != 0x80u) ++column;
    }
    return column;
  }

  std::string_view text_, rest_, line_;
  bool ended_ = false;
  const std::string& name_;
  ReadingNotes& notes_;
};

std::string comment_of(std::string_view line) {
  if (line.starts_with('#')) line.remove_prefix(1);
  if (line.starts_with(' ')) line.remove_prefix(1);
  return std::string(line);
}

// Kept with the others, but for the one that says when time_s is 0.
void take_comment(const Lines& lines, std::string_view line, Recording& recording) {
  const std::string comment = comment_of(line);
  if (!comment.starts_with(time_zero_key)) return recording.comments.push_back(comment);
  const std::string_view value = trimmed(line.substr(line.find(time_zero_key) + time_zero_key.size()));
  double time_s = 0.0;
  const auto [end, error] = std::from_chars(value.data(), value.data() + value.size(), time_s);
  if (error != std::errc() || end != value.data() + value.size() || !std::isfinite(time_s) || std::abs(time_s) > latest_time_s)
    lines.fail_at(value.data(), "time_zero_s", value, "must be a number of seconds, 1e10 at most: when time_s is 0");
  if (recording.time_zero_s) lines.fail_at(value.data(), "time_zero_s", value, "stands twice; leave one out");
  recording.time_zero_s = time_s;
}

// Whether one of the first lines begins with the column of the logger's clock.
bool looks_like_logger(std::string_view text, std::string_view logger_clock) {
  if (logger_clock.empty()) return false;
  for (std::size_t i = 0; i < preamble_search_lines && !text.empty(); ++i) {
    const std::size_t end = std::min(text.find('\n'), text.size());
    if (same_name(first_field(text.substr(0, end)), logger_clock, false)) return true;
    text.remove_prefix(std::min(end + 1, text.size()));
  }
  return false;
}

// A row as it stands in the file: a missing input is NaN.
struct Row {
  Sample sample;
  const char* time_field;
};

// Reads the table below a header: header, then rows, then what is odd about their order.
class TableReader {
 public:
  TableReader(Lines& lines, const Format& format, Recording& recording)
      : lines_(lines),
        format_(format),
        recording_(recording),
        notes_(recording.notes),
        inputs_(recording.columns.inputs.size()),
        channels_(recording.columns.channels.size()) {
    notes_.held_input.resize(inputs_);
    notes_.missing.resize(channels_);
    for (const Column& column : recording.columns.inputs) notes_.input_words.push_back(column.words);
    for (const Column& column : recording.columns.channels) notes_.channel_words.push_back(column.words);
  }

  // The header is the line that `lines` stands on.
  void read() {
    read_header();
    while (lines_.next()) {
      const std::string_view line = lines_.line();
      if (trimmed(line).empty()) {
        lines_.count(notes_.blank_lines, line.data());
      } else if (line.front() == '#') {
        lines_.count(notes_.late_comments, line.data());
        take_comment(lines_, line, recording_);
      } else {
        read_row(line);
      }
    }
    if (rows_.size() < 2) {
      lines_.fail("rows", std::to_string(rows_.size()), "a recording has at least two rows below its header");
    }
    put_in_order();
    look_at_steps();
  }

 private:
  const std::string& name_of(std::size_t role) const { return format_.names[role]; }

  void read_header() {
    const std::string_view line = lines_.line();
    std::vector<std::string_view> names, extra;
    std::vector<bool> found(format_.names.size());
    for_each_field(line, [&](std::string_view field) {
      const std::string_view name = trimmed(field);
      const auto is_it = [&](std::string_view wanted) { return same_name(name, wanted, format_.case_matters); };
      const auto wanted = std::find_if(format_.names.begin(), format_.names.end(), is_it);
      const auto role = wanted == format_.names.end() ? no_role : static_cast<std::size_t>(wanted - format_.names.begin());
      names.push_back(name);
      role_of_field_.push_back(role);
      if (role == no_role) {
        const bool known = std::any_of(format_.known_names.begin(), format_.known_names.end(), is_it);
        if (!known) extra.push_back(name);
      } else {
        if (found[role]) lines_.fail_at(name.data(), "column", name, "stands twice in the header; leave one out");
        found[role] = true;
      }
    });
    if (contains(found, false)) fail_for_missing_columns(names, extra, found);
    for (const std::string_view name : extra) {
      lines_.count(notes_.extra_columns, line.data());
      notes_.extra_column_names.push_back(name.empty() ? "(no name)" : printable(name));
    }
  }

  [[noreturn]] void fail_for_missing_columns(std::span<const std::string_view> names, std::span<const std::string_view> extra,
                                             const std::vector<bool>& found) const {
    const std::string_view line = lines_.line();
    std::vector<std::string_view> missing;
    std::string near;
    for (std::size_t role = 0; role < found.size(); ++role) {
      if (found[role]) continue;
      missing.push_back(format_.names[role]);
      const std::string spelling = nearest(format_.names[role], extra);
      if (spelling.empty()) continue;
      near += '\n' + format_.names[role] + ": did you mean " + printable(spelling) + '?';
    }
    std::string advice = "the columns here are: " + list(names) + near;
    if (!format_.milliseconds_of_day && looks_like_logger(lines_.text(), format_.logger_clock)) {
      advice = "this is a file of the logger; `sinew convert` makes a recording of it";
    } else if (line.find(',') == std::string_view::npos && line.find_first_of(";\t") != std::string_view::npos) {
      advice += "\nfields must be separated by ',', and decimals written with '.'; `sinew convert --map` reads other files";
    } else if (line.find('"') != std::string_view::npos) {
      advice += "\nnames and numbers stand without quotes; `sinew convert --map` reads a file with quotes";
    }
    lines_.fail_on_line(line.data(), missing.size() == 1 ? "missing column" : "missing columns", list(missing), advice);
  }

  void read_row(std::string_view line) {
    std::vector<std::string_view>& fields = fields_;
    fields.assign(format_.names.size(), {});
    std::size_t field_count = 0;
    const std::size_t expected = role_of_field_.size();
    const char* surplus = nullptr;
    for_each_field(line, [&](std::string_view field) {
      if (field_count < expected) {
        if (role_of_field_[field_count] != no_role) fields[role_of_field_[field_count]] = field;
      } else if (field_count == expected) {
        surplus = field.data();
      }
      ++field_count;
    });
    if (field_count < expected && !lines_.ended()) {
      lines_.count(notes_.cut_off_last_line, line.data());
      return;
    }
    if (field_count != expected) {
      std::string advice = "the header has " + std::to_string(expected) + " columns";
      if (2 * field_count > 3 * expected)
        advice += "\nif decimals are written with ',', `sinew convert --map` reads the file where another mark separates fields";
      if (surplus != nullptr) lines_.fail_at(surplus, "fields in this row", std::to_string(field_count), advice);
      lines_.fail_on_line(line.data(), "fields in this row", std::to_string(field_count), advice);
    }
    const std::size_t last_role = role_of_field_.back();
    const bool may_be_cut = !lines_.ended() && last_role != no_role && !trimmed(fields[last_role]).empty();
    if (may_be_cut && !parse_number(fields[last_role])) {
      lines_.count(notes_.cut_off_last_line, line.data());
      return;
    }
    Sample sample;
    sample.time_s = time_s(fields[time_role]);
    for (std::size_t i = 0; i < inputs_; ++i) sample.inputs.push_back(input(fields[1 + i], i));
    for (std::size_t c = 0; c < channels_; ++c)
      sample.channels.push_back(in_range(fields[1 + inputs_ + c], 1 + inputs_ + c, recording_.columns.channels[c]));
    rows_.push_back({std::move(sample), fields[time_role].data()});
  }

  [[noreturn]] void fail_in_field(std::string_view field, std::size_t role, std::string advice) const {
    const std::string_view token = trimmed(field);
    lines_.fail_at(token.data(), name_of(role), token.empty() ? "(empty)" : token, std::move(advice));
  }

  double number_or_nan(std::string_view field, std::size_t role) const {
    if (trimmed(field).empty()) return not_a_number;
    const std::optional<double> value = parse_number(field);
    if (!value) {
      std::string advice = "must be a number; a missing sample is an empty field or nan";
      if (field.find('"') != std::string_view::npos)
        advice += "\nnames and numbers stand without quotes; `sinew convert --map` reads a file with quotes";
      fail_in_field(field, role, std::move(advice));
    }
    return *value;
  }

  double time_s(std::string_view field) {
    const double value = number_or_nan(field, time_role);
    if (std::isnan(value)) fail_in_field(field, time_role, "every row needs its time");
    if (!format_.milliseconds_of_day) {
      if (std::abs(value) > latest_time_s) fail_in_field(field, time_role, "must lie within 1e10 s of 0");
      return value;
    }
    if (value < 0.0 || value > day_ms) fail_in_field(field, time_role, "must lie in [0, 86400000], a day in ms");
    if (rows_.empty()) {
      first_clock_ms_ = value;
    } else if (value < last_clock_ms_ - day_ms / 2) {
      // Only the clock starting anew takes it back by half a day; a row out of order may take it over again.
      if (++day_ > static_cast<int>(notes_.midnights.count)) lines_.count(notes_.midnights, field.data());
    } else if (value > last_clock_ms_ + day_ms / 2 && day_ > 0) {
      --day_;
    }
    last_clock_ms_ = value;
    return (day_ * day_ms + value - first_clock_ms_) / 1000.0;
  }

  double in_range(std::string_view field, std::size_t role, const Column& column) const {
    const double value = number_or_nan(field, role);
    if (std::isnan(value) || column.range.contains(value)) return value;
    std::string advice = "must lie in [" + shortest(column.range.lowest) + ", " + shortest(column.range.highest) + "]";
    if (!column.unit.empty()) advice += " " + column.unit;
    const bool is_fraction = column.range.lowest == 0.0 && column.range.highest == 1.0;
    if (is_fraction && value > 1.0 && value <= 100.0) advice += "\nif it is in percent, divide it by 100";
    if (is_fraction && value > 1.0 && value <= 255.0 && value == std::round(value)) advice += "\nif it counts to 255, divide it by 255";
    if (is_fraction && value < 0.0) advice += "\nit has no direction: each part that is driven has a column of its own";
    fail_in_field(field, role, std::move(advice));
  }

  double input(std::string_view field, std::size_t i) const {
    const double value = in_range(field, 1 + i, recording_.columns.inputs[i]);
    if (std::isnan(value) && rows_.empty()) fail_in_field(field, 1 + i, "the first row needs a value: there is none before it to hold");
    return value;
  }

  // Rows to samples: what repeats a time or goes back is dropped, a missing input is held.
  void put_in_order() {
    std::vector<double> forward_s;
    forward_s.reserve(rows_.size());
    for (std::size_t i = 1; i < rows_.size(); ++i) {
      const double step_s = rows_[i].sample.time_s - rows_[i - 1].sample.time_s;
      if (step_s > 0.0) forward_s.push_back(step_s);
    }
    if (forward_s.empty()) {
      lines_.fail_on_line(rows_[1].time_field, name_of(time_role), trimmed(field_at(rows_[1].time_field)),
                          "time never moves forward in this file");
    }
    const double tolerated_s = backward_periods * lower_median(std::move(forward_s));

    recording_.samples.reserve(rows_.size());
    time_fields_.reserve(rows_.size());
    for (Row& row : rows_) {
      Sample& sample = row.sample;
      const Sample* const before = recording_.samples.empty() ? nullptr : &recording_.samples.back();
      if (before != nullptr && sample.time_s < before->time_s) {
        if (before->time_s - sample.time_s >= tolerated_s) {
          lines_.fail_at(row.time_field, name_of(time_role), trimmed(field_at(row.time_field)),
                         "goes back by " + shortest(before->time_s - sample.time_s) +
                             " s; two recordings in one file? then cut it in two here");
        }
        lines_.count(notes_.backward_rows, row.time_field);
        continue;
      }
      // The first row has its inputs: read_row saw to it.
      std::vector<std::size_t> held;
      for (std::size_t i = 0; i < inputs_ && before != nullptr; ++i)
        if (std::isnan(sample.inputs[i])) {
          sample.inputs[i] = before->inputs[i];
          held.push_back(i);
        }
      if (before != nullptr && sample.time_s == before->time_s) {
        lines_.count(same_values(sample, *before) ? notes_.repeated_rows : notes_.conflicting_rows, row.time_field);
        continue;
      }
      for (const std::size_t i : held) lines_.count(notes_.held_input[i], row.time_field);
      for (std::size_t c = 0; c < channels_; ++c)
        if (std::isnan(sample.channels[c])) lines_.count(notes_.missing[c], row.time_field);
      recording_.samples.push_back(std::move(sample));
      time_fields_.push_back(row.time_field);
    }
    notes_.rows = recording_.samples.size();
    for (const Sample& sample : recording_.samples) {
      const auto missing = std::count_if(sample.channels.begin(), sample.channels.end(), [](double value) { return std::isnan(value); });
      notes_.full_rows += missing == 0;
      notes_.partial_rows += missing > 0 && static_cast<std::size_t>(missing) < channels_;
    }
    const std::size_t out_of_order = notes_.backward_rows.count + notes_.conflicting_rows.count;
    if (out_of_order >= least_out_of_order && static_cast<double>(out_of_order) > most_out_of_order * static_cast<double>(rows_.size())) {
      const Oddity& first = notes_.backward_rows.count > 0 ? notes_.backward_rows : notes_.conflicting_rows;
      lines_.fail("rows out of order", std::to_string(out_of_order),
                  "of " + std::to_string(rows_.size()) + " rows, the first on line " + std::to_string(first.first_line) +
                      ", go back in time or repeat it: sort the rows by " + name_of(time_role) + ", or cut the file in two");
    }
    if (recording_.samples.size() < 2) {
      lines_.fail("rows in order of time", std::to_string(recording_.samples.size()),
                  "of " + std::to_string(rows_.size()) + " rows; the others go back in time or repeat it");
    }
  }

  void look_at_steps() {
    const double period_s = recording_.median_period_s();
    if (period_s > recording_.columns.longest_period_s)
      lines_.fail(name_of(time_role) + ", median step", shortest(period_s) + " s",
                  "is longer than " + shortest(recording_.columns.longest_period_s) +
                      " s, which such a plant can be followed with: are these milliseconds or microseconds? then divide by 1000 or 1e6");
    const std::vector<Sample>& samples = recording_.samples;
    // Where rows are readings their steps are of any length, and a gap is where no channel is read.
    const bool are_readings = notes_.rows_are_readings();
    const double usual_s = are_readings ? shortest_reading_period_s() : period_s;
    for (std::size_t i = 1; i < samples.size(); ++i) {
      const double step_s = samples[i].time_s - samples[i - 1].time_s;
      if (step_s > gap_periods * usual_s) {
        lines_.count(notes_.gaps, time_fields_[i]);
        notes_.longest_gap_s = std::max(notes_.longest_gap_s, step_s);
      } else if (!are_readings && std::abs(step_s - period_s) > uneven_share * period_s) {
        lines_.count(notes_.uneven_steps, time_fields_[i]);
        const bool first = notes_.uneven_steps.count == 1;
        notes_.shortest_step_s = first ? step_s : std::min(notes_.shortest_step_s, step_s);
        notes_.longest_step_s = first ? step_s : std::max(notes_.longest_step_s, step_s);
      }
    }
  }

  // Of the channel that is read most often: the median time from one reading to the next.
  double shortest_reading_period_s() const {
    double shortest_s = std::numeric_limits<double>::infinity();
    for (std::size_t c = 0; c < channels_; ++c) {
      std::vector<double> steps_s;
      double last_s = std::numeric_limits<double>::quiet_NaN();
      for (const Sample& sample : recording_.samples) {
        if (std::isnan(sample.channels[c])) continue;
        if (!std::isnan(last_s)) steps_s.push_back(sample.time_s - last_s);
        last_s = sample.time_s;
      }
      if (!steps_s.empty()) shortest_s = std::min(shortest_s, lower_median(std::move(steps_s)));
    }
    return shortest_s;
  }

  static bool same_values(const Sample& a, const Sample& b) {
    const auto same = [](double x, double y) { return x == y || (std::isnan(x) && std::isnan(y)); };
    return std::equal(a.inputs.begin(), a.inputs.end(), b.inputs.begin(), same) &&
           std::equal(a.channels.begin(), a.channels.end(), b.channels.begin(), same);
  }

  // The field of the text that begins here.
  std::string_view field_at(const char* at) const {
    const std::string_view text = lines_.text();
    const std::string_view from = text.substr(static_cast<std::size_t>(at - text.data()));
    return from.substr(0, from.find_first_of(",\r\n"));
  }

  Lines& lines_;
  const Format& format_;
  Recording& recording_;
  ReadingNotes& notes_;
  std::size_t inputs_, channels_;
  std::vector<std::size_t> role_of_field_;
  std::vector<std::string_view> fields_;  // of the row that is read, by role
  std::vector<Row> rows_;
  std::vector<const char*> time_fields_;  // of each sample, for line numbers
  double first_clock_ms_ = 0.0, last_clock_ms_ = 0.0;
  int day_ = 0;
};

// The number in at most four digits, for reading.
std::string rounded(double value) {
  std::array<char, 32> digits;
  const auto end = std::to_chars(digits.data(), digits.data() + digits.size(), value, std::chars_format::general, 4);
  return std::string(digits.data(), end.ptr);
}

}  // namespace

bool ReadingNotes::rows_are_readings() const { return 4 * partial_rows > rows && 20 * full_rows < rows; }

std::string ReadingNotes::summary() const {
  std::string text;
  const auto say = [&text](const Oddity& oddity, std::string_view one, std::string_view many, std::string_view rest) {
    if (oddity.count == 0) return;
    text += std::to_string(oddity.count);
    text.append(1, ' ').append(oddity.count == 1 ? one : many).append(rest);
    text.append(oddity.count == 1 ? " (line " : " (first on line ").append(std::to_string(oddity.first_line));
    text.append(")\n");
  };
  say(byte_order_mark, "byte-order mark", "", ", passed over");
  say(windows_line_ends, "line ends", "lines end", " as on Windows, CR LF");
  say(blank_lines, "blank line", "blank lines", ", passed over");
  say(late_comments, "comment", "comments", " below the header, kept with those above it");
  say(unusual_preamble, "preamble", "", " of " + std::to_string(preamble_lines) + " lines where two are usual, kept");
  std::string names;
  for (std::size_t i = 0; i < std::min(extra_column_names.size(), listed_names); ++i) {
    names += (i == 0 ? ": " : ", ") + extra_column_names[i];
  }
  if (extra_column_names.size() > listed_names) names += ", ...";
  say(extra_columns, "extra column", "extra columns", ", not used" + names);
  for (std::size_t i = 0; i < held_input.size(); ++i)
    say(held_input[i], "missing value", "missing values", " of " + input_words[i] + ", the one before held");
  if (rows_are_readings()) {
    text += std::to_string(rows) + " rows, each with readings of some channels:";
    for (std::size_t c = 0; c < missing.size(); ++c)
      text.append(c == 0 ? " " : ", ").append(std::to_string(rows - missing[c].count)).append(" of ").append(channel_words[c]);
    text += "\n";
  }
  for (std::size_t c = 0; c < missing.size() && !rows_are_readings(); ++c)
    say(missing[c], "missing value", "missing values", " of " + channel_words[c] + ", left missing");
  say(repeated_rows, "row repeats", "rows repeat", " the row before, time and values; dropped");
  say(conflicting_rows, "row has", "rows have", " the time of the row before but other values; dropped");
  say(backward_rows, "row goes", "rows go", " back in time by a little; dropped");
  say(midnights, "midnight", "midnights", " at which the logger's clock began anew; time continued");
  const std::string range_s = ", from " + rounded(shortest_step_s) + " to " + rounded(longest_step_s) + " s; kept";
  say(uneven_steps, "uneven step", "uneven steps", " of time" + range_s);
  say(gaps, "gap", "gaps", " in time, the longest of " + rounded(longest_gap_s) + " s; kept");
  say(cut_off_last_line, "last line", "", " cut off in its middle; dropped");
  return text;
}

double Recording::median_period_s() const {
  std::vector<double> steps_s;
  for (std::size_t i = 1; i < samples.size(); ++i) steps_s.push_back(samples[i].time_s - samples[i - 1].time_s);
  return lower_median(std::move(steps_s));
}

std::vector<std::pair<double, double>> pauses_of(const Recording& recording) {
  const double longest_s = pause_periods * recording.median_period_s();
  std::vector<std::pair<double, double>> pauses_s;
  for (std::size_t k = 1; k < recording.samples.size(); ++k) {
    const Sample &before = recording.samples[k - 1], &after = recording.samples[k];
    const bool was_measured = std::any_of(before.channels.begin(), before.channels.end(), [](double value) { return !std::isnan(value); });
    if (after.time_s - before.time_s > longest_s && was_measured) pauses_s.emplace_back(before.time_s, after.time_s);
  }
  return pauses_s;
}

std::vector<Recording> parts_between_pauses(const Recording& recording) {
  const auto pauses_s = pauses_of(recording);
  if (pauses_s.empty()) return {recording};
  std::vector<Recording> parts;
  auto begin = recording.samples.begin();
  for (std::size_t p = 0; p <= pauses_s.size(); ++p) {
    auto end = recording.samples.end();
    if (p < pauses_s.size()) end = std::find_if(begin, end, [&](const Sample& sample) { return sample.time_s > pauses_s[p].first; });
    parts.push_back(
        {.name = recording.name + " from " + shortest(begin->time_s) + " s", .columns = recording.columns, .samples = {begin, end}});
    parts.back().time_zero_s = recording.time_zero_s;
    begin = end;
  }
  return parts;
}

std::optional<double> Recording::begins_s() const {
  if (!time_zero_s || samples.empty()) return std::nullopt;
  return *time_zero_s + samples.front().time_s;
}

double Recording::duration_s() const { return samples.empty() ? 0.0 : samples.back().time_s - samples.front().time_s; }

Columns columns_of(const plant::System& system) {
  Columns columns;
  if (system.averaging_s() > 0.0) columns.longest_period_s = periods_averaged * system.averaging_s();
  for (const auto& input : system.inputs())
    columns.inputs.push_back({input.column, input.words, std::string(input.unit.text), input.range});
  for (const auto& channel : system.channels())
    columns.channels.push_back({channel.column, channel.words, std::string(channel.unit.text), channel.range});
  return columns;
}

std::string time_zero_comment(std::optional<double> time_zero_s) {
  return time_zero_s ? "# " + std::string(time_zero_key) + " " + shortest(*time_zero_s) + "\n" : "";
}

std::string header_of(const Columns& columns) {
  std::string text;
  for (const std::string& name : recording_format(columns).names) text.append(name).append(1, ',');
  text.back() = '\n';
  return text;
}

Recording parse_recording(std::string_view text, std::string name, const Columns& columns) {
  Recording recording{.name = std::move(name), .columns = columns};
  Format format = recording_format(columns);
  const plant::Plant usual = plant::default_plant();
  for (const plant::LoggerFormat& logger : usual.system().loggers()) format.logger_clock = logger.clock_column;
  Lines lines(text, recording.name, recording.notes);
  while (lines.next()) {
    const std::string_view line = lines.line();
    if (line.starts_with('#')) {
      take_comment(lines, line, recording);
    } else if (trimmed(line).empty()) {
      lines.count(recording.notes.blank_lines, line.data());
    } else {
      TableReader(lines, format, recording).read();
      return recording;
    }
  }
  lines.fail("no header", "", "expected the names of the columns: " + list(format.names));
}

Recording parse_logger(std::string_view text, std::string name, const plant::System& system, bool swap_sides) {
  Recording recording{.name = std::move(name), .columns = columns_of(system)};
  ReadingNotes& notes = recording.notes;
  Lines lines(text, recording.name, notes);
  const auto& known = system.loggers();
  if (known.size() < (swap_sides ? 2u : 1u)) lines.fail("no logger is known of this plant", "", "use `sinew convert --map`");
  const plant::LoggerFormat& logger = known[swap_sides ? 1 : 0];
  const Format format = logger_format(logger, recording.columns);
  std::string advice =
      "expected two lines of preamble, then the logger's " + std::to_string(1 + logger.columns.size() + logger.unused.size()) + " columns";
  while (notes.preamble_lines < preamble_search_lines && lines.next()) {
    const std::string_view line = lines.line(), first = first_field(line);
    if (same_name(first, logger.clock_column, false)) {
      if (notes.preamble_lines != logger_preamble_lines) lines.count(notes.unusual_preamble, line.data());
      TableReader(lines, format, recording).read();
      return recording;
    }
    const std::array<std::string_view, 1> wanted{logger.clock_column};
    if (!nearest(first, wanted).empty()) {
      const std::string number = std::to_string(lines.line_number(line.data()));
      advice += "\nline " + number + " begins with " + printable(first) + ": misspelled?";
    }
    if (first == time_column) advice = "this is a recording already: nothing to convert";
    if (!trimmed(line).empty()) recording.comments.push_back(comment_of(line));
    ++notes.preamble_lines;
  }
  lines.fail("no header", "", "none of the first lines begins with " + std::string(logger.clock_column) + '\n' + advice);
}

Recording read_recording(const std::filesystem::path& path, const Columns& columns) {
  return parse_recording(read_file(path), path.string(), columns);
}

Recording read_logger(const std::filesystem::path& path, const plant::System& system, bool swap_sides) {
  return parse_logger(read_file(path), path.string(), system, swap_sides);
}

std::string to_csv(const Recording& recording) {
  std::string text;
  text.reserve(256 + 64 * recording.samples.size());
  text += time_zero_comment(recording.time_zero_s);
  for (const std::string& comment : recording.comments) {
    for (std::size_t start = 0; start <= comment.size();) {
      const std::size_t end = std::min(comment.find('\n', start), comment.size());
      text.append(end > start ? "# " : "#").append(comment, start, end - start).append(1, '\n');
      start = end + 1;
    }
  }
  text += header_of(recording.columns);
  for (const Sample& sample : recording.samples) {
    const auto put = [&](double value) {
      if (!std::isnan(value)) append_shortest(text, value);
      text += ',';
    };
    put(sample.time_s);
    for (const double value : sample.inputs) put(value);
    for (const double value : sample.channels) put(value);
    text.back() = '\n';
  }
  return text;
}

void write_recording(const std::filesystem::path& path, const Recording& recording) { write_file_whole(path, to_csv(recording)); }

}  // namespace sinew::sim

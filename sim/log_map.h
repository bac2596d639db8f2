// SPDX-License-Identifier: Apache-2.0
// A map says what the columns of a logger's file mean: `sinew convert --map`. Reference: docs/convert.md.
//
// The map is read first and by itself: every complaint about it has its place in the map. Applied to a log it gives a
// table that begins with time_s, and notes of everything that was put right, left missing or dropped.
#pragma once

#include <cstddef>
#include <filesystem>
#include <limits>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "sim/log_reader.h"
#include "sim/table.h"
#include "sim/yaml.h"

namespace sinew::sim {

// A factor as it is written: 0.5, or 1/255, which is divided by 255 and not multiplied by what that is nearly.
struct Ratio {
  double numerator = 1.0, denominator = 1.0;
  double times(double value) const { return value * numerator / denominator; }
};

// A column of the file: by its name there, or by its number from 1.
struct LogColumn {
  YamlValue named;         // where the map names it
  std::size_t number = 0;  // 0: by name
  std::vector<double> missing_numbers{};
  std::vector<std::string> missing_words{};
  // A row that repeats the last reading is missing for as long after it; 0: repeats are readings.
  double repeats_missing_s = 0.0;
};

enum class TimeUnit { s, ms, us, ns, min, h, ms_of_day, clock };

struct TimeRule {
  YamlValue at;
  std::optional<LogColumn> column{};  // none: a row each period
  TimeUnit unit = TimeUnit::s;
  Ratio period_s{};
  bool first_row_at_zero = true;
};

// A point that is followed, by the columns of its two coordinates.
struct PointRule {
  std::string name;
  LogColumn x, y;
};

enum class ColumnKind { read, constant, difference, direction };
enum class Outside { error, missing, clip };

struct ColumnRule {
  std::string name;
  YamlValue at;
  bool written = true;  // a helper is not
  ColumnKind kind = ColumnKind::read;
  LogColumn read{};              // read
  double constant = 0.0;         // constant
  std::size_t of = 0, less = 0;  // difference: of - less, places in LogMap::columns
  std::size_t from = 0, to = 0;  // direction, in degrees: places in LogMap::points
  Ratio unit{};                  // value = ((raw in unit + unit_offset) scale + offset), reversed or not, less its zero
  double unit_offset = 0.0;
  Ratio scale{};
  double offset = 0.0;
  bool reversed = false;
  std::size_t zero_rows = 0;  // the median of the first so many samples is zero; 0: as logged
  double lowest = -std::numeric_limits<double>::infinity(), highest = std::numeric_limits<double>::infinity();
  Outside outside = Outside::error;
};

// A pause is a gap in which the logger wrote nothing, and the machine was not left as the last row says.
struct PauseRule {
  double longer_than_s = 0.0;
  std::vector<std::pair<std::size_t, double>> then;      // a column in LogMap::columns, and its value while the pause lasts
  std::vector<std::pair<std::size_t, double>> settling;  // a column, and how long after a pause its samples are missing, in seconds
};

struct LogMap {
  std::string file;
  LogLayout layout{};
  TimeRule time{};
  std::vector<PointRule> points;
  std::vector<ColumnRule> columns;  // helpers among them; in the order of the map
  std::vector<std::size_t> order;   // of computing: what a column is computed from comes before it
  std::optional<PauseRule> pauses;
  // The names in the file that the map asks for.
  std::vector<std::string> wanted_names() const;
};

LogMap parse_log_map(const YamlValue& map);
LogMap read_log_map(const std::filesystem::path& path);

struct Conversion {
  Table table;
  std::string notes;  // a line of plain words, ended by '\n', for each thing that was odd
};

// Throws InputError with the place in the log, and in the map where it names the column.
Conversion apply_log_map(const LogMap& map, const Log& log);
// Both together.
Conversion convert_log(const std::filesystem::path& log, const LogMap& map);

// For how many rows a slow converter repeats each reading: judged where the values change so fast that each new reading differs.
// None where they do so in every row, or too little is there to tell.
std::optional<double> rows_per_reading(const std::vector<double>& values);

// Seconds of a clock, hh:mm:ss or hh:mm:ss.fff, from midnight; with a date before it (2023-04-05 or 2023/04/05, then a space or T),
// from 1970.
struct ClockTime {
  double seconds;
  bool dated;
};
std::optional<ClockTime> parse_clock(std::string_view text);

// The number in so many digits at most, for reading.
std::string rounded(double value, int digits = 4);

}  // namespace sinew::sim

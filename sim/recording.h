// SPDX-License-Identifier: Apache-2.0
// Recordings of a plant, in and out: samples of its inputs and of its channels.
//
// A recording is a CSV file in UTF-8: lines that begin with '#' are comments, then a header that names the columns: time_s, and
// those of the System's lists of inputs and channels, for instance
//
//     time_s,duty_A,duty_B,temperature_A_degC,temperature_B_degC,angle_deg
//
// (in any order, others among them), then rows. An empty field, or nan, is a missing sample. Files are read as they
// are: what is odd about one is either put right and counted in `ReadingNotes`, or an InputError with file, line and
// column. Nothing is dropped without a count. One comment says something to the program: `# time_zero_s: 412.5`, when time_s is 0 on a
// clock that the recordings of a limb share (seconds since 1970, or since anything).
#pragma once

#include <cstddef>
#include <filesystem>
#include <limits>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "plant/system.h"

namespace sinew::sim {

// What the columns of a recording are, beside the time.
struct Column {
  std::string name;   // "temperature_A_degC"
  std::string words;  // "temperature A"
  std::string unit;   // "degC"
  plant::Range range{-1e300, 1e300};
  friend bool operator==(const Column& a, const Column& b) { return a.name == b.name; }
};
struct Columns {
  std::vector<Column> inputs, channels;
  double longest_period_s = std::numeric_limits<double>::infinity();  // a longer median step is no time in seconds
  friend bool operator==(const Columns& a, const Columns& b) { return a.inputs == b.inputs && a.channels == b.channels; }
};
Columns columns_of(const plant::System& system);

// A measurement that is missing is NaN; time and inputs never are. In the units of the file.
struct Sample {
  double time_s = 0.0;
  std::vector<double> inputs;  // held until the next sample, unless the System says that they change in between
  std::vector<double> channels;
};

struct Oddity {
  std::size_t count = 0;
  int first_line = 0;  // of the file, from 1; 0 while the count is 0
};

// What was odd about a file, and put right or passed over in reading it. Counts of missing samples and of steps are
// those of the rows that were kept.
struct ReadingNotes {
  Oddity byte_order_mark;
  Oddity windows_line_ends;  // lines that end in CR LF
  Oddity blank_lines;
  Oddity late_comments;     // comments below the header
  Oddity unusual_preamble;  // logger only: above the header stand not two lines but preamble_lines
  std::size_t preamble_lines = 0;
  Oddity extra_columns;  // neither used nor known
  std::vector<std::string> extra_column_names;
  // Of each input, and of each channel: a missing input is the one before, held.
  std::vector<Oddity> held_input, missing;
  std::vector<std::string> input_words, channel_words;
  std::size_t rows = 0, partial_rows = 0, full_rows = 0;  // that were kept; with readings of some channels; of all
  // Rows are readings of some channels each, at the times at which they were made.
  bool rows_are_readings() const;
  Oddity repeated_rows;          // same time and same values as the row before: dropped
  Oddity conflicting_rows;       // same time, other values: the first is kept, these dropped
  Oddity backward_rows;          // time goes back by less than 10 periods: dropped
  Oddity midnights;              // logger only: the clock started anew from 0
  Oddity uneven_steps;           // off the median period by more than a tenth, and no gap
  double shortest_step_s = 0.0;  // of the uneven ones, and
  double longest_step_s = 0.0;
  Oddity gaps;  // steps of more than 2.5 median periods
  double longest_gap_s = 0.0;
  Oddity cut_off_last_line;  // the file ends in the middle of a row: dropped

  // A line of plain words, ended by '\n', for each oddity that there was; empty when there was none.
  std::string summary() const;
};

struct Recording {
  std::string name;  // where it came from, as messages say it: the path
  Columns columns{};
  std::vector<std::string> comments{};  // without the "# "; logger: the lines above the header
  std::vector<Sample> samples{};        // times finite and strictly increasing
  ReadingNotes notes{};
  // When time_s is 0, on a clock that all recordings share which say it: `# time_zero_s: 412.5` in the file.
  std::optional<double> time_zero_s{};

  // When it begins, on that clock.
  std::optional<double> begins_s() const;

  // The median of the steps between samples (the lower one of two in the middle); NaN with fewer than two samples.
  double median_period_s() const;
  // From the first sample to the last; 0 with fewer than two.
  double duration_s() const;
};

// Reads a recording of at least two rows. An InputError for, among others: a column that is missing or stands
// twice; a row with too few or too many fields; a field that is no number; no time; no input in the first row; a value outside
// its column's range; a time beyond 1e10 s, or one that goes back by 10 median periods or more; NUL bytes. A logger's file is
// told from a recording by name.
// A last line without line end whose last number is cut short to another number cannot be told from a whole one.
Recording read_recording(const std::filesystem::path& path, const Columns& columns);
Recording parse_recording(std::string_view text, std::string name, const Columns& columns);
inline Recording read_recording(const std::filesystem::path& path, const plant::System& system) {
  return read_recording(path, columns_of(system));
}

// Reads the file that the usual logger of such a plant writes (System::loggers): two lines of anything, then its header (matched
// by name, letter case and spaces around commas aside). Time: the clock, milliseconds since midnight, with the first row at
// 0 s, continued over midnight. `swap_sides`: with the sides exchanged. Errors are those of a recording, and a time outside
// [0, 86400000] ms.
Recording read_logger(const std::filesystem::path& path, const plant::System& system, bool swap_sides = false);
Recording parse_logger(std::string_view text, std::string name, const plant::System& system, bool swap_sides = false);

// The recording cut at its pauses: gaps of more than ten median periods. What the inputs were meanwhile nobody knows, nor what state the
// plant was in after it, so that each part needs a start of its own. A gap after a row in which nothing was measured is no pause: with such
// a row a converter says what the inputs are until the next one (`pauses` in its map). Each part has the recording's own time, and, where
// there are several, says in its name from when it is.
inline constexpr double pause_periods = 10.0;
std::vector<Recording> parts_between_pauses(const Recording& recording);
std::vector<std::pair<double, double>> pauses_of(const Recording& recording);  // the times of the samples on both sides

// The recording as such a file, with LF line ends, comments first, a missing sample as an empty field, and every number
// in the shortest form that reads back the same.
std::string to_csv(const Recording& recording);
void write_recording(const std::filesystem::path& path, const Recording& recording);

// "# time_zero_s: 412.5\n"; empty where that is not known.
std::string time_zero_comment(std::optional<double> time_zero_s);
// "time_s,duty_A,...\n"
std::string header_of(const Columns& columns);

}  // namespace sinew::sim

// SPDX-License-Identifier: Apache-2.0
#include "sim/recording.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <filesystem>
#include <limits>
#include <optional>
#include <random>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "plant/limb/limb.h"
#include "sim/input_error.h"
#include "sim/text.h"

namespace sim_recording_test {

namespace fs = std::filesystem;
using namespace sinew::sim;
using namespace std::literals;

namespace {

// The two-coil limb's coils, inputs and thermocouples, and the channel of its angle.
constexpr std::size_t A = 0, B = 1, angle = 2;
const Columns columns = columns_of(*sinew::plant::two_coil_limb());
constexpr double missing = std::numeric_limits<double>::quiet_NaN();
const std::string header = "time_s,duty_A,duty_B,temperature_A_degC,temperature_B_degC,angle_deg\n";
const std::string clock_name = "Timestamp (millisec since midnight today)";
const std::string logger_header =
    clock_name +
    ", Test time, theta_targ, pwm_0, pwm_1, x_251, y_251, x_285, y_285, theta, Tl, Tr, Vl, Vr, Al, Ar, Bl, Br, "
    "T_time, B_time, pctime\n";
const std::string logger_top = "CV Data Logger started on:,2021-03-04\nanything, at all\n" + logger_header;

// A row of the logger: only the columns that are used differ from row to row.
std::string logger_row(const std::string& clock_ms, const std::string& pwm_0, const std::string& pwm_1, const std::string& tl,
                       const std::string& tr, const std::string& bl) {
  return clock_ms + ",0,30," + pwm_0 + ',' + pwm_1 + ",251,1,285,2,12.5," + tl + ',' + tr + ",0,0,0,0," + bl + ",7.5,1,1,1\n";
}

std::string rows(std::initializer_list<const char*> times) {
  std::string text;
  for (const char* time : times) text += std::string(time) + ",0.5,0,20,21,3\n";
  return text;
}

Recording parse(const std::string& text) { return parse_recording(text, "r.csv", columns); }
Recording parse_log(const std::string& text) { return parse_logger(text, "log.csv", *sinew::plant::two_coil_limb()); }

template <class Reader>
std::string message_of(Reader reader, const std::string& text) {
  try {
    reader(text);
  } catch (const InputError& error) {
    return error.what();
  }
  return "nothing was thrown";
}
std::string error_of(const std::string& text) { return message_of(parse, text); }
std::string logger_error_of(const std::string& text) { return message_of(parse_log, text); }

bool same_bits(double a, double b) {
  return std::bit_cast<std::uint64_t>(a) == std::bit_cast<std::uint64_t>(b) || (std::isnan(a) && std::isnan(b));
}

bool same_bits(const Sample& a, const Sample& b) {
  const auto same = [](double x, double y) { return same_bits(x, y); };
  return same_bits(a.time_s, b.time_s) && std::ranges::equal(a.inputs, b.inputs, same) && std::ranges::equal(a.channels, b.channels, same);
}

// What every recording promises, whatever it was read from; empty when it holds.
std::string broken_promise(const Recording& recording) {
  const std::vector<Sample>& samples = recording.samples;
  if (samples.size() < 2) return "fewer than two samples";
  for (std::size_t i = 0; i < samples.size(); ++i) {
    const Sample& sample = samples[i];
    if (!std::isfinite(sample.time_s)) return "a time that is not finite";
    if (i > 0 && !(sample.time_s > samples[i - 1].time_s)) return "time does not increase";
    if (sample.inputs.size() != 2 || sample.channels.size() != 3) return "values that are not there";
    for (const double duty : sample.inputs) {
      if (!(duty >= 0.0 && duty <= 1.0)) return "a duty outside [0, 1]";
    }
    for (const std::size_t j : {A, B}) {
      const double temperature = sample.channels[j];
      if (std::isinf(temperature) || temperature < -273.15) return "an impossible temperature";
    }
    if (std::isinf(sample.channels[angle]) || std::abs(sample.channels[angle]) > 360.0) return "an impossible angle";
  }
  return "";
}

}  // namespace

TEST_CASE("recording: a clean file is read as it stands and has no notes") {
  const Recording r = parse("# from the bench\n#second\n" + header + "0,0.5,0,20,21.25,-3\n0.1,0,0.25,20.5,21,-2.5\n");
  CHECK(r.name == "r.csv");
  CHECK(r.comments == std::vector<std::string>{"from the bench", "second"});
  REQUIRE(r.samples.size() == 2);
  CHECK(r.samples[0].time_s == 0.0);
  CHECK(r.samples[0].inputs == std::vector{0.5, 0.0});
  CHECK(r.samples[0].channels == std::vector{20.0, 21.25, -3.0});
  CHECK(r.samples[1].inputs == std::vector{0.0, 0.25});
  CHECK(r.notes.summary().empty());
}

TEST_CASE("recording: period and duration") {
  const Recording r = parse(header + rows({"1", "1.5", "2", "4", "4.25"}));
  // Steps 0.5, 0.5, 2, 0.25: the lower of the two in the middle, 0.5 and 0.5.
  CHECK(r.median_period_s() == 0.5);
  CHECK(r.duration_s() == 3.25);
  CHECK(std::isnan(Recording{}.median_period_s()));
  CHECK(Recording{}.duration_s() == 0.0);
}

TEST_CASE("recording: columns are found by name, in any order, spaces around them aside") {
  const Recording r = parse(
      "angle_deg, duty_B ,time_s,temperature_B_degC,duty_A,temperature_A_degC\n"
      "-3, 0.25 ,0,21,0.5,20\n-2,0.25,0.1,21,0.5,20\n");
  CHECK(r.samples[0].inputs == std::vector{0.5, 0.25});
  CHECK(r.samples[0].channels == std::vector{20.0, 21.0, -3.0});
  CHECK(r.samples[1].time_s == 0.1);
  CHECK(r.notes.summary().empty());
}

TEST_CASE("recording: extra columns are not used, and are counted by name") {
  const Recording r = parse(
      "time_s,duty_A,duty_B,current_A,temperature_A_degC,temperature_B_degC,angle_deg,note\n"
      "0,0.5,0,what,20,21,3,a\n0.1,0.5,0,ever,20,21,3,\n");
  CHECK(r.notes.extra_columns.count == 2);
  CHECK(r.notes.extra_column_names == std::vector<std::string>{"current_A", "note"});
  CHECK(r.notes.summary() == "2 extra columns, not used: current_A, note (first on line 1)\n");
}

TEST_CASE("recording: missing columns are all named, with what is there and the nearest spelling") {
  CHECK(error_of("# c\ntime_s,dutyA,duty_B,T,temperature_B_degC,angle_deg\n0,0,0,0,0,0\n") ==
        "r.csv:2: missing columns = duty_A, temperature_A_degC\n"
        "  the columns here are: time_s, dutyA, duty_B, T, temperature_B_degC, angle_deg\n"
        "  duty_A: did you mean dutyA?");
  CHECK(error_of("time_s;duty_A;duty_B\n0;0,5;0\n") ==
        "r.csv:1: missing columns = time_s, duty_A, duty_B, temperature_A_degC, temperature_B_degC, angle_deg\n"
        "  the columns here are: time_s;duty_A;duty_B\n"
        "  fields must be separated by ',', and decimals written with '.'; `sinew convert --map` reads other files");
}

TEST_CASE("recording: a column that stands twice is an error") {
  CHECK(error_of("time_s,duty_A,duty_B,temperature_A_degC,temperature_B_degC,angle_deg,duty_A\n" + rows({"0", "1"})) ==
        "r.csv:1:70: column = duty_A\n  stands twice in the header; leave one out");
}

TEST_CASE("recording: a logger's file is told from a recording, and sinew convert is named") {
  CHECK(error_of(logger_top + logger_row("1000", "0", "0", "20", "20", "1")) ==
        "r.csv:1: missing columns = time_s, duty_A, duty_B, temperature_A_degC, temperature_B_degC, angle_deg\n"
        "  this is a file of the logger; `sinew convert` makes a recording of it");
}

TEST_CASE("recording: missing measurements are NaN and counted by channel") {
  const Recording r = parse(header + "0,0.5,0,,21,3\n0.1,0.5,0,nan,NaN,3\n0.2,0.5,0, ,21,\n0.3,0.5,0,20,21,4\n");
  CHECK(std::isnan(r.samples[0].channels[A]));
  CHECK(std::isnan(r.samples[1].channels[B]));
  CHECK(std::isnan(r.samples[2].channels[angle]));
  CHECK(r.samples[3].channels[A] == 20.0);
  CHECK(r.notes.missing[A].count == 3);
  CHECK(r.notes.missing[A].first_line == 2);
  CHECK(r.notes.missing[B].count == 1);
  CHECK(r.notes.missing[B].first_line == 3);
  CHECK(r.notes.missing[angle].count == 1);
  CHECK(r.notes.missing[angle].first_line == 4);
  CHECK(r.notes.summary() ==
        "3 missing values of temperature A, left missing (first on line 2)\n"
        "1 missing value of temperature B, left missing (line 3)\n"
        "1 missing value of angle, left missing (line 4)\n");
}

TEST_CASE("recording: a missing duty is the one before, held, and counted") {
  const Recording r = parse(header + "0,0.5,0.25,20,21,3\n0.1,,0.125,20,21,3\n0.2,nan,,20,21,3\n0.3,0,0,20,21,3\n");
  CHECK(r.samples[1].inputs == std::vector{0.5, 0.125});
  CHECK(r.samples[2].inputs == std::vector{0.5, 0.125});
  CHECK(r.samples[3].inputs == std::vector{0.0, 0.0});
  CHECK(r.notes.summary() ==
        "2 missing values of duty A, the one before held (first on line 3)\n"
        "1 missing value of duty B, the one before held (line 4)\n");
}

TEST_CASE("recording: no duty in the first row is an error") {
  CHECK(error_of(header + "0,0.5,,20,21,3\n" + rows({"0.1"})) ==
        "r.csv:2:7: duty_B = (empty)\n  the first row needs a value: there is none before it to hold");
}

TEST_CASE("recording: a row without a readable time is an error") {
  CHECK(error_of(header + rows({"0"}) + ",0.5,0,20,21,3\n") == "r.csv:3:1: time_s = (empty)\n  every row needs its time");
  CHECK(error_of(header + rows({"0", "nan"})) == "r.csv:3:1: time_s = nan\n  every row needs its time");
  CHECK(error_of(header + rows({"0", "12:30"})) ==
        "r.csv:3:1: time_s = 12:30\n  must be a number; a missing sample is an empty field or nan");
  CHECK(error_of(header + rows({"0", "1e11"})) == "r.csv:3:1: time_s = 1e11\n  must lie within 1e10 s of 0");
}

TEST_CASE("recording: what is no number is an error that points at it") {
  CHECK(error_of("# c\n" + header + rows({"0"}) + "0.1,0.5,0, warm,21,3\n") ==
        "r.csv:4:12: temperature_A_degC = warm\n  must be a number; a missing sample is an empty field or nan");
  CHECK(error_of(header + "0,0.5,0,20,21,inf\n") ==
        "r.csv:2:15: angle_deg = inf\n  must be a number; a missing sample is an empty field or nan");
  // Columns count characters, not bytes: two letters of two bytes each stand before the duty.
  CHECK(error_of("note," + header + "\xc3\xa4\xc3\xb6,0,x,0,20,21,3\n") ==
        "r.csv:2:6: duty_A = x\n  must be a number; a missing sample is an empty field or nan");
}

TEST_CASE("recording: a duty outside [0, 1] is an error, with a hint") {
  CHECK(error_of(header + "0,60,0,20,21,3\n") ==
        "r.csv:2:3: duty_A = 60\n  must lie in [0, 1]\n  if it is in percent, divide it by 100\n"
        "  if it counts to 255, divide it by 255");
  CHECK(error_of(header + "0,60.5,0,20,21,3\n") ==
        "r.csv:2:3: duty_A = 60.5\n  must lie in [0, 1]\n  if it is in percent, divide it by 100");
  CHECK(error_of(header + "0,0,-0.25,20,21,3\n") ==
        "r.csv:2:5: duty_B = -0.25\n  must lie in [0, 1]\n"
        "  it has no direction: each part that is driven has a column of its own");
  CHECK(error_of(header + "0,0,255,20,21,3\n") == "r.csv:2:5: duty_B = 255\n  must lie in [0, 1]\n  if it counts to 255, divide it by 255");
  CHECK(error_of(header + "0,0,256,20,21,3\n") == "r.csv:2:5: duty_B = 256\n  must lie in [0, 1]");
  CHECK(parse(header + "0,0,1,20,21,3\n1,-0,1,20,21,3\n").samples.size() == 2);
}

TEST_CASE("recording: impossible temperatures and angles are errors") {
  CHECK(error_of(header + "0,0,0,-273.16,21,3\n") == "r.csv:2:7: temperature_A_degC = -273.16\n  must lie in [-273.15, 10000] degC");
  CHECK(error_of(header + "0,0,0,20,21,-360.5\n") == "r.csv:2:13: angle_deg = -360.5\n  must lie in [-360, 360] deg");
  CHECK(parse(header + "0,0,0,-273.15,21,360\n1,0,0,20,21,-360\n").samples.size() == 2);
}

TEST_CASE("recording: a row that repeats a time is dropped, alike or not, and counted apart") {
  const Recording r = parse(header + rows({"0", "0.1", "0.1", "0.1"}) + "0.1,0.5,0,20,21,99\n" + rows({"0.2", "0.3"}));
  REQUIRE(r.samples.size() == 4);
  CHECK(r.samples[1].channels[angle] == 3.0);
  CHECK(r.notes.repeated_rows.count == 2);
  CHECK(r.notes.repeated_rows.first_line == 4);
  CHECK(r.notes.conflicting_rows.count == 1);
  CHECK(r.notes.conflicting_rows.first_line == 6);
  CHECK(r.notes.summary() ==
        "2 rows repeat the row before, time and values; dropped (first on line 4)\n"
        "1 row has the time of the row before but other values; dropped (line 6)\n");
}

TEST_CASE("recording: missing fields in a dropped row are not counted as missing samples") {
  const Recording r = parse(header + "0,0.5,0,20,21,3\n0,,,,,\n" + rows({"0.1", "0.2"}));
  CHECK(r.notes.summary() == "1 row has the time of the row before but other values; dropped (line 3)\n");
}

TEST_CASE("recording: a row that goes back in time by a little is dropped and counted") {
  // 0.3 after 1.0 goes back by 7 periods of 0.1 s; 0.9 is still behind.
  const Recording r = parse(header + rows({"0", "0.1", "0.2", "0.3", "0.4", "0.5", "0.6", "0.7", "0.8", "0.9", "1", "0.3", "0.9", "1.1"}));
  CHECK(r.samples.size() == 12);
  CHECK(r.notes.backward_rows.count == 2);
  CHECK(r.notes.backward_rows.first_line == 13);
  CHECK(r.notes.summary() == "2 rows go back in time by a little; dropped (first on line 13)\n");
}

TEST_CASE("recording: rows of which all but one go back in time are an error") {
  CHECK(error_of(header + rows({"0.5", "0.1", "0.2"})) ==
        "r.csv: rows in order of time = 1\n  of 3 rows; the others go back in time or repeat it");
}

TEST_CASE("recording: time that goes back by ten periods is an error") {
  CHECK(error_of(header + rows({"0", "1", "2", "3", "4", "5", "6", "7", "8", "9", "10", "0", "1"})) ==
        "r.csv:13:1: time_s = 0\n  goes back by 10 s; two recordings in one file? then cut it in two here");
}

TEST_CASE("recording: time that never moves is an error") {
  CHECK(error_of(header + rows({"5", "5", "4"})) == "r.csv:3: time_s = 5\n  time never moves forward in this file");
}

TEST_CASE("recording: a last line cut off in its middle is dropped and counted") {
  const std::string whole = header + rows({"0", "0.1", "0.2"});
  for (const char* cut : {"0", "0.3", "0.3,", "0.3,0.5,0,20,21", "0.3,0.5,0,20,21,-", "0.3,0.5,0,20,21,1e"}) {
    CAPTURE(cut);
    const Recording r = parse(whole + cut);
    CHECK(r.samples.size() == 3);
    CHECK(r.notes.summary() == "1 last line cut off in its middle; dropped (line 5)\n");
  }
}

TEST_CASE("recording: a full last line needs no line end") {
  const Recording r = parse(header + rows({"0", "0.1"}) + "0.2,0.5,0,20,21,4");
  REQUIRE(r.samples.size() == 3);
  CHECK(r.samples[2].channels[angle] == 4.0);
  CHECK(r.notes.summary().empty());
}

TEST_CASE("recording: too few or too many fields elsewhere are an error") {
  CHECK(error_of(header + rows({"0"}) + "0.1,0.5,0,20,21\n" + rows({"0.2"})) ==
        "r.csv:3: fields in this row = 5\n  the header has 6 columns");
  CHECK(error_of(header + rows({"0"}) + "0.1,0.5,0,20,21,3,4,5\n") == "r.csv:3:19: fields in this row = 8\n  the header has 6 columns");
  // No line end does not make a long row a cut one.
  CHECK(error_of(header + rows({"0", "1"}) + "2,0.5,0,20,21,3,4") == "r.csv:4:17: fields in this row = 7\n  the header has 6 columns");
}

TEST_CASE("recording: Windows line ends, a byte-order mark, blank lines and late comments are counted") {
  std::string text = "\xef\xbb\xbf# c\n" + header + "\n" + rows({"0"}) + "# paused\n" + rows({"0.1"}) + "  \n";
  const Recording r = parse(text);
  CHECK(r.comments == std::vector<std::string>{"c", "paused"});
  CHECK(r.samples.size() == 2);
  CHECK(r.notes.summary() ==
        "1 byte-order mark, passed over (line 1)\n"
        "2 blank lines, passed over (first on line 3)\n"
        "1 comment below the header, kept with those above it (line 5)\n");

  std::string windows;
  for (const char c : text) windows += c == '\n' ? std::string("\r\n") : std::string(1, c);
  const Recording w = parse(windows);
  CHECK(w.comments == r.comments);
  CHECK(w.notes.windows_line_ends.count == 7);
  CHECK(w.notes.windows_line_ends.first_line == 1);
  CHECK(w.samples.size() == 2);
  CHECK(w.samples[1].channels[angle] == 3.0);
  CHECK(
      w.notes.summary().starts_with("1 byte-order mark, passed over (line 1)\n"
                                    "7 lines end as on Windows, CR LF (first on line 1)\n"));
  // Columns of an error in the first line do not count the mark.
  CHECK(error_of("\xef\xbb\xbftime_s,time_s\n") == "r.csv:1:8: column = time_s\n  stands twice in the header; leave one out");
}

TEST_CASE("recording: uneven steps and gaps are kept and counted") {
  // Steps 0.1 0.1 0.1 0.08 0.12 0.24 0.1 0.3 0.1, median 0.1: three off by more than 0.01, one longer than 0.25.
  const Recording r = parse(header + rows({"0", "0.1", "0.2", "0.3", "0.38", "0.5", "0.74", "0.84", "1.14", "1.24"}));
  CHECK(r.samples.size() == 10);
  CHECK(r.notes.uneven_steps.count == 3);
  CHECK(r.notes.uneven_steps.first_line == 6);
  CHECK(r.notes.shortest_step_s == doctest::Approx(0.08).epsilon(1e-12));  // rounding of differences
  CHECK(r.notes.longest_step_s == doctest::Approx(0.24).epsilon(1e-12));
  CHECK(r.notes.gaps.count == 1);
  CHECK(r.notes.gaps.first_line == 10);
  CHECK(r.notes.longest_gap_s == doctest::Approx(0.3).epsilon(1e-12));
  CHECK(r.notes.summary() ==
        "3 uneven steps of time, from 0.08 to 0.24 s; kept (first on line 6)\n"
        "1 gap in time, the longest of 0.3 s; kept (line 10)\n");
}

TEST_CASE("recording: a pause cuts it in two, unless the row before says what the inputs are until the next one") {
  Recording recording{.name = "r.csv"};
  for (int k = 0; k < 100; ++k) recording.samples.push_back({k < 50 ? 0.1 * k : 0.1 * k + 40.0, {0.2, 0.0}, {30.0, 30.0, 0.0}});
  const std::vector<Recording> parts = parts_between_pauses(recording);
  REQUIRE(parts.size() == 2);
  CHECK(parts[0].samples.size() == 50);
  CHECK(parts[1].samples.size() == 50);
  CHECK(parts[1].samples.front().time_s == 45.0);  // the recording's own time
  CHECK(parts[1].name == "r.csv from 45 s");
  recording.samples[49].channels = {not_a_number, not_a_number, not_a_number};
  CHECK(parts_between_pauses(recording).size() == 1);
  CHECK(parts_between_pauses(recording)[0].name == "r.csv");
}

TEST_CASE("recording: rows that are readings of a channel each are no missing samples and no uneven steps") {
  // A at 0, 0.1, ..., B 0.03 s later, the angle 0.06 s later; then nothing for half a second.
  std::string text = header;
  const auto row = [&](double time_s, std::string_view readings) { text += shortest(time_s) + ",0.5,0," + std::string(readings) + "\n"; };
  for (int k = 0; k < 30; ++k) {
    const double time_s = 0.1 * k + (k >= 20 ? 0.5 : 0.0);
    row(time_s, "21,,"), row(time_s + 0.03, ",22,"), row(time_s + 0.06, ",,3");
  }
  const Recording r = parse(text);
  CHECK(r.notes.rows_are_readings());
  CHECK(r.notes.summary() ==
        "90 rows, each with readings of some channels: 30 of temperature A, 30 of temperature B, 30 of angle\n"
        "1 gap in time, the longest of 0.54 s; kept (line 62)\n");
  CHECK_FALSE(parse(header + rows({"0", "0.1", "0.2"})).notes.rows_are_readings());
}

TEST_CASE("recording: a file may say when its time is 0, and so do its parts and what is written of it") {
  const std::string table = header + rows({"5", "5.1", "5.2"});
  CHECK_FALSE(parse(table).begins_s());
  const Recording said = parse("# of a session\n# time_zero_s: 1796000000.25\n" + table);
  CHECK(said.time_zero_s.value() == 1796000000.25);
  CHECK(said.begins_s().value() == 1796000005.25);
  CHECK(said.comments == std::vector<std::string>{"of a session"});
  const Recording again = parse(to_csv(said));
  CHECK(again.time_zero_s == said.time_zero_s);
  CHECK(to_csv(again) == to_csv(said));
  Recording paused = said;
  for (int k = 0; k < 50; ++k) paused.samples.push_back({30.0 + 0.1 * k, paused.samples[0].inputs, paused.samples[0].channels});
  const std::vector<Recording> parts = parts_between_pauses(paused);
  REQUIRE(parts.size() == 2);
  CHECK(parts[1].begins_s().value() == 1796000030.25);
  CHECK(error_of("# time_zero_s: noon\n" + table) ==
        "r.csv:1:16: time_zero_s = noon\n  must be a number of seconds, 1e10 at most: when time_s is 0");
  CHECK(error_of("# time_zero_s:\n" + table).find("must be a number of seconds") != std::string::npos);
  CHECK(error_of("# time_zero_s: 1e11\n" + table).find("1e10 at most") != std::string::npos);
  CHECK(error_of("# time_zero_s: 1\n# time_zero_s: 2\n" + table) == "r.csv:2:16: time_zero_s = 2\n  stands twice; leave one out");
}

TEST_CASE("recording: files that are no text are errors") {
  CHECK(error_of(header + "0,0.5,0,2" + "\0"s + ",21,3\n") == "r.csv:2:10: a NUL byte\n  this is not a text file, or it is damaged");
  CHECK(error_of("\xff\xfet") == "r.csv: text in UTF-16\n  save it as UTF-8");
  CHECK(error_of("time_s,duty_A\r0,0\r1,0\r") == "r.csv:1: line ends = CR alone\n  save the file with LF or CR LF at the end of each line");
}

TEST_CASE("recording: an empty file, a header alone and a single row are errors") {
  CHECK(error_of("") == "r.csv: the file is empty\n  expected a header and at least two rows");
  const std::string no_header =
      "r.csv: no header\n  expected the names of the columns: "
      "time_s, duty_A, duty_B, temperature_A_degC, temperature_B_degC, angle_deg";
  CHECK(error_of("# only a comment\n\n") == no_header);
  CHECK(error_of("\xef\xbb\xbf") == no_header);
  CHECK(error_of(header) == "r.csv: rows = 0\n  a recording has at least two rows below its header");
  CHECK(error_of(header + rows({"0"})) == "r.csv: rows = 1\n  a recording has at least two rows below its header");
}

TEST_CASE("recording: written and read again it is the same to the last bit") {
  std::mt19937_64 random(4711);
  const auto fraction = [&] { return static_cast<double>(random() >> 11) * 0x1p-53; };
  Recording r{.name = "made", .columns = columns, .comments = {"seed 4711", "", " indented", "ü"}, .samples = {}};
  double time_s = -1.0 / 3.0;
  for (int i = 0; i < 2000; ++i) {
    time_s += 0.05 + 0.1 * fraction();
    const auto maybe = [&](double value) { return random() % 16 == 0 ? missing : value; };
    r.samples.push_back({.time_s = time_s,
                         .inputs = {fraction(), random() % 2 == 0 ? 0.0 : 1e-300 * fraction()},
                         .channels = {maybe(20.0 + 80.0 * fraction()), maybe(-0.0), maybe(720.0 * fraction() - 360.0)}});
  }
  const std::string text = to_csv(r);
  const Recording back = parse_recording(text, "made", columns);
  CHECK(back.comments == r.comments);
  REQUIRE(back.samples.size() == r.samples.size());
  CHECK(std::equal(r.samples.begin(), r.samples.end(), back.samples.begin(),
                   [](const Sample& a, const Sample& b) { return same_bits(a, b); }));
  CHECK(to_csv(back) == text);
}

TEST_CASE("recording: the bytes that are written") {
  const Recording r{.name = "",
                    .columns = columns,
                    .comments = {"one\ntwo", ""},
                    .samples = {{0.0, {0.5, 0.0}, {20.25, missing, -3.0}}, {0.1, {0.5, 1.0}, {missing, 21.0, missing}}}};
  CHECK(to_csv(r) == "# one\n# two\n#\n" + header + "0,0.5,0,20.25,,-3\n0.1,0.5,1,,21,\n");
}

TEST_CASE("recording: a file on disk, and its path in messages") {
  std::string folder = (fs::temp_directory_path() / "sinew_recording_test_XXXXXX").string();
  REQUIRE(mkdtemp(folder.data()) != nullptr);
  const fs::path file = fs::path(folder) / "a.csv";
  const Recording r = parse(header + rows({"0", "0.1"}));
  write_recording(file, r);
  const Recording back = read_recording(file, columns);
  CHECK(back.name == file.string());
  CHECK(back.samples.size() == 2);
  write_file_whole(file, header);
  CHECK_THROWS_WITH_AS(read_recording(file, columns),
                       (file.string() + ": rows = 0\n  a recording has at least two rows below its header").c_str(), InputError);
  fs::remove_all(folder);
  CHECK_THROWS_WITH_AS(read_logger(file, *sinew::plant::two_coil_limb()),
                       (file.string() + ": cannot read\n  No such file or directory").c_str(), InputError);
}

TEST_CASE("logger: time from the first row on, pwm_0 and Tl as coil A, pwm_1 and Tr as coil B") {
  const std::string text =
      logger_top + logger_row("36000000", "0.5", "0", "27.75", "28.25", "-3.5") + logger_row("36000103", "0", "0.25", "28", "28.5", "-4");
  const Recording r = parse_log(text);
  REQUIRE(r.samples.size() == 2);
  CHECK(r.samples[0].time_s == 0.0);
  CHECK(r.samples[1].time_s == 0.103);
  CHECK(r.samples[0].inputs == std::vector{0.5, 0.0});
  CHECK(r.samples[0].channels == std::vector{27.75, 28.25, -3.5});
  CHECK(r.samples[1].inputs == std::vector{0.0, 0.25});
  CHECK(r.comments == std::vector<std::string>{"CV Data Logger started on:,2021-03-04", "anything, at all"});
  CHECK(r.notes.summary().empty());

  const Recording swapped = parse_logger(text, "log.csv", *sinew::plant::two_coil_limb(), true);
  CHECK(swapped.samples[0].inputs == std::vector{0.0, 0.5});
  CHECK(swapped.samples[0].channels == std::vector{28.25, 27.75, -3.5});
}

TEST_CASE("logger: what is converted reads as a recording with the same samples") {
  const Recording r =
      parse_log(logger_top + logger_row("86399950", "0.1", "0", "27.75", "", "-3.5") + logger_row("48", "0.3", "0.25", "28", "28.5", "-4"));
  const Recording back = parse(to_csv(r));
  CHECK(back.comments == r.comments);
  REQUIRE(back.samples.size() == 2);
  CHECK(same_bits(back.samples[0], r.samples[0]));
  CHECK(same_bits(back.samples[1], r.samples[1]));
}

TEST_CASE("logger: the names of columns may differ in letter case and spaces") {
  std::string upper = logger_top;
  std::transform(upper.begin(), upper.end(), upper.begin(),
                 [](char c) { return c >= 'a' && c <= 'z' ? static_cast<char>(c - 'a' + 'A') : c; });
  std::erase(upper, ' ');
  // Spaces within a name are part of it.
  const std::size_t at = upper.find("TIMESTAMP");
  upper.replace(at, upper.find(',', at) - at, "TIMESTAMP (MILLISEC SINCE MIDNIGHT TODAY)");
  const Recording r = parse_log(upper + logger_row("0", "0.5", "0", "20", "21", "3") + logger_row("100", "0.5", "0", "20", "21", "3"));
  CHECK(r.samples.size() == 2);
  CHECK(r.notes.extra_column_names == std::vector<std::string>{"TESTTIME"});
}

TEST_CASE("logger: midnight is passed, and counted") {
  std::string text = logger_top;
  for (const char* ms : {"86399800", "86399900", "0", "100"}) text += logger_row(ms, "0.5", "0", "20", "21", "3");
  const Recording r = parse_log(text);
  REQUIRE(r.samples.size() == 4);
  CHECK(r.samples[1].time_s == 0.1);
  CHECK(r.samples[2].time_s == 0.2);
  CHECK(r.samples[3].time_s == 0.3);
  CHECK(r.notes.summary() == "1 midnight at which the logger's clock began anew; time continued (line 6)\n");
}

TEST_CASE("logger: a row out of order across midnight goes back by a little, not by a day") {
  std::string text = logger_top;
  for (const char* ms : {"86399800", "86399900", "0", "86399950", "100"}) {
    text += logger_row(ms, "0.5", "0", "20", "21", "3");
  }
  const Recording r = parse_log(text);
  REQUIRE(r.samples.size() == 4);
  CHECK(r.samples[3].time_s == 0.3);
  CHECK(r.notes.midnights.count == 1);
  CHECK(r.notes.backward_rows.count == 1);
  CHECK(r.notes.backward_rows.first_line == 7);
}

TEST_CASE("logger: errors name the logger's columns and point at them") {
  const std::string row = logger_row("1000", "0.5", "0", "20", "21", "3");
  CHECK(logger_error_of(logger_top + row + logger_row("1100", "-0.5", "0", "20", "21", "3")) ==
        "log.csv:5:11: pwm_0 = -0.5\n  must lie in [0, 1]\n"
        "  it has no direction: each part that is driven has a column of its own");
  CHECK(logger_error_of(logger_top + row + logger_row("86400001", "0.5", "0", "20", "21", "3")) ==
        "log.csv:5:1: Timestamp (millisec since midnight today) = 86400001\n"
        "  must lie in [0, 86400000], a day in ms");
  std::string without = logger_top + row;
  without.replace(without.find(" Bl,"), 4, "B1,");
  CHECK(logger_error_of(without) ==
        "log.csv:3: missing column = Bl\n"
        "  the columns here are: " +
            clock_name +
            ", Test time, theta_targ, pwm_0, pwm_1, x_251, y_251, x_285, "
            "y_285, theta, Tl, Tr, Vl, Vr, Al, Ar, B1, Br, T_time, B_time, pctime\n"
            "  Bl: did you mean B1?");
  CHECK(logger_error_of(header + rows({"0", "0.1"})) ==
        "log.csv: no header\n  none of the first lines begins with " + clock_name + "\n  this is a recording already: nothing to convert");
  CHECK(logger_error_of("a\nb\nTimestamp (milisec since midnight today),pwm_0\n1,2\n") ==
        "log.csv: no header\n  none of the first lines begins with " + clock_name +
            "\n  expected two lines of preamble, then the logger's 21 columns"
            "\n  line 3 begins with Timestamp (milisec since midnight today): misspelled?");
}

TEST_CASE("logger: a preamble of another length is read, and counted") {
  const Recording r = parse_log("a\nb\nc\n" + logger_header + logger_row("0", "0.5", "0", "20", "21", "3") +
                                logger_row("100", "0.5", "0", "20", "21", "3"));
  CHECK(r.comments == std::vector<std::string>{"a", "b", "c"});
  CHECK(r.notes.summary() == "1 preamble of 3 lines where two are usual, kept (line 4)\n");
}

TEST_CASE("logger: a last line cut off in its middle is dropped, as in a recording") {
  const std::string row = logger_row("1000", "0.5", "0", "20", "21", "3");
  const Recording r = parse_log(logger_top + row + logger_row("1100", "0.5", "0", "20", "21", "3") + "1200,0,30,0.5");
  CHECK(r.samples.size() == 2);
  CHECK(r.notes.summary() == "1 last line cut off in its middle; dropped (line 6)\n");
}

namespace {

// One to four changes, at places that the generator picks: of bits, bytes, tokens and lines.
std::string mutated(std::string text, std::mt19937_64& random) {
  const auto below = [&](std::size_t bound) { return bound == 0 ? 0 : static_cast<std::size_t>(random() % bound); };
  // Separated by bars.
  static constexpr std::string_view troubles =
      "nan|inf|-|1e999|1e-320|-0|,|,,|\n|\r\n|\r|#|\"|\0|\xff| |\t|0|1|-274|1e10|time_s|T|Tl|duty_A|\xef\xbb\xbf|0.5,0|"
      "1;2|86400000|+0.1|0x1|361|9007199254740993"sv;
  std::vector<std::string> pieces;
  for (std::size_t start = 0; start < troubles.size(); start += pieces.back().size() + 1) {
    pieces.emplace_back(troubles.substr(start, troubles.find('|', start) - start));
  }
  for (std::size_t changes = 1 + below(4); changes > 0 && !text.empty(); --changes) {
    const std::size_t at = below(text.size());
    switch (below(7)) {
      case 0:  // a bit
        text[at] = static_cast<char>(static_cast<unsigned char>(text[at]) ^ (1u << below(8)));
        break;
      case 1:  // the end
        text.resize(at);
        break;
      case 2:  // a stretch, twice
        text.insert(below(text.size()), text.substr(at, below(80)));
        break;
      case 3:  // bytes that make trouble
        text.insert(at, pieces[below(pieces.size())]);
        break;
      case 4:  // a stretch, gone
        text.erase(at, 1 + below(20));
        break;
      case 5: {  // a token, replaced
        const std::size_t end = std::min(text.find_first_of(",\n", at), text.size());
        text.replace(at, end - at, pieces[below(pieces.size())]);
        break;
      }
      default: {  // two tokens, swapped
        const std::size_t other = at + below(text.size() - at);
        const std::size_t end = std::min({text.find_first_of(",\n", at), text.size(), other});
        const std::size_t other_end = std::min(text.find_first_of(",\n", other), text.size());
        const std::string first = text.substr(at, end - at), second = text.substr(other, other_end - other);
        text.replace(other, second.size(), first).replace(at, first.size(), second);
      }
    }
  }
  return text;
}

template <class Reader>
void fuzz(Reader reader, const std::string& text, std::uint64_t seed) {
  std::mt19937_64 random(seed);
  int read = 0, refused = 0;
  for (int i = 0; i < 20000; ++i) {
    const std::string input = mutated(text, random);
    std::string wrong;
    std::optional<Recording> recording;
    try {
      recording = reader(input);
      ++read;
    } catch (const InputError& error) {
      if (error.file.empty() || error.key.empty()) wrong = "an error without file or key";
      ++refused;
    }
    if (recording) {
      wrong = broken_promise(*recording);
      // What could be read can be written and read again; an error here ends the test.
      if (wrong.empty() && parse(to_csv(*recording)).samples.size() != recording->samples.size()) wrong = "round trip";
    }
    if (!wrong.empty()) {
      CAPTURE(i);
      CAPTURE(input);
      FAIL(wrong);
    }
  }
  // Both outcomes happen often, or the mutations test nothing.
  CHECK(read > 1000);
  CHECK(refused > 1000);
}

}  // namespace

TEST_CASE("recording: damaged files give a recording that keeps its promises, or an InputError") {
  fuzz(parse,
       "# a comment\n# another\n" + header + rows({"0", "0.1", "0.2", "0.31", "0.4"}) +
           "0.5,,0.25,nan,21.5,-12.03125\n0.6,0.599,1,98.25,,1e-3\r\n" + rows({"0.7", "0.8", "0.9", "1.5"}),
       1);
}

TEST_CASE("logger: damaged files give a recording that keeps its promises, or an InputError") {
  std::string text = logger_top;
  for (const char* ms : {"86399700", "86399801", "86399900", "1", "102", "199"}) {
    text += logger_row(ms, "0.5", "0", "20.25", "21", "-3.03125");
  }
  fuzz(parse_log, text, 2);
}

TEST_CASE("recording: the recordings of the physical limb are read, where they are at hand") {
  const fs::path folder = fs::path(SINEW_SOURCE_DIR) / ".." / "shared" / "data";
  std::vector<fs::path> files;
  if (fs::is_directory(folder)) {
    for (const fs::directory_entry& entry : fs::directory_iterator(folder)) {
      const std::string file = entry.path().filename().string();
      if (file.starts_with("paper_limb_") && file.ends_with(".csv")) files.push_back(entry.path());
    }
  }
  if (files.empty()) MESSAGE("no recordings in " << folder.string() << ": skipped");
  std::sort(files.begin(), files.end());
  for (const fs::path& file : files) {
    CAPTURE(file.string());
    const Recording r = read_recording(file, columns);
    CHECK(broken_promise(r).empty());
    CHECK(r.samples.size() > 1000);
    CHECK(r.median_period_s() == doctest::Approx(0.1).epsilon(1e-9));  // sampled at 10 Hz; rounding of differences
    const Recording back = parse_recording(to_csv(r), r.name, columns);
    CHECK(back.comments == r.comments);
    CHECK(std::equal(r.samples.begin(), r.samples.end(), back.samples.begin(), back.samples.end(),
                     [](const Sample& a, const Sample& b) { return same_bits(a, b); }));
    MESSAGE(file.filename().string() << ": " << r.samples.size() << " samples\n" << r.notes.summary());
  }
}

}  // namespace sim_recording_test

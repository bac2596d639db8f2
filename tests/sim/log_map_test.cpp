// SPDX-License-Identifier: Apache-2.0
#include "sim/log_map.h"
#include "plant/systems.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <limits>
#include <string>
#include <vector>

#include "sim/input_error.h"
#include "sim/recording.h"
#include "sim/text.h"

namespace sim_log_map_test {

namespace fs = std::filesystem;
using namespace sinew::sim;

namespace {

const fs::path source = SINEW_SOURCE_DIR;
const fs::path data = source.parent_path() / "shared" / "data";

LogMap map_of(const std::string& text) { return parse_log_map(parse_yaml(text, "m.yaml")); }

Conversion convert(const std::string& map, const std::string& log) {
  const LogMap parsed = map_of(map);
  return apply_log_map(parsed, parse_text_log(log, "log.csv", parsed.layout, parsed.wanted_names()));
}

// The values of a column as text, with spaces; "-" is missing.
std::string values(const Conversion& conversion, const std::string& name) {
  const TableColumn* column = conversion.table.find(name);
  if (column == nullptr) return "no such column";
  std::string text;
  for (const double value : column->values) {
    text += (text.empty() ? "" : " ") + (std::isnan(value) ? "-" : rounded(value, 6));
  }
  return text;
}

template <class Action>
std::string error_of(Action action) {
  try {
    action();
  } catch (const InputError& error) {
    return error.what();
  }
  return "nothing was thrown";
}
std::string map_error(const std::string& map) {
  return error_of([&] { map_of(map); });
}
std::string error(const std::string& map, const std::string& log) {
  return error_of([&] { convert(map, log); });
}

// A map with these columns, of a file whose time is t.
std::string with_columns(const std::string& columns) { return "format: 1\ntime: t\ncolumns:\n" + columns; }

}  // namespace

TEST_CASE("map: columns by name, in the map's order, time first") {
  const Conversion c = convert("format: 1\ntime: t\ncolumns: {level_V: {column: L}, duty_A: pwm}\n", "pwm,t,L\n0.5,3,20\n0.25,3.5,21\n");
  CHECK(to_csv(c.table) == "time_s,level_V,duty_A\n0,20,0.5\n0.5,21,0.25\n");
  CHECK(c.notes.empty());
}

TEST_CASE("map: columns by number, in a file without a header") {
  const Conversion c = convert("format: 1\nfile: {header: false}\ntime: 1\ncolumns: {angle_deg: {column: 3}}\n", "0,9,1\n1,9,2\n");
  CHECK(values(c, "angle_deg") == "1 2");
}

TEST_CASE("map: letter case decides only between names that differ by nothing else") {
  CHECK(values(convert(with_columns("  angle_deg: ANGLE\n"), "t,angle\n0,1\n1,2\n"), "angle_deg") == "1 2");
  CHECK(values(convert(with_columns("  angle_deg: b\n"), "t,B,b\n0,1,3\n1,2,4\n"), "angle_deg") == "3 4");
}

TEST_CASE("map: scale, offset, sense") {
  const std::string log = "t,x\n0,10\n1,20\n";
  CHECK(values(convert(with_columns("  y_V: {column: x, scale: 0.5, offset: -1, sense: reversed}\n"), log), "y_V") == "-4 -9");
  // A ratio is divided: 49/49 is 1, and 49 times the double nearest 1/49 is not.
  CHECK(convert(with_columns("  duty: {column: x, scale: 1/49}\n"), "t,x\n0,49\n1,0\n").table.find("duty")->values[0] == 1.0);
}

TEST_CASE("map: units are converted to the one that ends the column's name") {
  const std::string log = "t,x\n0,0\n1,180\n";
  CHECK(values(convert(with_columns("  a_rad: {column: x, unit: deg}\n"), log), "a_rad") == "0 3.14159");
  CHECK(values(convert(with_columns("  a_deg: {column: x, unit: rad}\n"), "t,x\n0,0\n1,1\n"), "a_deg") == "0 57.2958");
  CHECK(values(convert(with_columns("  T_degC: {column: x, unit: K}\n"), "t,x\n0,273.15\n1,300\n"), "T_degC") == "0 26.85");
  CHECK(values(convert(with_columns("  T_degC: {column: x, unit: degF}\n"), "t,x\n0,32\n1,212\n"), "T_degC") == "0 100");
  CHECK(values(convert(with_columns("  duty_A: {column: x, unit: counts_255}\n"), "t,x\n0,255\n1,51\n"), "duty_A") == "1 0.2");
  CHECK(values(convert(with_columns("  duty_A: {column: x, unit: percent}\n"), "t,x\n0,100\n1,5\n"), "duty_A") == "1 0.05");
  CHECK(values(convert(with_columns("  p_m: {column: x, unit: mm}\n"), log), "p_m") == "0 0.18");
  CHECK(map_error(with_columns("  duty_A: {column: x, unit: percnt}\n")) ==
        "m.yaml:4:29: columns.duty_A.unit = percnt\n"
        "  for duty_A must be one of: fraction, percent, counts_255, counts_1023, counts_4095, counts_65535; did you mean percent?\n"
        "  or use `scale` and `offset`");
  CHECK(map_error(with_columns("  speed: {column: x, unit: mm}\n")) ==
        "m.yaml:4:28: columns.speed.unit = mm\n"
        "  the name speed ends in no unit that one can be converted to; use `scale` and `offset`");
}

TEST_CASE("map: values that mean missing, by number and by word") {
  const Conversion c =
      convert(with_columns("  x_V: {column: x, missing: [-999, ERR]}\n  y_V: y\n"), "t,x,y\n0,1,5\n1,-999.0,-999\n2,err,\n3,4,5\n");
  CHECK(values(c, "x_V") == "1 - - 4");
  CHECK(values(c, "y_V") == "5 -999 - 5");
  CHECK(c.notes == "x_V: 2 missing samples, left missing (first on line 3)\ny_V: 1 missing sample, left missing (line 4)\n");
}

TEST_CASE("map: what happens in a pause that was not logged") {
  const std::string map =
      "format: 1\ntime: t\ncolumns: {duty_A: d, angle_deg: a}\n"
      "pauses: {longer_than_s: 5, then: {duty_A: 0}, settling: {angle_deg: 1.5}}\n";
  const Conversion c = convert(map, "t,d,a\n0,0.1,1\n1,0.2,2\n11,0.3,3\n12,0.4,4\n13,0.5,5\n17,0.6,6\n");
  CHECK(values(c, "time_s") == "0 1 2 11 12 13 17");
  CHECK(values(c, "duty_A") == "0.1 0.2 0 0.3 0.4 0.5 0.6");
  CHECK(values(c, "angle_deg") == "1 2 - - - 5 6");
  CHECK(c.notes.find("1 pause of more than 5 s, each with a row of its own as the map says\n") != std::string::npos);
  CHECK(map_error("format: 1\ntime: t\ncolumns: {duty_A: d}\npauses: {longer_than_s: 5, then: {duty_a: 0}}\n") ==
        "m.yaml:4:35: pauses.then.duty_a\n  no such column in `columns`; did you mean duty_A?");
  CHECK(map_error("format: 1\ntime: t\ncolumns: {duty_A: d}\npauses: {longer_than_s: 0, then: {duty_A: 0}}\n") ==
        "m.yaml:4:25: pauses.longer_than_s = 0\n  must be greater than 0");
  CHECK(map_error("format: 1\ntime: t\ncolumns: {duty_A: d}\npauses: {longer_than_s: 5, then: {duty_A: 3}}\n") ==
        "m.yaml:4:43: pauses.then.duty_A = 3\n  must lie in [0, 1]");
  CHECK(map_error("format: 1\ntime: t\ncolumns: {duty_A: d}\npauses: {longer_than_s: 5}\n").find("pauses.then") != std::string::npos);
}

TEST_CASE("map: time in its units, the first row at 0") {
  const auto times = [](const std::string& time, const std::string& a, const std::string& b) {
    return values(convert("format: 1\ntime: " + time + "\ncolumns: {x_V: x}\n", "t,x\n" + a + ",1\n" + b + ",2\n"), "time_s");
  };
  CHECK(times("{column: t, unit: s}", "15", "15.5") == "0 0.5");
  CHECK(times("{column: t, unit: s, first_row: as_logged}", "15", "15.5") == "15 15.5");
  CHECK(times("{column: t, unit: ms}", "1902", "2009") == "0 0.107");
  CHECK(times("{column: t, unit: us}", "10", "1000010") == "0 1");
  CHECK(times("{column: t, unit: min}", "1", "1.5") == "0 30");
  CHECK(times("{column: t, unit: h}", "1", "2") == "0 3600");
  CHECK(times("{column: t, unit: ms_of_day}", "86399900", "100") == "0 0.2");
  CHECK(times("{column: t, unit: clock}", "10:30:48.949", "10:31:00") == "0 11.051");
  CHECK(times("{column: t, unit: clock}", "23:59:59", "0:00:01") == "0 2");
  CHECK(times("{column: t, unit: clock}", "2023-12-31 23:59:59", "2024-01-01T00:00:01.5Z") == "0 2.5");
  CHECK(times("{period_s: 1/4}", "7", "7") == "0 0.25");
}

TEST_CASE("map: clocks") {
  CHECK(parse_clock("1:02:03")->seconds == 3723.0);
  CHECK(parse_clock("01:02")->seconds == 3720.0);
  CHECK(parse_clock("1970-01-02 00:00:01")->seconds == 86401.0);
  for (const char* wrong :
       {"", "12", "1:2:3", "25:00:00", "10:60:00", "10:00:61", "10:00:00x", "2023-02-30 10:00:00", "10:00:-1", "a:b:c"}) {
    CAPTURE(wrong);
    CHECK_FALSE(parse_clock(wrong).has_value());
  }
}

TEST_CASE("map: over midnight a clock goes on, also for a row out of order") {
  const Conversion c = convert("format: 1\ntime: {column: t, unit: ms_of_day}\ncolumns: {x_V: x}\n",
                               "t,x\n86399800,1\n86399900,2\n50,3\n86399950,4\n150,5\n");
  CHECK(values(c, "time_s") == "0 0.1 0.25 0.35");
  CHECK(values(c, "x_V") == "1 2 3 5");
  CHECK(c.notes ==
        "1 row goes back in time by a little; dropped (line 5)\n"
        "1 midnight at which the logger's clock began anew; time continued (line 4)\n"
        "1 uneven step of time, from 0.15 to 0.15 s; kept (line 4)\n");
}

TEST_CASE("map: when the log's time is 0 becomes when the recording's is") {
  const std::string map = "format: 1\ntime: {column: t, unit: ms}\ncolumns:\n  angle_deg: {column: a}\n";
  const Conversion shifted = convert(map, "# of today\n# time_zero_s: 100\nt,a\n600000,1\n600100,2\n600200,3\n");
  CHECK(shifted.table.comments == std::vector<std::string>{"of today", "time_zero_s: 700"});
}

TEST_CASE("map: repeated, conflicting and backward rows are dropped and counted, gaps are kept") {
  const Conversion c = convert(with_columns("  x_V: x\n"), "t,x,n\n0,1,a\n1,2,b\n1,2,c\n1,3,d\n2,4,e\n1.5,9,f\n3,5,g\n10,6,h\n");
  CHECK(values(c, "time_s") == "0 1 2 3 10");
  CHECK(values(c, "x_V") == "1 2 4 5 6");
  CHECK(c.notes ==
        "1 row repeats the row before, time and values; dropped (line 4)\n"
        "1 row has the time of the row before but other values; dropped (line 5)\n"
        "1 row goes back in time by a little; dropped (line 7)\n"
        "1 gap in time, the longest of 7 s; kept (line 9)\n");
}

TEST_CASE("map: time that goes back far, or never forward, or is not there") {
  std::string log = "t,x\n";
  for (int i = 0; i < 20; ++i) log += std::to_string(i) + ",1\n";
  CHECK(error(with_columns("  x_V: x\n"), log + "3,1\n") ==
        "log.csv:22:1: t = 3\n  goes back by 16 s; two recordings in one file? then cut it in two here\n  m.yaml:2:7: time says so");
  CHECK(error(with_columns("  x_V: x\n"), "t,x\n5,1\n5,2\n4,2\n") ==
        "log.csv:3: time\n  never moves forward in this file\n  m.yaml:2:7: time says so");
  CHECK(error(with_columns("  x_V: x\n"), "t,x\n5,1\n,2\n") ==
        "log.csv:3:1: t = (nothing)\n  every row needs its time\n  m.yaml:2:7: time says so");
  CHECK(error(with_columns("  x_V: x\n"), "t,x\n5,1\n") == "log.csv: rows = 1\n  a recording has at least two rows");
  CHECK(error("format: 1\ntime: {column: t, unit: clock}\ncolumns: {x_V: x}\n", "t,x\n10:00:00,1\n10.5,2\n") ==
        "log.csv:3:1: t = 10.5\n  must be a time such as 10:30:48.949\n  m.yaml:2:7: time says so");
  CHECK(error("format: 1\ntime: {column: t, unit: ms_of_day}\ncolumns: {x_V: x}\n", "t,x\n1,1\n86400001,2\n") ==
        "log.csv:3:1: t = 86400001\n  must lie within a day\n  m.yaml:2:7: time says so");
}

TEST_CASE("map: constants") {
  const Conversion c = convert(with_columns("  duty_B: {constant: 0}\n  x_V: x\n"), "t,x\n0,1\n1,2\n");
  CHECK(values(c, "duty_B") == "0 0");
}

TEST_CASE("map: a difference, of helpers that are not written") {
  const Conversion c = convert(
      "format: 1\ntime: t\nhelpers: {half_V: {column: x, scale: 0.5}}\ncolumns:\n"
      "  d_V: {difference: {of: y_V, less: half_V}}\n  y_V: y\n",
      "t,x,y\n0,2,10\n1,4,\n2,6,30\n");
  CHECK(to_csv(c.table) == "time_s,d_V,y_V\n0,9,10\n1,,\n2,27,30\n");
}

TEST_CASE("map: the direction from point to point is unwrapped over missing rows, and differences begin within half a turn") {
  // Round the origin by 90 degrees a row, one row not seen: 135, 225, (315), 405.
  const std::string log = "t,ax,ay,bx,by\n0,1,1,-9,11\n1,1,1,-9,-9\n2,0,0,5,5\n3,1,1,11,11\n";
  const std::string points = "points: {a: {x: ax, y: ay, missing: 0}, b: {x: bx, y: by}}\n";
  const Conversion c = convert("format: 1\ntime: t\n" + points + "columns: {turn_deg: {direction: {from: a, to: b}}}\n", log);
  CHECK(values(c, "turn_deg") == "135 225 - 405");
  // Base at 170 degrees, tip at -170: the tip is 20 ahead, not 340 behind.
  const Conversion d = convert(
      "format: 1\ntime: t\npoints: {o: {x: ox, y: oy}, a: {x: ax, y: ay}, b: {x: bx, y: by}}\n"
      "helpers: {base_deg: {direction: {from: o, to: a}}, tip_deg: {direction: {from: o, to: b}}}\n"
      "columns: {bend_deg: {difference: {of: tip_deg, less: base_deg}}}\n",
      "t,ox,oy,ax,ay,bx,by\n0,0,0,-0.984807753,0.173648178,-0.984807753,-0.173648178\n1,0,0,-1,0,0,1\n");
  CHECK(d.table.find("bend_deg")->values[0] == doctest::Approx(20.0).epsilon(1e-6));
  CHECK(d.table.find("bend_deg")->values[1] == doctest::Approx(-90.0).epsilon(1e-6));
}

TEST_CASE("map: two points in one place have no direction") {
  const Conversion c = convert(
      "format: 1\ntime: t\npoints: {a: {x: ax, y: ay}, b: {x: bx, y: by}}\n"
      "columns: {turn_deg: {direction: {from: a, to: b}}}\n",
      "t,ax,ay,bx,by\n0,1,1,1,1\n1,1,1,2,1\n");
  CHECK(values(c, "turn_deg") == "- 0");
}

TEST_CASE("map: the zero is the first row that has the value, or the median of several") {
  const std::string log = "t,d,x\n0,0,\n1,0,10\n2,0.5,13\n3,0.5,12\n4,0.5,20\n";
  const Conversion c = convert(with_columns("  duty_A: d\n  x_deg: {column: x, zero: first_row}\n"), log);
  CHECK(values(c, "x_deg") == "- 0 3 2 10");
  CHECK(c.notes == "x_deg: its zero is 10, of the first row that has it (line 3)\nx_deg: 1 missing sample, left missing (line 2)\n");
  const Conversion m = convert(with_columns("  duty_A: d\n  x_deg: {column: x, zero: {median_of_rows: 3}}\n"), log);
  CHECK(values(m, "x_deg") == "- -2 1 0 8");
  CHECK(m.notes ==
        "x_deg: its zero is 12, the median of the first 3 rows that have it (from line 3); not at rest: duty_A is driven 1 s earlier\n"
        "x_deg: 1 missing sample, left missing (line 2)\n");
}

TEST_CASE("map: repeats of a slow converter are missing, and each reading counts once") {
  const std::string log = "t,x\n0,20\n0.2,20\n0.4,21\n0.6,21\n0.8,21\n1.0,21\n1.2,22\n";
  const Conversion all = convert(with_columns("  T_degC: {column: x, repeats: missing}\n"), log);
  CHECK(values(all, "T_degC") == "20 - 21 - - - 22");
  CHECK(all.notes == "T_degC: 4 rows repeat the last reading, of 7; each reading is counted once (first on line 3)\n");
  // A converter of 0.5 s has read 21 twice: at 0.4 s, and again by 1.0 s.
  CHECK(values(convert(with_columns("  T_degC: {column: x, repeats: {reading_every_s: 0.5}}\n"), log), "T_degC") == "20 - 21 - - 21 22");
  CHECK(values(convert(with_columns("  T_degC: {column: x, repeats: readings}\n"), log), "T_degC") == "20 20 21 21 21 21 22");
  // Before a reading is scaled, and over a row that is missing.
  CHECK(values(convert(with_columns("  T_degC: {column: x, scale: 2, repeats: missing}\n"), "t,x\n0,1\n1,\n2,1\n3,2\n"), "T_degC") ==
        "2 - - 4");
}

TEST_CASE("map: a point repeats where both coordinates do") {
  const Conversion c = convert(
      "format: 1\ntime: t\npoints: {a: {x: ax, y: ay, repeats: missing}, b: {x: bx, y: by}}\n"
      "columns: {turn_deg: {direction: {from: a, to: b}}}\n",
      "t,ax,ay,bx,by\n0,1,1,2,1\n1,1,1,2,1\n2,1,0,2,0\n");
  CHECK(values(c, "turn_deg") == "0 - 0");
  CHECK(c.notes ==
        "a: 1 row repeats the last reading, of 3; each reading is counted once (line 3)\n"
        "turn_deg: 1 missing sample, left missing (line 3)\n");
}

TEST_CASE("map: a converter that is slower than the logger is recognised where the values change fast") {
  std::vector<double> slow, every_row, still;
  for (int i = 0; i < 200; ++i) {
    slow.push_back(20.0 + 0.0625 * std::floor(7.3 * std::floor(i / 2.5)));
    every_row.push_back(20.0 + 0.5 * i);
    still.push_back(i < 100 ? 20.0 : 20.0625);
  }
  slow[199] = slow[198] + 0.0625;
  REQUIRE(rows_per_reading(slow).has_value());
  CHECK(*rows_per_reading(slow) == doctest::Approx(2.5).epsilon(0.05));
  CHECK_FALSE(rows_per_reading(every_row).has_value());
  CHECK_FALSE(rows_per_reading(still).has_value());
  std::string log = "t,x\n";
  for (std::size_t i = 0; i < slow.size(); ++i) log += shortest(0.2 * static_cast<double>(i)) + "," + shortest(slow[i]) + "\n";
  CHECK(convert(with_columns("  T_degC: x\n"), log).notes ==
        "T_degC: repeats each reading for about 2.5 rows, as a converter does that is slower than the logger; "
        "`repeats: {reading_every_s: 0.5}` in the map counts each once\n");
}

TEST_CASE("map: a value outside its range is an error with both places, unless the map says otherwise") {
  const std::string log = "t,x\n0,0.5\n1,1.25\n2,-0.5\n";
  CHECK(error(with_columns("  duty_A: x\n"), log) ==
        "log.csv:3:3: x = 1.25\n  duty_A is 1.25 here, and must lie in [0, 1]\n"
        "  is it in percent, or in counts? then say `unit: percent`, or `unit: counts_255`\n"
        "  m.yaml:4:3: columns.duty_A says so; `outside: clip` and `outside: missing` count such values");
  CHECK(error(with_columns("  duty_A: x\n"), "t,x\n0,0\n1,-0.5\n")
            .find("a duty has no direction: each part that is driven has a column of its own") != std::string::npos);
  const Conversion clipped = convert(with_columns("  duty_A: {column: x, outside: clip}\n"), log);
  CHECK(values(clipped, "duty_A") == "0.5 1 0");
  CHECK(clipped.notes == "duty_A: 2 values outside its range, put to its edge (first on line 3)\n");
  const Conversion missing = convert(with_columns("  duty_A: {column: x, outside: missing}\n"), log);
  CHECK(values(missing, "duty_A") == "0.5 - -");
  CHECK(values(convert(with_columns("  duty_A: {column: x, scale: 0.5, offset: 0.25}\n"), log), "duty_A") == "0.5 0.875 0");
  CHECK(error(with_columns("  T_degC: x\n"), "t,x\n0,20\n1,-300\n")
            .starts_with("log.csv:3:3: x = -300\n  T_degC is -300 here, and must lie in [-273.15, inf]\n"));
  CHECK(error(with_columns("  x_deg: {column: x, lowest: 0, highest: 1}\n"), log).starts_with("log.csv:3:3: x = 1.25\n"));
  CHECK(error(with_columns("  x_V: x\n  y_V: {column: x, sense: reversed}\n  d_V: {difference: {of: x_V, less: y_V}, highest: 2}\n"), log)
            .starts_with("log.csv:3: d_V\n  d_V is 2.5 here, and must lie in [-inf, 2]\n"));
}

TEST_CASE("map: a field that is no number has its place in the log and in the map") {
  CHECK(error(with_columns("  x_V: {column: x}\n"), "t, x\n0,1\n1, what\n") ==
        "log.csv:3:4: x = what\n  must be a number; an empty field and nan are missing ones, and what `missing` names\n"
        "  m.yaml:4:17: columns.x_V.column reads it");
  CHECK(error(with_columns("  x_V: x\n"), "t,x\n0,\n1,\n") ==
        "m.yaml:4:3: columns.x_V = x\n  not one sample in log.csv is there: all 2 are missing");
}

TEST_CASE("map: a column that is not there is named with the nearest, and a map that matches nothing says so") {
  const std::string map = with_columns("  x_V: {column: presure}\n  y_V: {column: gone}\n");
  CHECK(error(map, "t,pressure\n0,1\n1,2\n") ==
        "m.yaml:4:17: columns.x_V.column = presure\n  no such column in log.csv:1; did you mean pressure?\n"
        "  its columns are: t, pressure\n  nor is there: gone");
  CHECK(error(with_columns("  x_V: x\n"), "a,b\n0,1\n1,2\n") ==
        "m.yaml:2:7: time = t\n  no such column in log.csv:1\n  its columns are: a, b\n  nor is there: x\n"
        "  the map matches nothing in this file: is it for another logger?");
  CHECK(error(with_columns("  x_V: x\n"), "t;x\n0;1\n1;2\n").find("one column alone: is `delimiter` right?") != std::string::npos);
  CHECK(error(with_columns("  x_V: {column: 5}\n"), "t,x\n0,1\n1,2\n") ==
        "m.yaml:4:17: columns.x_V.column = 5\n  there are 2 columns in log.csv");
  CHECK(error(with_columns("  x_V: {column: x}\n"), "t,x,x\n0,1,1\n1,2,2\n") ==
        "m.yaml:4:17: columns.x_V.column = x\n  stands twice in the header of log.csv, as columns 2 and 3; name it by its number");
}

TEST_CASE("map: variables of a file that is no text") {
  const auto convert_arrays = [](const std::string& map, std::vector<LogArray> arrays) {
    return apply_log_map(map_of(map), array_log(std::move(arrays), "d.mat"));
  };
  const std::vector<LogArray> arrays{{"t", {0.0, 1.0, 2.0}}, {"q", {5.0, 6.0, 1.5}}, {"g", {35.0}},
                                     {"tags[1]", {1, 2, 3}}, {"tags[2]", {4, 5, 6}}, {"short", {1, 2}}};
  CHECK(to_csv(convert_arrays(with_columns("  q_m: q\n  tag_m: {column: \"tags[2]\"}\n"), arrays).table) ==
        "time_s,q_m,tag_m\n0,5,4\n1,6,5\n2,1.5,6\n");
  CHECK(to_csv(convert_arrays("format: 1\ntime: {period_s: 0.5}\ncolumns: {q_m: q}\n", arrays).table) == "time_s,q_m\n0,5\n0.5,6\n1,1.5\n");
  const auto error_of_arrays = [&](const std::string& columns) { return error_of([&] { convert_arrays(with_columns(columns), arrays); }); };
  CHECK(error_of_arrays("  q_m: g\n") == "m.yaml:4:8: columns.q_m = g\n  is a single number in d.mat, not a series; use `constant`");
  CHECK(error_of_arrays("  q_m: short\n") == "m.yaml:4:8: columns.q_m = short\n  has 2 values in d.mat, and t has 3");
  CHECK(error_of_arrays("  q_m: tags\n").find("it is a matrix: name its columns tags[1], tags[2] and so on") != std::string::npos);
  CHECK(error_of_arrays("  q_m: 2\n") ==
        "m.yaml:4:8: columns.q_m = 2\n  this file has variables; name one of them: t, q, g, tags[1], tags[2], short");
  CHECK(error_of_arrays("  q_m: {column: q, highest: 5.5}\n") ==
        "d.mat: q, sample 2 = 6\n  q_m is 6 here, and must lie in [-inf, 5.5]\n"
        "  m.yaml:4:3: columns.q_m says so; `outside: clip` and `outside: missing` count such values");
}

TEST_CASE("map: every mistake in it has its place") {
  const std::string head = "format: 1\ntime: t\n";
  CHECK(map_error("time: t\ncolumns: {x_V: x}\n") == "m.yaml:1:1: format\n  is missing: 1 in this version");
  CHECK(map_error("format: 2\n") == "m.yaml:1:9: format = 2\n  must be 1");
  CHECK(map_error("format: 1\ncolumns: {x_V: x}\n") ==
        "m.yaml:1:1: time\n  is missing: the file's column of time, or `{period_s: ...}` where it has none");
  CHECK(map_error(head) == "m.yaml:1:1: columns\n  is missing: what is written: a name for each column, and where it comes from");
  CHECK(map_error(head + "columns:\n") == "m.yaml:3:1: columns = (nothing)\n  names no column");
  CHECK(map_error(head + "colums: {x_V: x}\ncolumns: {x_V: x}\n") == "m.yaml:3:1: colums\n  no such key here; did you mean columns?");
  CHECK(map_error("format: 1\ntime: {column: t, period_s: 1}\n") ==
        "m.yaml:2:7: time = { a map }\n  needs either `column`, the file's column of time, or `period_s`, where it has none: one row each "
        "period");
  CHECK(map_error("format: 1\ntime: {column: t, unit: msec}\n") ==
        "m.yaml:2:25: time.unit = msec\n  must be one of: s, ms, us, ns, min, h, ms_of_day, clock; did you mean ms?");
  CHECK(map_error("format: 1\ntime: {period_s: 0}\n") == "m.yaml:2:18: time.period_s = 0\n  must be greater than 0");
  CHECK(map_error("format: 1\ntime: {period_s: 1/0}\n") ==
        "m.yaml:2:18: time.period_s = 1/0\n  must be a number, or a ratio such as 1/255");
  CHECK(map_error(head + "columns: {x_V: {}}\n") ==
        "m.yaml:3:11: columns.x_V = { a map }\n"
        "  needs exactly one of `column`, `constant`, `difference`, `direction`: where its values come from");
  CHECK(map_error(head + "columns: {x_V: {colum: x}}\n") == "m.yaml:3:17: columns.x_V.colum\n  no such key here; did you mean column?");
  CHECK(map_error(head + "columns: {x_V: {column: x, scael: 2}}\n") ==
        "m.yaml:3:28: columns.x_V.scael\n  no such key here; did you mean scale?");
  CHECK(map_error(head + "columns: {x_V: {column: x, scale: 0}}\n") == "m.yaml:3:35: columns.x_V.scale = 0\n  must not be 0");
  CHECK(map_error(head + "columns: {x_V: {column: x, constant: 0}}\n").find("needs exactly one of") != std::string::npos);
  CHECK(map_error(head + "columns: {x_V: {column: 0}}\n") == "m.yaml:3:25: columns.x_V.column = 0\n  columns are numbered from 1");
  CHECK(map_error(head + "columns: {x_V: {column: x, lowest: 1, highest: 0}}\n") ==
        "m.yaml:3:48: columns.x_V.highest = 0\n  must be greater than `lowest`, 1");
  CHECK(map_error(head + "columns: {x_V: {column: x, repeats: once}}\n") ==
        "m.yaml:3:37: columns.x_V.repeats = once\n  must be one of: missing, readings");
  CHECK(map_error(head + "columns: {x_V: {column: x, repeats: {reading_every_s: -1}}}\n") ==
        "m.yaml:3:55: columns.x_V.repeats.reading_every_s = -1\n  must be greater than 0");
  CHECK(map_error(head + "columns: {x_V: {column: x, zero: {median_of_rows: 0}}}\n") ==
        "m.yaml:3:51: columns.x_V.zero.median_of_rows = 0\n  must lie in [1, 10000]");
  CHECK(map_error(head + "columns: {time_s: t}\n") == "m.yaml:3:11: columns.time_s = t\n  time_s is written always, and comes from `time`");
  CHECK(map_error(head + "columns: {\"a b\": t}\n") == "m.yaml:3:11: columns.a b = t\n  a column's name has no spaces, commas and quotes");
  CHECK(map_error(head + "columns: {x_V: {constant: 1}}\n") == "nothing was thrown");
  CHECK(map_error("format: 1\ntime: {period_s: 1}\ncolumns: {x_V: {constant: 1}}\n") ==
        "m.yaml:3:10: columns = { a map }\n  nothing of this is read from the file");
  CHECK(map_error(head + "helpers: {x_V: x}\ncolumns: {x_V: x}\n") == "m.yaml:4:11: columns.x_V\n  stands twice; the first is in line 3");
  CHECK(map_error(head + "columns: {x_V: x, d_V: {difference: {of: x_V, less: xV}}}\n") ==
        "m.yaml:3:53: columns.d_V.difference.less = xV\n  no such column in `helpers` or `columns`; did you mean x_V?\n  there are: x_V, "
        "d_V");
  CHECK(map_error(head + "columns: {a_V: {difference: {of: b_V, less: x_V}}, b_V: {difference: {of: x_V, less: a_V}}, x_V: x}\n") ==
        "m.yaml:3:11: columns.a_V = { a map }\n  is computed from itself, through `difference`");
  CHECK(map_error(head + "points: {p: {x: a, y: b}}\ncolumns: {a_deg: {direction: {from: p, to: q}}}\n") ==
        "m.yaml:4:44: columns.a_deg.direction.to = q\n  no such point in `points`\n  there are: p");
  CHECK(map_error(head + "points: {p: {x: a}}\ncolumns: {x_V: x}\n") ==
        "m.yaml:3:13: points.p.y\n  is missing: the column of its second coordinate");
  CHECK(map_error("format: 1\nfile: {delimiter: semikolon}\ntime: t\n") ==
        "m.yaml:2:19: file.delimiter = semikolon\n  must be one of: comma, semicolon, tab, spaces, bar, ,, ;, \\x09,  , |; did you mean "
        "semicolon?");
  CHECK(map_error("format: 1\nfile: {decimal: comma}\ntime: t\n") ==
        "m.yaml:2:17: file.decimal = comma\n  a comma cannot be in the numbers and between them; which delimiter has the file?");
  CHECK(map_error("format: 1\nfile: {text_lines: [\"*\"]}\ntime: t\n") ==
        "m.yaml:2:21: file.text_lines[0] = *\n  this pattern matches every line");
  CHECK(map_error("format: 1\nfile: {lines_before_header: -1}\ntime: t\n") ==
        "m.yaml:2:29: file.lines_before_header = -1\n  must be a number of lines, or `any`, which looks for the header");
  CHECK(map_error("format: 1\nfile: {header: false}\ntime: t\ncolumns: {x_V: 2}\n") ==
        "m.yaml:3:7: time = t\n  the map says `header: false`: columns have numbers, from 1");
}

TEST_CASE("map: the paper's limb is read as the built-in reader reads it") {
  const std::string log =
      "CV Data Logger started on:,2021-03-04\nanything, at all\n"
      "Timestamp (millisec since midnight today), Test time, theta_targ, pwm_0, pwm_1, x_251, y_251, x_285, y_285, theta, Tl, Tr, "
      "Vl, Vr, Al, Ar, Bl, Br, T_time, B_time, pctime\n"
      "86399800,0,30,0.5,0,251,1,285,2,12.5,27.75,28.25,0,0,0,0,-3.5,7.5,1,1,1\n"
      "86399900,0,30,0.5,0.125,251,1,285,2,12.5,nan,28.5,0,0,0,0,-3.25,7.5,1,1,1\n"
      "86399900,0,30,0.5,0.125,251,1,285,2,12.5,nan,28.5,0,0,0,0,-3.25,7.5,1,1,1\n"
      "37,0,30,0,0.25,251,1,285,2,12.5,28.1,28.5,0,0,0,0,,7.5,1,1,1\n"
      "137,0,30,0,0.25,251,1,285,2,12.5,28.1,28.75,0,0,0,0,1e-3,7.5,1,1,1\n";
  const LogMap map = read_log_map(source / "plant/limbs/paper_limb.map.yaml");
  const Conversion mapped = apply_log_map(map, parse_text_log(log, "log.csv", map.layout, map.wanted_names()));
  CHECK(to_csv(mapped.table) == to_csv(parse_logger(log, "log.csv", sinew::plant::default_plant().system())));
}

TEST_CASE("map: those that ship read the data at hand") {
  if (!fs::exists(data)) {
    MESSAGE("SKIPPED: maps on recordings: no " << data.string());
    return;
  }
  const auto with = [&](const char* map, const char* log) { return convert_log(data / log, read_log_map(source / "plant" / map)); };
  for (const auto& [log, driven, end] :
       {std::tuple{"2023-4-5_103045.csv", "limb0_reverse", -1.0}, std::tuple{"2023-4-5_103831.csv", "limb0_forward", 1.0},
        std::tuple{"2023-4-5_104441.csv", "limb1_reverse", -1.0}, std::tuple{"2023-4-5_105056.csv", "limb1_forward", 1.0}}) {
    CAPTURE(log);
    const Conversion lab = with("limbs/lab_two_limbs_2023.map.yaml", (std::string("lab_two_limbs_2023/") + log).c_str());
    REQUIRE(lab.table.columns.size() == 11);
    // The coil that is driven is the one that warms, and its limb bends, forward to positive angles.
    for (const TableColumn& column : lab.table.columns) {
      double highest = -1e9, lowest = 1e9;
      for (const double value : column.values) {
        if (!std::isnan(value)) highest = std::max(highest, value), lowest = std::min(lowest, value);
      }
      const bool of_driven = column.name.find(driven) != std::string::npos;
      CAPTURE(column.name);
      if (column.name.starts_with("duty")) CHECK(highest == (of_driven ? 0.35 : 0.0));
      if (column.name.starts_with("temperature")) CHECK((highest > 50.0) == of_driven);
      if (column.name.starts_with("angle")) {
        const bool of_limb = column.name.substr(6, 5) == std::string(driven).substr(0, 5);
        CHECK((std::max(highest, -lowest) > 12.0) == of_limb);
        if (of_limb) CHECK((highest > -lowest) == (end > 0.0));
      }
    }
  }
  const Conversion walk = with("limbs/two_axis_limb.map.yaml", "two_axis_limb/data_random_walk_stiff_1.csv");
  CHECK(walk.table.rows() == 16951);
  CHECK(walk.table.find("duty_nx")->values.back() == 25.0 / 255.0);
  CHECK(walk.table.find("time_s")->values.back() == doctest::Approx(2921.972));
  for (const char* coil : {"px", "nx", "py", "ny"}) {
    CAPTURE(coil);
    const std::string name = coil;
    const Conversion c =
        with(("limbs/two_axis_limb_calibration_" + name + ".map.yaml").c_str(), ("two_axis_limb/calibration_" + name + ".csv").c_str());
    for (const TableColumn& column : c.table.columns) {
      if (column.name.starts_with("duty")) CHECK(column.values[0] == (column.name == "duty_" + name ? 20.0 / 255.0 : 0.0));
    }
    const auto& bent = c.table.find(name.ends_with("x") ? "angle_x_deg" : "angle_y_deg")->values;
    const auto extreme = std::max_element(bent.begin(), bent.end(), [](double a, double b) { return std::abs(a) < std::abs(b); });
    CHECK((*extreme > 90.0) == name.starts_with("p"));
    CHECK((*extreme < -90.0) == name.starts_with("n"));
  }
  const Conversion emps = with("emps/emps.map.yaml", "emps/DATA_EMPS.mat");
  CHECK(emps.table.rows() == 24841);
  CHECK(emps.table.find("position_m")->values[1] == doctest::Approx(1.43e-5).epsilon(1e-12));
  const Conversion tanks = with("tanks/tanks.map.yaml", "cascaded_tanks/estimation.csv");
  CHECK(tanks.table.find("time_s")->values.back() == 4092.0);
  CHECK(tanks.table.find("level_V")->values[0] == 5.205);
  const Conversion silverbox = with("silverbox/silverbox.map.yaml", "silverbox/multisine.csv");
  CHECK(silverbox.table.find("time_s")->values[6103] == doctest::Approx(6103.0 / 610.35).epsilon(1e-15));
  CHECK(silverbox.table.find("drive_V")->values[0] == 0.005861);
}

}  // namespace sim_log_map_test

// SPDX-License-Identifier: Apache-2.0
#include "sim/log_suggest.h"

#include <doctest/doctest.h>

#include <cmath>
#include <filesystem>
#include <string>

#include "sim/input_error.h"
#include "sim/log_map.h"
#include "sim/text.h"

namespace sim_log_suggest_test {

namespace fs = std::filesystem;
using namespace sinew::sim;

namespace {

// What is suggested for the text, after its two lines of comment; it must be a map that converts the text.
std::string suggested(const std::string& text) {
  const std::string yaml = suggest_text_map(text, "log.csv");
  const LogMap map = parse_log_map(parse_yaml(yaml, "suggested.yaml"));
  CHECK(apply_log_map(map, parse_text_log(text, "log.csv", map.layout, map.wanted_names())).table.rows() >= 2);
  return yaml.substr(yaml.find("format: 1"));
}

}  // namespace

TEST_CASE("suggest: time, duty, temperature, angle and counts are known by name and range") {
  std::string text = "made by a logger\n\nmillis,pwm_duty_left,Temp1,bend angle,PWM_R,limit,note_V\n";
  for (int i = 0; i < 20; ++i) {
    text += std::to_string(100 + 20 * i) + (i < 10 ? ",0.5," : ",0,") + shortest(20.0 + i) + "," + shortest(3.0 * i) + "," +
            (i < 5 ? "0" : "128") + ",115," + shortest(0.1 * i) + "\n";
  }
  CHECK(suggest_text_map(text, "log.csv").find("# 20 rows, 7 columns, a row every 0.02 s in the median (50 Hz)\n") != std::string::npos);
  CHECK(suggested(text) ==
        "format: 1\n"
        "file: {lines_before_header: 2}\n"
        "time: {column: \"millis\", unit: ms}   # 100 to 480\n"
        "columns:\n"
        "  duty_left: {column: \"pwm_duty_left\"}   # 0 to 0.5: looks like a duty\n"
        "  Temp1_degC: {column: \"Temp1\"}   # 20 to 39: looks like a temperature\n"
        "  bend_angle_deg: {column: \"bend angle\"}   # 0 to 57: looks like an angle\n"
        "  duty_R: {column: \"PWM_R\", unit: counts_255}   # 0 to 128: looks like PWM counts of 255\n"
        "  note_V: {column: \"note_V\"}   # 0 to 1.9\n"
        "  # What else is there:\n"
        "  # limit: {column: \"limit\"}   # always 115\n");
}

TEST_CASE("suggest: a duty whose name says percent is in percent, unless it goes beyond 100") {
  std::string text = "time_s,PWM A [%],pwm_b_pct\n";
  for (int i = 0; i < 20; ++i) text += shortest(0.1 * i) + "," + (i < 10 ? "60" : "0") + "," + (i < 10 ? "200" : "0") + "\n";
  const std::string map = suggested(text);
  CHECK(map.find("{column: \"PWM A [%]\", unit: percent}   # 0 to 60: looks like a duty in percent\n") != std::string::npos);
  CHECK(map.find("{column: \"pwm_b_pct\", unit: counts_255}   # 0 to 200: looks like PWM counts of 255\n") != std::string::npos);
}

TEST_CASE("suggest: a header that is not UTF-8 is refused, since no map can name its columns") {
  CHECK_THROWS_WITH_AS(suggest_text_map("time_s;T [\xb0"
                                        "C]\n0;25\n0,1;26\n0,2;27\n",
                                        "log.csv"),
                       doctest::Contains("save the file as UTF-8"), InputError);
}

TEST_CASE("suggest: delimiter, decimal comma, clock, and no header") {
  CHECK(suggested("clock;x\n10:00:00,5;1,25\n10:00:01,5;1,5\n")
            .starts_with("format: 1\nfile: {delimiter: semicolon, decimal: comma}\ntime: {column: \"clock\", unit: clock}"));
  CHECK(suggested("0.0\t5\n0.1\t6\n0.2\t9\n").starts_with("format: 1\nfile: {header: false, delimiter: tab}\ntime: {column: 1, unit: s}"));
  CHECK(suggested("ready\n0 5\nstate 3\n100 6\n200 9\n")
            .starts_with("format: 1\nfile: {header: false, lines_before_rows: 1, delimiter: spaces, text_lines: ignore}\ntime: {column: 1, "
                         "unit: ms}"));
}

TEST_CASE("suggest: points, and a converter that repeats its readings") {
  std::string text = "time_s,tag_x_1,tag_y_1,thermo\n";
  for (int i = 0; i < 120; ++i) {
    const double reading = i == 119 ? 20.0 + 0.0625 * (std::floor(7.3 * 59) + 1) : 20.0 + 0.0625 * std::floor(7.3 * (i / 2));
    text += shortest(0.25 * i) + (i < 3 ? ",0,0," : "," + shortest(100.5 + i) + ",7." + std::to_string(i) + ",") + shortest(reading) + "\n";
  }
  const std::string yaml = suggested(text);
  CHECK(yaml.find("points:\n  tag_1: {x: \"tag_x_1\", y: \"tag_y_1\", missing: 0}\n") != std::string::npos);
  CHECK(yaml.find("  temperature_thermo_degC: {column: \"thermo\", repeats: {reading_every_s: 0.5}}") != std::string::npos);
}

TEST_CASE("suggest: without a column of time it asks for the period, as a comment") {
  const std::string yaml = suggest_text_map("level_V,pump_V\n3,1\n2,1.5\n4,1\n1,9\n", "log.csv");
  CHECK(yaml.find("# time: {period_s: 0.1}\n") != std::string::npos);
  CHECK_THROWS_AS(parse_log_map(parse_yaml(yaml, "s.yaml")), InputError);
}

TEST_CASE("suggest: a file without rows of numbers is an error") {
  try {
    suggest_text_map("dear reader\nno numbers here\n", "letter.txt");
    FAIL("nothing was thrown");
  } catch (const InputError& error) {
    CHECK(std::string(error.what()) == "letter.txt: no rows of numbers\n  in the first 2 lines, whatever delimiter is tried");
  }
}

TEST_CASE("suggest: for the data at hand it prints maps that convert them") {
  const fs::path data = fs::path(SINEW_SOURCE_DIR).parent_path() / "shared" / "data";
  if (!fs::exists(data)) {
    MESSAGE("SKIPPED: suggestions for recordings: no " << data.string());
    return;
  }
  for (const char* name : {"lab_two_limbs_2023/2023-4-5_103045.csv", "two_axis_limb/data_random_walk_stiff_1.csv",
                           "two_axis_limb/calibration_nx.csv", "two_axis_limb/calibration_py.csv", "emps/DATA_EMPS.mat",
                           "cascaded_tanks/estimation.csv", "silverbox/multisine.csv", "paper_limb_bidirectional_0_190s.csv"}) {
    CAPTURE(name);
    const LogMap map = parse_log_map(parse_yaml(suggest_map(data / name), "suggested.yaml"));
    CHECK(convert_log(data / name, map).table.rows() > 1000);
  }
}

}  // namespace sim_log_suggest_test

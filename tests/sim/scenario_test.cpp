// SPDX-License-Identifier: Apache-2.0
#include "sim/scenario.h"

#include <doctest/doctest.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <optional>
#include <set>
#include <string>
#include <variant>
#include <vector>

#include "sim/input_error.h"
#include "sim/text.h"

namespace sim_scenario_test {

namespace fs = std::filesystem;
namespace plant = sinew::plant;
using namespace sinew::sim;

namespace {

// The two-coil limb's coils, inputs and thermocouples, and the channel of its angle.
constexpr std::size_t A = 0, B = 1, angle = 2;

const std::string head = "format: 1\nduration_s: 5\n";

Scenario parse(const std::string& text) { return parse_scenario(text, "s.yaml"); }

template <class Action>
std::string error_of(Action action) {
  try {
    action();
  } catch (const InputError& error) {
    return error.what();
  }
  return "nothing was thrown";
}
std::string parsing_error(const std::string& text) {
  return error_of([&] { parse(text); });
}

class Folder {
 public:
  explicit Folder(const std::string& name = "sinew_scenario_test")
      : path_(fs::temp_directory_path() / (name + "_" + std::to_string(getpid()))) {
    fs::remove_all(path_);
    fs::create_directories(path_);
  }
  ~Folder() { fs::remove_all(path_); }
  fs::path write(const std::string& name, const std::string& text) const {
    fs::create_directories((path_ / name).parent_path());
    std::ofstream(path_ / name) << text;
    return path_ / name;
  }
  const fs::path& path() const { return path_; }

 private:
  fs::path path_;
};

const std::string small_recording =
    "time_s,duty_A,duty_B,temperature_A_degC,temperature_B_degC,angle_deg\n0,0.5,0,20,21,3\n0.1,0.25,0,20,21,3\n";

// What stands beside the scenarios for `dataset`, `train` and `evaluate` is read in tests/model and tests/cli/test_predict.py.
std::vector<fs::path> shipped() {
  const std::set<std::string> others{"domain.yaml", "one_limb.yaml", "stress.yaml", "train.yaml"};
  std::vector<fs::path> files;
  for (const auto& entry : fs::recursive_directory_iterator(fs::path(SINEW_SOURCE_DIR) / "scenarios"))
    if (entry.path().extension() == ".yaml" && !others.count(entry.path().filename().string())) files.push_back(entry.path());
  std::sort(files.begin(), files.end());
  return files;
}

// A scenario with something of everything.
const std::string everything = R"(# First line of what it is for.
#second line
format: 1
seed: 9007199254740993
duration_s: 12.5
sample_period_s: 0.05
plant:
  parameters: { ambient_temperature_degC: 22.0, angle_offset_deg: -1.1 }
  effects:
    thermocouple_lag: { time_constant_s: 1.2 }
    gravity_load: { moment_Nm: 0.01, tilt_deg: 29 }
    viscoelastic_creep: { stiffness_Nm_rad: 0.02, time_constant_s: 25.0 }
    coil_slack: { enabled: true }
start:
  temperature_A_degC: 61.3
  martensite_B_fraction: 0.3
  angle_deg: 7.7
  angular_velocity_deg_s: -29
  viscoelastic_creep.angle_deg: 3.3
input:
  duty_A:
    - constant: { value_fraction: 0.05 }
    - step: { height_fraction: 0.5, from_s: 1.0, until_s: 5.0 }
    - ramp: { first_fraction: 0.0, last_fraction: 0.3, from_s: 5.0, until_s: 6.0 }
    - sine: { mean_fraction: -0.1, amplitude_fraction: 0.3, period_s: 2.0, from_s: 6.0, until_s: 9.0 }
  duty_B:
    - chirp: { mean_fraction: 0.2, amplitude_fraction: 0.1, first_frequency_Hz: 0.1, last_frequency_Hz: 2.0, from_s: 0.0, until_s: 9.0 }
    - prbs: { low_fraction: 0.1, high_fraction: 0.2, hold_s: 0.3, from_s: 9.0, until_s: 12.0 }
sensors:
  temperature_A: { noise_degC: 0.2, step_degC: 0.5, bias_degC: -1.5, dropout_fraction: 0.01 }
  angle: { noise_deg: 0.0, stuck: { from_s: 2.0, until_s: 3.0 } }
numerics: { method: arkode, relative_tolerance: 1.0e-6, restart_period_s: 2.5 }
)";

}  // namespace

TEST_CASE("scenario: every shipped scenario is read, and its resolved form resolves to itself") {
  const std::vector<fs::path> files = shipped();
  REQUIRE(files.size() >= 7);
  bool demo = false;
  for (const fs::path& file : files) {
    CAPTURE(file.string());
    demo = demo || file.filename() == "made_by.yaml";
    const Scenario scenario = read_scenario(file);
    REQUIRE_FALSE(scenario.comments.empty());
    CHECK(scenario.comments.front().size() > 20);
    const std::string resolved = to_yaml(scenario);
    CHECK(to_yaml(parse(resolved)) == resolved);
    CHECK(parse(resolved).plant == scenario.plant);
  }
  CHECK(demo);
}

TEST_CASE("scenario: a scenario with something of everything resolves to itself") {
  const Scenario scenario = parse(everything);
  const std::string resolved = to_yaml(scenario);
  const Scenario back = parse(resolved);
  CHECK(to_yaml(back) == resolved);
  CHECK(back.plant == scenario.plant);
  CHECK(back.start == scenario.start);
  CHECK(resolved.find("  angle_deg: 7.7\n") != std::string::npos);
  CHECK(resolved.find("  angular_velocity_deg_s: -29\n") != std::string::npos);
  CHECK(resolved.find("      tilt_deg: 29\n") != std::string::npos);
}

TEST_CASE("scenario: a start in degrees is the same to the last bit after it was resolved") {
  for (int tenths = -900; tenths <= 900; ++tenths) {
    const std::string degrees = shortest(tenths / 10.0);
    const Scenario scenario = parse(head + "start: { angle_deg: " + degrees + " }\n");
    const Scenario back = parse(to_yaml(scenario));
    REQUIRE(back.start[4].has_value());
    CHECK(*back.start[4] == *scenario.start[4]);
  }
}

TEST_CASE("scenario: every value stands where it was given") {
  const Scenario s = parse(everything);
  CHECK(s.comments == std::vector<std::string>{"First line of what it is for.", "second line"});
  CHECK(s.seed == 9007199254740993);  // 2^53 + 1: not a double
  CHECK(s.duration_s == 12.5);
  CHECK(s.sample_period_s == 0.05);
  CHECK(s.plant.get(s.plant.system().parameter("ambient_temperature_degC")) == 22.0);
  // Core states, then those of the effects in their order: thermocouple_lag's two, then viscoelastic_creep's.
  REQUIRE(s.start.size() == 9);
  CHECK(s.start[0] == 61.3);
  CHECK_FALSE(s.start[1].has_value());
  CHECK(s.start[3] == 0.3);
  CHECK(*s.start[4] == doctest::Approx(7.7 * 0.017453292519943295).epsilon(1e-15));
  CHECK(*s.start[5] == doctest::Approx(-29.0 * 0.017453292519943295).epsilon(1e-15));
  CHECK(*s.start[8] == doctest::Approx(3.3 * 0.017453292519943295).epsilon(1e-15));
  const auto& input = std::get<OpenLoopInput>(s.input);
  REQUIRE(input.signals[A].size() == 4);
  REQUIRE(input.signals[B].size() == 2);
  CHECK(std::get<ConstantSignal>(input.signals[A][0]).value_fraction == 0.05);
  CHECK(std::get<StepSignal>(input.signals[A][1]).until_s == 5.0);
  CHECK(std::get<RampSignal>(input.signals[A][2]).last_fraction == 0.3);
  CHECK(std::get<SineSignal>(input.signals[A][3]).mean_fraction == -0.1);
  CHECK(std::get<ChirpSignal>(input.signals[B][0]).last_frequency_Hz == 2.0);
  CHECK(std::get<PrbsSignal>(input.signals[B][1]).hold_s == 0.3);
  CHECK(s.sensors[A].noise == 0.2);
  CHECK(s.sensors[A].step == 0.5);
  CHECK(s.sensors[A].bias == -1.5);
  CHECK(s.sensors[A].dropout_fraction == 0.01);
  CHECK(s.sensors[B].noise == 0.1);
  CHECK(s.sensors[angle].noise == 0.0);
  CHECK(s.sensors[angle].step == 0.03125);
  REQUIRE(s.sensors[angle].stuck.has_value());
  CHECK(s.sensors[angle].stuck->from_s == 2.0);
  CHECK(s.numerics.method == plant::Method::arkode);
  CHECK(s.numerics.relative_tolerance == 1e-6);
  CHECK(s.restart_period_s == 2.5);
}

TEST_CASE("scenario: what is left out has its default") {
  const Scenario s = parse(head);
  CHECK(s.comments.empty());
  CHECK(s.seed == 1);
  CHECK(s.sample_period_s == 0.1);
  CHECK(s.plant == plant::default_plant());
  CHECK(s.start == std::vector<std::optional<double>>(6));
  for (const auto& of_input : std::get<OpenLoopInput>(s.input).signals) CHECK(of_input.empty());
  // The sensors of docs/plant.md, section 3.
  for (const std::size_t j : {A, B}) {
    CHECK(s.sensors[j].noise == 0.1);
    CHECK(s.sensors[j].step == 0.25);
    CHECK(s.sensors[j].dropout_fraction == 0.0);
    CHECK_FALSE(s.sensors[j].stuck.has_value());
  }
  CHECK(s.sensors[angle].noise == 0.05);
  CHECK(s.sensors[angle].step == 1.0 / 32.0);
  CHECK(s.numerics.method == plant::Method::cvode);
  CHECK(s.numerics.relative_tolerance == 1e-8);
  CHECK(s.restart_period_s == 60.0);
}

TEST_CASE("scenario: babbling has the paper's law unless told otherwise") {
  const Scenario s = parse(head + "input: { babble: { lowest_deg: -45, highest_deg: 45 } }\n");
  const auto& babble = std::get<BabbleInput>(s.input);
  CHECK(babble.shortest_hold_s == 1.0);
  CHECK(babble.longest_hold_s == 30.0);
  CHECK(babble.proportional_gain_1_deg == 0.06);
  CHECK(babble.integral_gain_1_deg_s == 1e-5);
  CHECK(babble.duty_limit_fraction == 0.6);
  CHECK(babble.positive_drives == "A");
  CHECK(babble.both_sides);
  const Scenario other = parse(head + "input: { babble: { lowest_deg: 0, highest_deg: 45, positive_drives: B, both_coils: false } }\n");
  CHECK(std::get<BabbleInput>(other.input).positive_drives == "B");
  CHECK_FALSE(std::get<BabbleInput>(other.input).both_sides);
}

TEST_CASE("scenario: samples are at both ends, and their times are rounded once") {
  Scenario s = parse("format: 1\nduration_s: 60\n");
  CHECK(s.ticks() == 601);
  CHECK(s.time_s(3) == 0.3);  // 3 * 0.1 is 0.30000000000000004
  CHECK(s.time_s(600) == 60.0);
  CHECK(s.restart_ticks() == 600);
  s = parse("format: 1\nduration_s: 0.1\n");
  CHECK(s.ticks() == 2);
  s = parse("format: 1\nduration_s: 1\nsample_period_s: 0.3\nnumerics: { restart_period_s: 0.001 }\n");
  CHECK(s.ticks() == 4);  // 0, 0.3, 0.6, 0.9
  CHECK(s.time_s(2) == 0.6);
  CHECK(s.restart_ticks() == 1);
}

TEST_CASE("scenario: one signal may stand without a list") {
  const Scenario s = parse(head + "input: { duty_B: { constant: { value_fraction: 0.25 } } }\n");
  const auto& input = std::get<OpenLoopInput>(s.input);
  CHECK(input.signals[A].empty());
  REQUIRE(input.signals[B].size() == 1);
  CHECK(std::get<ConstantSignal>(input.signals[B][0]).value_fraction == 0.25);
}

TEST_CASE("scenario: format and duration must be there, and the format be known") {
  CHECK(parsing_error("") == "s.yaml: format\n  is missing: format: 1");
  CHECK(parsing_error("duration_s: 5\n") == "s.yaml:1:1: format\n  is missing: format: 1");
  CHECK(parsing_error("format: 1\n") == "s.yaml:1:1: duration_s\n  is missing: how long the scenario lasts");
  CHECK(parsing_error("format: 2\nlength: 5\n") == "s.yaml:1:9: format = 2\n  must be 1, the format that this version reads");
  CHECK(parsing_error("format: one\nduration_s: 5\n") == "s.yaml:1:9: format = one\n  must be a whole number");
}

TEST_CASE("scenario: an unknown key is an error with the nearest, before what is missing") {
  CHECK(parsing_error("format: 1\nduration_ms: 600\n") == "s.yaml:2:1: duration_ms\n  no such key here; did you mean duration_s?");
  CHECK(parsing_error(head + "sample_period_ms: 100\n") ==
        "s.yaml:3:1: sample_period_ms\n  no such key here; did you mean sample_period_s?");
  CHECK(parsing_error(head + "sensor: {}\n") == "s.yaml:3:1: sensor\n  no such key here; did you mean sensors?");
  CHECK(parsing_error(head + "sensors: { temperature_a: {} }\n") ==
        "s.yaml:3:12: sensors.temperature_a\n  no such key here; did you mean temperature_A?");
  CHECK(parsing_error(head + "sensors: { angle: { noise_degC: 0.1 } }\n") ==
        "s.yaml:3:21: sensors.angle.noise_degC\n  no such key here; did you mean noise_deg?");
  CHECK(parsing_error(head + "sensors: { angle: { stuck: { from_s: 1, til_s: 2 } } }\n") ==
        "s.yaml:3:41: sensors.angle.stuck.til_s\n  no such key here; did you mean until_s?");
  CHECK(parsing_error(head + "numerics: { relative_tolerence: 1e-6 }\n") ==
        "s.yaml:3:13: numerics.relative_tolerence\n  no such key here; did you mean relative_tolerance?");
  CHECK(parsing_error(head + "input: { duty_A: { step: { height: 0.5, from_s: 1, until_s: 2 } } }\n") ==
        "s.yaml:3:28: input.duty_A.step.height\n  no such key here; did you mean height_fraction?");
  CHECK(parsing_error(head + "input: { duty_A: { stp: {} } }\n") ==
        "s.yaml:3:20: input.duty_A.stp\n  no such key here; did you mean step?");
  CHECK(parsing_error(head + "input: { duty_a: { constant: { value_fraction: 1 } } }\n") ==
        "s.yaml:3:10: input.duty_a\n  no such key here; did you mean duty_A?");
  CHECK(parsing_error(head + "input: { replay: { file: x.csv } }\n") ==
        "s.yaml:3:20: input.replay.file\n  no such key here; what may stand here: recording");
  CHECK(parsing_error(head + "input: { babble: { lowest_deg: 0, heighest_deg: 45 } }\n") ==
        "s.yaml:3:35: input.babble.heighest_deg\n  no such key here; did you mean highest_deg?");
}

TEST_CASE("scenario: a signal gives all its values") {
  CHECK(parsing_error(head + "input: { duty_A: { ramp: { first_fraction: 0 } } }\n") ==
        "s.yaml:3:26: input.duty_A.ramp.last_fraction\n  is missing: value at the end");
  CHECK(parsing_error(head + "input: { babble: { lowest_deg: 0 } }\n") == "s.yaml:3:18: input.babble.highest_deg\n  is missing: to here");
  CHECK(parsing_error(head + "input: { replay: {} }\n") ==
        "s.yaml:3:18: input.replay.recording\n  is missing: a recording's file, looked for beside this one");
  CHECK(parsing_error(head + "sensors: { angle: { stuck: { from_s: 1 } } }\n") ==
        "s.yaml:3:28: sensors.angle.stuck.until_s\n  is missing: end");
}

TEST_CASE("scenario: a seed is a whole number and not negative") {
  CHECK(parse(head + "seed: 0\n").seed == 0);
  CHECK(parsing_error(head + "seed: -3\n") == "s.yaml:3:7: seed = -3\n  must not be negative");
  CHECK(parsing_error(head + "seed: 1.5\n") == "s.yaml:3:7: seed = 1.5\n  must be a whole number");
}

TEST_CASE("scenario: numbers out of their ranges are errors with the range") {
  CHECK(parsing_error("format: 1\nduration_s: 0\n") == "s.yaml:2:13: duration_s = 0\n  must lie in [0.1, 1e+06]");
  CHECK(parsing_error("format: 1\nduration_s: 600 s\n") ==
        "s.yaml:2:13: duration_s = 600 s\n  must be a number alone; its unit stands in the key");
  CHECK(parsing_error(head + "sample_period_s: 0\n") == "s.yaml:3:18: sample_period_s = 0\n  must lie in [0.001, 60]");
  CHECK(parsing_error(head + "input: { duty_A: { constant: { value_fraction: 60 } } }\n") ==
        "s.yaml:3:48: input.duty_A.constant.value_fraction = 60\n  must lie in [0, 1]");
  CHECK(parsing_error(head + "sensors: { angle: { dropout_fraction: 1.1 } }\n") ==
        "s.yaml:3:39: sensors.angle.dropout_fraction = 1.1\n  must lie in [0, 1]");
  CHECK(parsing_error(head + "sensors: { angle: { noise_deg: -0.1 } }\n") ==
        "s.yaml:3:32: sensors.angle.noise_deg = -0.1\n  must lie in [0, 100]");
  CHECK(parsing_error(head + "numerics: { relative_tolerance: 0 }\n") ==
        "s.yaml:3:33: numerics.relative_tolerance = 0\n  must lie in [1e-13, 0.01]");
}

TEST_CASE("scenario: more than 20 million samples are too many") {
  CHECK(parsing_error("format: 1\nduration_s: 1.0e6\nsample_period_s: 0.001\n") ==
        "s.yaml:1:1: the file = { a map }\n  more than 20 million samples; shorten duration_s or lengthen sample_period_s");
}

TEST_CASE("scenario: what ends before it begins is an error at its end") {
  CHECK(parsing_error(head + "input: { duty_A: { step: { height_fraction: 0.5, from_s: 5, until_s: 2 } } }\n") ==
        "s.yaml:3:70: input.duty_A.step.until_s = 2\n  must lie after from_s = 5");
  CHECK(parsing_error(head + "input: { duty_A: { ramp: { first_fraction: 0, last_fraction: 1, from_s: 2, until_s: 2 } } }\n") ==
        "s.yaml:3:85: input.duty_A.ramp.until_s = 2\n  must lie after from_s = 2");
  CHECK(parsing_error(head + "sensors: { angle: { stuck: { from_s: 4, until_s: 3 } } }\n") ==
        "s.yaml:3:50: sensors.angle.stuck.until_s = 3\n  must lie after from_s = 4");
  CHECK(parsing_error(head + "input: { babble: { lowest_deg: 5, highest_deg: 2 } }\n") ==
        "s.yaml:3:48: input.babble.highest_deg = 2\n  must lie after lowest_deg = 5");
  CHECK(parsing_error(head + "input: { babble: { lowest_deg: 5, highest_deg: 9, shortest_hold_s: 40 } }\n") ==
        "s.yaml:3:18: input.babble = { a map }\n  shortest_hold_s must lie before longest_hold_s");
}

TEST_CASE("scenario: two inputs at once are an error") {
  const std::string babble = "babble: { lowest_deg: 0, highest_deg: 45 }", duty = "duty_A: { constant: { value_fraction: 0.5 } }",
                    replay = "replay: { recording: r.csv }",
                    complaint = "s.yaml:3:8: input = { a map }\n  one of babble, replay, or duty_A and duty_B";
  CHECK(parsing_error(head + "input: { " + babble + ", " + duty + " }\n") == complaint);
  CHECK(parsing_error(head + "input: { " + babble + ", " + replay + " }\n") == complaint);
  CHECK(parsing_error(head + "input: { " + replay + ", " + duty + " }\n") == complaint);
  CHECK(parsing_error(head +
                      "input: { duty_A: { constant: { value_fraction: 1 }, step: { height_fraction: 1, from_s: 0, until_s: 1 } } }\n") ==
        "s.yaml:3:59: input.duty_A.step = { a map }\n  one signal a map; write a list for a sum of signals");
  CHECK(parsing_error(head + "input: { duty_A: {} }\n") ==
        "s.yaml:3:18: input.duty_A = { a map }\n  must be one of constant, step, ramp, sine, chirp, prbs");
  CHECK(parsing_error(head + "input: { duty_A: 0.5 }\n") == "s.yaml:3:18: input.duty_A = 0.5\n  must be a map");
}

TEST_CASE("scenario: words that are choices are checked") {
  CHECK(parsing_error(head + "numerics: { method: cvodes }\n") ==
        "s.yaml:3:21: numerics.method = cvodes\n  must be cvode, arkode or automatic");
  CHECK(parse(head + "numerics: { method: automatic }\n").numerics.method == plant::Method::automatic);
  CHECK(parsing_error(head + "input: { babble: { lowest_deg: 0, highest_deg: 45, positive_drives: a } }\n") ==
        "s.yaml:3:69: input.babble.positive_drives = a\n  must be A or B");
  CHECK(parsing_error(head + "input: { babble: { lowest_deg: 0, highest_deg: 45, both_coils: yes } }\n") ==
        "s.yaml:3:64: input.babble.both_coils = yes\n  must be true or false");
}

TEST_CASE("scenario: a start names states that the limb has") {
  CHECK(parsing_error(head + "start: { temperatur_A_degC: 80 }\n") ==
        "s.yaml:3:10: start.temperatur_A_degC\n  no such key here; did you mean temperature_A_degC?\n"
        "  a state that is left out is at rest");
  // Creep has a state only where creep is on.
  const std::string creep = "start: { viscoelastic_creep.angle_deg: 2 }\n";
  CHECK(parsing_error(head + creep).starts_with("s.yaml:3:10: start.viscoelastic_creep.angle_deg\n  no such key here"));
  CHECK(parsing_error(head + "plant: { effects: { viscoelastic_creep: { stiffness_Nm_rad: 0.02, time_constant_s: 25 } } }\n" + creep) ==
        "nothing was thrown");
}

TEST_CASE("scenario: an error in the plant points into the scenario") {
  CHECK(parsing_error(head + "plant:\n  effects:\n    thermocouple_lag: { time_constant_s: -1.2 }\n") ==
        "s.yaml:5:42: plant.effects.thermocouple_lag.time_constant_s = -1.2\n  must lie in [0, 30] s; 0 turns thermocouple_lag off");
}

TEST_CASE("scenario: a plant's base is looked for beside the scenario, and resolved") {
  const Folder folder;
  folder.write("limbs/mine.yaml", "parameters: { heat_loss_A_W_K: 0.05 }\n");
  const fs::path file = folder.write("s.yaml", head + "plant: { base: limbs/mine.yaml }\n");
  const Scenario scenario = read_scenario(file);
  CHECK(scenario.plant.get(scenario.plant.system().parameter("heat_loss_A_W_K")) == 0.05);
  const std::string resolved = to_yaml(scenario);
  CHECK(resolved.find("base") == std::string::npos);
  CHECK(parse(resolved).plant == scenario.plant);
}

TEST_CASE("scenario: a recording to replay is looked for beside the scenario") {
  const Folder folder;
  folder.write("data/r.csv", small_recording);
  const fs::path file = folder.write("s.yaml", head + "input: { replay: { recording: data/r.csv } }\n");
  const Scenario scenario = read_scenario(file);
  const auto& input = std::get<ReplayInput>(scenario.input);
  REQUIRE(input.recording.samples.size() == 2);
  CHECK(input.recording.samples[1].inputs[A] == 0.25);
  CHECK(input.recording_path == (folder.path() / "data/r.csv").string());
}

TEST_CASE("scenario: a resolved replay names its recording by an absolute path, whatever is in it") {
  for (const char* name : {"sinew_scenario_test", "sinew 'scenario' \"test\" #1: {a}"}) {
    const Folder folder(name);
    folder.write("r.csv", small_recording);
    const fs::path file = folder.write("s.yaml", head + "input: { replay: { recording: r.csv } }\n");
    const std::string resolved = to_yaml(read_scenario(file));
    const Scenario back = parse_scenario(resolved, "/elsewhere/s.yaml");
    CHECK(std::get<ReplayInput>(back.input).recording.samples.size() == 2);
    CHECK(to_yaml(back) == resolved);
  }
}

TEST_CASE("scenario: a recording that is not there is an error where it is named, with where it was looked for") {
  CHECK(error_of([] { parse_scenario(head + "input:\n  replay: { recording: no.csv }\n", "/nowhere/s.yaml"); }) ==
        "/nowhere/s.yaml:4:24: input.replay.recording = no.csv\n  no such file; looked for /nowhere/no.csv");
}

TEST_CASE("scenario: an error in a recording to replay points into the recording") {
  const Folder folder;
  const fs::path recording = folder.write("r.csv", small_recording + "0.2,1.5,0,20,21,3\n");
  const fs::path file = folder.write("s.yaml", head + "input: { replay: { recording: r.csv } }\n");
  CHECK(error_of([&] { read_scenario(file); }).starts_with(recording.string() + ":4:5: duty_A = 1.5\n"));
}

TEST_CASE("scenario: a file that is not there is an error with the system's reason") {
  CHECK(error_of([] { read_scenario("/nowhere/s.yaml"); }) == "/nowhere/s.yaml: cannot read\n  No such file or directory");
}

}  // namespace sim_scenario_test

// SPDX-License-Identifier: Apache-2.0
#include "sim/simulation.h"

#include <doctest/doctest.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <optional>
#include <sstream>
#include <string>
#include <vector>

#include "plant/limb/limb.h"
#include "sim/input_error.h"
#include "sim/manifest.h"
#include "sim/recording.h"
#include "sim/text.h"

namespace sim_simulation_test {

namespace fs = std::filesystem;
namespace plant = sinew::plant;
using namespace sinew::sim;

namespace {

// The two-coil limb's coils, inputs and thermocouples, and the channel of its angle.
constexpr std::size_t A = 0, B = 1, angle = 2;
const Columns columns = columns_of(*sinew::plant::two_coil_limb());

Scenario parse(const std::string& text) { return parse_scenario(text, "s.yaml"); }

// All bytes that a run leaves, run.json among them.
struct Bytes {
  std::string recording, truth, json;
  friend bool operator==(const Bytes&, const Bytes&) = default;
};
Bytes bytes_of(const Scenario& scenario, const RunResult& result) {
  return {result.recording_csv, result.truth_csv,
          run_json(scenario, result, {{"recording.csv", result.recording_csv}, {"truth.csv", result.truth_csv}})};
}
Bytes bytes_of(const Scenario& scenario) { return bytes_of(scenario, run(scenario)); }

// The run stopped at the first checkpoint at or after each of these times and resumed from the checkpoint's text.
Bytes resumed(const Scenario& scenario, const std::vector<double>& stops_s, int* stopped = nullptr) {
  const std::string yaml = to_yaml(scenario);
  std::optional<RunCheckpoint> from;
  std::size_t next = 0;
  for (;;) {
    RunOptions options;
    options.resume = from;
    double now_s = 0.0;
    options.progress = [&](double time_s) { now_s = time_s; };
    options.should_stop = [&] { return next < stops_s.size() && now_s >= stops_s[next]; };
    const RunResult result = run(scenario, options);
    if (result.status != RunStatus::stopped) return bytes_of(scenario, result);
    if (stopped) ++*stopped;
    while (next < stops_s.size() && stops_s[next] <= now_s) ++next;
    from = checkpoint_from_json(to_json(*result.checkpoint, yaml), "checkpoint.json", yaml);
  }
}

void check_resuming(const Scenario& scenario, double stop_s) {
  int stopped = 0;
  const Bytes whole = bytes_of(scenario), parts = resumed(scenario, {stop_s}, &stopped);
  CHECK(stopped == 1);
  // In brackets, so that a failure does not print both files.
  CHECK((parts.recording == whole.recording));
  CHECK((parts.truth == whole.truth));
  CHECK(parts.json == whole.json);
}

const std::string babbling =
    "format: 1\nseed: 3\nduration_s: 40\ninput: { babble: { lowest_deg: -45, highest_deg: 45, longest_hold_s: 8 } }\n"
    "numerics: { restart_period_s: 2.0 }\n";
// A delay that is no whole number of samples, and a change of airflow between two samples, not at a checkpoint.
const std::string with_effects =
    "format: 1\nduration_s: 40\nplant:\n  effects:\n    input_delay: { delay_s: 0.37 }\n"
    "    airflow_change: { relative_change: 0.5, onset_s: 21.234 }\n    thermocouple_lag: { time_constant_s: 1.5 }\n"
    "    fatigue: { loss_per_cycle: 0.05 }\ninput: { babble: { lowest_deg: -45, highest_deg: 45, longest_hold_s: 8 } }\n"
    "numerics: { restart_period_s: 2.0 }\n";
const std::string with_faults =
    "format: 1\nduration_s: 40\ninput: { babble: { lowest_deg: -45, highest_deg: 45, longest_hold_s: 8 } }\nsensors:\n"
    "  temperature_A: { dropout_fraction: 0.3, stuck: { from_s: 15, until_s: 25 } }\n"
    "  temperature_B: { dropout_fraction: 1 }\n  angle: { dropout_fraction: 0.2, stuck: { from_s: 18, until_s: 23 } }\n"
    "numerics: { restart_period_s: 2.0 }\n";
const std::string noise_free =
    "sensors:\n  temperature_A: { noise_degC: 0, step_degC: 0 }\n  temperature_B: { noise_degC: 0, step_degC: 0 }\n"
    "  angle: { noise_deg: 0, step_deg: 0 }\n";
// Cooling that turns into heating where the wire is far below ambient: a wire that a drift of 1 K/s leaves behind is lost.
const std::string failing =
    "format: 1\nduration_s: 60\nplant: { effects: { convection_nonlinearity: { slope_1_K: 0.1 }, ambient_drift: { rate_K_s: 1 } } }\n"
    "input: { duty_A: { step: { height_fraction: 0.25, from_s: 1, until_s: 100 } } }\n";

class Folder {
 public:
  Folder() : path_(fs::temp_directory_path() / ("sinew_simulation_test_" + std::to_string(getpid()))) {
    fs::remove_all(path_);
    fs::create_directories(path_);
  }
  ~Folder() { fs::remove_all(path_); }
  fs::path write(const std::string& name, const std::string& text) const {
    std::ofstream(path_ / name) << text;
    return path_ / name;
  }
  const fs::path& path() const { return path_; }

 private:
  fs::path path_;
};

template <class Action>
std::string error_of(Action action) {
  try {
    action();
  } catch (const InputError& error) {
    return error.what();
  }
  return "nothing was thrown";
}

std::size_t lines(const std::string& text) { return static_cast<std::size_t>(std::count(text.begin(), text.end(), '\n')); }

}  // namespace

TEST_CASE("simulation: two runs of one scenario write the same bytes") {
  for (const std::string& text : {babbling, with_effects, with_faults}) {
    const Scenario scenario = parse(text);
    CHECK((bytes_of(scenario) == bytes_of(scenario)));
  }
}

TEST_CASE("simulation: the resolved scenario writes the bytes of the scenario") {
  const std::string started = babbling + "start: { angle_deg: 7.7, temperature_A_degC: 61.3, angular_velocity_deg_s: -29 }\n";
  for (const std::string& text : {babbling, with_effects, with_faults, started}) {
    const Scenario scenario = parse(text);
    CHECK((bytes_of(parse(to_yaml(scenario))) == bytes_of(scenario)));
  }
}

TEST_CASE("simulation: another seed is another run") {
  Scenario scenario = parse(babbling);
  const Bytes first = bytes_of(scenario);
  scenario.seed = 4;
  CHECK((bytes_of(scenario).recording != first.recording));
}

TEST_CASE("simulation: a resumed run of the core writes the bytes of one that did not stop") { check_resuming(parse(babbling), 20.0); }

TEST_CASE("simulation: so does one with commands under way, a switch in time, lagging sensors and fatigue") {
  const Scenario scenario = parse(with_effects);
  check_resuming(scenario, 20.0);  // before the airflow changes
  check_resuming(scenario, 22.0);  // after
}

TEST_CASE("simulation: so does one whose sensors drop out and stick") {
  const Scenario scenario = parse(with_faults);
  check_resuming(scenario, 10.0);  // before they stick
  check_resuming(scenario, 20.0);  // while they do
}

TEST_CASE("simulation: so does one with every effect on") {
  Scenario scenario = parse(babbling);
  const plant::System& system = scenario.plant.system();
  for (const auto& effect : system.effects())
    for (const plant::ParameterId p : effect.parameters) scenario.plant.set_in_file_units(p, system.parameters()[p].declaration.typical);
  scenario.plant.set_in_file_units(system.parameter("airflow_change.onset_s"), 13.57);
  scenario.plant.turn_on_by_strength();
  REQUIRE(std::ranges::all_of(scenario.plant.on(), [](bool on) { return on; }));
  scenario.start.clear();
  check_resuming(scenario, 20.0);
}

TEST_CASE("simulation: so does one with the explicit integrator") {
  Scenario scenario = parse(babbling);
  scenario.numerics.method = plant::Method::arkode;
  check_resuming(scenario, 20.0);
}

TEST_CASE("simulation: so does one that leaves the choice of the integrator to the stiffness at its start") {
  // Dry friction is stiff at rest, where the choice is made, and not in motion, where some of these checkpoints are.
  Scenario scenario = parse(babbling + "plant: { effects: { dry_friction: { moment_Nm: 0.003, smoothing_rad_s: 0.05 } } }\n");
  scenario.numerics.method = plant::Method::automatic;
  for (const double stop_s : {6.0, 14.0, 20.0, 30.0}) check_resuming(scenario, stop_s);
  scenario = parse(babbling);
  scenario.numerics.method = plant::Method::automatic;
  check_resuming(scenario, 20.0);
}

TEST_CASE("simulation: so do an open loop and a replay") {
  const Folder folder;
  Scenario scenario = parse(
      "format: 1\nduration_s: 20\ninput:\n  duty_A:\n"
      "    - prbs: { low_fraction: 0.1, high_fraction: 0.5, hold_s: 1.3, from_s: 2, until_s: 15 }\n"
      "    - sine: { mean_fraction: 0.1, amplitude_fraction: 0.1, period_s: 3, from_s: 5, until_s: 12 }\n"
      "numerics: { restart_period_s: 3 }\n");
  check_resuming(scenario, 9.0);
  folder.write("r.csv", run(scenario).recording_csv);
  scenario = parse_scenario("format: 1\nduration_s: 20\ninput: { replay: { recording: r.csv } }\nnumerics: { restart_period_s: 3 }\n",
                            folder.path() / "s.yaml");
  check_resuming(scenario, 9.0);
}

TEST_CASE("simulation: a run that is stopped at every checkpoint writes the same bytes too") {
  for (const std::string& text : {babbling, with_effects, with_faults}) {
    const Scenario scenario = parse(text);
    std::vector<double> stops_s;
    for (double stop_s = 2.0; stop_s <= 40.0; stop_s += 2.0) stops_s.push_back(stop_s);
    int stopped = 0;
    CHECK((resumed(scenario, stops_s, &stopped) == bytes_of(scenario)));
    CHECK(stopped == 20);
  }
}

TEST_CASE("simulation: a checkpoint's text gives back the checkpoint") {
  const Scenario scenario = parse(with_faults);
  const std::string yaml = to_yaml(scenario);
  RunOptions options;
  double now_s = 0.0;
  options.progress = [&](double time_s) { now_s = time_s; };
  options.should_stop = [&] { return now_s >= 20.0; };
  const RunResult result = run(scenario, options);
  REQUIRE(result.checkpoint.has_value());
  CHECK(result.checkpoint->tick == 200);
  CHECK(lines(result.checkpoint->recording_csv) == 1 + 200);
  const std::string text = to_json(*result.checkpoint, yaml);
  CHECK((to_json(checkpoint_from_json(text, "c.json", yaml), yaml) == text));
  CHECK(std::isnan(checkpoint_from_json(text, "c.json", yaml).measured.channels[B]));
}

TEST_CASE("simulation: a checkpoint of another scenario, or of another seed, is refused") {
  const Scenario scenario = parse(babbling);
  Scenario other = scenario;
  other.seed = 4;
  RunOptions options;
  options.should_stop = [] { return true; };
  const std::string text = to_json(*run(scenario, options).checkpoint, to_yaml(scenario));
  CHECK(error_of([&] { checkpoint_from_json(text, "c.json", to_yaml(scenario)); }) == "nothing was thrown");
  const std::string refusal = "c.json: scenario_sha256\n  is a checkpoint of another scenario or seed; remove it to start anew";
  CHECK(error_of([&] { checkpoint_from_json(text, "c.json", to_yaml(other)); }) == refusal);
  CHECK(error_of([&] { checkpoint_from_json(text, "c.json", to_yaml(parse(with_effects))); }) == refusal);
}

TEST_CASE("simulation: text that is no checkpoint is refused") {
  const auto refusal = [](const std::string& text) { return error_of([&] { checkpoint_from_json(text, "c.json", "s"); }); };
  const std::string begins = "c.json\n  is no checkpoint of `sinew run`: ";
  CHECK(refusal("").starts_with(begins));
  CHECK(refusal("{}").starts_with(begins));
  CHECK(refusal("[1, 2]").starts_with(begins));
  const Scenario scenario = parse(babbling);
  RunOptions options;
  options.should_stop = [] { return true; };
  const std::string yaml = to_yaml(scenario), whole = to_json(*run(scenario, options).checkpoint, yaml);
  CHECK(error_of([&] { checkpoint_from_json(whole.substr(0, whole.size() / 2), "c.json", yaml); }).starts_with(begins));
  auto json = nlohmann::json::parse(whole);
  for (const auto& [key, value] : json.items()) {
    if (key == "what") continue;
    auto without = json;
    without.erase(key);
    CAPTURE(key);
    CHECK(error_of([&] { checkpoint_from_json(without.dump(), "c.json", yaml); }).starts_with(begins));
  }
}

TEST_CASE("simulation: stopping is asked for, and progress told, at every restart and nowhere else") {
  const Scenario scenario = parse(babbling);
  std::vector<double> told_s;
  int asked = 0;
  RunOptions options;
  options.progress = [&](double time_s) { told_s.push_back(time_s); };
  options.should_stop = [&] { return ++asked > 1000; };
  const RunResult result = run(scenario, options);
  CHECK(result.status == RunStatus::finished);
  CHECK_FALSE(result.checkpoint.has_value());
  CHECK(asked == 20);
  REQUIRE(told_s.size() == 20);
  CHECK(told_s.front() == 2.0);
  CHECK(told_s.back() == 40.0);
  CHECK((bytes_of(scenario, result) == bytes_of(scenario)));
}

TEST_CASE("simulation: the recording has a row a sample, and reads back without the truth beside it") {
  const Scenario scenario = parse(babbling);
  const RunResult result = run(scenario);
  CHECK(result.status == RunStatus::finished);
  CHECK(result.recording_csv.starts_with("time_s,duty_A,duty_B,temperature_A_degC,temperature_B_degC,angle_deg\n0,"));
  const Recording recording = parse_recording(result.recording_csv, "recording.csv", columns);
  CHECK(recording.notes.summary().empty());
  REQUIRE(recording.samples.size() == 401);
  for (std::size_t k = 0; k < recording.samples.size(); ++k) CHECK(recording.samples[k].time_s == static_cast<double>(k) / 10.0);
  CHECK((to_csv(recording) == result.recording_csv));
}

TEST_CASE("simulation: the truth has a row a sample and a column a state") {
  const RunResult result = run(parse(with_effects));
  CHECK(lines(result.truth_csv) == 2 + 401);
  CHECK(
      result.truth_csv.starts_with("# The simulated limb's own state, for people; nothing past the seam reads it.\n"
                                   "time_s,temperature_A_degC,temperature_B_degC,martensite_A_fraction,martensite_B_fraction,angle_rad,"
                                   "angular_velocity_rad_s,"));
}

TEST_CASE("simulation: without input a limb at rest stays at rest") {
  const Recording recording = parse_recording(run(parse("format: 1\nduration_s: 10\n" + noise_free)).recording_csv, "r", columns);
  for (const Sample& sample : recording.samples) {
    CHECK(sample.channels[A] == 25.0);
    CHECK(sample.channels[B] == 25.0);
    // Both coils pull alike; the balance is found to 1e-13 rad.
    CHECK(std::abs(sample.channels[angle]) < 1e-10);
  }
}

TEST_CASE("simulation: a wire without transformation heat warms as a first-order lag does") {
  const Recording recording = parse_recording(
      run(parse("format: 1\nduration_s: 20\ninput: { duty_A: { step: { height_fraction: 0.5, from_s: 0, until_s: 20 } } }\n" + noise_free))
          .recording_csv,
      "r", columns);
  // By hand: 0.5 * 7^2 / 2.5 = 9.8 W over 0.04 W/K is a rise of 245 K with a time constant of 0.85/0.04 = 21.25 s.
  for (const Sample& sample : recording.samples) {
    const double expected_degC = 25.0 + 245.0 * (1.0 - std::exp(-sample.time_s / 21.25));
    // The integrator's tolerance is 1e-8 a step, of which there are some hundreds.
    CHECK(sample.channels[A] == doctest::Approx(expected_degC).epsilon(1e-6));
    CHECK(sample.channels[B] == 25.0);
  }
  CHECK(recording.samples.back().channels[angle] > 10.0);
}

TEST_CASE("simulation: a command acts from its sample on, and the measurement is the one before it") {
  const Recording recording =
      parse_recording(run(parse("format: 1\nduration_s: 2\ninput: { duty_A: { step: { height_fraction: 1, from_s: 1, until_s: 2 } } }\n" +
                                noise_free))
                          .recording_csv,
                      "r", columns);
  CHECK(recording.samples[9].inputs[A] == 0.0);
  CHECK(recording.samples[10].inputs[A] == 1.0);
  CHECK(recording.samples[10].channels[A] == 25.0);
  CHECK(recording.samples[11].channels[A] > 26.0);
}

TEST_CASE("simulation: the backend behind the seam gives what a run records") {
  Scenario scenario = parse(babbling);
  scenario.restart_period_s = 1000.0;
  const Recording recording = parse_recording(run(scenario).recording_csv, "r", columns);
  SimulatedBackend limb(scenario);
  Measurement measured = limb.begin();
  bool equal = true;
  for (std::size_t k = 0; k < recording.samples.size(); ++k) {
    const Sample& sample = recording.samples[k];
    equal = equal && measured.tick == static_cast<std::int64_t>(k) && measured.channels == sample.channels;
    measured = limb.exchange({static_cast<std::int64_t>(k), sample.inputs});
  }
  CHECK(equal);
}

TEST_CASE("simulation: where checkpoints could be taken does not matter beyond the integrator's tolerance") {
  const std::string text = babbling + noise_free;
  Scenario often = parse(text), never = often;
  never.restart_period_s = 1000.0;
  // Open loop, since a controller would feed differences back.
  OpenLoopInput input{.signals = {{}, {}}};
  input.signals[A] = {StepSignal{0.5, 1.0, 12.0}};
  input.signals[B] = {StepSignal{0.4, 15.0, 30.0}};
  often.input = never.input = input;
  const Recording a = parse_recording(run(often).recording_csv, "a", columns), b = parse_recording(run(never).recording_csv, "b", columns);
  for (std::size_t k = 0; k < a.samples.size(); ++k) {
    // Tolerance 1e-8 a step over some hundreds of steps, of temperatures about 100 degC and angles about 45 deg.
    CHECK(std::abs(a.samples[k].channels[A] - b.samples[k].channels[A]) < 1e-4);
    CHECK(std::abs(a.samples[k].channels[B] - b.samples[k].channels[B]) < 1e-4);
    CHECK(std::abs(a.samples[k].channels[angle] - b.samples[k].channels[angle]) < 1e-3);
  }
}

TEST_CASE("simulation: a run's own duty, replayed on the same limb, gives the same temperatures and angles") {
  const Folder folder;
  for (const std::string& text : {babbling, with_effects}) {
    const Scenario scenario = parse(text + noise_free);
    const RunResult original = run(scenario);
    folder.write("original.csv", original.recording_csv);
    Scenario replaying = parse_scenario("format: 1\nduration_s: 40\ninput: { replay: { recording: original.csv } }\n" + noise_free,
                                        folder.path() / "s.yaml");
    replaying.plant = scenario.plant;
    replaying.start = scenario.start;
    // Other restarts on purpose: 60 s instead of 2 s.
    const Recording before = parse_recording(original.recording_csv, "r", columns),
                    after = parse_recording(run(replaying).recording_csv, "r", columns);
    REQUIRE(after.samples.size() == before.samples.size());
    for (std::size_t k = 0; k < before.samples.size(); ++k) {
      CHECK(after.samples[k].inputs == before.samples[k].inputs);
      for (const std::size_t j : {A, B}) CHECK(std::abs(after.samples[k].channels[j] - before.samples[k].channels[j]) < 1e-4);
      CHECK(std::abs(after.samples[k].channels[angle] - before.samples[k].channels[angle]) < 1e-3);
    }
    // And with the same restarts the same bytes.
    replaying.restart_period_s = scenario.restart_period_s;
    CHECK((run(replaying).recording_csv == original.recording_csv));
  }
}

TEST_CASE("simulation: so does replaying in the recording's own times") {
  const Scenario scenario = parse(with_effects + noise_free);
  const Recording recording = parse_recording(run(scenario).recording_csv, "r", columns);
  for (const plant::Method method : {plant::Method::cvode, plant::Method::arkode}) {
    plant::Integrator limb(scenario.plant, plant::Start{}, {method, 1e-8});
    std::size_t visited = 0;
    const auto failure = replay(limb, scenario.plant.system(), recording.samples, [&](std::size_t k) {
      const auto shown = in_file_units(scenario.plant.system(), limb.readings());
      for (const std::size_t j : {A, B}) CHECK(std::abs(shown[j] - recording.samples[k].channels[j]) < 1e-4);
      CHECK(std::abs(shown[angle] - recording.samples[k].channels[angle]) < 1e-3);
      ++visited;
    });
    CHECK_FALSE(failure.has_value());
    CHECK(visited == recording.samples.size());
  }
}

TEST_CASE("simulation: a run whose integration fails looks failed") {
  const Scenario scenario = parse(failing);
  const RunResult result = run(scenario);
  CHECK(result.status == RunStatus::failed);
  REQUIRE(result.failure.has_value());
  const double failed_s = result.failure->time_s;
  CHECK(failed_s > 10.0);  // a wire cannot be 10 K behind before
  CHECK(failed_s < 60.0);
  CHECK(result.failure->reason.find("right-hand side") != std::string::npos);
  CHECK(result.failure->reason.find("; largest errors: ") != std::string::npos);

  // Rows up to the last sample that was reached have values, all others are there and empty.
  std::istringstream rows(result.recording_csv);
  std::string row;
  std::getline(rows, row);
  std::int64_t tick = 0;
  for (; std::getline(rows, row); ++tick) {
    const double time_s = scenario.time_s(tick);
    CAPTURE(row);
    CHECK(row.starts_with(shortest(time_s) + ","));
    CHECK(std::count(row.begin(), row.end(), ',') == 5);
    CHECK(row.ends_with(",,,") == (time_s > failed_s));
    CHECK((row.find(",,") != std::string::npos) == (time_s > failed_s));
    // Nothing is commanded any more either.
    if (time_s > failed_s) CHECK(row == shortest(time_s) + ",0,0,,,");
  }
  CHECK(tick == scenario.ticks());
  CHECK(result.recording_csv.ends_with("\n60,0,0,,,\n"));
  CHECK(result.truth_csv.ends_with("\n60,,,,,,,\n"));
  CHECK(lines(result.truth_csv) == 2 + 601);

  const auto json = nlohmann::json::parse(bytes_of(scenario, result).json);
  CHECK(json.at("status") == "failed");
  CHECK(json.at("failure").at("time_s") == failed_s);
}

TEST_CASE("simulation: a failed run writes the same bytes twice, and when it was resumed") {
  Scenario scenario = parse(failing);
  scenario.restart_period_s = 5.0;
  CHECK((bytes_of(scenario) == bytes_of(scenario)));
  check_resuming(scenario, 10.0);
}

TEST_CASE("simulation: an integrator that may take too few steps fails where it would need them") {
  Scenario scenario = parse("format: 1\nduration_s: 10\ninput: { duty_A: { step: { height_fraction: 1, from_s: 5, until_s: 10 } } }\n");
  scenario.numerics.most_steps = 5;
  const RunResult result = run(scenario);
  CHECK(result.status == RunStatus::failed);
  REQUIRE(result.failure.has_value());
  CHECK(result.failure->time_s == 5.0);
  CHECK(result.failure->reason.find("mxstep steps") != std::string::npos);
  const Recording recording = parse_recording(result.recording_csv, "r", columns);
  CHECK_FALSE(std::isnan(recording.samples[50].channels[angle]));
  CHECK(std::isnan(recording.samples[51].channels[angle]));
  CHECK(recording.samples[50].inputs[A] == 1.0);
}

TEST_CASE("simulation: a backend that has failed goes on giving nothing") {
  const Scenario scenario = parse(
      "format: 1\nduration_s: 10\nplant: { parameters: { heat_capacity_A_J_K: 0.05 }, effects: { convection_nonlinearity: { slope_1_K: 0.1 "
      "} } }\n"
      "start: { temperature_A_degC: -1000 }\n");
  SimulatedBackend limb(scenario);
  CHECK_FALSE(std::isnan(limb.begin().channels[A]));
  for (std::int64_t tick = 0; tick < 3; ++tick) {
    const Measurement measured = limb.exchange({tick, {0.0, 0.0}});
    CHECK(measured.tick == tick + 1);
    CHECK(std::isnan(measured.channels[A]));
    CHECK(std::isnan(measured.channels[B]));
    CHECK(std::isnan(measured.channels[angle]));
    REQUIRE(limb.failure().has_value());
    CHECK(limb.failure()->time_s == 0.0);
  }
}

TEST_CASE("simulation: in the paper's babbling the duty never passes 0.6, and one coil at most is driven") {
  for (const char* name : {"babble_bidirectional.yaml", "babble_unidirectional.yaml"}) {
    CAPTURE(name);
    const Scenario scenario = read_scenario(fs::path(SINEW_SOURCE_DIR) / "scenarios" / name);
    const RunResult result = run(scenario);
    REQUIRE(result.status == RunStatus::finished);
    const Recording recording = parse_recording(result.recording_csv, name, columns);
    REQUIRE(recording.samples.size() == 6001);
    double highest = 0.0, lowest_deg = 0.0, highest_deg = 0.0;
    std::array<std::size_t, 2> driven{};
    for (const Sample& sample : recording.samples) {
      for (const std::size_t j : {A, B}) {
        CHECK(sample.inputs[j] >= 0.0);
        highest = std::max(highest, sample.inputs[j]);
        driven[j] += sample.inputs[j] > 0.0;
      }
      CHECK((sample.inputs[A] == 0.0 || sample.inputs[B] == 0.0));
      lowest_deg = std::min(lowest_deg, sample.channels[angle]);
      highest_deg = std::max(highest_deg, sample.channels[angle]);
    }
    CHECK(highest == 0.6);
    CHECK(driven[A] > 500);
    const bool both = std::get<BabbleInput>(scenario.input).both_sides;
    CHECK((driven[B] > 500) == both);
    if (!both) CHECK(driven[B] == 0);
    // The limb moves through most of what is asked of it.
    CHECK(highest_deg > 25.0);
    CHECK((lowest_deg < -25.0) == both);
  }
}

}  // namespace sim_simulation_test

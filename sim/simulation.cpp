// SPDX-License-Identifier: Apache-2.0
#include "sim/simulation.h"

#include <limits>
#include <nlohmann/json.hpp>

#include "sim/input_error.h"
#include "sim/manifest.h"
#include "sim/text.h"

namespace sinew::sim {
namespace {

constexpr double nan = std::numeric_limits<double>::quiet_NaN();

void append_row(std::string& csv, double time_s, const std::vector<double>& inputs, const std::vector<double>& channels) {
  const auto put = [&](double value) {
    if (!std::isnan(value)) append_shortest(csv, value);
    csv += ',';
  };
  put(time_s);
  for (const double value : inputs) put(value);
  for (const double value : channels) put(value);
  csv.back() = '\n';
}

std::string truth_header(const plant::System& system, const plant::States& states) {
  const std::string what(system.words().substr(system.words().find(' ') + 1));
  std::string header = "# The simulated " + what + "'s own state, for people; nothing past the seam reads it.\ntime_s";
  for (const plant::StateInfo& state : states) header += "," + state.key;
  return header + "\n";
}

void append_truth(std::string& csv, double time_s, const std::vector<double>& state, bool failed) {
  append_shortest(csv, time_s);
  for (const double value : state) {
    csv += ',';
    if (!failed) append_shortest(csv, value);
  }
  csv += '\n';
}

nlohmann::json number_or_null(double value) { return std::isnan(value) ? nlohmann::json() : nlohmann::json(value); }
double number_or_nan(const nlohmann::json& value) { return value.is_null() ? nan : value.get<double>(); }

}  // namespace

std::vector<double> in_file_units(const plant::System& system, std::vector<double> readings) {
  for (const plant::ChannelId c : system.channels().ids()) readings[c.index] /= system.channels()[c].unit.internal_per_unit;
  return readings;
}

void command_sample(plant::Integrator& integrator, const plant::System& system, const std::vector<Sample>& samples, std::size_t k) {
  std::vector<double> slopes_1_s;
  for (const plant::InputId i : system.inputs().ids()) {
    if (system.inputs()[i].between == plant::Between::held || k + 1 >= samples.size()) continue;
    slopes_1_s.resize(system.inputs().size(), 0.0);
    slopes_1_s[i.index] = (samples[k + 1].inputs[i.index] - samples[k].inputs[i.index]) / (samples[k + 1].time_s - samples[k].time_s);
  }
  integrator.hold(samples[k].inputs, slopes_1_s);
}

std::vector<SensorSettings> usual_sensors(const plant::System& system) {
  std::vector<SensorSettings> sensors;
  for (const auto& channel : system.channels()) sensors.push_back({.noise = channel.noise, .step = channel.step});
  return sensors;
}

SimulatedBackend::SimulatedBackend(const Scenario& scenario) : scenario_(scenario) {
  const auto& channels = scenario.plant.system().channels();
  for (const plant::ChannelId c : channels.ids())
    sensors_.emplace_back(scenario.sensors.at(c.index), static_cast<std::uint64_t>(scenario.seed), channels[c].short_name);
  integrator_.emplace(scenario.plant, plant::Start{scenario.start, {}}, scenario.numerics);
}

void SimulatedBackend::resume(const plant::Checkpoint& from) { integrator_.emplace(scenario_.plant, from, scenario_.numerics); }

Measurement SimulatedBackend::measure(std::int64_t tick) {
  if (failure_) return {tick, std::vector<double>(sensors_.size(), nan)};
  Measurement measured{tick, in_file_units(scenario_.plant.system(), integrator_->readings())};
  for (std::size_t c = 0; c < sensors_.size(); ++c)
    measured.channels[c] = sensors_[c].report(measured.channels[c], tick, scenario_.time_s(tick));
  return measured;
}

Measurement SimulatedBackend::begin() { return measure(0); }

Measurement SimulatedBackend::exchange(const Command& command) {
  if (!failure_) {
    integrator_->hold(command.inputs);
    failure_ = integrator_->advance_to(scenario_.time_s(command.tick + 1));
  }
  return measure(command.tick + 1);
}

RunResult run(const Scenario& scenario, const RunOptions& options) {
  SimulatedBackend limb(scenario);
  const plant::System& system = scenario.plant.system();
  Driver driver(system, scenario.input, static_cast<std::uint64_t>(scenario.seed), scenario.sample_period_s);
  RunResult result;
  Measurement measured;
  std::int64_t tick = 0;
  if (options.resume) {
    const RunCheckpoint& from = *options.resume;
    limb.resume(from.plant);
    driver.set_state(from.driver);
    for (std::size_t c = 0; c < from.sensors.size(); ++c) limb.sensors()[c].set_last(from.sensors[c]);
    tick = from.tick;
    measured = from.measured;
    result.recording_csv = from.recording_csv;
    result.truth_csv = from.truth_csv;
  } else {
    measured = limb.begin();
    result.recording_csv = header_of(columns_of(system));
    result.truth_csv = truth_header(system, limb.integrator().states());
  }
  for (; tick < scenario.ticks(); ++tick) {
    const double time_s = scenario.time_s(tick);
    if (tick % scenario.restart_ticks() == 0 && tick > 0 && !limb.failure()) {
      limb.integrator().restart();
      if (options.progress) options.progress(time_s);
      if (options.should_stop && options.should_stop()) {
        result.status = RunStatus::stopped;
        result.checkpoint =
            RunCheckpoint{tick, measured, limb.integrator().checkpoint(), driver.state(), {}, result.recording_csv, result.truth_csv};
        for (const Sensor& sensor : limb.sensors()) result.checkpoint->sensors.push_back(sensor.last());
        break;
      }
    }
    const Command command =
        limb.failure() ? Command{tick, std::vector<double>(system.inputs().size(), 0.0)} : driver.command(measured, time_s);
    append_row(result.recording_csv, time_s, command.inputs, measured.channels);
    append_truth(result.truth_csv, time_s, limb.integrator().state(), limb.failure().has_value());
    if (tick + 1 < scenario.ticks()) measured = limb.exchange(command);
  }
  if (limb.failure()) {
    result.status = RunStatus::failed;
    result.failure = limb.failure();
  }
  result.counters = limb.integrator().counters();
  return result;
}

std::string to_json(const RunCheckpoint& checkpoint, const std::string& scenario_yaml) {
  nlohmann::ordered_json json;
  json["what"] = "checkpoint of `sinew run`; go on with --resume";
  json["scenario_sha256"] = sha256(scenario_yaml);
  json["tick"] = checkpoint.tick;
  for (const double value : checkpoint.measured.channels) json["measured"].push_back(nlohmann::ordered_json(number_or_null(value)));
  const plant::Checkpoint& limb = checkpoint.plant;
  json["method"] = limb.method == plant::Method::cvode ? "cvode" : "arkode";
  json["time_s"] = limb.time_s;
  json["segment_start_s"] = limb.segment_start_s;
  json["held_inputs"] = limb.held_inputs;
  json["commands_under_way"] = limb.commands_under_way;
  json["state"] = limb.state;
  json["next_step_s"] = limb.next_step_s;
  const plant::SolverCounters& counters = limb.counters;
  json["counters"] = {counters.steps, counters.rhs_evaluations, counters.jacobian_evaluations, counters.error_test_failures,
                      counters.restarts};
  const DriverState& driver = checkpoint.driver;
  json["driver"]["replay_index"] = driver.replay_index;
  json["driver"]["following"] = nlohmann::ordered_json::array();
  for (const auto& one : driver.following)
    json["driver"]["following"].push_back({{"setpoints_drawn", one.setpoints_drawn},
                                           {"setpoint", one.setpoint},
                                           {"next_setpoint_s", one.next_setpoint_s},
                                           {"error_integral", one.error_integral},
                                           {"last_measured", one.last_measured}});
  for (const auto& last : checkpoint.sensors) json["sensors"].push_back(last ? nlohmann::ordered_json(*last) : nlohmann::ordered_json());
  json["recording_csv"] = checkpoint.recording_csv;
  json["truth_csv"] = checkpoint.truth_csv;
  return json.dump(1) + "\n";
}

RunCheckpoint checkpoint_from_json(std::string_view text, const std::string& file, const std::string& scenario_yaml) {
  try {
    const auto json = nlohmann::json::parse(text);
    if (json.at("scenario_sha256") != sha256(scenario_yaml))
      throw InputError(
          {.file = file, .key = "scenario_sha256", .advice = "is a checkpoint of another scenario or seed; remove it to start anew"});
    RunCheckpoint from;
    from.tick = json.at("tick");
    from.measured.tick = from.tick;
    for (const auto& value : json.at("measured")) from.measured.channels.push_back(number_or_nan(value));
    from.plant.method = json.at("method") == "cvode" ? plant::Method::cvode : plant::Method::arkode;
    from.plant.time_s = json.at("time_s");
    from.plant.segment_start_s = json.at("segment_start_s");
    from.plant.held_inputs = json.at("held_inputs").get<std::vector<double>>();
    from.plant.commands_under_way = json.at("commands_under_way");
    from.plant.state = json.at("state").get<std::vector<double>>();
    from.plant.next_step_s = json.at("next_step_s");
    const auto& counters = json.at("counters");
    from.plant.counters = {counters.at(0), counters.at(1), counters.at(2), counters.at(3), counters.at(4)};
    const auto& driver = json.at("driver");
    from.driver.replay_index = driver.at("replay_index");
    for (const auto& one : driver.at("following"))
      from.driver.following.push_back(
          {one.at("setpoints_drawn"), one.at("setpoint"), one.at("next_setpoint_s"), one.at("error_integral"), one.at("last_measured")});
    for (const auto& last : json.at("sensors"))
      from.sensors.push_back(last.is_null() ? std::nullopt : std::optional<double>(last.get<double>()));
    from.recording_csv = json.at("recording_csv");
    from.truth_csv = json.at("truth_csv");
    return from;
  } catch (const nlohmann::json::exception& e) {
    throw InputError({.file = file, .advice = std::string("is no checkpoint of `sinew run`: ") + e.what()});
  }
}

}  // namespace sinew::sim

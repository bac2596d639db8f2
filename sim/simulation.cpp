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

void append_row(std::string& csv, std::initializer_list<double> values) {
  bool first = true;
  for (const double value : values) {
    if (!first) csv += ',';
    first = false;
    if (!std::isnan(value)) append_shortest(csv, value);
  }
  csv += '\n';
}

std::string truth_header(const plant::Layout& layout) {
  std::string header = "# The simulated limb's own state, for people; nothing past the seam reads it.\ntime_s";
  for (const auto& entry : layout.entries) header += "," + entry.key;
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

SimulatedBackend::SimulatedBackend(const Scenario& scenario)
    : scenario_(scenario),
      sensors_{Sensor(scenario.sensors.temperature[plant::A], static_cast<std::uint64_t>(scenario.seed), "temperature_A"),
               Sensor(scenario.sensors.temperature[plant::B], static_cast<std::uint64_t>(scenario.seed), "temperature_B"),
               Sensor(scenario.sensors.angle, static_cast<std::uint64_t>(scenario.seed), "angle")} {
  integrator_.emplace(scenario.limb, plant::Start{scenario.start, {}}, scenario.numerics);
}

void SimulatedBackend::resume(const plant::Checkpoint& from) {
  integrator_.emplace(scenario_.limb, from, scenario_.numerics);
}

Measurement SimulatedBackend::measure(std::int64_t tick) {
  if (failure_) return {tick, {nan, nan}, nan};
  const plant::Reading<double> shown = integrator_->reading();
  const double time_s = scenario_.time_s(tick);
  return {tick,
          {sensors_[0].report(shown.temperature_degC[plant::A], tick, time_s),
           sensors_[1].report(shown.temperature_degC[plant::B], tick, time_s)},
          sensors_[2].report(shown.angle_rad / plant::radians_per_degree, tick, time_s)};
}

Measurement SimulatedBackend::begin() { return measure(0); }

Measurement SimulatedBackend::exchange(const Command& command) {
  if (!failure_) {
    integrator_->hold(command.duty_fraction);
    failure_ = integrator_->advance_to(scenario_.time_s(command.tick + 1));
  }
  return measure(command.tick + 1);
}

RunResult run(const Scenario& scenario, const RunOptions& options) {
  SimulatedBackend limb(scenario);
  Driver driver(scenario.input, static_cast<std::uint64_t>(scenario.seed), scenario.sample_period_s);
  RunResult result;
  Measurement measured;
  std::int64_t tick = 0;
  if (options.resume) {
    const RunCheckpoint& from = *options.resume;
    limb.resume(from.plant);
    driver.set_state(from.driver);
    for (std::size_t i = 0; i < 3; ++i) limb.sensors()[i].set_last(from.sensors[i]);
    tick = from.tick;
    measured = from.measured;
    result.recording_csv = from.recording_csv;
    result.truth_csv = from.truth_csv;
  } else {
    measured = limb.begin();
    result.recording_csv = "time_s,duty_A,duty_B,temperature_A_degC,temperature_B_degC,angle_deg\n";
    result.truth_csv = truth_header(limb.integrator().layout());
  }
  for (; tick < scenario.ticks(); ++tick) {
    const double time_s = scenario.time_s(tick);
    if (tick % scenario.restart_ticks() == 0 && tick > 0 && !limb.failure()) {
      limb.integrator().restart();
      if (options.progress) options.progress(time_s);
      if (options.should_stop && options.should_stop()) {
        result.status = RunStatus::stopped;
        result.checkpoint = RunCheckpoint{tick,
                                          measured,
                                          limb.integrator().checkpoint(),
                                          driver.state(),
                                          {limb.sensors()[0].last(), limb.sensors()[1].last(), limb.sensors()[2].last()},
                                          result.recording_csv,
                                          result.truth_csv};
        break;
      }
    }
    const Command command = limb.failure() ? Command{tick, {}} : driver.command(measured, time_s);
    append_row(result.recording_csv,
               {time_s, command.duty_fraction[plant::A], command.duty_fraction[plant::B],
                measured.temperature_degC[plant::A], measured.temperature_degC[plant::B], measured.angle_deg});
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
  json["measured"] = {number_or_null(checkpoint.measured.temperature_degC[0]),
                      number_or_null(checkpoint.measured.temperature_degC[1]), number_or_null(checkpoint.measured.angle_deg)};
  const plant::Checkpoint& limb = checkpoint.plant;
  json["method"] = limb.method == plant::Method::cvode ? "cvode" : "arkode";
  json["time_s"] = limb.time_s;
  json["segment_start_s"] = limb.segment_start_s;
  json["held_duty_fraction"] = limb.held_duty_fraction;
  json["commands_under_way"] = limb.commands_under_way;
  json["state"] = limb.state;
  json["next_step_s"] = limb.next_step_s;
  const plant::SolverCounters& counters = limb.counters;
  json["counters"] = {counters.steps, counters.rhs_evaluations, counters.jacobian_evaluations, counters.error_test_failures,
                      counters.restarts};
  const DriverState& driver = checkpoint.driver;
  json["driver"] = {{"setpoints_drawn", driver.setpoints_drawn},
                    {"setpoint_deg", driver.setpoint_deg},
                    {"next_setpoint_s", driver.next_setpoint_s},
                    {"error_integral_deg_s", driver.error_integral_deg_s},
                    {"last_angle_deg", driver.last_angle_deg},
                    {"replay_index", driver.replay_index}};
  for (const auto& last : checkpoint.sensors) json["sensors"].push_back(last ? nlohmann::ordered_json(*last) : nlohmann::ordered_json());
  json["recording_csv"] = checkpoint.recording_csv;
  json["truth_csv"] = checkpoint.truth_csv;
  return json.dump(1) + "\n";
}

RunCheckpoint checkpoint_from_json(std::string_view text, const std::string& file, const std::string& scenario_yaml) {
  try {
    const auto json = nlohmann::json::parse(text);
    if (json.at("scenario_sha256") != sha256(scenario_yaml))
      throw InputError({.file = file, .key = "scenario_sha256",
                        .advice = "is a checkpoint of another scenario or seed; remove it to start anew"});
    RunCheckpoint from;
    from.tick = json.at("tick");
    from.measured = {from.tick,
                     {number_or_nan(json.at("measured").at(0)), number_or_nan(json.at("measured").at(1))},
                     number_or_nan(json.at("measured").at(2))};
    from.plant.method = json.at("method") == "cvode" ? plant::Method::cvode : plant::Method::arkode;
    from.plant.time_s = json.at("time_s");
    from.plant.segment_start_s = json.at("segment_start_s");
    from.plant.held_duty_fraction = json.at("held_duty_fraction");
    from.plant.commands_under_way = json.at("commands_under_way");
    from.plant.state = json.at("state").get<std::vector<double>>();
    from.plant.next_step_s = json.at("next_step_s");
    const auto& counters = json.at("counters");
    from.plant.counters = {counters.at(0), counters.at(1), counters.at(2), counters.at(3), counters.at(4)};
    const auto& driver = json.at("driver");
    from.driver = {driver.at("setpoints_drawn"),      driver.at("setpoint_deg"),   driver.at("next_setpoint_s"),
                   driver.at("error_integral_deg_s"), driver.at("last_angle_deg"), driver.at("replay_index")};
    for (std::size_t i = 0; i < 3; ++i)
      if (const auto& last = json.at("sensors").at(i); !last.is_null()) from.sensors[i] = last.get<double>();
    from.recording_csv = json.at("recording_csv");
    from.truth_csv = json.at("truth_csv");
    return from;
  } catch (const nlohmann::json::exception& e) {
    throw InputError({.file = file, .advice = std::string("is no checkpoint of `sinew run`: ") + e.what()});
  }
}

}  // namespace sinew::sim

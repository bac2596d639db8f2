// SPDX-License-Identifier: Apache-2.0
// A scenario: one question to a plant, as plain values. Reading and writing it as YAML: scenario_yaml.cpp.
//
//     format: 1
//     seed: 4711
//     duration_s: 60.0
//     plant: { base: paper_limb, effects: { thermocouple_lag: { time_constant_s: 1.2 } } }
//     input: { duty_A: { step: { height_fraction: 0.5, from_s: 1.0, until_s: 5.0 } } }
//
// What is left out has the default of its field here.
#pragma once

#include <filesystem>
#include <string>

#include "plant/integrator.h"
#include "plant/systems.h"
#include "sim/input.h"
#include "sim/sensor.h"

namespace sinew::sim {

// One a channel: noise and steps of the usual sensor.
std::vector<SensorSettings> usual_sensors(const plant::System& system);

struct Scenario {
  std::vector<std::string> comments;  // the lines at the top, without "# "
  std::int64_t seed = 1;
  double duration_s = 60.0;
  double sample_period_s = 0.1;
  plant::Plant plant = plant::default_plant();
  std::vector<std::optional<double>> start;  // one entry a state, internal units; empty entries are at rest
  Input input = OpenLoopInput{};
  std::vector<SensorSettings> sensors = usual_sensors(plant.system());  // one a channel
  plant::NumericalSettings numerics;
  // The integrator starts again at least this often, so that a checkpoint can be taken there.
  double restart_period_s = 60.0;

  std::int64_t ticks() const;              // samples are at ticks 0 to ticks() - 1
  double time_s(std::int64_t tick) const;  // tick * sample_period_s, rounded once
  std::int64_t restart_ticks() const;
};

// Throws InputError.
Scenario parse_scenario(std::string_view text, const std::filesystem::path& file);
Scenario read_scenario(const std::filesystem::path& file);

// Every value written out, defaults included; reads back as the same scenario. A replayed recording is named by an
// absolute path.
std::string to_yaml(const Scenario& scenario);

}  // namespace sinew::sim

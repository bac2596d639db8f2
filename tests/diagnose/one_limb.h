// SPDX-License-Identifier: Apache-2.0
// A limb with known parameters, and recordings of it, for the tests of diagnose/.
#pragma once

#include <stdexcept>

#include "diagnose/explanation.h"
#include "plant/limb/limb.h"
#include "sim/scenario.h"
#include "sim/simulation.h"

namespace sinew::testing {

// The lists of the two-coil limb.
inline const plant::System& limb_system() { return *plant::two_coil_limb(); }
inline plant::ParameterId parameter(std::string_view key) { return limb_system().parameter(key); }
inline plant::EffectId effect(std::string_view name) { return limb_system().effect(name); }
inline plant::VariableId variable(std::string_view name) {
  const auto& all = limb_system().variables();
  for (const plant::VariableId v : all.ids())
    if (all[v].name == name) return v;
  throw std::out_of_range(std::string(name));
}
inline plant::EntryGroupId group(std::string_view name) {
  const auto& all = limb_system().entry_groups();
  for (const plant::EntryGroupId g : all.ids())
    if (all[g].name == name) return g;
  throw std::out_of_range(std::string(name));
}
inline constexpr plant::ChannelId temperature_A{0}, temperature_B{1}, angle{2};

// Babbling of `duration_s`; noise-free sensors.
inline sim::Scenario babbling(double duration_s, const plant::Plant& plant = plant::default_plant()) {
  sim::Scenario scenario;
  scenario.duration_s = duration_s;
  scenario.plant = plant;
  sim::BabbleInput input;
  input.longest_hold_s = 10.0;
  scenario.input = input;
  scenario.sensors.assign(plant.system().channels().size(), {});
  return scenario;
}

inline sim::Recording recorded(const sim::Scenario& scenario) {
  return sim::parse_recording(sim::run(scenario).recording_csv, "recorded", sim::columns_of(scenario.plant.system()));
}

inline const diagnose::PerChannel paper_noise({0.12, 0.12, 0.05});
inline diagnose::PerChannel noise_of(const sim::Recording& recording) { return diagnose::noise_of(limb_system(), recording); }
inline std::vector<diagnose::FitData> data_of(const sim::Recording& recording, const diagnose::PerChannel& noise = paper_noise) {
  return {{&recording, recording.samples.size(), noise}};
}

// A recording that begins at rest, and the paper's core fitted to it.
struct FittedCore {
  sim::Recording recording;
  std::vector<diagnose::FitData> data;
  diagnose::ExplanationSettings settings;
  diagnose::Explanation core;

  explicit FittedCore(const sim::Scenario& scenario) : recording(recorded(scenario)), data(data_of(recording)) {
    settings.start = diagnose::StartPolicy::at_rest;
    core = diagnose::explain(plant::default_plant(), data, {}, settings);
  }
  FittedCore(const FittedCore&) = delete;  // `data` points into it
  FittedCore& operator=(const FittedCore&) = delete;
};

}  // namespace sinew::testing

// SPDX-License-Identifier: Apache-2.0
// A limb with known parameters, and recordings of it, for the tests of diagnose/.
#pragma once

#include "diagnose/explanation.h"
#include "sim/scenario.h"
#include "sim/simulation.h"

namespace sinew::testing {

// Babbling of `duration_s`; noise-free sensors.
inline sim::Scenario babbling(double duration_s) {
  sim::Scenario scenario;
  scenario.duration_s = duration_s;
  sim::BabbleInput input;
  input.longest_hold_s = 10.0;
  scenario.input = input;
  for (auto& sensor : scenario.sensors.temperature) sensor = {};
  scenario.sensors.angle = {};
  return scenario;
}

inline sim::Recording recorded(const sim::Scenario& scenario) {
  return sim::parse_recording(sim::run(scenario).recording_csv, "recorded");
}

inline constexpr diagnose::PerChannel paper_noise{0.12, 0.12, 0.05};

// A recording that begins at rest, and the paper's core fitted to it.
struct FittedCore {
  sim::Recording recording;
  std::vector<diagnose::FitData> data;
  diagnose::ExplanationSettings settings;
  diagnose::Explanation core;

  explicit FittedCore(const sim::Scenario& scenario)
      : recording(recorded(scenario)), data{{&recording, recording.samples.size(), paper_noise}} {
    settings.start = diagnose::StartPolicy::at_rest;
    core = diagnose::explain({}, data, {}, settings);
  }
  FittedCore(const FittedCore&) = delete;  // `data` points into it
  FittedCore& operator=(const FittedCore&) = delete;
};

}  // namespace sinew::testing

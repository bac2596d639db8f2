// A limb with known parameters, and recordings of it, for the tests of diagnose/.
#pragma once

#include "diagnose/fit.h"
#include "sim/scenario.h"
#include "sim/simulation.h"

namespace sinew::testing {

// Babbling of `duration_s`; noise-free sensors unless `sensors` says otherwise.
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

}  // namespace sinew::testing

// SPDX-License-Identifier: Apache-2.0
// What all benchmarks share: the babbling experiment as a recording, its replay, how far a replay is off, and a clock.
//
// Times are processor time of the one thread that works, the least of several repeats: on an idle machine that is the time
// by the clock on the wall, and where others compile beside it it moves by some per cent, not by factors. `conditions()`
// is printed beside every table, and what is compared is timed in turn.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <fstream>
#include <functional>
#include <string>
#include <thread>
#include <vector>

#include "sim/simulation.h"

namespace sinew::bench {

// The two-coil limb's coils and thermocouples, and the channel of its angle.
inline constexpr std::size_t coils[] = {0, 1}, angle_channel = 2;

inline double seconds_on(clockid_t clock) {
  timespec time{};
  clock_gettime(clock, &time);
  return static_cast<double>(time.tv_sec) + 1e-9 * static_cast<double>(time.tv_nsec);
}

// The least processor time of this thread that `work` took in so many repeats.
template <class Work>
double fastest_s(int repeats, Work&& work) {
  double least_s = 1e300;
  for (int k = 0; k < repeats; ++k) {
    const double began_s = seconds_on(CLOCK_THREAD_CPUTIME_ID);
    work();
    least_s = std::min(least_s, seconds_on(CLOCK_THREAD_CPUTIME_ID) - began_s);
  }
  return least_s;
}

// The same for several pieces of work, taken in turn, so that other load on the machine meets all of them alike.
inline std::vector<double> fastest_in_turn_s(int repeats, const std::vector<std::function<void()>>& works) {
  std::vector<double> least_s(works.size(), 1e300);
  for (int k = 0; k < repeats; ++k)
    for (std::size_t i = 0; i < works.size(); ++i) least_s[i] = std::min(least_s[i], fastest_s(1, works[i]));
  return least_s;
}

// scenarios/babble_bidirectional.yaml, measured with its sensors.
inline sim::Recording babbling(double duration_s, const plant::Plant& limb = plant::default_plant(), std::int64_t seed = 7) {
  sim::Scenario scenario = sim::read_scenario(SINEW_SOURCE_DIR "/scenarios/babble_bidirectional.yaml");
  scenario.seed = seed;
  scenario.duration_s = duration_s;
  scenario.plant = limb;
  const sim::RunResult run = sim::run(scenario);
  if (run.status != sim::RunStatus::finished) throw std::runtime_error("the babbling did not finish");
  return sim::parse_recording(run.recording_csv, "babbling", sim::columns_of(limb.system()));
}

inline sim::Recording first_part(const sim::Recording& recording, double duration_s) {
  sim::Recording part{.name = recording.name, .columns = recording.columns};
  for (const sim::Sample& sample : recording.samples)
    if (sample.time_s <= duration_s + 1e-6) part.samples.push_back(sample);
  return part;
}

struct Replay {
  std::vector<std::vector<double>> shown;  // one a sample, [channels], internal units
  plant::SolverCounters counters;
};

// The recording's duty on a limb that starts at rest. With a request, the sensitivities of the readings are asked for at
// every sample, as a fit does.
inline Replay replay(const sim::Recording& recording, const plant::NumericalSettings& numerics,
                     const plant::SensitivityRequest& request = {}, const plant::Plant& limb = plant::default_plant(),
                     const plant::Start& start = {}) {
  Replay result;
  result.shown.reserve(recording.samples.size());
  plant::Integrator integrator(limb, start, numerics, request);
  std::vector<double> reading;
  Eigen::MatrixXd sensitivity;
  const auto failure = sim::replay(integrator, limb.system(), recording.samples, [&](std::size_t) {
    if (request.columns() > 0)
      integrator.readings_with_sensitivity(reading, sensitivity);
    else
      reading = integrator.readings();
    result.shown.push_back(reading);
  });
  if (failure) throw std::runtime_error("integration failed at " + std::to_string(failure->time_s) + " s: " + failure->reason);
  result.counters = integrator.counters();
  return result;
}

struct Errors {
  double angle_rms_deg = 0.0, angle_max_deg = 0.0, temperature_rms_K = 0.0, temperature_max_K = 0.0;
};
inline Errors errors_of(const Replay& run, const Replay& reference) {
  Errors errors;
  const double count = static_cast<double>(reference.shown.size());
  for (std::size_t k = 0; k < reference.shown.size(); ++k) {
    const double angle = std::abs(run.shown[k][angle_channel] - reference.shown[k][angle_channel]) / plant::radians_per_degree;
    errors.angle_max_deg = std::max(errors.angle_max_deg, angle);
    errors.angle_rms_deg += angle * angle / count;
    for (const std::size_t j : coils) {
      const double kelvin = std::abs(run.shown[k][j] - reference.shown[k][j]);
      errors.temperature_max_K = std::max(errors.temperature_max_K, kelvin);
      errors.temperature_rms_K += kelvin * kelvin / (2.0 * count);
    }
  }
  errors.angle_rms_deg = std::sqrt(errors.angle_rms_deg);
  errors.temperature_rms_K = std::sqrt(errors.temperature_rms_K);
  return errors;
}

inline const char* name_of(plant::Method method) {
  switch (method) {
    case plant::Method::cvode:
      return "CVODE";
    case plant::Method::arkode:
      return "ARKODE";
    case plant::Method::rosenbrock:
      return "Rosenbrock";
    case plant::Method::automatic:
      return "automatic";
  }
  return "";
}

// So many columns: all parameters of the core, then the first values of its states, then the same again. They need
// `given_start()`.
inline plant::SensitivityRequest columns(std::size_t count) {
  plant::SensitivityRequest request;
  const plant::Plant limb = plant::default_plant();
  std::vector<plant::ParameterId> of_core;
  for (const plant::ParameterId p : limb.system().parameters().ids())
    if (!limb.system().parameters()[p].effect) of_core.push_back(p);
  for (std::size_t k = 0; k < count; ++k) {
    const std::size_t place = k % (of_core.size() + limb.states().size());
    if (place < of_core.size())
      request.parameters.push_back(of_core[place]);
    else
      request.initial_states.push_back(plant::StateId{place - of_core.size()});
  }
  return request;
}

// Rest, with every state given.
inline plant::Start given_start(const plant::Plant& limb = plant::default_plant()) {
  const std::vector<double> rest = plant::Integrator(limb, plant::Start{}, plant::NumericalSettings{}).state();
  return {{rest.begin(), rest.end()}, {}};
}

inline const char* verdict(bool reached) { return reached ? "reached" : "**missed**"; }

// "load 0.12 of 2 cores": what else the machine did in the last minute, this program included.
inline std::string conditions() {
  double loads[1] = {0.0};
  getloadavg(loads, 1);
  char text[64];
  std::snprintf(text, sizeof text, "load %.2f of %u cores", loads[0], std::thread::hardware_concurrency());
  return text;
}

}  // namespace sinew::bench

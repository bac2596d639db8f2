// SPDX-License-Identifier: Apache-2.0
#include "diagnose/chance.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "sim/parallel.h"
#include "sim/random.h"
#include "sim/simulation.h"

namespace sinew::diagnose {
namespace {

constexpr double still_s = 1.0;  // the surroundings stand still for as long

// What the explanation would have recorded on the recording's inputs, where it has readings, had the surroundings and the sensors
// been others. Missing from where the integration fails.
sim::Recording drawn_recording(const Explanation& from, std::size_t r, double nuisance, const FitData& data,
                               const sim::RandomStream& chance, const plant::NumericalSettings& numerics) {
  const plant::System& system = from.system();
  const std::optional<plant::ParameterId> surroundings = system.surroundings();
  double memory_s = 1.0;
  for (const plant::EntryGroup& group : system.entry_groups())
    if (group.is_nuisance) memory_s = group.correlation_time_s;
  sim::Recording recording = *data.recording;
  recording.samples.resize(data.sample_count);
  std::uint64_t draw = 0;
  double offset = nuisance * chance.normal(draw++);
  const auto plant_in = [&](double by) {
    plant::Plant plant = from.model();
    if (surroundings) plant.set(*surroundings, plant.get(*surroundings) + by);
    return plant;
  };
  plant::Integrator integrator(plant_in(offset), from.start(r), numerics);
  const double first_s = recording.samples.front().time_s;
  double since_s = 0.0;
  bool failed = false;
  for (std::size_t k = 0; k < recording.samples.size(); ++k) {
    sim::Sample& sample = recording.samples[k];
    failed = failed || integrator.advance_to(sample.time_s - first_s);
    const std::vector<double> readings = integrator.readings();
    for (const plant::ChannelId c : system.channels().ids()) {
      double& value = measured(sample, c);
      const double noise = data.deviation[c] * chance.normal(draw++);
      if (!std::isnan(value)) value = failed ? std::numeric_limits<double>::quiet_NaN() : shown(system, readings, c) + noise;
    }
    if (failed) continue;
    sim::command_sample(integrator, system, recording.samples, k);
    const double stood_s = sample.time_s - first_s - since_s;
    if (!surroundings || stood_s < still_s) continue;
    since_s = sample.time_s - first_s;
    const double kept = std::exp(-stood_s / memory_s);
    offset = kept * offset + std::sqrt(1.0 - kept * kept) * nuisance * chance.normal(draw++);
    integrator.restart();
    integrator = plant::Integrator(plant_in(offset), integrator.checkpoint(), numerics);
    sim::command_sample(integrator, system, recording.samples, k);  // a checkpoint holds what is held, not what changes
  }
  return recording;
}

}  // namespace

ProcessNoiseByChance process_noise_by_chance(const Explanation& found, double process_noise, const std::vector<FitData>& data, int threads,
                                             std::uint64_t seed, const ExplanationSettings& settings) {
  constexpr std::size_t most = 99, at_once = 4;
  // The fit begins where the draw was made, so that a short one is near; one that matters is fitted to the end.
  ExplanationSettings shortly = settings;
  shortly.most_rounds = 2;
  shortly.iterations_per_round = 3;
  shortly.enough = 1.0;
  ForcingSize size;
  static_cast<void>(likelihood_with(found, nuisance_free(found.system()), &size));
  ProcessNoiseByChance result;
  result.process_noise = process_noise;
  result.nuisance = nuisance_of(found.system(), size);
  while (result.drawn < most && result.as_large == 0) {
    std::vector<double> drawn(std::min(at_once, most - result.drawn));
    sim::in_parallel(drawn.size(), threads, [&](std::size_t i) {
      std::vector<sim::Recording> recordings;
      for (std::size_t r = 0; r < data.size(); ++r) {
        const std::string name = "diagnose.chance." + std::to_string(result.drawn + i) + "." + std::to_string(r);
        recordings.push_back(drawn_recording(found, r, result.nuisance, data[r], sim::RandomStream(seed, name), settings.numerics));
      }
      std::vector<FitData> instead = data;
      for (std::size_t r = 0; r < data.size(); ++r) instead[r].recording = &recordings[r];
      Guess guess = found.as_guess();
      guess.course = nullptr;  // of other air
      Explanation again = explain(found.problem->centres(), instead, guess, shortly);
      if (again.usable && again.process_noise >= process_noise)
        if (const Explanation whole = explain(found.problem->centres(), instead, again.as_guess(), settings); whole.usable) again = whole;
      drawn[i] = again.usable ? again.process_noise : process_noise;
      if (again.usable && again.process_noise >= process_noise) drawn[i] = process_noise_after_refit(again, instead, settings);
    });
    for (const double one : drawn) {
      ++result.drawn;
      result.as_large += one >= process_noise;
      result.largest = std::max(result.largest, one);
    }
  }
  return result;
}

}  // namespace sinew::diagnose

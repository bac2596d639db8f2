// SPDX-License-Identifier: Apache-2.0
#include "diagnose/chance.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "sim/parallel.h"
#include "sim/random.h"

namespace sinew::diagnose {
namespace {

constexpr double air_period_s = 1.0;  // the air stands still for as long

// What the explanation would have recorded on the recording's duty, where it has readings, had the air and the sensors been
// others. Missing from where the integration fails.
sim::Recording drawn_recording(const Explanation& from, std::size_t r, double air_K, const FitData& data,
                     const sim::RandomStream& chance, const plant::NumericalSettings& numerics) {
  sim::Recording recording = *data.recording;
  recording.samples.resize(data.sample_count);
  std::uint64_t draw = 0;
  double offset_K = air_K * chance.normal(draw++);
  const auto limb_in = [&](double air_offset_K) {
    plant::Limb<double> limb = from.limb();
    limb.core.ambient_temperature_degC += air_offset_K;
    return limb;
  };
  plant::Integrator integrator(limb_in(offset_K), from.start(r), numerics);
  const double first_s = recording.samples.front().time_s;
  double air_since_s = 0.0;  // the air stands still
  bool failed = false;
  for (sim::Sample& sample : recording.samples) {
    failed = failed || integrator.advance_to(sample.time_s - first_s);
    const plant::Reading<double> reading = integrator.reading();
    for (std::size_t c = 0; c < channel_count; ++c) {
      double& value = measured(sample, c);
      const double noise = data.deviation[c] * chance.normal(draw++);
      if (!std::isnan(value)) value = failed ? std::numeric_limits<double>::quiet_NaN() : shown(reading, c) + noise;
    }
    if (failed) continue;
    integrator.hold(sample.duty_fraction);
    const double stood_s = sample.time_s - first_s - air_since_s;
    if (stood_s < air_period_s) continue;
    air_since_s = sample.time_s - first_s;
    const double kept = std::exp(-stood_s / forcings[static_cast<std::size_t>(Forcing::air)].correlation_time_s);
    offset_K = kept * offset_K + std::sqrt(1.0 - kept * kept) * air_K * chance.normal(draw++);
    integrator.restart();
    integrator = plant::Integrator(limb_in(offset_K), integrator.checkpoint(), numerics);
  }
  return recording;
}

}  // namespace

UnrestByChance unrest_by_chance(const Explanation& found, double unrest, const std::vector<FitData>& data, int threads,
                                std::uint64_t seed, const ExplanationSettings& settings) {
  constexpr std::size_t most = 99, at_once = 4;
  // The fit begins where the draw was made, so that a short one is near; one that matters is fitted to the end.
  ExplanationSettings shortly = settings;
  shortly.most_rounds = 2;
  shortly.iterations_per_round = 3;
  shortly.enough = 1.0;
  ForcingSize air{};
  static_cast<void>(likelihood_with(found, air_free, settings.most_air_K, &air));
  UnrestByChance result;
  result.unrest = unrest;
  result.air_K = air[0];
  while (result.drawn < most && result.as_large == 0) {
    std::vector<double> drawn(std::min(at_once, most - result.drawn));
    sim::in_parallel(drawn.size(), threads, [&](std::size_t i) {
      std::vector<sim::Recording> recordings;
      for (std::size_t r = 0; r < data.size(); ++r) {
        const std::string name = "diagnose.chance." + std::to_string(result.drawn + i) + "." + std::to_string(r);
        recordings.push_back(drawn_recording(found, r, air[0], data[r], sim::RandomStream(seed, name), settings.numerics));
      }
      std::vector<FitData> instead = data;
      for (std::size_t r = 0; r < data.size(); ++r) instead[r].recording = &recordings[r];
      Explanation again = explain(found.problem->centres(), instead, found.as_guess(), shortly);
      if (again.usable && again.unrest >= unrest)
        if (const Explanation whole = explain(found.problem->centres(), instead, again.as_guess(), settings); whole.usable)
          again = whole;
      drawn[i] = again.usable ? again.unrest : unrest;
      if (again.usable && again.unrest >= unrest) drawn[i] = unrest_after_refit(again, instead, settings);
    });
    for (const double one : drawn) {
      ++result.drawn;
      result.as_large += one >= unrest;
      result.largest = std::max(result.largest, one);
    }
  }
  return result;
}

}  // namespace sinew::diagnose

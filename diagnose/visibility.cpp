#include "diagnose/visibility.h"

#include <algorithm>
#include <cmath>

#include "diagnose/open_loop.h"

namespace sinew::diagnose {
namespace {

// What the effect would gain; NaN where it cannot be integrated.
double gain_of(const Explanation& at, std::size_t effect, double strength, const ExplanationSettings& settings) {
  const plant::Limb<double> without = at.limb();
  plant::Limb<double> with = with_effect(without, effect);
  plant::set(with, plant::effects()[effect].strength, strength);
  std::vector<FitData> data = at.problem->data();
  std::vector<sim::Recording> recordings;
  for (std::size_t r = 0; r < data.size(); ++r) {
    recordings.push_back(*data[r].recording);
    const plant::Start start = at.start(r);
    const Series before = predict(without, start, recordings[r], settings.numerics),
                 after = predict(with, carried_over(start, without, with), recordings[r], settings.numerics);
    for (std::size_t k = 0; k < data[r].sample_count; ++k)
      for (std::size_t c = 0; c < channel_count; ++c) {
        double& value = measured(recordings[r].samples[k], c);
        if (std::isnan(value)) continue;
        value += after[c][k] - before[c][k];
        if (std::isnan(value)) return value;
      }
  }
  for (std::size_t r = 0; r < data.size(); ++r) data[r].recording = &recordings[r];
  const Explanation again = explain(at.problem->centres(), data, at.as_guess(), settings);
  return again.usable ? 2.0 * (at.log_posterior - again.log_posterior) : std::nan("");
}

}  // namespace

double smallest_seen(const Explanation& at, std::size_t effect, double least_gain, const ExplanationSettings& settings) {
  const auto& declared = plant::parameters()[plant::effects()[effect].strength].declaration;
  const double null = declared.null_value.value_or(0.0), typical = declared.typical - null;
  const auto gain_at = [&](double factor) {
    const double strength = null + factor * typical;
    if (strength < declared.range.lowest || strength > declared.range.highest) return std::nan("");
    return std::max(1e-3, gain_of(at, effect, strength * declared.unit.internal_per_unit, settings));
  };
  const auto internal = [&](double factor) { return factor * std::abs(typical) * declared.unit.internal_per_unit; };
  double factor = 1.0, gain = gain_at(factor);
  const bool seen = gain >= least_gain;
  const double step = seen ? 0.5 : 2.0;
  while (seen ? factor > 1.0 / 64.0 : factor < 8.0) {
    const double next = gain_at(step * factor);
    if (std::isnan(next)) break;
    // Between one that is seen and one that is not the logarithms follow a line.
    if ((next >= least_gain) != seen)
      return internal(factor * std::pow(step, std::log(least_gain / gain) / std::log(next / gain)));
    factor *= step;
    gain = next;
  }
  return seen ? internal(factor) : 0.0;
}

}  // namespace sinew::diagnose

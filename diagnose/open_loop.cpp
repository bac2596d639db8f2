// SPDX-License-Identifier: Apache-2.0
#include "diagnose/open_loop.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include "diagnose/compare.h"
#include "plant/integrator.h"
#include "sim/parallel.h"
#include "sim/simulation.h"

namespace sinew::diagnose {
Series predict(const plant::Plant& plant, const plant::Start& start, const sim::Recording& recording,
               const plant::NumericalSettings& numerics) {
  const plant::System& system = plant.system();
  Series model(system.channels().size(), std::vector<double>(recording.samples.size(), std::numeric_limits<double>::quiet_NaN()));
  plant::Integrator integrator(plant, start, numerics);
  static_cast<void>(sim::replay(integrator, system, recording.samples, [&](std::size_t k) {
    const std::vector<double> readings = integrator.readings();
    for (const plant::ChannelId c : model.ids()) model[c][k] = shown(system, readings, c);
  }));
  return model;
}

plant::Start start_of(const plant::Plant& plant, const sim::Recording& recording, const PerChannel& noise,
                      const ExplanationSettings& settings) {
  if (settings.start == StartPolicy::at_rest) return {};
  ExplanationSettings fit = settings;
  fit.only_start = true;
  fit.most_rounds = 1;
  const std::size_t count = samples_until(recording, recording.samples.front().time_s + settling_s);
  const std::vector<FitData> data{{&recording, std::max<std::size_t>(count, 2), noise}};
  Explanation begun = explain(plant, data, {}, fit);
  if (begun.usable)
    for (const Guess& other : with_other_starts(begun))
      if (const Explanation again = explain(plant, data, other, fit); again.usable && again.log_posterior > begun.log_posterior)
        begun = again;
  return begun.usable ? begun.start(0) : plant::Start{};
}

Fitted fitted(const Explanation& explanation) {
  Fitted result{explanation, explanation.model(), {}};
  for (std::size_t r = 0; r < explanation.problem->data().size(); ++r) result.starts.push_back(explanation.start(r));
  return result;
}

Spread spread_of(const Fitted& fitted, const std::vector<FitData>& data, const plant::NumericalSettings& numerics) {
  Spread spread;
  for (std::size_t r = 0; r < data.size(); ++r) {
    const auto model = predict(fitted.model, fitted.starts[r], *data[r].recording, numerics);
    spread.rmse.push_back(data[r].deviation);
    for (const plant::ChannelId c : fitted.model.system().channels().ids()) {
      double sum = 0.0, count = 0.0;
      for (std::size_t k = 0; k < data[r].sample_count; ++k) {
        const double target = measured(data[r].recording->samples[k], c);
        if (std::isnan(target)) continue;
        sum += std::pow(model[c][k] - target, 2);
        ++count;
      }
      if (std::isnan(sum)) sum = lost;
      if (count > 0.0) spread.rmse[r][c] = std::max(data[r].deviation[c], std::sqrt(sum / count));
      spread.log_sum += count * std::log(spread.rmse[r][c]);
    }
  }
  return spread;
}

Fitted polished(const Explanation& explanation, const std::vector<FitData>& data, const ExplanationSettings& settings) {
  Fitted best = fitted(explanation);
  ExplanationSettings least_squares = settings;
  least_squares.least_squares = true;
  least_squares.most_rounds = 1;
  least_squares.iterations_per_round = 10;
  Spread spread = spread_of(best, data, least_squares.numerics);
  Guess guess = explanation.as_guess();
  for (int pass = 0; pass < 3; ++pass) {
    std::vector<FitData> weighted = data;
    for (std::size_t r = 0; r < data.size(); ++r) weighted[r].deviation = spread.rmse[r];
    const Explanation closest = explain(explanation.problem->centres(), weighted, guess, least_squares);
    if (!closest.usable) break;
    guess = closest.as_guess();
    const Fitted tried = fitted(closest);
    const Spread reached = spread_of(tried, data, least_squares.numerics);
    if (reached.log_sum >= spread.log_sum) break;
    best = tried;
    spread = reached;
  }
  return best;
}

}  // namespace sinew::diagnose

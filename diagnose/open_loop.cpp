// SPDX-License-Identifier: Apache-2.0
#include "diagnose/open_loop.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include "diagnose/compare.h"
#include "diagnose/error_size.h"
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
  if (settings.start == StartPolicy::at_rest)
    return {elapsed_where_it_begins(plant.states(), recording, settings.start.counted_from_s), {}};
  ExplanationSettings fit = settings;
  fit.start.policy = StartPolicy::estimated;  // at rest at most the first one begins, and this is another
  fit.start.later = true;
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

Fitted calibrated(const plant::Plant& plant, const std::vector<FitData>& data, const CalibrationSettings& settings) {
  const Calibration found = calibrate(plant, data, settings);
  ExplanationSettings as_it_is;
  as_it_is.start = settings.start;
  as_it_is.numerics = settings.numerics;
  as_it_is.least_squares = true;
  as_it_is.most_rounds = 0;
  Guess guess;
  for (const Estimate& one : found.estimates) guess.values[one.unknown.name] = one.value;
  Explanation of = explain(plant, data, guess, as_it_is);
  if (!of.usable) throw std::runtime_error("the calibrated plant cannot be integrated");
  for (std::size_t u = 0; u < of.problem->unknowns().size(); ++u) {  // a guess at a bound was moved off it
    const Unknown& unknown = of.problem->unknowns()[u];
    of.z(static_cast<Eigen::Index>(u)) = unknown.coordinate_of(guess.values.at(unknown.name));
  }
  return fitted(of);
}

Spread spread_of(const Fitted& fitted, const std::vector<FitData>& data, const plant::NumericalSettings& numerics) {
  Spread spread;
  SquaredErrors errors{std::vector<PerChannel>(data.size(), per_channel(fitted.model.system())), {}};
  errors.count = errors.sum;
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
      errors.sum[r][c] = sum;
      errors.count[r][c] = count;
    }
  }
  const plant::System& system = fitted.model.system();
  const ErrorSize size = error_size(errors, data, scale_of(system, data), std::vector(data.size(), per_channel(system, 1.0)));
  spread.count = errors.count;
  spread.deviation = size.deviation;
  spread.log_sum = -size.log_likelihood;
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
    for (std::size_t r = 0; r < data.size(); ++r) weighted[r].deviation = spread.deviation[r];
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

std::vector<PerChannel> samples_alike_of(const Fitted& path, const std::vector<FitData>& data, const plant::NumericalSettings& numerics) {
  std::vector<PerChannel> samples(data.size(), per_channel(path.model.system()));
  for (std::size_t r = 0; r < data.size(); ++r) {
    const Series model = predict(path.model, path.starts[r], *data[r].recording, numerics);
    for (const plant::ChannelId c : samples[r].ids()) {
      std::vector<double> residual(data[r].sample_count);
      for (std::size_t k = 0; k < residual.size(); ++k) residual[k] = model[c][k] - measured(data[r].recording->samples[k], c);
      samples[r][c] = correlation_samples(residual);
    }
  }
  return samples;
}

namespace {

bool has_reading(const sim::Sample& sample) {
  return std::any_of(sample.channels.begin(), sample.channels.end(), [](double value) { return !std::isnan(value); });
}

}  // namespace

std::vector<FitData> weighted_by(const Fitted& path, const std::vector<FitData>& data, const plant::NumericalSettings& numerics) {
  const std::vector<PerChannel> correlation = samples_alike_of(path, data, numerics);
  const Spread spread = spread_of(path, data, numerics);
  std::vector<FitData> weighted = data;
  for (std::size_t r = 0; r < data.size(); ++r)
    for (const plant::ChannelId c : correlation[r].ids()) weighted[r].deviation[c] = spread.deviation[r][c] * std::sqrt(correlation[r][c]);
  return weighted;
}

Explanation as_fitted(const Fitted& path, const std::vector<FitData>& data, const ExplanationSettings& settings) {
  ExplanationSettings as_it_is = settings;
  as_it_is.least_squares = true;
  as_it_is.most_rounds = 0;
  Explanation result = explain(path.of.problem->centres(), weighted_by(path, data, settings.numerics), path.of.as_guess(), as_it_is);
  if (!result.usable) return path.of;
  result.z = path.of.z;  // a guess at a bound was moved off it
  return result;
}

FoldErrors cross_validated(const Fitted& path, const std::vector<FitData>& data, int threads, const ExplanationSettings& settings) {
  constexpr std::size_t folds = 10;
  constexpr double beginning_s = 10.0;  // is always fitted: it tells how the recording begins
  ExplanationSettings least_squares = settings;
  least_squares.least_squares = true;
  least_squares.most_rounds = 1;
  const std::vector<FitData> weighted = weighted_by(path, data, settings.numerics);

  FoldErrors errors;
  errors.squares.assign(folds, per_channel(path.model.system()));
  errors.noise = errors.squares;
  sim::in_parallel(folds, threads, [&](std::size_t fold) {
    std::vector<sim::Recording> masked;
    std::vector<std::pair<std::size_t, std::size_t>> left_out;  // of each recording: first sample, one past the last
    for (const FitData& one : data) {
      const auto& samples = one.recording->samples;
      std::vector<std::size_t> shown;  // samples with a reading, after the beginning
      for (std::size_t k = 0; k < one.sample_count; ++k)
        if (samples[k].time_s >= samples[0].time_s + beginning_s && has_reading(samples[k])) shown.push_back(k);
      const std::size_t first = shown.size() * fold / folds, end = shown.size() * (fold + 1) / folds;
      left_out.emplace_back(first < end ? shown[first] : 0, first < end ? shown[end - 1] + 1 : 0);
      masked.push_back(*one.recording);
      if (first == end) continue;
      for (sim::Sample& sample : masked.back().samples) {
        if (sample.time_s < samples[shown[first]].time_s - guard_s || sample.time_s > samples[shown[end - 1]].time_s + guard_s) continue;
        mask(sample);
      }
    }
    std::vector<FitData> rest = weighted;
    for (std::size_t r = 0; r < rest.size(); ++r) rest[r].recording = &masked[r];
    const Explanation refitted = explain(path.of.problem->centres(), rest, path.of.as_guess(), least_squares);
    const Fitted without = refitted.usable ? fitted(refitted) : path;
    for (std::size_t r = 0; r < data.size(); ++r) {
      const Series model = predict(without.model, without.starts[r], *data[r].recording, settings.numerics);
      for (std::size_t k = left_out[r].first; k < left_out[r].second; ++k) {
        for (const plant::ChannelId c : path.model.system().channels().ids()) {
          const double target = measured(data[r].recording->samples[k], c);
          if (std::isnan(target)) continue;
          errors.squares[fold][c] += refitted.usable ? square_of_error(model[c][k], target) : lost;
          errors.noise[fold][c] += std::pow(data[r].deviation[c], 2);
        }
      }
    }
  });
  return errors;
}

FoldGain gain_of(const FoldErrors& before, const FoldErrors& after) {
  const std::size_t folds = before.squares.size();
  const auto gain_without = [&](std::size_t left_out) {
    double gain = 0.0;
    for (const plant::ChannelId c : before.squares.front().ids()) {
      double was = 0.0, is = 0.0, noise = 0.0;
      for (std::size_t f = 0; f < folds; ++f) {
        if (f == left_out) continue;
        was += before.squares[f][c], is += after.squares[f][c], noise += before.noise[f][c];
      }
      if (noise > 0.0) gain += 0.5 * std::log(std::max(was, noise) / std::max(is, noise));
    }
    return gain;
  };
  std::vector<double> gains;
  for (std::size_t f = 0; f < folds; ++f) gains.push_back(gain_without(f));
  const double n = static_cast<double>(folds), mean = std::accumulate(gains.begin(), gains.end(), 0.0) / n;
  double variance = 0.0;
  for (const double gain : gains) variance += (gain - mean) * (gain - mean) * (n - 1.0) / n;
  return {gain_without(folds), std::sqrt(variance)};
}

}  // namespace sinew::diagnose

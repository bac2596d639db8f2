// SPDX-License-Identifier: Apache-2.0
#include "diagnose/held_out.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <tuple>

#include "diagnose/bootstrap.h"
#include "diagnose/compare.h"
#include "sim/random.h"
#include "sim/text.h"

namespace sinew::diagnose {
namespace {

constexpr std::size_t least_stretches = 3;  // of fewer a bootstrap knows nothing: 5 s each, at least

// Where the training recordings are held out from, as shares of their duration, when no recording is given to hold
// out.
constexpr std::array<std::pair<double, double>, 2> held_out_shares{{{0.40, 0.50}, {0.88, 1.0}}};

struct Stretch {  // squares of one channel over some seconds of what was held out
  double nominal = 0.0, fitted = 0.0, calibrated = 0.0, before = 0.0, after = 0.0, noise = 0.0;
  std::size_t count = 0;
};

// Adds the stretches of one channel of one recording: at least a dozen to draw from, but none shorter than 5 s.
void add_stretches(const Prediction& prediction, plant::ChannelId c, std::vector<Stretch>& stretches) {
  const auto [rows, period_s] = measured_rows(*prediction.recording, c);
  const double kept_s =
      period_s * static_cast<double>(std::ranges::count_if(rows, [&](std::size_t k) { return static_cast<bool>(prediction.held_out[k]); }));
  const double stretch_s = std::clamp(kept_s / 12.0, 5.0, bootstrap_block_s);
  double end_s = -1e300;
  for (std::size_t k = 0; k < prediction.time_s.size(); ++k) {
    if (!prediction.held_out[k] || std::isnan(prediction.measured[c][k])) continue;
    if (prediction.time_s[k] > end_s) {
      stretches.push_back({});
      end_s = prediction.time_s[k] + stretch_s;
    }
    const auto square = [&](const Series& model) { return square_of_error(model[c][k], prediction.measured[c][k]); };
    Stretch& stretch = stretches.back();
    stretch.nominal += square(prediction.nominal);
    stretch.fitted += prediction.fitted.empty() ? lost : square(prediction.fitted);
    stretch.calibrated += prediction.calibrated.empty() ? lost : square(prediction.calibrated);
    stretch.before += square(prediction.before);
    stretch.after += square(prediction.after);
    stretch.noise += prediction.noise[c] * prediction.noise[c];
    ++stretch.count;
  }
}

std::vector<double> autocorrelation(const std::vector<Prediction>& predictions, plant::ChannelId channel, bool after) {
  constexpr std::size_t lags = 41;  // up to 20 s
  std::vector<double> product(lags, 0.0);
  for (const Prediction& prediction : predictions) {
    const auto [rows, period_s] = measured_rows(*prediction.recording, channel);
    if (rows.size() < 2) continue;
    const auto residual = [&](std::size_t k) {
      return prediction.held_out[k] ? (after ? prediction.after : prediction.before)[channel][k] - prediction.measured[channel][k]
                                    : sim::not_a_number;
    };
    const double near_s = 0.5 * std::min(period_s, correlation_lag_s);
    for (std::size_t lag = 0; lag < lags; ++lag)
      for (std::size_t i = 0, j = 0; i < rows.size(); ++i) {
        const double at_s = prediction.time_s[rows[i]] + static_cast<double>(lag) * correlation_lag_s;
        const auto off_s = [&](std::size_t row) { return std::abs(prediction.time_s[rows[row]] - at_s); };
        while (j + 1 < rows.size() && off_s(j + 1) <= off_s(j)) ++j;
        if (off_s(j) > near_s) continue;
        const double value = residual(rows[i]) * residual(rows[j]);
        if (!std::isnan(value)) product[lag] += value;
      }
  }
  if (product[0] > 0.0)
    for (std::size_t lag = lags; lag-- > 0;) product[lag] /= product[0];
  return product;
}

}  // namespace

Split split(const sim::Recording& gated, double fit_until_s, bool keep_blocks) {
  Split result{gated, gated.samples.size(), std::vector<bool>(gated.samples.size(), false)};
  const std::size_t until = samples_until(gated, fit_until_s);
  if (until < gated.samples.size()) {
    result.sample_count = until;
    for (std::size_t k = until; k < gated.samples.size(); ++k) result.held_out[k] = true;
    return result;
  }
  if (!keep_blocks) return result;
  const double first_s = gated.samples.front().time_s, duration_s = gated.duration_s();
  const double guard = std::min(guard_s, 0.05 * duration_s);  // of a short recording it must not take all
  for (std::size_t k = 0; k < gated.samples.size(); ++k)
    for (const auto& [from, to] : held_out_shares) {
      const double time_s = gated.samples[k].time_s - first_s;
      if (time_s < from * duration_s - guard || time_s > to * duration_s + guard) continue;
      result.held_out[k] = result.held_out[k] || (time_s >= from * duration_s && time_s <= to * duration_s);
      mask(result.fitted.samples[k]);
    }
  return result;
}

std::vector<plant::InputId> driven_more(const plant::System& system, const sim::Recording& recording,
                                        const std::vector<FitData>& training) {
  std::vector<plant::InputId> more;
  for (const plant::InputId i : system.inputs().ids()) {
    Span fitted;
    for (const FitData& one : training)
      for (std::size_t k = 0; k < one.sample_count; ++k) fitted.include(one.recording->samples[k].inputs[i.index]);
    Span with = fitted;
    for (const sim::Sample& sample : recording.samples) with.include(sample.inputs[i.index]);
    if (fitted.width() == 0.0 && with.width() > 0.0) more.push_back(i);
  }
  return more;
}

HeldOutError error_of(const std::vector<Prediction>& predictions, std::uint64_t seed) {
  HeldOutError error;
  std::vector<double> total(bootstrap_draws, 0.0);
  std::size_t most_stretches = 0;
  const std::size_t channels = predictions.empty() ? 0 : predictions.front().measured.size();
  for (PerChannel* one : {&error.nominal, &error.fitted, &error.calibrated, &error.before, &error.after, &error.noise, &error.gain,
                          &error.gain_lowest, &error.gain_highest})
    *one = per_channel(channels);
  error.samples = plant::ListOf<plant::ChannelId, std::size_t>(channels, 0);
  for (const plant::ChannelId c : error.samples.ids()) {
    std::vector<Stretch> stretches;
    for (const Prediction& prediction : predictions) add_stretches(prediction, c, stretches);
    most_stretches = std::max(most_stretches, stretches.size());
    Stretch sum;
    for (const Stretch& s : stretches) {
      sum.nominal += s.nominal, sum.fitted += s.fitted, sum.calibrated += s.calibrated, sum.before += s.before;
      sum.after += s.after, sum.noise += s.noise, sum.count += s.count;
    }
    error.samples[c] = sum.count;
    if (sum.count == 0) {
      error.nominal[c] = error.fitted[c] = error.calibrated[c] = error.before[c] = error.after[c] = error.noise[c] = error.gain[c] =
          error.gain_lowest[c] = error.gain_highest[c] = sim::not_a_number;
      continue;
    }
    const auto n = static_cast<double>(sum.count);
    const auto rms = [&](double squares) { return squares < lost ? std::sqrt(squares / n) : sim::not_a_number; };
    error.nominal[c] = rms(sum.nominal);
    error.fitted[c] = rms(sum.fitted);
    error.calibrated[c] = rms(sum.calibrated);
    error.before[c] = rms(sum.before);
    error.after[c] = rms(sum.after);
    error.noise[c] = rms(sum.noise);
    error.gain[c] = 1.0 - error.after[c] / error.before[c];
    const sim::RandomStream chance(seed, "diagnose.gain." + std::to_string(c.index));
    std::vector<double> gains;
    std::uint64_t index = 0;
    for (double& of_draw : total) {
      double before = 0.0, after = 0.0;
      for (std::size_t i = 0; i < stretches.size(); ++i) {
        const auto pick =
            std::min(stretches.size() - 1, static_cast<std::size_t>(chance.uniform(index++) * static_cast<double>(stretches.size())));
        before += stretches[pick].before;
        after += stretches[pick].after;
      }
      gains.push_back(before > 0.0 ? 1.0 - std::sqrt(after / before) : 0.0);
      of_draw += (before - after) * n / sum.noise;
    }
    std::tie(error.gain_lowest[c], error.gain_highest[c]) = middle_95(gains);
  }
  std::tie(error.lowest_total_gain, error.highest_total_gain) = middle_95(total);
  if (most_stretches < least_stretches) {
    error.lowest_total_gain = -std::numeric_limits<double>::infinity();
    error.highest_total_gain = std::numeric_limits<double>::infinity();
  }
  return error;
}

void choose_before(std::vector<Prediction>& predictions) {
  if (predictions.empty()) return;
  for (const plant::ChannelId c : predictions.front().measured.ids()) {
    std::vector<Stretch> stretches;
    for (const Prediction& prediction : predictions) add_stretches(prediction, c, stretches);
    double fitted = 0.0, calibrated = 0.0;
    for (const Stretch& one : stretches) fitted += one.fitted, calibrated += one.calibrated;
    for (Prediction& prediction : predictions) prediction.before[c] = (calibrated < fitted ? prediction.calibrated : prediction.fitted)[c];
  }
}

ResidualCorrelation correlation_of(const std::vector<Prediction>& predictions) {
  ResidualCorrelation result;
  for (const plant::ChannelId c : plant::IdRange<plant::ChannelId>(predictions.empty() ? 0 : predictions.front().measured.size())) {
    result.before.push_back(autocorrelation(predictions, c, false));
    result.after.push_back(autocorrelation(predictions, c, true));
  }
  return result;
}

}  // namespace sinew::diagnose

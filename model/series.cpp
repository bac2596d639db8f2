// SPDX-License-Identifier: Apache-2.0
#include "model/series.h"

#include <cmath>
#include <stdexcept>

#include "sim/input_error.h"
#include "sim/text.h"

namespace sinew::model {
namespace {

double of_channel(const sim::Sample& sample, const Channel& channel) {
  return channel.temperature ? sample.temperature_degC[channel.coil] : sample.duty_fraction[channel.coil];
}

[[noreturn]] void refuse_missing(const std::string& name, const std::vector<sim::Sample>& samples, const std::string& column,
                                 std::size_t first, std::size_t count, int paper_case) {
  const bool all = count == samples.size();
  throw sim::InputError(
      {.file = name, .key = column,
       .value = all ? "nothing" : "not a number at " + sim::shortest(samples[first].time_s) + " s",
       .advice = all ? "case " + std::to_string(paper_case) + " needs it, and the recording has none"
                     : std::to_string(count) + " samples are missing; with --hold-missing the value before each is taken"});
}

}  // namespace

std::vector<Channel> channels_of(int paper_case) {
  const Channel duty_a{"duty_A", false, plant::A}, duty_b{"duty_B", false, plant::B};
  const Channel hot_a{"temperature_A_degC", true, plant::A}, hot_b{"temperature_B_degC", true, plant::B};
  switch (paper_case) {
    case 1: return {duty_a};
    case 2: return {duty_a, hot_a};
    case 3: return {duty_a, duty_b};
    case 4: return {duty_a, hot_a, duty_b, hot_b};
  }
  throw std::invalid_argument("the paper's cases are 1 to 4, not " + std::to_string(paper_case));
}

Series series_of(const sim::Recording& recording, int paper_case, Missing missing) {
  const auto channels = channels_of(paper_case);
  const double median_s = recording.median_period_s();
  if (!(std::abs(median_s - period_s) <= 0.02 * period_s))
    throw sim::InputError({.file = recording.name, .key = "time_s", .value = "a sample every " + sim::shortest(std::round(1e6 * median_s) / 1e6) + " s",
                           .advice = "the predictor works at 10 Hz, a sample every 0.1 s"});
  std::vector<sim::Sample> samples;
  for (const sim::Sample& sample : recording.samples) {
    if (!samples.empty()) {
      const double step_s = sample.time_s - samples.back().time_s, lost = std::round(step_s / period_s) - 1.0;
      const bool held = missing == Missing::held && lost >= 1.0 && step_s <= longest_held_s;
      if (!held && std::abs(step_s - period_s) > 0.2 * period_s)
        throw sim::InputError({.file = recording.name, .key = "time_s", .value = sim::shortest(sample.time_s),
                               .advice = "comes " + sim::shortest(std::round(1e6 * step_s) / 1e6) +
                                         " s after the sample before; the predictor needs one every 0.1 s"});
      const sim::Sample before = samples.back();
      for (double k = 1.0; k <= lost; ++k)  // rows that are missing: the duty is held, all else is missing
        samples.push_back({before.time_s + k * period_s, before.duty_fraction, {std::nan(""), std::nan("")}, std::nan("")});
    }
    samples.push_back(sample);
  }
  Series series{recording.name, samples.front().time_s, Matrix<double>(channels.size(), samples.size()),
                Vector<double>(samples.size())};
  const auto fill = [&](const std::string& column, auto&& value_of, auto&& entry) {
    std::size_t count = 0, first = 0;
    for (std::size_t k = samples.size(); k-- > 0;)
      if (std::isnan(value_of(samples[k]))) {
        first = k;
        ++count;
      }
    if (count == samples.size() || (count > 0 && missing == Missing::refused))
      refuse_missing(recording.name, samples, column, first, count, paper_case);
    double last = 0.0;
    for (std::size_t k = 0; k < samples.size(); ++k)  // what is missing at the very beginning is what comes first
      if (!std::isnan(value_of(samples[k]))) {
        last = value_of(samples[k]);
        break;
      }
    for (std::size_t k = 0; k < samples.size(); ++k) {
      if (const double value = value_of(samples[k]); !std::isnan(value)) last = value;
      entry(static_cast<Index>(k)) = last;
    }
  };
  for (std::size_t c = 0; c < channels.size(); ++c)
    fill(channels[c].name, [&](const sim::Sample& sample) { return of_channel(sample, channels[c]); },
         [&](Index k) -> double& { return series.v(static_cast<Index>(c), k); });
  fill("angle_deg", [](const sim::Sample& sample) { return sample.angle_deg; },
       [&](Index k) -> double& { return series.angle_deg(k); });
  return series;
}

Series part_of(const Series& series, Index first, Index count) {
  return {series.name, series.first_s + static_cast<double>(first) * period_s, series.v.middleCols(first, count),
          series.angle_deg.segment(first, count)};
}

Scaling scaling_of(const std::vector<Series>& training, int paper_case) {
  const auto channels = channels_of(paper_case);
  Scaling scaling{Vector<double>::Zero(static_cast<Index>(channels.size())),
                  Vector<double>::Ones(static_cast<Index>(channels.size()))};
  const auto span = [](double low, double high) { return high > low ? high - low : 1.0; };
  for (std::size_t c = 0; c < channels.size(); ++c) {
    if (!channels[c].temperature) continue;
    double low = HUGE_VAL, high = -HUGE_VAL;
    for (const Series& one : training) {
      low = std::min(low, one.v.row(static_cast<Index>(c)).minCoeff());
      high = std::max(high, one.v.row(static_cast<Index>(c)).maxCoeff());
    }
    scaling.v_offset(static_cast<Index>(c)) = low;
    scaling.v_span(static_cast<Index>(c)) = span(low, high);
  }
  double low = HUGE_VAL, high = -HUGE_VAL;
  for (const Series& one : training) {
    low = std::min(low, one.angle_deg.minCoeff());
    high = std::max(high, one.angle_deg.maxCoeff());
  }
  scaling.angle_offset_deg = low;
  scaling.angle_span_deg = span(low, high);
  return scaling;
}

ScaledSeries scaled(const Series& series, const Scaling& scaling) {
  const Index n = series.samples(), K = series.v.rows();
  const Matrix<float> v = ((series.v.colwise() - scaling.v_offset).array().colwise() / scaling.v_span.array()).cast<float>();
  ScaledSeries result{Matrix<float>(2 * K, n - 1),
                      ((series.angle_deg.array() - scaling.angle_offset_deg) / scaling.angle_span_deg).cast<float>()};
  result.exogenous << v.rightCols(n - 1), v.leftCols(n - 1);
  return result;
}

}  // namespace sinew::model

// SPDX-License-Identifier: Apache-2.0
#include "model/series.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "plant/contains.h"
#include "sim/input_error.h"
#include "sim/text.h"

namespace sinew::model {
namespace {

[[noreturn]] void refuse_missing(const std::string& name, const std::vector<sim::Sample>& samples, const std::string& column,
                                 std::size_t first, std::size_t count, int paper_case) {
  const bool all = count == samples.size();
  throw sim::InputError(
      {.file = name,
       .key = column,
       .value = all ? "nothing" : "not a number at " + sim::shortest(samples[first].time_s) + " s",
       .advice = all ? "case " + std::to_string(paper_case) + " needs it, and the recording has none"
                     : std::to_string(count) + " samples are missing; with --hold-missing the value before each is taken"});
}

}  // namespace

Task task_of(const plant::System& system, int paper_case, std::optional<plant::ChannelId> predicted) {
  if (paper_case < 1 || paper_case > 4) throw std::invalid_argument("the paper's cases are 1 to 4, not " + std::to_string(paper_case));
  const bool one_input = paper_case <= 2, with_measured = paper_case % 2 == 0;
  if (!predicted && !system.drives().empty()) predicted = system.drives().front().channel;
  if (!predicted && system.channels().size() == 1) predicted = plant::ChannelId{};
  if (!predicted) throw std::invalid_argument("nothing says which channel of this plant is to be predicted");
  const std::string_view predicted_kind = system.channels()[*predicted].kind;
  plant::InputId first;
  for (const plant::Drive& drive : system.drives())
    if (drive.channel == *predicted) {
      first = drive.input;
      break;
    }
  const sim::Columns columns = sim::columns_of(system);
  Task task{.paper_case = paper_case, .features = {}, .predicted = columns.channels[predicted->index]};
  const auto add_measured = [&](std::optional<plant::InputId> driven_by) {
    for (const plant::ChannelId c : system.channels().ids()) {
      const plant::ChannelInfo& channel = system.channels()[c];
      if (c != *predicted && channel.kind != predicted_kind && channel.driven_by == driven_by)
        task.features.push_back({columns.channels[c.index], true});
    }
  };
  for (const plant::InputId i : system.inputs().ids()) {
    if (one_input && i != first) continue;
    task.features.push_back({columns.inputs[i.index], false});
    if (with_measured) add_measured(i);
  }
  if (with_measured) add_measured(std::nullopt);
  return task;
}

sim::Columns columns_of(const Task& task) {
  sim::Columns columns;
  for (const Feature& feature : task.features) (feature.measured ? columns.channels : columns.inputs).push_back(feature.column);
  if (!contains(columns.channels, task.predicted)) columns.channels.push_back(task.predicted);
  return columns;
}

namespace {

std::string listed(const sim::Columns& columns) {
  std::string names;
  for (const auto* some : {&columns.inputs, &columns.channels})
    for (const sim::Column& one : *some) names += (names.empty() ? "" : ", ") + one.name;
  return names;
}

}  // namespace

Places places_in(const sim::Columns& columns, const Task& task, const std::string& recording) {
  const auto place = [&](const sim::Column& column, bool measured) -> std::size_t {
    const auto& among = measured ? columns.channels : columns.inputs;
    const auto found = std::find(among.begin(), among.end(), column);
    if (found == among.end())
      throw sim::InputError({.file = recording,
                             .key = column.name,
                             .value = "nothing",
                             .advice = "the predictor needs it; what is there: " + listed(columns)});
    return static_cast<std::size_t>(found - among.begin());
  };
  Places places;
  for (const Feature& feature : task.features) places.features.push_back({feature.measured, place(feature.column, feature.measured)});
  places.predicted = place(task.predicted, true);
  return places;
}

sim::Recording on_grid(const sim::Recording& recording) {
  const std::vector<sim::Sample>& from = recording.samples;
  sim::Recording to = recording;
  to.samples.clear();
  // Of each channel, the last sample that has it at or before now, and the first after.
  const std::size_t channels = from.front().channels.size(), none = from.size();
  std::vector<std::size_t> before(channels, none), after(channels, 0);
  const auto next_with = [&](std::size_t c, std::size_t i) {
    while (i < from.size() && std::isnan(from[i].channels[c])) ++i;
    return i;
  };
  for (std::size_t c = 0; c < channels; ++c) after[c] = next_with(c, 0);
  std::size_t held = 0;
  const double first_s = from.front().time_s;
  const auto count = static_cast<Index>(std::floor((from.back().time_s - first_s) / period_s + 1e-6)) + 1;
  for (Index k = 0; k < count; ++k) {
    const double now_s = first_s + static_cast<double>(k) * period_s, reached_s = now_s + 1e-6 * period_s;
    while (held + 1 < from.size() && from[held + 1].time_s <= reached_s) ++held;
    sim::Sample sample{now_s, from[held].inputs, std::vector<double>(channels, std::nan(""))};
    for (std::size_t c = 0; c < channels; ++c) {
      while (after[c] < from.size() && from[after[c]].time_s <= reached_s) {
        before[c] = after[c];
        after[c] = next_with(c, after[c] + 1);
      }
      if (before[c] == none) continue;
      const sim::Sample& a = from[before[c]];
      if (now_s - a.time_s <= 1e-6 * period_s) {
        sample.channels[c] = a.channels[c];
      } else if (after[c] < from.size() && from[after[c]].time_s - a.time_s <= longest_gap_s) {
        const sim::Sample& b = from[after[c]];
        sample.channels[c] = a.channels[c] + (b.channels[c] - a.channels[c]) * (now_s - a.time_s) / (b.time_s - a.time_s);
      }
    }
    to.samples.push_back(std::move(sample));
  }
  return to;
}

Series series_of(const sim::Recording& recording, const Task& task, Missing missing) {
  if (missing == Missing::resampled) {
    const sim::Recording grid = on_grid(recording);
    const std::size_t predicted = places_in(recording.columns, task, recording.name).predicted;
    Series series = series_of(grid, task, Missing::held);
    series.counted.resize(series.samples());
    for (Index k = 0, before = -1; k < series.samples(); ++k) {
      const bool measured = !std::isnan(grid.samples[static_cast<std::size_t>(k)].channels[predicted]);
      series.counted(k) = measured ? 1.0 : 0.0;
      if (!measured) continue;
      if (before >= 0 && k - before > 1)
        for (Index i = before + 1; i < k; ++i)
          series.y(i) =
              series.y(before) + (series.y(k) - series.y(before)) * static_cast<double>(i - before) / static_cast<double>(k - before);
      before = k;
    }
    return series;
  }
  const Places places = places_in(recording.columns, task, recording.name);
  const double median_s = recording.median_period_s();
  if (!(std::abs(median_s - period_s) <= 0.02 * period_s))
    throw sim::InputError({.file = recording.name,
                           .key = "time_s",
                           .value = "a sample every " + sim::shortest(std::round(1e6 * median_s) / 1e6) + " s",
                           .advice = "the predictor works at 10 Hz, a sample every 0.1 s"});
  std::vector<sim::Sample> samples;
  for (const sim::Sample& sample : recording.samples) {
    if (!samples.empty()) {
      const double step_s = sample.time_s - samples.back().time_s, lost = std::round(step_s / period_s) - 1.0;
      const bool held = missing == Missing::held && lost >= 1.0 && step_s <= longest_held_s;
      if (!held && std::abs(step_s - period_s) > 0.2 * period_s)
        throw sim::InputError({.file = recording.name,
                               .key = "time_s",
                               .value = sim::shortest(sample.time_s),
                               .advice = "comes " + sim::shortest(std::round(1e6 * step_s) / 1e6) +
                                         " s after the sample before; the predictor needs one every 0.1 s"});
      const sim::Sample before = samples.back();
      for (double k = 1.0; k <= lost; ++k)  // rows that are missing: inputs are held, all else is missing
        samples.push_back({before.time_s + k * period_s, before.inputs, std::vector<double>(before.channels.size(), std::nan(""))});
    }
    samples.push_back(sample);
  }
  Series series{recording.name, samples.front().time_s, Matrix<double>(task.features.size(), samples.size()),
                Vector<double>(samples.size())};
  const auto fill = [&](const std::string& column, auto&& value_of, auto&& entry) {
    std::size_t count = 0, first = 0;
    for (std::size_t k = samples.size(); k-- > 0;)
      if (std::isnan(value_of(samples[k]))) {
        first = k;
        ++count;
      }
    if (count == samples.size() || (count > 0 && missing == Missing::refused))
      refuse_missing(recording.name, samples, column, first, count, task.paper_case);
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
  for (std::size_t f = 0; f < task.features.size(); ++f) {
    const auto [measured, index] = places.features[f];
    fill(
        task.features[f].column.name, [&](const sim::Sample& sample) { return measured ? sample.channels[index] : sample.inputs[index]; },
        [&](Index k) -> double& { return series.v(static_cast<Index>(f), k); });
  }
  fill(
      task.predicted.name, [&](const sim::Sample& sample) { return sample.channels[places.predicted]; },
      [&](Index k) -> double& { return series.y(k); });
  return series;
}

Series part_of(const Series& series, Index first, Index count) {
  return {series.name, series.first_s + static_cast<double>(first) * period_s, series.v.middleCols(first, count),
          series.y.segment(first, count), series.counted.size() > 0 ? series.counted.segment(first, count) : Vector<double>()};
}

Index training_samples(const Series& series, double training_fraction) {
  return std::max(Index{1}, static_cast<Index>(std::floor(training_fraction * static_cast<double>(series.samples()))));
}

std::vector<Series> training_parts(const std::vector<Series>& recordings, double training_fraction) {
  std::vector<Series> parts;
  for (const Series& one : recordings) parts.push_back(part_of(one, 0, training_samples(one, training_fraction)));
  return parts;
}

Scaling scaling_of(const std::vector<Series>& training, const Task& task, Scaled which) {
  const auto features = static_cast<Index>(task.features.size());
  Scaling scaling{Vector<double>::Zero(features), Vector<double>::Ones(features)};
  // To 0 ... 1; what does not move keeps its unit.
  const auto scale = [&](auto&& row_of, double& offset, double& span) {
    double low = HUGE_VAL, high = -HUGE_VAL;
    for (const Series& one : training) {
      low = std::min(low, row_of(one).minCoeff());
      high = std::max(high, row_of(one).maxCoeff());
    }
    offset = low;
    span = high > low ? high - low : 1.0;
  };
  for (Index f = 0; f < features; ++f)
    if (const Feature& feature = task.features[static_cast<std::size_t>(f)];
        which == Scaled::all || feature.measured || !feature.column.unit.empty())
      scale([&](const Series& one) { return one.v.row(f); }, scaling.v_offset(f), scaling.v_span(f));
  const auto measured = [](const Series& one) {
    Vector<double> y(one.samples());
    Index n = 0;
    for (Index k = 0; k < one.samples(); ++k)
      if (one.is_measured(k)) y(n++) = one.y(k);
    return Vector<double>(y.head(n));
  };
  scale(measured, scaling.y_offset, scaling.y_span);
  return scaling;
}

ScaledSeries scaled(const Series& series, const Scaling& scaling) {
  const Index n = series.samples(), K = series.v.rows();
  const Matrix<float> v = ((series.v.colwise() - scaling.v_offset).array().colwise() / scaling.v_span.array()).cast<float>();
  ScaledSeries result{Matrix<float>(2 * K, n - 1), ((series.y.array() - scaling.y_offset) / scaling.y_span).cast<float>()};
  result.exogenous << v.rightCols(n - 1), v.leftCols(n - 1);
  return result;
}

}  // namespace sinew::model

// SPDX-License-Identifier: Apache-2.0
#include "model/interval.h"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "model/predictor.h"
#include "model/task_json.h"
#include "sim/parallel.h"

namespace sinew::model {
namespace {

using IntervalJson = nlohmann::ordered_json;

// Ends of the steps: errors change most right after the beginning.
constexpr std::array<double, 12> ends_s{0.5, 1.0, 2.0, 4.0, 8.0, 15.0, 30.0, 60.0, 120.0, 300.0, 600.0, 3600.0};
constexpr Index minute = 600, least_samples = static_cast<Index>(shortest_for_intervals_s / period_s + 0.5);
constexpr std::size_t least_recordings = 5;  // that are units; of fewer, minutes are
constexpr Index starts_a_recording = 4, most_starts = 20, least_apart = 300;

std::size_t step_at(Index samples_since) {
  const double since_s = static_cast<double>(samples_since) * period_s;
  std::size_t i = 0;
  while (i + 1 < ends_s.size() && since_s > ends_s[i] + 1e-9) ++i;
  return i;
}

// Absolute errors of one unit in one step.
struct UnitErrors {
  std::size_t step;
  std::int64_t unit;
  std::vector<double> open, ahead;
};

// interval.h. Infinite where an error is that is needed.
double half_width_of(const std::vector<const std::vector<double>*>& units) {
  const auto M = static_cast<double>(units.size());
  std::vector<std::pair<double, std::size_t>> errors;  // and of which unit
  for (std::size_t u = 0; u < units.size(); ++u)
    for (const double error : *units[u]) errors.emplace_back(error, u);
  std::sort(errors.begin(), errors.end());
  if (units.size() == 1) return errors.back().first;
  const auto weight = [&](std::size_t unit) { return 1.0 / static_cast<double>(units[unit]->size()); };

  // Of each error, the share of the other units' errors that lie below it: the least level at which a width from these holds it.
  std::vector<std::pair<double, double>> levels;  // and its weight
  std::vector<double> own(units.size(), 0.0);     // shares that lie below, of each unit, and the sum of these
  double all = 0.0;
  for (std::size_t i = 0, end = 0; i < errors.size(); i = end) {
    while (end < errors.size() && errors[end].first == errors[i].first) ++end;
    for (std::size_t k = i; k < end; ++k) levels.emplace_back((all - own[errors[k].second]) / (M - 1.0), weight(errors[k].second) / M);
    for (std::size_t k = i; k < end; ++k) {
      all += weight(errors[k].second);
      own[errors[k].second] += weight(errors[k].second);
    }
  }
  std::sort(levels.begin(), levels.end());
  double held = 0.0, level = 1.0;  // no width from the others holds the largest error: there the level stays 1
  for (const auto& [below, share] : levels)
    if ((held += share) >= interval_share - 1e-12) {
      level = below;
      break;
    }
  double sum = 0.0;
  for (const auto& [error, unit] : errors)
    if ((sum += weight(unit) / M) > level + 1e-12) return error;
  return errors.back().first;
}

// Places at which rollouts begin, where something was measured.
std::vector<Index> starts_in(const SetAside& one, bool unit_is_recording) {
  const Index n = one.series.samples(), first = one.from > 0 ? one.from : n / 10, left = n - first;
  const Index wanted = unit_is_recording ? starts_a_recording : std::clamp(left / least_apart, Index{1}, most_starts);
  std::vector<Index> starts;
  for (Index i = 0; i < wanted; ++i) {
    Index at = first + i * left / wanted;
    while (at < n && !one.series.is_measured(at)) ++at;
    if (n - at >= least_samples && (starts.empty() || at > starts.back())) starts.push_back(at);
  }
  return starts;
}

}  // namespace

const IntervalSteps* Intervals::steps_for(Beginning beginning) const {
  const auto steps = [&](Beginning one) {
    const auto& found = by_beginning[static_cast<std::size_t>(one)];
    return found ? &*found : nullptr;
  };
  if (const auto* own = steps(beginning)) return own;
  return steps(Beginning::in_motion);
}

double promised_share(const IntervalSteps& steps) {
  const auto fewest = static_cast<double>(*std::min_element(steps.units.begin(), steps.units.end()));
  return std::min(interval_share, fewest / (fewest + 1.0));
}

Vector<double> half_widths(const IntervalSteps& steps, bool one_step, Index samples) {
  Vector<double> result = Vector<double>::Zero(samples);
  const std::vector<double>& widths = one_step ? steps.one_step : steps.open_loop;
  std::size_t i = 0;
  for (Index k = 1; k < samples; ++k) {
    while (i + 1 < widths.size() && static_cast<double>(k) * period_s > steps.until_s[i] + 1e-9) ++i;
    result(k) = widths[i];
  }
  return result;
}

double share_inside(const Vector<double>& predicted, const Vector<double>& half_width, const Series& series) {
  double inside = 0.0, counted = 0.0;
  for (Index k = 1; k < series.samples(); ++k) {
    if (!series.is_measured(k)) continue;
    ++counted;
    inside += std::abs(predicted(k) - series.y(k)) <= half_width(k);
  }
  return inside / counted;
}

Intervals intervals_from(const Predictor& predictor, const std::vector<SetAside>& data, int threads,
                         const std::function<bool()>& should_stop) {
  Intervals intervals;
  intervals.unit_is_recording = data.size() >= least_recordings;
  for (const Beginning beginning : {Beginning::at_first, Beginning::in_motion, Beginning::after_history}) {
    if (beginning == Beginning::at_first && !intervals.unit_is_recording) continue;
    // Of each recording, in one step after the other: errors by unit.
    std::vector<std::vector<UnitErrors>> found(data.size());
    sim::in_parallel(data.size(), threads, [&](std::size_t r) {
      const SetAside& one = data[r];
      std::vector<Index> starts{0};
      if (beginning != Beginning::at_first)
        starts = starts_in(one, intervals.unit_is_recording);
      else if (one.from > 0 || one.series.samples() < least_samples || !one.series.is_measured(0))
        return;
      const auto own = predictor.copy();
      for (const Index start : starts) {
        if (should_stop && should_stop()) throw Stopped{};
        const Index past = beginning == Beginning::after_history ? std::min(start, static_cast<Index>(longest_history_s / period_s)) : 0;
        if (beginning == Beginning::after_history && static_cast<double>(past) * period_s < enough_history_s) continue;
        const Series history = part_of(one.series, start - past, past + 1), rest = part_of(one.series, start, one.series.samples() - start);
        const Vector<double> open = rollout(*own, rest, &history), ahead = one_step_ahead(*own, rest, &history);
        for (Index k = 1; k < rest.samples(); ++k) {
          if (!rest.is_measured(k)) continue;
          const std::size_t step = step_at(k);
          const std::int64_t unit = intervals.unit_is_recording ? 0 : (start - one.from + k) / minute;
          auto to = std::find_if(found[r].rbegin(), found[r].rend(), [&](const auto& u) { return u.step == step && u.unit == unit; });
          if (to == found[r].rend()) {
            found[r].push_back({step, unit, {}, {}});
            to = found[r].rbegin();
          }
          const auto bounded = [](double error) { return std::isfinite(error) ? std::abs(error) : HUGE_VAL; };
          to->open.push_back(bounded(open(k) - rest.y(k)));
          to->ahead.push_back(bounded(ahead(k) - rest.y(k)));
        }
      }
    });
    IntervalSteps steps;
    std::size_t most_units = 0;
    for (std::size_t i = 0; i < ends_s.size(); ++i) {
      std::vector<const std::vector<double>*> open, ahead;
      for (const auto& of_recording : found)
        for (const UnitErrors& unit : of_recording)
          if (unit.step == i) {
            open.push_back(&unit.open);
            ahead.push_back(&unit.ahead);
          }
      // Where few rollouts come so far, the step before holds on.
      most_units = std::max(most_units, open.size());
      if (open.empty() || 2 * open.size() < most_units) break;
      steps.until_s.push_back(ends_s[i]);
      steps.open_loop.push_back(half_width_of(open));
      steps.one_step.push_back(half_width_of(ahead));
      steps.units.push_back(static_cast<Index>(open.size()));
    }
    const auto bounded = [](const std::vector<double>& all) {
      return std::all_of(all.begin(), all.end(), [](double w) { return std::isfinite(w); });
    };
    if (!steps.until_s.empty() && bounded(steps.open_loop) && bounded(steps.one_step))
      intervals.by_beginning[static_cast<std::size_t>(beginning)] = std::move(steps);
  }
  return intervals;
}

nlohmann::ordered_json json_of(const Intervals& intervals) {
  IntervalJson json{{"share", interval_share},
                    {"unit", intervals.unit_is_recording ? "recording" : "minute"},
                    {"taken_from", intervals.taken_from}};
  for (std::size_t b = 0; b < beginning_names.size(); ++b)
    if (const auto& steps = intervals.by_beginning[b])
      json[std::string(beginning_names[b])] = {{"until_s", steps->until_s},
                                               {"open_loop", steps->open_loop},
                                               {"one_step", steps->one_step},
                                               {"units", steps->units}};
  return json;
}

Intervals intervals_of_json(const nlohmann::ordered_json& json, const std::string& file) {
  Intervals intervals;
  if (json.at("share") != interval_share) complain(file, "intervals", json.at("share").dump(), "are not of this version's share");
  intervals.unit_is_recording = json.at("unit") == "recording";
  intervals.taken_from = json.at("taken_from");
  for (std::size_t b = 0; b < beginning_names.size(); ++b) {
    const auto found = json.find(beginning_names[b]);
    if (found == json.end()) continue;
    IntervalSteps steps{found->at("until_s"), found->at("open_loop"), found->at("one_step"), found->at("units")};
    const std::size_t count = steps.until_s.size();
    if (count == 0 || steps.open_loop.size() != count || steps.one_step.size() != count || steps.units.size() != count)
      complain(file, "intervals", std::to_string(count) + " steps", "every step needs its widths and its number of units");
    intervals.by_beginning[b] = std::move(steps);
  }
  return intervals;
}

}  // namespace sinew::model

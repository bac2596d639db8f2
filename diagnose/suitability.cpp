// SPDX-License-Identifier: Apache-2.0
#include "diagnose/suitability.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "diagnose/gate.h"
#include "sim/log_map.h"
#include "sim/text.h"

namespace sinew::diagnose {
namespace {

constexpr double least_averages = 120.0;     // blocks of what a plant can do: a minute of a limb, three of a wire's time constants
constexpr std::size_t least_samples = 200;   // of a System that is not averaged
constexpr double least_motion_noises = 8.0;  // from lowest to highest: twice the reach of noise

std::string listed(const std::vector<std::string>& names) {
  std::string text;
  for (std::size_t i = 0; i < names.size(); ++i) text += (i == 0 ? "" : i + 1 == names.size() ? " and " : ", ") + names[i];
  return text;
}

// Rows that stand still, and the leap after them.
constexpr std::size_t least_rows = 4, most_leap_rows = 3, most_rows_around = 10;
constexpr double still_share = 0.15;       // of the leap: what stands still moves by less
constexpr double before_share = 0.25;      // of the leap: what moved before went further, the same way, in as many rows
constexpr double faster_than_steps = 1.5;  // and than any step there
constexpr double faster = 2.0;             // a leap is so many times faster than the motion before and after it
constexpr double least_leap_noises = 10.0, least_leap_share = 0.05;  // of the whole range

struct Leap {
  std::size_t first, last, rows;  // stands still from first to last, and has leapt `rows` later
};

bool is_leap(const std::vector<double>& v, std::size_t first, std::size_t last, std::size_t rows) {
  const std::size_t around = std::min(last - first + 1, most_rows_around), end = last + rows;
  if (end + around >= v.size() || first < around) return false;
  const double leap = v[end] - v[last], sense = leap < 0.0 ? -1.0 : 1.0, n = static_cast<double>(around);
  const double before = sense * (v[first] - v[first - around]), after = sense * (v[end + around] - v[end]);
  if (!(before >= before_share * std::abs(leap)) || std::isnan(after)) return false;
  const double pace = std::abs(leap) / static_cast<double>(rows);
  // A converter that is slower than the logger leaps all the time.
  double largest_step = 0.0;
  for (std::size_t i = 0; i < around; ++i)
    largest_step = std::max({largest_step, std::abs(v[first - i] - v[first - i - 1]), std::abs(v[end + i + 1] - v[end + i])});
  return pace >= faster * std::max(before, after) / n && pace >= faster_than_steps * largest_step;
}

std::vector<Leap> leaps(const std::vector<double>& v, double noise) {
  Span whole;
  for (const double value : v) whole.include(value);
  const double least = std::max(least_leap_noises * noise, least_leap_share * whole.width());
  std::vector<Leap> found;
  for (std::size_t last = least_rows - 1; last + 1 < v.size(); ++last) {
    for (std::size_t rows = 1; rows <= most_leap_rows && last + rows < v.size(); ++rows) {
      const double leap = v[last + rows] - v[last];
      if (!(std::abs(leap) >= least)) continue;
      bool one_way = true;
      for (std::size_t i = 0; i < rows; ++i) one_way = one_way && (v[last + i + 1] - v[last + i]) * leap > 0.0;
      Span still;
      std::size_t first = last;
      still.include(v[last]);
      while (first > 0 && !std::isnan(v[first - 1])) {
        Span wider = still;
        wider.include(v[first - 1]);
        if (wider.width() > still_share * std::abs(leap)) break;
        still = wider;
        --first;
      }
      if (!one_way || last - first + 1 < least_rows || !is_leap(v, first, last, rows)) continue;
      found.push_back({first, last, rows});
      last += rows;
      break;
    }
  }
  return found;
}

}  // namespace

std::vector<std::string> shortcomings(const plant::System& system, const sim::Recording& recording, const PerChannel& noise) {
  std::vector<std::string> found;
  const double duration_s = recording.duration_s(), least_s = least_averages * system.averaging_s();
  if (duration_s < least_s)
    found.push_back("it lasts " + sim::rounded(duration_s) + " s, and says little of anything slow: at least " + sim::shortest(least_s) +
                    " s are needed, ten minutes are better");
  else if (recording.samples.size() < least_samples)
    found.push_back("it has " + std::to_string(recording.samples.size()) + " samples: at least " + std::to_string(least_samples) +
                    " are needed");

  const auto& inputs = system.inputs();
  std::vector<std::string> moving, resting;
  std::vector<bool> moves(inputs.size());
  for (const plant::InputId i : inputs.ids()) {
    Span span;
    for (const sim::Sample& sample : recording.samples) span.include(sample.inputs[i.index]);
    moves[i.index] = span.width() > 0.0;
    (moves[i.index] ? moving : resting).push_back(inputs[i].words);
  }
  if (moving.empty())
    found.push_back("no input ever changes: what the plant does when it is driven cannot be learnt");
  else if (!resting.empty())
    found.push_back(listed(resting) + (resting.size() == 1 ? " never changes" : " never change") + ": what belongs there cannot be learnt");
  if (moving.size() > 1) {
    const bool alike = std::all_of(recording.samples.begin(), recording.samples.end(), [&](const sim::Sample& sample) {
      double first = sim::not_a_number;
      for (const plant::InputId i : inputs.ids()) {
        if (!moves[i.index]) continue;
        if (std::isnan(first)) first = sample.inputs[i.index];
        if (sample.inputs[i.index] != first) return false;
      }
      return true;
    });
    if (alike) found.push_back(listed(moving) + " are always equal: what each does alone cannot be told");
  }

  for (const plant::ChannelId c : system.channels().ids()) {
    const plant::ChannelInfo& info = system.channels()[c];
    Span span;
    for (const sim::Sample& sample : recording.samples) span.include(measured(sample, c));
    const bool own_input_rests = info.driven_by && !moves[info.driven_by->index];
    if (span.none())
      found.push_back(info.words + " is never measured");
    else if (const auto stuck = unresponsive(system, recording, c))
      found.push_back(stuck->words);
    else if (!moving.empty() && !own_input_rests && span.width() < least_motion_noises * noise[c])
      found.push_back(info.words + " never moves by more than its noise: nothing can be learnt from it");
  }
  return found;
}

std::vector<SuspectedMisreading> suspected_misreadings(const plant::System& system, const sim::Recording& recording,
                                                       const PerChannel& noise) {
  std::vector<SuspectedMisreading> found;
  for (const plant::ChannelId c : system.channels().ids()) {
    std::vector<double> values;
    for (const sim::Sample& sample : recording.samples) values.push_back(measured(sample, c));
    for (const Leap& leap : leaps(values, noise[c]))
      found.push_back({c, recording.samples[leap.first].time_s, recording.samples[leap.last + leap.rows].time_s, values[leap.last],
                       values[leap.last + leap.rows] - values[leap.last]});
  }
  return found;
}

}  // namespace sinew::diagnose

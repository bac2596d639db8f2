// SPDX-License-Identifier: Apache-2.0
#include "diagnose/gate.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

#include "sim/log_map.h"
#include "sim/text.h"

namespace sinew::diagnose {
namespace {

constexpr std::size_t reach = 3;  // neighbours on each side

// Where the limb moves fast its neighbours say little of a sample, but the line through them does: the distance from
// it, and the largest of theirs. A bend, a turn or a jump puts both off alike. NaN without two neighbours on each side.
struct OffLine {
  double own, neighbours;
};
OffLine off_line(const std::vector<double>& values, std::size_t k) {
  if (k < 2 || k + 2 >= values.size()) return {sim::not_a_number, sim::not_a_number};
  constexpr std::array<double, 4> at{-2.0, -1.0, 1.0, 2.0};
  std::array<double, 4> value;
  double mean = 0.0, slope = 0.0;
  for (std::size_t i = 0; i < 4; ++i) {
    value[i] = values[i < 2 ? k - 2 + i : k - 1 + i];
    mean += value[i] / 4.0;
    slope += at[i] * value[i] / 10.0;
  }
  OffLine off{std::abs(values[k] - mean), 0.0};
  for (std::size_t i = 0; i < 4; ++i) off.neighbours = std::max(off.neighbours, std::abs(value[i] - mean - slope * at[i]));
  return off;
}

// Masks those that its samples show. How many. `ends`: also within `reach` of the recording's ends.
std::size_t mask_plain_outliers(sim::Recording& recording, plant::ChannelId channel, double noise, bool ends) {
  std::size_t count = 0;
  const std::vector<std::size_t> rows = measured_rows(recording, channel).rows;
  std::vector<double> values;  // as they were: none that is masked here judges another
  for (const std::size_t row : rows) values.push_back(measured(recording.samples[row], channel));
  for (std::size_t k = 0; k < values.size(); ++k) {
    const double value = values[k];
    const bool at_end = k < reach || k + reach >= values.size();
    if (at_end && !ends) continue;
    std::vector<double> around;
    std::size_t before = 0;
    // The six nearest; at the ends they all lie on one side.
    const std::size_t window = std::min(2 * reach, values.size() - 1);
    const std::size_t begin = std::min(k - std::min(k, reach), values.size() - 1 - window);
    for (std::size_t i = begin; i <= begin + window; ++i)
      if (i != k) {
        around.push_back(values[i]);
        before += i < k;
      }
    // With one on one side and three on the other, the median of samples on a steep line is off it.
    if (around.size() < 4 || (!at_end && (before < 2 || around.size() - before < 2))) continue;
    std::sort(around.begin(), around.end());
    // The extremes may be outliers themselves.
    const double range = around[around.size() - 2] - around[1];
    const double median = 0.5 * (around[(around.size() - 1) / 2] + around[around.size() / 2]);
    const OffLine off = off_line(values, k);
    if (std::abs(value - median) > 8.0 * noise + range || off.own > 8.0 * noise + 3.0 * off.neighbours) {
      measured(recording.samples[rows[k]], channel) = sim::not_a_number;
      ++count;
    }
  }
  return count;
}

// Of three outliers within a few samples the one in the middle shows only when the others are gone.
std::size_t mask_outliers(sim::Recording& recording, plant::ChannelId channel, double noise) {
  std::size_t count = mask_plain_outliers(recording, channel, noise, true);
  for (std::size_t more = count; more > 0; count += more) more = mask_plain_outliers(recording, channel, noise, false);
  return count;
}

double longest_run_share(const sim::Recording& recording, plant::ChannelId channel) {
  std::size_t longest = 0, run = 0;
  double last = sim::not_a_number;
  const std::vector<std::size_t> rows = measured_rows(recording, channel).rows;
  for (const std::size_t row : rows) {
    const sim::Sample& sample = recording.samples[row];
    const double value = measured(sample, channel);
    run = value == last ? run + 1 : 1;
    last = value;
    // What rests shows one value for long; what is driven does not.
    const bool driven = std::any_of(sample.inputs.begin(), sample.inputs.end(), [](double input) { return input != 0.0; });
    if (driven) longest = std::max(longest, run);
  }
  return static_cast<double>(longest) / static_cast<double>(std::max<std::size_t>(rows.size(), 1));
}

// What should move a channel, sample by sample: the input of its part; what all inputs together do to it, each in its own sense; else all.
std::vector<double> drive_of(const plant::System& system, const sim::Recording& recording, plant::ChannelId channel) {
  const auto driven_by = system.channels()[channel].driven_by;
  const bool has_drives =
      std::any_of(system.drives().begin(), system.drives().end(), [&](const plant::Drive& d) { return d.channel == channel; });
  std::vector<double> drive;
  for (const sim::Sample& sample : recording.samples) {
    double sum = 0.0;
    if (driven_by) {
      sum = sample.inputs[driven_by->index];
    } else if (has_drives) {
      for (const plant::Drive& d : system.drives())
        if (d.channel == channel) sum += d.sense * sample.inputs[d.input.index];
    } else {
      for (const double input : sample.inputs) sum += std::abs(input);
    }
    drive.push_back(sum);
  }
  return drive;
}

// Where each reading has a row of its own, steps are of many lengths; nine in ten are no longer than this.
double usual_step_s(const sim::Recording& recording) {
  std::vector<double> steps_s;
  for (std::size_t k = 1; k < recording.samples.size(); ++k)
    steps_s.push_back(recording.samples[k].time_s - recording.samples[k - 1].time_s);
  if (steps_s.empty()) return sim::not_a_number;
  const auto at = steps_s.begin() + static_cast<std::ptrdiff_t>(9 * (steps_s.size() - 1) / 10);
  std::nth_element(steps_s.begin(), at, steps_s.end());
  return *at;
}

constexpr double least_change = 0.1;        // of the largest drive: a smaller one need not show
constexpr double least_share = 0.2;         // of the samples in a run, for it to be odd, and
constexpr std::size_t least_in_a_run = 20;  // so many of them

}  // namespace

// A run of one value, however long, is no sign of anything while the drive stays what it was when the run began.
std::optional<Unresponsive> unresponsive(const plant::System& system, const sim::Recording& recording, plant::ChannelId channel) {
  const std::vector<double> drive = drive_of(system, recording, channel);
  double largest = 0.0;
  for (const double value : drive) largest = std::max(largest, std::abs(value));
  if (largest == 0.0) return std::nullopt;
  struct Run {
    std::size_t first = 0, last = 0, count = 0, against = 0;  // samples in it, and those at which the drive has changed
    double value = sim::not_a_number;
  } run, longest;
  std::size_t measured_samples = 0, driven_samples = 0;
  for (std::size_t k = 0; k < drive.size(); ++k) {
    const double value = measured(recording.samples[k], channel);
    if (std::isnan(value)) continue;
    ++measured_samples;
    driven_samples += std::abs(drive[k]) >= least_change * largest;
    if (value != run.value) run = {k, k, 0, 0, value};
    run.last = k;
    ++run.count;
    run.against += std::abs(drive[k] - drive[run.first]) >= least_change * largest;
    if (run.against > longest.against || run.first == longest.first) longest = run;
  }
  const bool throughout = run.count == measured_samples;
  if (throughout) longest = run;
  const std::size_t against = throughout ? driven_samples : longest.against;
  if (against < least_in_a_run || static_cast<double>(against) < least_share * static_cast<double>(measured_samples)) return std::nullopt;
  const plant::ChannelInfo& info = system.channels()[channel];
  Unresponsive result{channel, longest.value, recording.samples[longest.first].time_s, recording.samples[longest.last].time_s, throughout,
                      ""};
  const std::string space = info.unit_words.empty() || info.unit_words == "°" ? "" : " ";
  result.words =
      info.words + " stays at " + sim::shortest(longest.value) + space + info.unit_words +
      (result.throughout ? " all along" : " from " + sim::rounded(result.from_s, 6) + " to " + sim::rounded(result.until_s, 6) + " s") +
      " while it is driven: its sensor is stuck or not connected, or what it measures is held fast";
  return result;
}

sim::Recording gated(const plant::System& system, const sim::Recording& recording, const PerChannel* noise, GateNotes& notes) {
  const std::size_t channels = system.channels().size();
  sim::Recording result = recording;
  notes.recording = recording.name;
  notes.samples = recording.samples.size();
  notes.period_s = recording.median_period_s();
  notes.duration_s = recording.duration_s();
  notes.begins_s = recording.begins_s();
  notes.noise = noise ? *noise : noise_of(system, recording);
  notes.step = notes.stuck_share = notes.reading_period_s = per_channel(channels);
  notes.outliers = notes.missing = plant::ListOf<plant::ChannelId, std::size_t>(channels, 0);
  const std::vector<std::pair<double, double>> pauses_s = sim::pauses_of(recording);
  notes.pauses_s = pauses_s;
  for (std::size_t k = 1, p = 0; k < recording.samples.size(); ++k) {
    const double from_s = recording.samples[k - 1].time_s, until_s = recording.samples[k].time_s;
    if (p < pauses_s.size() && pauses_s[p].first == from_s)
      ++p;
    else
      notes.longest_gap_s = std::max(notes.longest_gap_s, until_s - from_s);
  }
  for (const sim::Sample& sample : recording.samples)
    for (const double input : sample.inputs) notes.largest_input = std::max(notes.largest_input, std::abs(input));
  for (const plant::ChannelId c : system.channels().ids()) {
    double last = sim::not_a_number;
    notes.step[c] = 0.0;
    for (const sim::Sample& sample : recording.samples) {
      const double value = measured(sample, c);
      if (std::isnan(value)) {
        ++notes.missing[c];
        continue;
      }
      const double step = std::abs(value - last);
      if (step > 1e-9 && (notes.step[c] == 0.0 || step < notes.step[c])) notes.step[c] = step;
      last = value;
    }
    notes.reading_period_s[c] = measured_rows(recording, c).period_s;
    notes.outliers[c] = mask_outliers(result, c, notes.noise[c]);
    notes.stuck_share[c] = longest_run_share(recording, c);
    const std::string& words = system.channels()[c].words;
    if (notes.missing[c] == notes.samples) notes.warnings.push_back(words + " was never measured");
    if (auto found = unresponsive(system, recording, c)) {
      notes.warnings.push_back(found->words);
      notes.unresponsive.push_back(*std::move(found));
    }
    if (notes.outliers[c] * 50 > notes.samples - notes.missing[c]) notes.warnings.push_back("more than 2 % of " + words + " are outliers");
  }
  if (notes.largest_input == 0.0) notes.warnings.push_back("nothing is ever driven: little can be learnt from this recording");
  for (const auto& [from_s, until_s] : pauses_s)
    notes.warnings.push_back("nothing is recorded from " + sim::rounded(from_s, 6) + " to " + sim::rounded(until_s, 6) +
                             " s, nor what the inputs are meanwhile: cut the recording there");
  if (notes.longest_gap_s > 2.5 * usual_step_s(recording))
    notes.warnings.push_back("rows are missing for up to " + sim::shortest(notes.longest_gap_s) + " s; inputs are held over the gap");
  return result;
}

}  // namespace sinew::diagnose

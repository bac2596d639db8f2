// SPDX-License-Identifier: Apache-2.0
#include "diagnose/gate.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "sim/text.h"

namespace sinew::diagnose {
namespace {

constexpr std::size_t reach = 3;  // neighbours on each side

// Where the limb moves fast its neighbours say little of a sample, but the line through them does: the distance from
// it, and the largest of theirs. A bend, a turn or a jump puts both off alike. NaN without two neighbours on each side.
struct OffLine {
  double own, neighbours;
};
OffLine off_line(const std::vector<sim::Sample>& samples, std::size_t k, plant::ChannelId channel) {
  if (k < 2 || k + 2 >= samples.size()) return {sim::not_a_number, sim::not_a_number};
  constexpr std::array<double, 4> at{-2.0, -1.0, 1.0, 2.0};
  std::array<double, 4> value;
  double mean = 0.0, slope = 0.0;
  for (std::size_t i = 0; i < 4; ++i) {
    value[i] = measured(samples[i < 2 ? k - 2 + i : k - 1 + i], channel);
    mean += value[i] / 4.0;
    slope += at[i] * value[i] / 10.0;
  }
  OffLine off{std::abs(measured(samples[k], channel) - mean), 0.0};
  for (std::size_t i = 0; i < 4; ++i) off.neighbours = std::max(off.neighbours, std::abs(value[i] - mean - slope * at[i]));
  return off;
}

// Masks those that its samples show. How many. `ends`: also within `reach` of the recording's ends.
std::size_t mask_plain_outliers(sim::Recording& recording, plant::ChannelId channel, double noise, bool ends) {
  std::size_t count = 0;
  const std::vector<sim::Sample> samples = recording.samples;
  for (std::size_t k = 0; k < samples.size(); ++k) {
    const double value = measured(samples[k], channel);
    if (std::isnan(value)) continue;
    const bool at_end = k < reach || k + reach >= samples.size();
    if (at_end && !ends) continue;
    std::vector<double> around;
    std::size_t before = 0;
    // The six nearest; at the ends they all lie on one side.
    const std::size_t window = std::min(2 * reach, samples.size() - 1);
    const std::size_t begin = std::min(k - std::min(k, reach), samples.size() - 1 - window);
    for (std::size_t i = begin; i <= begin + window; ++i)
      if (const double near = measured(samples[i], channel); i != k && !std::isnan(near)) {
        around.push_back(near);
        before += i < k;
      }
    // With one on one side and three on the other, the median of samples on a steep line is off it.
    if (around.size() < 4 || (!at_end && (before < 2 || around.size() - before < 2))) continue;
    std::sort(around.begin(), around.end());
    // The extremes may be outliers themselves.
    const double range = around[around.size() - 2] - around[1];
    const double median = 0.5 * (around[(around.size() - 1) / 2] + around[around.size() / 2]);
    const OffLine off = off_line(samples, k, channel);
    if (std::abs(value - median) > 8.0 * noise + range || off.own > 8.0 * noise + 3.0 * off.neighbours) {
      measured(recording.samples[k], channel) = sim::not_a_number;
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
  for (const sim::Sample& sample : recording.samples) {
    const double value = measured(sample, channel);
    run = value == last ? run + 1 : 1;
    last = value;
    // What rests shows one value for long; what is driven does not.
    const bool driven = std::any_of(sample.inputs.begin(), sample.inputs.end(), [](double input) { return input != 0.0; });
    if (!std::isnan(value) && driven) longest = std::max(longest, run);
  }
  return static_cast<double>(longest) / static_cast<double>(recording.samples.size());
}

}  // namespace

sim::Recording gated(const plant::System& system, const sim::Recording& recording, const PerChannel* noise, GateNotes& notes) {
  const std::size_t channels = system.channels().size();
  sim::Recording result = recording;
  notes.recording = recording.name;
  notes.samples = recording.samples.size();
  notes.period_s = recording.median_period_s();
  notes.duration_s = recording.duration_s();
  notes.noise = noise ? *noise : noise_of(system, recording);
  notes.step = notes.stuck_share = per_channel(channels);
  notes.outliers = notes.missing = plant::ListOf<plant::ChannelId, std::size_t>(channels, 0);
  for (std::size_t k = 1; k < recording.samples.size(); ++k)
    notes.longest_gap_s = std::max(notes.longest_gap_s, recording.samples[k].time_s - recording.samples[k - 1].time_s);
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
    notes.outliers[c] = mask_outliers(result, c, notes.noise[c]);
    notes.stuck_share[c] = longest_run_share(recording, c);
    const std::string& words = system.channels()[c].words;
    if (notes.missing[c] == notes.samples) notes.warnings.push_back(words + " was never measured");
    if (notes.stuck_share[c] > 0.2) notes.warnings.push_back(words + " shows one value for a long time while something is driven");
    if (notes.outliers[c] * 50 > notes.samples) notes.warnings.push_back("more than 2 % of " + words + " are outliers");
  }
  if (notes.largest_input == 0.0) notes.warnings.push_back("nothing is ever driven: little can be learnt from this recording");
  if (notes.longest_gap_s > 2.5 * notes.period_s)
    notes.warnings.push_back("rows are missing for up to " + sim::shortest(notes.longest_gap_s) + " s; inputs are held over the gap");
  return result;
}

}  // namespace sinew::diagnose

// SPDX-License-Identifier: Apache-2.0
#include "diagnose/locate.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "diagnose/bootstrap.h"
#include "plant/contains.h"
#include "sim/random.h"
#include "sim/simulation.h"

namespace sinew::diagnose {
namespace {

// "while <part> cools, between 72 and 55 °C": of the parts that have a sensor and are driven, the one that is furthest up in these
// windows, and what it does there. Empty where no part of the plant is both.
std::string describe(const plant::System& system, const sim::Recording& recording, const std::vector<std::pair<double, double>>& windows) {
  struct Part {
    const plant::ChannelInfo* channel;
    plant::ChannelId id;
    std::vector<double> values{};
    double driven = 0.0, low = 0.0, high = 0.0;
  };
  std::vector<Part> parts;
  for (const plant::ChannelId c : system.channels().ids())
    if (system.channels()[c].driven_by) parts.push_back({.channel = &system.channels()[c], .id = c});
  std::size_t count = 0;
  for (const sim::Sample& sample : recording.samples) {
    const bool inside =
        std::any_of(windows.begin(), windows.end(), [&](const auto& w) { return sample.time_s >= w.first && sample.time_s <= w.second; });
    if (!inside) continue;
    ++count;
    for (Part& part : parts) {
      if (const double value = measured(sample, part.id); !std::isnan(value)) part.values.push_back(value);
      part.driven += sample.inputs[part.channel->driven_by->index];
    }
  }
  if (count == 0 || parts.empty()) return "";
  for (Part& part : parts) {
    if (part.values.empty()) continue;
    std::sort(part.values.begin(), part.values.end());
    part.low = part.values[part.values.size() / 10];
    part.high = part.values[part.values.size() * 9 / 10];
  }
  const Part& most = *std::max_element(parts.begin(), parts.end(), [](const Part& a, const Part& b) { return a.high < b.high; });
  const bool driven = most.driven / static_cast<double>(count) > 0.1;
  const auto whole = [](double value) { return std::to_string(static_cast<int>(std::lround(value))); };
  const std::string who = "while " + most.channel->part + " ", unit = " " + most.channel->unit_words;
  return driven ? who + most.channel->driven_words + ", at " + whole(most.low) + " to " + whole(most.high) + unit
                : who + most.channel->idle_words + ", between " + whole(most.high) + " and " + whole(most.low) + unit;
}

struct Binned {
  double explained = -1.0;
  std::vector<double> centre, mean, deviation;
};

// Eight bins of equal count; what their means account for in the half of the time they were not made from.
Binned binned(const Eigen::VectorXd& variable, const Eigen::VectorXd& forcing, const std::vector<Blocks::Block>& blocks) {
  constexpr std::size_t bins = 8;
  std::vector<Eigen::Index> order(static_cast<std::size_t>(variable.size()));
  std::iota(order.begin(), order.end(), Eigen::Index{0});
  std::stable_sort(order.begin(), order.end(), [&](Eigen::Index a, Eigen::Index b) { return variable(a) < variable(b); });
  Binned result;
  std::vector<std::size_t> bin_of(order.size());
  for (std::size_t i = 0; i < order.size(); ++i) bin_of[static_cast<std::size_t>(order[i])] = i * bins / order.size();
  const auto half = [&](Eigen::Index i) {
    return static_cast<std::size_t>(blocks[static_cast<std::size_t>(i)].time_s / (2.0 * bootstrap_block_s)) % 2;
  };
  std::array<std::array<double, bins>, 2> sum{}, count{};
  std::array<double, bins> centre{}, square{};
  for (Eigen::Index i = 0; i < variable.size(); ++i) {
    const std::size_t bin = bin_of[static_cast<std::size_t>(i)];
    sum[half(i)][bin] += forcing(i);
    count[half(i)][bin] += 1.0;
    centre[bin] += variable(i);
    square[bin] += forcing(i) * forcing(i);
  }
  const double mean = forcing.mean();
  double left = 0.0, whole = 0.0;
  for (Eigen::Index i = 0; i < variable.size(); ++i) {
    const std::size_t bin = bin_of[static_cast<std::size_t>(i)], other = 1 - half(i);
    const double predicted = count[other][bin] > 0.0 ? sum[other][bin] / count[other][bin] : mean;
    left += (forcing(i) - predicted) * (forcing(i) - predicted);
    whole += (forcing(i) - mean) * (forcing(i) - mean);
  }
  result.explained = whole > 0.0 ? 1.0 - left / whole : 0.0;
  for (std::size_t bin = 0; bin < bins; ++bin) {
    const double n = count[0][bin] + count[1][bin];
    if (n == 0.0) continue;
    const double m = (sum[0][bin] + sum[1][bin]) / n;
    result.centre.push_back(centre[bin] / n);
    result.mean.push_back(m);
    result.deviation.push_back(std::sqrt(std::max(0.0, square[bin] / n - m * m)));
  }
  return result;
}

}  // namespace

std::vector<std::string_view> places_alike(const plant::System& system, std::string_view place) {
  std::vector<std::string_view> alike{place};
  for (const plant::EntryGroup& group : system.entry_groups()) {
    if (!contains(group.places, place)) continue;
    for (const plant::EntryGroup& other : system.entry_groups())
      if (other.name == group.name || (!group.alike.empty() && other.alike == group.alike))
        for (const std::string_view one : other.places)
          if (!contains(alike, one)) alike.push_back(one);
  }
  return alike;
}

namespace {

// Of the reading of a channel, not of what moves it.
bool is_of_reading(const plant::System& system, std::string_view place) {
  return std::any_of(system.entries().begin(), system.entries().end(), [&](const plant::Entry& entry) {
    const auto& places = system.entry_groups()[entry.group].places;
    return entry.channel && contains(places, place);
  });
}

}  // namespace

std::vector<std::string> places_said(const plant::System& system, const PlaceEvidence& evidence) {
  constexpr double likely = 0.5, sure = 0.9;  // not chosen: what the words mean
  std::vector<std::string> said;
  const auto say = [&](std::string_view one) {
    if (!one.empty() && !contains(said, one)) said.emplace_back(one);
  };
  if (evidence.name_probability >= likely) say(evidence.name);
  if (evidence.name_probability >= sure) return said;
  for (const std::string& law : evidence.laws) say(law);
  if (evidence.forcing_speaks) say(evidence.forcing);
  for (const std::string& one : evidence.varying) say(one);
  if (said.empty()) say(evidence.forcing);
  say(evidence.name);
  for (const std::string& one : std::vector<std::string>(said))
    for (const std::string_view place : places_alike(system, one)) say(place);
  // Whatever moves a channel looks like an error of its reading, too.
  if (!said.empty() && evidence.name_probability < likely && is_of_reading(system, said.front())) {
    const std::string reading = said.front();
    const std::vector<std::string_view> alike = places_alike(system, reading);
    std::stable_partition(said.begin(), said.end(), [&](const std::string& one) { return one != reading && contains(alike, one); });
  }
  return said;
}

std::vector<Eigen::VectorXd> variables_of(const Explanation& at) {
  const plant::System& system = at.system();
  const auto& blocks = at.blocks->blocks();
  std::vector<Eigen::VectorXd> all(system.variables().size(), Eigen::VectorXd::Zero(static_cast<Eigen::Index>(blocks.size())));
  std::size_t b = 0;
  for (std::size_t r = 0; r < at.problem->data().size(); ++r) {
    const FitData& data = at.problem->data()[r];
    plant::Integrator integrator(at.model(), at.start(r), at.problem->numerics());
    const auto& samples = data.recording->samples;
    for (std::size_t k = 0; k < data.sample_count; ++k) {
      if (integrator.advance_to(samples[k].time_s - samples.front().time_s)) return {};
      at.problem->follow_course(integrator, r, k);
      sim::command_sample(integrator, system, samples, k);
      if (b >= blocks.size() || blocks[b].recording != r || blocks[b].first_sample != k) continue;
      const std::vector<double> values = integrator.variables();
      for (std::size_t v = 0; v < values.size(); ++v) all[v](static_cast<Eigen::Index>(b)) = values[v];
      ++b;
    }
  }
  return all;
}

Dependence depends_on(const Explanation& at, const Eigen::VectorXd& series, const std::vector<plant::VariableId>& among) {
  Dependence result;
  const std::vector<Eigen::VectorXd> values = variables_of(at);
  if (values.empty()) return result;
  const auto& list = at.system().variables();
  const auto ask = [&](plant::VariableId v) {
    const Binned found = binned(values[v.index], series, at.blocks->blocks());
    if (found.explained > result.explained_share)
      result = {list[v].name, list[v].unit, found.explained, found.centre, found.mean, found.deviation};
  };
  const auto& entries = at.system().entries();
  if (among.empty())
    for (const plant::VariableId v : list.ids())
      if (std::any_of(entries.begin(), entries.end(), [&](const plant::Entry& entry) { return contains(entry.may_depend_on, v); })) ask(v);
  for (const plant::VariableId v : among) ask(v);
  return result;
}

LeftOver left_over(const Explanation& at, plant::EntryGroupId group) {
  LeftOver result;
  result.group = group;
  ForcingSize size;
  static_cast<void>(likelihood_with(at, nuisance_and(at.system(), group), &size));
  Path path;
  if (!follow(*at.problem, at.z.data(), Want::points, path)) return result;
  StateNoise noise(*at.problem, *at.blocks, at.z.data(), path);
  noise.set(size);
  if (size[group] == 0.0) return result;
  const Smoothed smoothed = noise.smooth(at.residual);
  // The residual is model - measured, so what the plant has and the model has not is the forcing's opposite.
  const std::vector<plant::Entry>& entries = at.system().entries();
  for (std::size_t e = 0; e < entries.size(); ++e) {
    if (entries[e].group != group) continue;
    const Dependence found = depends_on(at, -smoothed.forcing[e], entries[e].may_depend_on);
    if (found.explained_share <= result.explained_share) continue;
    static_cast<Dependence&>(result) = found;
    result.entry = e;
  }
  return result;
}

Located locate(const Explanation& core, const std::vector<sim::Recording>& recordings, const std::vector<Prediction>& predictions,
               std::uint64_t seed) {
  Located result;
  const plant::System& system = core.system();
  const auto& groups = system.entry_groups();
  const auto& blocks = core.blocks->blocks();
  result.rmse = result.noise = per_channel(system);
  double worst = -1.0;
  for (const plant::ChannelId c : result.rmse.ids()) {
    double all_squares = 0.0, all_count = 0.0;
    for (std::size_t r = 0; r < recordings.size(); ++r) {
      const Prediction& prediction = predictions[r];
      double squares = 0.0, count = 0.0;
      for (std::size_t k = 0; k < prediction.time_s.size(); ++k) {
        if (prediction.held_out[k] || std::isnan(prediction.measured[c][k])) continue;
        squares += std::pow(prediction.before[c][k] - prediction.measured[c][k], 2);
        ++count;
      }
      all_squares += squares;
      all_count += count;
      result.noise[c] += prediction.noise[c] / static_cast<double>(recordings.size());
      const double in_noise = squares / (count * std::pow(prediction.noise[c], 2));
      if (count > 0.0 && in_noise > worst) {
        worst = in_noise;
        result.channel = c;
        result.worst_recording = r;
      }
    }
    result.rmse[c] = all_count > 0.0 ? std::sqrt(all_squares / all_count) : std::nan("");
  }
  const Prediction& there = predictions[result.worst_recording];
  std::vector<double> error = there.before[result.channel];
  for (std::size_t k = 0; k < error.size(); ++k) error[k] -= there.measured[result.channel][k];
  result.worst = worst_of(there.time_s, error);
  result.while_words = describe(system, recordings[result.worst_recording], result.worst.windows_s);

  Path path;
  if (!follow(*core.problem, core.z.data(), Want::points, path)) return result;
  StateNoise noise(*core.problem, *core.blocks, core.z.data(), path);
  noise.set(core.forcing);
  const Smoothed smoothed = noise.smooth(core.residual);
  // Squares of each forcing's response by stretch of time, for the bootstrap.
  std::vector<ForcingSize> stretches;
  double stretch_end_s = -1e300;
  std::size_t recording = static_cast<std::size_t>(-1);
  for (std::size_t b = 0; b < blocks.size(); ++b) {
    if (blocks[b].recording != recording || blocks[b].time_s > stretch_end_s) {
      stretches.push_back(no_forcing(system));
      recording = blocks[b].recording;
      stretch_end_s = blocks[b].time_s + bootstrap_block_s;
    }
    for (const plant::ChannelId c : result.rmse.ids())
      if (blocks[b].row[c] != Blocks::no_row)
        for (const plant::EntryGroupId g : groups.ids()) {
          if (groups[g].is_nuisance) continue;
          const double y = smoothed.response(static_cast<Eigen::Index>(blocks[b].row[c]), static_cast<Eigen::Index>(g.index));
          stretches.back()[g] += y * y;
        }
  }
  const auto shares_of = [&](auto&& index_of) {
    ForcingSize sum = no_forcing(system);
    double total = 0.0;
    for (std::size_t s = 0; s < stretches.size(); ++s) {
      const std::size_t picked = index_of(s);
      for (const plant::EntryGroupId g : groups.ids()) {
        sum[g] += stretches[picked][g];
        total += stretches[picked][g];
      }
    }
    for (double& value : sum) value = total > 0.0 ? value / total : 0.0;
    return sum;
  };
  const ForcingSize share = shares_of([](std::size_t s) { return s; });
  const sim::RandomStream chance(seed, "diagnose.locate");
  plant::ListOf<plant::EntryGroupId, std::vector<double>> drawn(groups.size(), {});
  std::uint64_t index = 0;
  for (std::size_t d = 0; d < bootstrap_draws; ++d) {
    const auto again = shares_of([&](std::size_t) {
      return std::min(stretches.size() - 1, static_cast<std::size_t>(chance.uniform(index++) * static_cast<double>(stretches.size())));
    });
    for (const plant::EntryGroupId g : groups.ids()) drawn[g].push_back(again[g]);
  }
  for (const plant::EntryGroupId g : groups.ids()) {
    if (groups[g].is_nuisance) continue;
    const auto [lowest, highest] = middle_95(drawn[g]);
    result.shares.push_back({g, share[g], lowest, highest, likelihood_with(core, nuisance_and(system, g))});
  }
  std::stable_sort(result.shares.begin(), result.shares.end(),
                   [](const PlaceShare& a, const PlaceShare& b) { return a.log_likelihood > b.log_likelihood; });
  return result;
}

}  // namespace sinew::diagnose

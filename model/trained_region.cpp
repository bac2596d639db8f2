// SPDX-License-Identifier: Apache-2.0
#include "model/trained_region.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <map>
#include <nlohmann/json.hpp>
#include <numeric>

#include "model/task_json.h"
#include "sim/text.h"

namespace sinew::model {
namespace {

constexpr Index one_minute = 600;
constexpr double share_each = 0.001, least_usual_share = 0.01;
constexpr std::size_t recordings_to_compare = 5, most_groups = 20;
constexpr int N = region_cells;
using Distances = std::array<std::uint8_t, N * N>;

Index entries_of(Index features) { return features * (1 + static_cast<Index>(region_memories_s.size())) + 1; }
std::size_t pairs_of(Index entries) { return static_cast<std::size_t>(entries * (entries - 1) / 2); }

// Calls use(pair, i, j) for every pair of entries.
template <class Use>
void for_each_pair(Index entries, Use&& use) {
  std::size_t pair = 0;
  for (Index i = 0; i < entries; ++i)
    for (Index j = i + 1; j < entries; ++j) use(pair++, i, j);
}

// Moves the low-passes of v in z on by a sample: exactly, for an input that is held.
void remember(Vector<double>& z, const Eigen::Ref<const Vector<double>>& v) {
  const Index K = v.size();
  for (std::size_t m = 0; m < region_memories_s.size(); ++m) {
    const double gain = 1.0 - std::exp(-period_s / region_memories_s[m]);
    auto slow = z.segment((static_cast<Index>(m) + 1) * K, K);
    slow += gain * (v - slow);
  }
}
void begin_memory(Vector<double>& z, const Eigen::Ref<const Vector<double>>& v) {
  for (Index m = 1; m <= static_cast<Index>(region_memories_s.size()); ++m) z.segment(m * v.size(), v.size()) = v;
}
void set_now(Vector<double>& z, const Eigen::Ref<const Vector<double>>& v, double y) {
  z.head(v.size()) = v;
  z(z.size() - 1) = y;
}

// Calls use(k, z) for every sample that was measured.
template <class Use>
void for_each_point(const Series& series, Use&& use) {
  Vector<double> z = Vector<double>::Zero(entries_of(series.v.rows()));
  begin_memory(z, series.v.col(0));
  for (Index k = 0; k < series.samples(); ++k) {
    if (k > 0) remember(z, series.v.col(k));
    set_now(z, series.v.col(k), series.y(k));
    if (series.is_measured(k)) use(k, z);
  }
}

bool moves(const TrainedRegion& region, Index i) {
  return region.highest(i) - region.lowest(i) > 1e-9 * (1.0 + std::abs(region.highest(i)));
}

int cell_of(const TrainedRegion& region, Index i, double value) {
  if (!moves(region, i)) return 0;
  const double share = (value - region.lowest(i)) / (region.highest(i) - region.lowest(i));
  return std::clamp(static_cast<int>(std::floor(share * N)), 0, N - 1);
}

// Of each cell, to the nearest visited one, the longer of both ways: a pass there and a pass back (Rosenfeld and Pfaltz 1966).
Distances distances_to(const CellMap& visited) {
  Distances away{};
  const auto at = [&](int i, int j) {
    return i < 0 || j < 0 || i >= N || j >= N ? 255 : static_cast<int>(away[static_cast<std::size_t>(i * N + j)]);
  };
  for (int i = 0; i < N; ++i)
    for (int j = 0; j < N; ++j) {
      const int next = 1 + std::min({at(i - 1, j - 1), at(i - 1, j), at(i - 1, j + 1), at(i, j - 1)});
      away[static_cast<std::size_t>(i * N + j)] =
          static_cast<std::uint8_t>(visited[static_cast<std::size_t>(i * N + j)] ? 0 : std::min(255, next));
    }
  for (int i = N - 1; i >= 0; --i)
    for (int j = N - 1; j >= 0; --j) {
      const int next = 1 + std::min({at(i + 1, j - 1), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)});
      away[static_cast<std::size_t>(i * N + j)] = static_cast<std::uint8_t>(std::min(at(i, j), next));
    }
  return away;
}

// The value that all but a share lie at or below.
template <class T>
T quantile(std::vector<T> values, double share_above) {
  const auto rank = static_cast<std::ptrdiff_t>(std::ceil((1.0 - share_above) * static_cast<double>(values.size()))) - 1;
  const auto at = values.begin() + std::clamp(rank, std::ptrdiff_t{0}, static_cast<std::ptrdiff_t>(values.size()) - 1);
  std::nth_element(values.begin(), at, values.end());
  return *at;
}

// Three digits, as people read them.
std::string rounded(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%.3g", value);
  return text;
}

}  // namespace

TrainedRegion trained_region_of(const std::vector<Series>& training) {
  const Index D = entries_of(training.front().v.rows());
  TrainedRegion region{Vector<double>::Constant(D, HUGE_VAL), Vector<double>::Constant(D, -HUGE_VAL), {}};
  // Groups that are compared with all others: recordings, several together where there are many; or parts of a minute and more.
  const bool by_recording = training.size() >= recordings_to_compare;
  std::vector<std::size_t> first_group{0};
  for (const Series& one : training)
    first_group.push_back(first_group.back() +
                          (by_recording ? 1 : static_cast<std::size_t>(std::clamp<Index>(one.samples() / one_minute, 1, most_groups))));
  const std::size_t units = first_group.back(), groups = std::min(units, most_groups);
  const auto unit_of = [&](std::size_t r, Index k) {
    const std::size_t parts = first_group[r + 1] - first_group[r];
    return first_group[r] + static_cast<std::size_t>(k) * parts / static_cast<std::size_t>(training[r].samples());
  };
  const auto group_of = [&](std::size_t unit) { return unit * groups / units; };

  std::vector<Vector<double>> lowest(groups, region.lowest), highest(groups, region.highest);
  std::vector<Index> samples(units, 0);
  for (std::size_t r = 0; r < training.size(); ++r)
    for_each_point(training[r], [&](Index k, const Vector<double>& z) {
      const std::size_t unit = unit_of(r, k), group = group_of(unit);
      lowest[group] = lowest[group].cwiseMin(z);
      highest[group] = highest[group].cwiseMax(z);
      ++samples[unit];
    });
  for (std::size_t g = 0; g < groups; ++g) {
    region.lowest = region.lowest.cwiseMin(lowest[g]);
    region.highest = region.highest.cwiseMax(highest[g]);
  }
  const std::size_t pairs = pairs_of(D);
  region.visited.assign(pairs, {});
  std::vector<std::vector<CellMap>> of_group(groups, std::vector<CellMap>(pairs));
  std::vector<int> cell(static_cast<std::size_t>(D));
  const auto find_cells = [&](const Vector<double>& z) {
    for (Index i = 0; i < D; ++i) cell[static_cast<std::size_t>(i)] = cell_of(region, i, z(i));
  };
  const auto place = [&](Index i, Index j) {
    return static_cast<std::size_t>(cell[static_cast<std::size_t>(i)] * N + cell[static_cast<std::size_t>(j)]);
  };
  for (std::size_t r = 0; r < training.size(); ++r)
    for_each_point(training[r], [&](Index k, const Vector<double>& z) {
      find_cells(z);
      auto& maps = of_group[group_of(unit_of(r, k))];
      for_each_pair(D, [&](std::size_t p, Index i, Index j) { maps[p][place(i, j)] = true; });
    });
  for (const auto& maps : of_group)
    for (std::size_t p = 0; p < pairs; ++p)
      for (std::size_t c = 0; c < maps[p].size(); ++c) region.visited[p][c] = region.visited[p][c] || maps[p][c];
  if (groups < 2) return region;

  // How far each group's points lie from what the others had.
  std::vector<std::vector<Distances>> away(groups, std::vector<Distances>(pairs));
  for (std::size_t g = 0; g < groups; ++g) {
    for (std::size_t p = 0; p < pairs; ++p) {
      CellMap others{};
      for (std::size_t h = 0; h < groups; ++h)
        for (std::size_t c = 0; h != g && c < others.size(); ++c) others[c] = others[c] || of_group[h][p][c];
      away[g][p] = distances_to(others);
    }
  }
  std::vector<Vector<double>> others_lowest(groups, Vector<double>::Constant(D, HUGE_VAL)),
      others_highest(groups, Vector<double>::Constant(D, -HUGE_VAL));
  for (std::size_t g = 0; g < groups; ++g)
    for (std::size_t h = 0; h < groups; ++h) {
      if (h == g) continue;
      others_lowest[g] = others_lowest[g].cwiseMin(lowest[h]);
      others_highest[g] = others_highest[g].cwiseMax(highest[h]);
    }
  // Every so many points: quantiles need no more than these.
  const Index all = std::accumulate(samples.begin(), samples.end(), Index{0}), stride = 1 + all / 20000;
  std::vector<double> beyond;
  std::vector<int> cells_away;
  std::vector<std::size_t> unit_of_point;
  Index seen = 0;
  for (std::size_t r = 0; r < training.size(); ++r)
    for_each_point(training[r], [&](Index k, const Vector<double>& z) {
      if (seen++ % stride != 0) return;
      find_cells(z);
      const std::size_t unit = unit_of(r, k), g = group_of(unit);
      unit_of_point.push_back(unit);
      double most = 0.0;
      for (Index i = 0; i < D; ++i)
        if (moves(region, i))
          most = std::max(most, std::max(others_lowest[g](i) - z(i), z(i) - others_highest[g](i)) / (region.highest(i) - region.lowest(i)));
      beyond.push_back(most);
      int furthest = 0;
      for_each_pair(D, [&](std::size_t p, Index i, Index j) { furthest = std::max<int>(furthest, away[g][p][place(i, j)]); });
      cells_away.push_back(furthest);
    });
  region.margin_share = quantile(beyond, share_each);
  region.reach_cells = quantile(cells_away, share_each);
  // Of each recording or part, how much would lie outside had its group not been there at all: neither in maps and ranges nor in limits.
  std::vector<double> shares;
  for (std::size_t g = 0; g < groups; ++g) {
    std::vector<double> beyond_of_others;
    std::vector<int> cells_of_others;
    for (std::size_t n = 0; n < unit_of_point.size(); ++n)
      if (group_of(unit_of_point[n]) != g) {
        beyond_of_others.push_back(beyond[n]);
        cells_of_others.push_back(cells_away[n]);
      }
    if (beyond_of_others.empty()) continue;
    const double margin = quantile(std::move(beyond_of_others), share_each);
    const int reach = quantile(std::move(cells_of_others), share_each);
    std::map<std::size_t, std::pair<double, double>> of_unit;  // outside, counted
    for (std::size_t n = 0; n < unit_of_point.size(); ++n)
      if (group_of(unit_of_point[n]) == g) {
        auto& [outside, counted] = of_unit[unit_of_point[n]];
        ++counted;
        outside += beyond[n] > margin || cells_away[n] > reach;
      }
    for (const auto& [unit, found] : of_unit) shares.push_back(found.first / found.second);
  }
  // Of n and a further one, which is exchangeable with them, one in twenty is above (of fewer than 19, one in n + 1).
  std::sort(shares.begin(), shares.end());
  const auto rank = static_cast<std::size_t>(std::ceil(0.95 * static_cast<double>(shares.size() + 1)));
  if (!shares.empty()) region.usual_share = std::max(least_usual_share, shares[std::min(rank, shares.size()) - 1]);
  return region;
}

std::vector<std::string> region_names(const Task& task) {
  std::vector<std::string> names;
  for (const Feature& feature : task.features) names.push_back(feature.column.words);
  for (const double memory_s : region_memories_s)
    for (const Feature& feature : task.features) names.push_back(feature.column.words + " over the last " + sim::shortest(memory_s) + " s");
  names.push_back(task.predicted.words);
  return names;
}

RegionWatch::RegionWatch(const TrainedRegion& region)
    : region_(region), z_(Vector<double>::Zero(region.lowest.size())), cell_(static_cast<std::size_t>(z_.size())) {
  for (const CellMap& visited : region.visited) cells_away_.push_back(distances_to(visited));
}

void RegionWatch::begin(const Eigen::Ref<const Vector<double>>& v) { begin_memory(z_, v); }

void RegionWatch::follow(const Eigen::Ref<const Vector<double>>& v) { remember(z_, v); }

std::optional<OutsidePoint> RegionWatch::outside(const Eigen::Ref<const Vector<double>>& v, double y) {
  remember(z_, v);
  set_now(z_, v, y);
  std::optional<OutsidePoint> found;
  for (Index i = 0; i < z_.size(); ++i) {
    const double beyond = std::max(region_.lowest(i) - z_(i), z_(i) - region_.highest(i));
    if (!(beyond > 0.0)) continue;
    const double how_far = moves(region_, i) ? beyond / (region_.highest(i) - region_.lowest(i)) - region_.margin_share : 1.0 + beyond;
    if (!(how_far > 0.0)) continue;
    if (!found || how_far > found->how_far) found = {.entry = i, .value = z_(i), .how_far = how_far};
  }
  if (found) return found;
  for (Index i = 0; i < z_.size(); ++i) cell_[static_cast<std::size_t>(i)] = cell_of(region_, i, z_(i));
  for_each_pair(z_.size(), [&](std::size_t p, Index i, Index j) {
    const int away = cells_away_[p][static_cast<std::size_t>(cell_[static_cast<std::size_t>(i)] * N + cell_[static_cast<std::size_t>(j)])];
    if (away <= region_.reach_cells) return;
    const double how_far = static_cast<double>(away - region_.reach_cells) / N;
    if (!found || how_far > found->how_far) found = {.entry = i, .with = j, .value = z_(i), .with_value = z_(j), .how_far = how_far};
  });
  return found;
}

void Departures::add(Index k, const std::optional<OutsidePoint>& found) {
  ++samples;
  is_outside.push_back(found.has_value());
  if (!found) return;
  ++of_entry[static_cast<std::size_t>(found->entry)];
  if (found->with) ++of_entry[static_cast<std::size_t>(*found->with)];
  alone += !found->with;
  if (outside == 0) first = k;
  if (outside++ > 0 && std::pair(!found->with, found->how_far) <= std::pair(!furthest.with, furthest.how_far)) return;
  at = k;
  furthest = *found;
}

Departures departures_of(const TrainedRegion& region, const Series& series, const Vector<double>& predicted, const Series* before) {
  RegionWatch watch(region);
  const Series& first = before ? *before : series;
  watch.begin(first.v.col(0));
  for (Index k = 1; before && k < before->samples(); ++k) watch.follow(before->v.col(k));
  Departures found(region);
  found.is_outside.push_back(false);
  for (Index k = 1; k < series.samples(); ++k) found.add(k, watch.outside(series.v.col(k), predicted(k)));
  return found;
}

std::string words_of(const OutsidePoint& point, const TrainedRegion& region, const Task& task) {
  const auto features = static_cast<Index>(task.features.size());
  const std::vector<std::string> names = region_names(task);
  const auto unit = [&](Index entry) {
    const sim::Column& column =
        entry + 1 == region.lowest.size() ? task.predicted : task.features[static_cast<std::size_t>(entry % features)].column;
    return column.unit.empty() ? "" : column.unit == "deg" ? "°" : column.unit == "degC" ? " °C" : " " + column.unit;
  };
  const std::string said = names[static_cast<std::size_t>(point.entry)] + " is " + rounded(point.value) + unit(point.entry);
  if (point.with)
    return said + " while " + names[static_cast<std::size_t>(*point.with)] + " is " + rounded(point.with_value) + unit(*point.with) +
           ", which training never had together";
  return said + ", in training " + rounded(region.lowest(point.entry)) + " to " + rounded(region.highest(point.entry)) + unit(point.entry);
}

std::string words_of(const Departures& departures, const TrainedRegion& region, const Task& task, double first_s) {
  if (departures.outside == 0)
    return "Inputs, their past and the prediction lie within what the predictor was trained on, or no further out than its own recordings "
           "are of each other (" +
           rounded(100.0 * region.margin_share) + " % of a column's range).";
  const auto time_s = [&](Index k) {
    return sim::shortest(std::round(10.0 * (first_s + static_cast<double>(k) * period_s)) / 10.0) + " s";
  };
  return rounded(100.0 * departures.share()) + " % of the samples lie outside of what the predictor was trained on, first at " +
         time_s(departures.first) + "; furthest at " + time_s(departures.at) + ": " + words_of(departures.furthest, region, task) + "." +
         (departures.share() > region.usual_share
              ? ""
              : " That is no more than recordings of one kind lie outside of each other (" + rounded(100.0 * region.usual_share) + " %).");
}

nlohmann::ordered_json json_of(const TrainedRegion& region) {
  const auto list = [](const Vector<double>& v) { return std::vector<double>(v.data(), v.data() + v.size()); };
  return {{"memories_s", region_memories_s},     {"lowest", list(region.lowest)},     {"highest", list(region.highest)},
          {"margin_share", region.margin_share}, {"reach_cells", region.reach_cells}, {"usual_share", region.usual_share}};
}

Hdf5Array visited_of(const TrainedRegion& region) {
  constexpr int bits = 16;
  Hdf5Array array{.extents = {region.visited.size(), N * N / bits}, .values = {}};
  for (const CellMap& map : region.visited)
    for (int c = 0; c < N * N; c += bits) {
      int word = 0;
      for (int b = 0; b < bits; ++b) word |= map[static_cast<std::size_t>(c + b)] << b;
      array.values.push_back(word);
    }
  return array;
}

TrainedRegion trained_region_of_json(const nlohmann::ordered_json& json, const Hdf5Array& visited, const Task& task,
                                     const std::string& file) {
  constexpr int bits = 16;
  const Index D = entries_of(static_cast<Index>(task.features.size()));
  if (json.at("memories_s") != nlohmann::ordered_json(region_memories_s))
    complain(file, "region", json.at("memories_s").dump(), "has other memories than this version's");
  const auto vector = [&](const char* key) {
    const auto list = json.at(key).get<std::vector<double>>();
    if (static_cast<Index>(list.size()) != D)
      complain(file, key, std::to_string(list.size()) + " entries", "must have " + std::to_string(D));
    return Vector<double>(Eigen::Map<const Vector<double>>(list.data(), D));
  };
  TrainedRegion region{vector("lowest"), vector("highest"), {}, json.at("margin_share"), json.at("reach_cells"), json.at("usual_share")};
  const std::size_t pairs = pairs_of(D);
  if (visited.extents != std::vector<std::uint64_t>{pairs, N * N / bits})
    complain(file, "visited", "", "must have " + std::to_string(pairs) + " maps");
  region.visited.assign(pairs, {});
  for (std::size_t p = 0; p < pairs; ++p)
    for (int c = 0; c < N * N; ++c) {
      const double word = visited.values[(p * N * N + static_cast<std::size_t>(c)) / bits];
      if (!(word >= 0.0 && word < 65536.0)) complain(file, "visited", "not 16 bits", "is damaged");
      region.visited[p][static_cast<std::size_t>(c)] = (static_cast<int>(word) >> (c % bits)) & 1;
    }
  return region;
}

}  // namespace sinew::model

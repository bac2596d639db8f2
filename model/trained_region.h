// SPDX-License-Identifier: Apache-2.0
// What a predictor was trained on, as far as its inputs, their past and the predicted channel show it: says where a rollout leaves it.
//
// A point is z = [v, v over the last 5 s, v over the last 30 s, y], where "over the last tau" is a low-pass of first order with the time
// constant tau: what warms a wire and what warms the body round it. A point lies outside where
//   - an entry of z is below its lowest or above its highest value in training, by more than a share of that range; or
//   - two entries are as they never were together: each pair has a map of 32 x 32 cells between lowest and highest, and the cell that is
//     hit is further from all that training visited than the reach. So two coils that are hot are told where training had each of them
//     hot, though never both; and a duty that is usual, where it lasts as never before.
// That share and the reach are one for all entries and all pairs: 99.9 % of training's own points lie inside by either of what the rest of
// training, without their recording, had (in fewer than five recordings: without their part of it). One for each entry would let fresh
// recordings out by the many entries that they have. Maps of pairs instead of one distance among all entries: with so many entries all
// points are far from each other, and a pair can be named. Novelty as what training's own parts are not to each other: Pimentel, Clifton,
// Clifton, Tarassenko 2014, Signal Processing 99, sections 2 and 3.
#pragma once

#include <array>
#include <cstdint>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <vector>

#include "model/hdf5_file.h"
#include "model/series.h"

namespace sinew::model {

inline constexpr std::array<double, 2> region_memories_s{5.0, 30.0};
inline constexpr int region_cells = 32;  // of a map, each way

// Whether training visited a cell, [row * region_cells + column]: row of the pair's first entry, column of its second.
using CellMap = std::array<bool, region_cells * region_cells>;

struct TrainedRegion {
  Vector<double> lowest, highest;  // [entries of z], in the units of a recording
  std::vector<CellMap> visited;    // [pairs], (0, 1), (0, 2), ..., (1, 2), ...; of entries that moved
  double margin_share = 0.0;       // of the range of each entry
  int reach_cells = 0;             // the longer of both ways
  // Of a further recording of their kind no more than this share lies outside, but for one in twenty (of fewer than 19 recordings or
  // parts, one in their number and one); at least 1 %. More is a departure.
  double usual_share = 0.01;
};

// Of the parts of recordings that were trained on. The same data give the same.
TrainedRegion trained_region_of(const std::vector<Series>& training);

// What z's entries are called: "duty A", "duty A over the last 5 s", ...
std::vector<std::string> region_names(const Task& task);

// Why a point lies outside: an entry alone, or with another one; and their values.
struct OutsidePoint {
  Index entry = 0;
  std::optional<Index> with{};
  double value = 0.0, with_value = 0.0;
  double how_far = 0.0;  // of an entry alone, beyond its margin, over its range; of two, cells beyond the reach, over all
};

// Follows one rollout. A step allocates nothing.
class RegionWatch {
 public:
  // The region must outlive it.
  explicit RegionWatch(const TrainedRegion& region);
  // At a first sample: what came before is taken to be as then.
  void begin(const Eigen::Ref<const Vector<double>>& v);
  // A sample that is not judged, of the time before: only the memory follows it.
  void follow(const Eigen::Ref<const Vector<double>>& v);
  // A sample, with y as predicted. None: it lies inside. An entry alone goes before a pair, what is further before what is less so.
  std::optional<OutsidePoint> outside(const Eigen::Ref<const Vector<double>>& v, double y);

 private:
  const TrainedRegion& region_;
  std::vector<std::array<std::uint8_t, region_cells * region_cells>> cells_away_;  // [pairs], from what was visited
  Vector<double> z_;
  std::vector<int> cell_;  // [entries of z]
};

// A rollout, as far as it lies outside.
struct Departures {
  Index samples = 0, outside = 0, alone = 0;  // alone: by one entry
  Index first = 0;                            // sample, of those outside
  Index at = 0;                               // the sample that is furthest, and
  OutsidePoint furthest{};                    // why
  std::vector<Index> of_entry{};              // [entries of z], samples in which each is why, alone or with another
  std::vector<bool> is_outside{};             // [samples], in their order

  explicit Departures(const TrainedRegion& region) : of_entry(static_cast<std::size_t>(region.lowest.size()), 0) {}
  // The next sample, of which the watch said `found`.
  void add(Index k, const std::optional<OutsidePoint>& found);
  double share() const { return samples > 0 ? static_cast<double>(outside) / static_cast<double>(samples) : 0.0; }
};

// Of the samples after the first one, which is measured. `before`: what lies before the series and ends with its first sample; null where
// it begins there.
Departures departures_of(const TrainedRegion& region, const Series& series, const Vector<double>& predicted,
                         const Series* before = nullptr);
// In words: "12.3 % of it lies outside ... first at 31.2 s; furthest ...". `first_s`: time of the series' first sample.
std::string words_of(const Departures& departures, const TrainedRegion& region, const Task& task, double first_s);
// Of a single sample: "duty A is 0.8, in training 0 to 0.6".
std::string words_of(const OutsidePoint& point, const TrainedRegion& region, const Task& task);

// As kept in a file: what goes into a description, and an array [pairs x 64], each row of a map as two numbers of 16 bits.
nlohmann::ordered_json json_of(const TrainedRegion& region);
Hdf5Array visited_of(const TrainedRegion& region);
// Throws nlohmann::json::exception, and InputError naming `file`, where it is none of that task.
TrainedRegion trained_region_of_json(const nlohmann::ordered_json& json, const Hdf5Array& visited, const Task& task,
                                     const std::string& file);

}  // namespace sinew::model

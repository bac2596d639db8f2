// SPDX-License-Identifier: Apache-2.0
// Prediction intervals of any predictor: how far off a rollout, or a prediction one step ahead, will be in 95 % of its samples.
//
// From errors over data that the predictor was not trained on, in steps of the time since a rollout began. Errors of one rollout go
// together, so that the unit that is exchangeable with another is not a sample: it is a whole recording, or, where fewer than five are set
// aside, a minute of one. With F(w) the share of errors up to a width w, each of M units weighing as much as another, however many samples
// it has, F^-1(l) the least error with F above l, and F_-i the same without unit i,
//
//   half width = F^-1(level),   level: the least with which F_-i^-1(level) holds 95 % of the samples of unit i, in the mean over i
//
// so that the level is that with which units that the width was not taken from are covered as is asked (Beran 1990, J. Am. Stat. Assoc.
// 85(411), calibrating prediction regions; by leaving one out as Barber, Candes, Ramdas, Tibshirani 2021, Ann. Statist. 49(1)). As it is
// chosen on the units themselves, a further one can be covered a little less: by up to 1/M where errors of a unit are all alike. Where no
// level does, as with fewer than 20 such units, the largest error takes its place. That holds a further unit's sample with a probability
// of M/(M + 1), which is what fewer than 19 units promise (Lee, Barber, Willett 2023, arXiv:2306.06342).
//
// It holds for recordings that come about as those did: other limbs than they had, other commands, other rooms void it (trained_region.h
// says where the inputs do). Minutes of one recording are exchangeable as far as it is stationary and forgets within a minute.
#pragma once

#include <array>
#include <functional>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <vector>

#include "model/series.h"

namespace sinew::model {

class Predictor;

inline constexpr double interval_share = 0.95;
inline constexpr double shortest_for_intervals_s = 10.0;  // of a rollout that is judged

// How a rollout begins decides what is known at first.
enum class Beginning {
  at_first,       // where a recording does, from one measured value
  in_motion,      // later in it, from one measured value
  after_history,  // later in it, after `enough_history_s` or more that were given to the predictor
};
inline constexpr double enough_history_s = 60.0, longest_history_s = 600.0;
inline constexpr std::array<std::string_view, 3> beginning_names{"at_first", "in_motion", "after_history"};

// Half widths in the unit of the channel that is predicted; step i holds from until_s[i - 1] to until_s[i] since the rollout began, the
// last one from there on.
struct IntervalSteps {
  std::vector<double> until_s, open_loop, one_step;
  std::vector<Index> units;  // that each was taken from
};

struct Intervals {
  std::array<std::optional<IntervalSteps>, 3> by_beginning{};  // in the order of Beginning
  bool unit_is_recording = true;                               // else a minute of one
  std::string taken_from;                                      // in words, for people

  bool any() const { return by_beginning[0] || by_beginning[1] || by_beginning[2]; }
  // The steps for a beginning; of another one where that was not calibrated: never of one that knows more. Null: none.
  const IntervalSteps* steps_for(Beginning beginning) const;
};

// What the fewest units of any step promise: interval_share, or M/(M + 1) where that is less.
double promised_share(const IntervalSteps& steps);
// Of a series [samples] whose first sample is where the rollout began; 0 there, as that is measured.
Vector<double> half_widths(const IntervalSteps& steps, bool one_step, Index samples);
// Of those samples after the first one that were measured. NaN: none was.
double share_inside(const Vector<double>& predicted, const Vector<double>& half_width, const Series& series);

// A recording of which what lies before `from` was seen in training: it may be a history, and is not judged.
struct SetAside {
  Series series;
  Index from = 0;
};
// Rolls the predictor out over what is set aside, from several places of each recording. No steps where all is too short, or where
// errors are beyond all bounds. `should_stop` is asked at every rollout; throws Stopped (train.h). The number of threads changes nothing.
Intervals intervals_from(const Predictor& predictor, const std::vector<SetAside>& data, int threads,
                         const std::function<bool()>& should_stop = {});

// As kept in a file, and back; the latter throws nlohmann::json::exception, and InputError naming `file`, where it is none.
nlohmann::ordered_json json_of(const Intervals& intervals);
Intervals intervals_of_json(const nlohmann::ordered_json& json, const std::string& file);

}  // namespace sinew::model

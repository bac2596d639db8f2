// SPDX-License-Identifier: Apache-2.0
// What a predictor is given of a plant, and what it is asked for: columns of a recording, and their scaling.
//
// Source: Sabelhaus, Mehta, Wertz, Majidi 2022 (doi 10.3389/frobt.2022.888261): X(t) = [v(t), v(t-1), y(t-1)], where y is the
// channel that is predicted, and v, from the System's lists, in
//   case 1: the first input that drives y;    2: that, and what the sensors of its part measure;
//   case 3: all inputs;                       4: each input, followed by what the sensors of its part measure.
// What sensors of no such part measure stands last in cases 2 and 4. Channels of y's own kind are not among it.
#pragma once

#include <Eigen/Core>
#include <cmath>
#include <optional>
#include <string>
#include <vector>

#include "model/network.h"
#include "plant/system.h"
#include "sim/recording.h"
#include "sim/signals.h"

namespace sinew::model {

inline constexpr double period_s = 0.1;  // of the paper's loop; nothing else is predicted

// An entry of v.
struct Feature {
  sim::Column column;
  bool measured = false;  // a channel of the plant; otherwise one of its inputs
};

struct Task {
  int paper_case = 3;             // 1 to 4
  std::vector<Feature> features;  // v, in order
  sim::Column predicted;          // y; its unit is that of all errors
};

// The task of a case. Without `predicted`, y is the first channel that the System says inputs drive, or its only channel.
// Throws std::invalid_argument for another case, and where the channel has to be named.
Task task_of(const plant::System& system, int paper_case, std::optional<plant::ChannelId> predicted = std::nullopt);
// The columns of a recording that the task needs.
sim::Columns columns_of(const Task& task);

// Where the task's columns lie among those of a recording, or of a System in its order.
struct Places {
  struct Place {
    bool measured;
    std::size_t index;  // of Sample::channels where measured, else of Sample::inputs
  };
  std::vector<Place> features;
  std::size_t predicted = 0;  // of Sample::channels
};
// Throws InputError naming `recording` where a column is not there.
Places places_in(const sim::Columns& columns, const Task& task, const std::string& recording);

// One recording as a task sees it, in the units of the file; column or entry k is the sample k.
struct Series {
  std::string name;
  double first_s = 0.0;
  Matrix<double> v;  // [features x samples]
  Vector<double> y;  // [samples]
  // [samples]; 0 where y was not measured, and what stands there lies on a line between its neighbours; empty: all were measured.
  Vector<double> counted = {};
  Index samples() const { return y.size(); }
  bool is_measured(Index k) const { return counted.size() == 0 || counted(k) > 0.0; }
  double measured(Index k) const { return is_measured(k) ? y(k) : std::nan(""); }
};

inline constexpr double longest_held_s = 10.0;
enum class Missing {
  refused,    // an InputError names the first one
  held,       // the value before is taken, as a predictor in a loop would have to
  resampled,  // the recording is put on the grid first (on_grid), and Series::counted says where y was not measured
};
// A recording on the grid of 10 Hz that begins with its first sample: inputs are those of the last sample, measurements lie on a line
// between their neighbours, and are missing where these are more than longest_gap_s apart. For recordings of uneven period, with pauses.
inline constexpr double longest_gap_s = 0.5;
sim::Recording on_grid(const sim::Recording& recording);

// Throws InputError where a column that the task needs is not there, a sample is missing, or the recording is not one at
// 10 Hz: a step off by more than a fifth of the period. With `held`, rows that are missing are held too, up to longest_held_s.
Series series_of(const sim::Recording& recording, const Task& task, Missing missing = Missing::refused);

// Samples from `first` on, `count` of them.
Series part_of(const Series& series, Index first, Index count);
// How many samples of a recording are trained on: that share of it, from its beginning; at least one. And these, of each.
Index training_samples(const Series& series, double training_fraction);
std::vector<Series> training_parts(const std::vector<Series>& recordings, double training_fraction);

// What one unit of a network's numbers is.
struct Scaling {
  Vector<double> v_offset, v_span;
  double y_offset = 0.0, y_span = 1.0;
  double scaled_y(double y) const { return (y - y_offset) / y_span; }
  double y(double scaled) const { return y_offset + y_span * scaled; }
};
enum class Scaled {
  with_unit,  // what is measured, y, and inputs with a unit go to 0 ... 1 over the data; other inputs stay as they are
  all,        // every column does
};
Scaling scaling_of(const std::vector<Series>& training, const Task& task, Scaled which = Scaled::with_unit);

// A series in a network's numbers: [v(t); v(t-1)] of sample t in column t - 1, and y of sample t in entry t.
struct ScaledSeries {
  Matrix<float> exogenous;  // [2 features x samples - 1]
  Vector<float> y;          // [samples]
};
ScaledSeries scaled(const Series& series, const Scaling& scaling);

// A linear reference (linear.h).
struct LinearModel {
  Index order = 0;              // 0: static
  Vector<double> coefficients;  // [p_1 ... p_n, v(t), v(t-1) ... v(t-n), b]
};

// All that a weights file holds.
struct Model {
  Task task;
  std::string method;  // "published", "stateful" or "gru"
  Scaling scaling;
  Weights<float> weights;
  std::string trained_on;                         // in words, for people
  std::optional<LinearModel> arx = std::nullopt;  // fitted to the same data: what the network must beat; a file may lack it
  // The published code clears the state at every step.
  bool memoryless() const { return method == "published"; }
};

}  // namespace sinew::model

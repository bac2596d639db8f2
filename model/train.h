// SPDX-License-Identifier: Apache-2.0
// Training: as published, and as a recurrent network should be trained that is to run for ten minutes on its own.
//
// published: every step a sample of its own, window of one, the state cleared before it, the measured y always fed in.
// So the recurrent weights take no part and all memory goes through y (the notebook of Sabelhaus et al. 2022, rkme/memalloy:
// batches of 100 in the recording's order, 20 epochs, Adam of Keras 2 with rate 0.01 and decay 0.9, first 67 % for training, one scaler
// to 0 ... 1 over all columns, inputs included, fitted to all data before they are split).
//
// stateful: many streams walk through the recordings side by side; their state is carried from stretch to stretch and the
// gradient is cut there (truncated back-propagation through time, Williams and Peng 1990). Most streams are fed their own
// output, as in a rollout, and the gradient goes through it; the others the measured y with noise on it. A stream begins
// anew, nothing remembered, after a random time. What is kept are the weights with the least error in rollouts over data set
// aside.
//
// The same seed gives the same weights to the last bit whatever the number of threads: streams are worked on in parts of a
// fixed size, and the parts' gradients are added in order.
#pragma once

#include <functional>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "model/series.h"
#include "sim/fields.h"
#include "sim/input.h"

namespace sinew::model {

struct PublishedSettings {
  static constexpr std::string_view name = "published";
  Index hidden = 300, dense = 300, batch = 100, epochs = 20;
  double rate = 0.01, decay = 0.9, training_fraction = 0.67;
  bool shuffle = false;         // the notebook says shuffle=False
  bool scaler_sees_all = true;  // as in the notebook; what follows the training part, and tests it, then has a say in the scaling
  template <class Self, class Visitor>
  static void fields(Self& self, Visitor&& visit) {
    visit(self.hidden, sim::Key{"hidden", {1, 4096}, "size of the LSTM layer"});
    visit(self.dense, sim::Key{"dense", {1, 4096}, "size of the dense layer"});
    visit(self.batch, sim::Key{"batch", {1, 100000}, "samples an update"});
    visit(self.epochs, sim::Key{"epochs", {1, 100000}, "passes over the training data"});
    visit(self.rate, sim::Key{"rate", {1e-8, 1.0}, "of Adam, at the first update"});
    visit(self.decay, sim::Key{"decay", {0.0, 10.0}, "the rate is divided by 1 + decay n at update n"});
    visit(self.training_fraction, sim::Key{"training_fraction", {0.05, 1.0}, "of each recording, from its beginning"});
    visit(self.shuffle, sim::Key{"shuffle", {}, "whether samples are drawn in random order"});
    visit(self.scaler_sees_all, sim::Key{"scaler_sees_all", {}, "whether the scaler is fitted to what follows the training part too"});
  }
};

struct StatefulSettings {
  static constexpr std::string_view name = "stateful";
  Index hidden = 64, dense = 64, streams = 50, steps = 100, updates = 3000;
  double rate = 3e-3, clip_norm = 1.0, teacher_fraction = 0.2, feedback_noise = 0.01;
  double longest_memory_s = 60.0, shortest_life_s = 60.0, longest_life_s = 600.0;
  double training_fraction = 0.67, validation_fraction = 0.15;
  double settling_s = 40.0, from_first_fraction = 0.2;
  Index validation_every = 100, patience = 0;
  template <class Self, class Visitor>
  static void fields(Self& self, Visitor&& visit) {
    visit(self.hidden, sim::Key{"hidden", {1, 4096}, "size of the LSTM layer"});
    visit(self.dense, sim::Key{"dense", {1, 4096}, "size of the dense layer"});
    visit(self.streams, sim::Key{"streams", {1, 10000}, "stretches an update, side by side"});
    visit(self.steps, sim::Key{"steps", {1, 10000}, "length of a stretch, through which the gradient goes back"});
    visit(self.updates, sim::Key{"updates", {1, 10000000}, "at most so many"});
    visit(self.rate, sim::Key{"rate", {1e-8, 1.0}, "of Adam, at first; falls as a cosine to a hundredth"});
    visit(self.clip_norm, sim::Key{"clip_norm", {1e-6, 1e6}, "a longer gradient is cut to this length"});
    visit(self.teacher_fraction, sim::Key{"teacher_fraction", sim::fraction, "of streams that are fed the measured value"});
    visit(self.feedback_noise, sim::Key{"feedback_noise", sim::fraction, "on that value, as a share of its range"});
    visit(self.longest_memory_s, sim::Key{"longest_memory_s", {0.0, 1e6}, "cells begin with memories up to this; 0: Keras's"});
    visit(self.shortest_life_s, sim::Key{"shortest_life_s", {0.1, 1e6}, "a stream begins anew after a time from here"});
    visit(self.longest_life_s, sim::Key{"longest_life_s", {0.1, 1e6}, "to here"});
    visit(self.settling_s, sim::Key{"settling_s", {0.0, 1e6}, "while this long, what a new stream cannot know counts less"});
    visit(self.from_first_fraction, sim::Key{"from_first_fraction", sim::fraction, "of streams that begin where a recording does"});
    visit(self.training_fraction, sim::Key{"training_fraction", {0.05, 1.0}, "of each recording, from its beginning"});
    visit(self.validation_fraction,
          sim::Key{"validation_fraction", {0.01, 0.9}, "of that, set aside: whole recordings where there are five or more"});
    visit(self.validation_every, sim::Key{"validation_every", {1, 1000000}, "updates between two validations"});
    visit(self.patience,
          sim::Key{"patience", {0, 1000000}, "validations without a better one before training ends; 0: the rate falls to its end first"});
  }
  void check(const sim::YamlValue& given) const {
    if (!(shortest_life_s < longest_life_s)) given.complain("shortest_life_s must lie below longest_life_s");
  }
};

// Settings as a file gives them: a map with the name of a predictor before each one's own (predictor.h reads it). What a file leaves
// out has its default.
struct TrainingFile {
  std::map<std::string, sim::YamlValue, std::less<>> given;
  bool has(std::string_view name) const { return given.find(name) != given.end(); }
  // Throws InputError.
  template <class Settings>
  Settings settings() const {
    Settings result;
    if (const auto found = given.find(Settings::name); found != given.end()) {
      sim::read_fields_of(result, found->second);
      if constexpr (requires { result.check(found->second); }) result.check(found->second);
    }
    return result;
  }
};
template <class Settings>
std::string settings_text_of(const TrainingFile& file) {
  const auto settings = file.settings<Settings>();
  std::string text;
  Settings::fields(settings, sim::Write{text, ""});
  return text;
}

// In the unit of the channel that is predicted.
struct CurvePoint {
  Index update;
  double training_error;    // root mean square since the point before
  double validation_error;  // published: one step ahead, over what follows the training part; stateful: in rollouts. NaN: no data
};

struct Trained {
  Model model;
  std::vector<CurvePoint> curve;
  Index best_update = 0;
};

struct TrainingRun {
  Task task;
  std::uint64_t seed = 1;
  int threads = 1;
  std::optional<Index> updates = std::nullopt;  // instead of those of the settings
  const Model* from = nullptr;                  // goes on from its weights and scaling, with an Adam that is new
  std::function<bool()> should_stop;            // asked at every update; throws Stopped
  std::function<void(double done_share, const CurvePoint& last_point)> progress;
};
struct Stopped {};

// Throw std::invalid_argument where a recording is too short for the settings.
Trained train_published(const std::vector<Series>& recordings, const PublishedSettings& settings, const TrainingRun& run);
Trained train_stateful(const std::vector<Series>& recordings, const StatefulSettings& settings, const TrainingRun& run,
                       Cell cell = Cell::lstm);

}  // namespace sinew::model

// SPDX-License-Identifier: Apache-2.0
// What the commands that train or use a predictor share: reading its data and weights, and its pages.
#pragma once

#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "apps/app.h"
#include "model/errors.h"
#include "model/predictor.h"
#include "model/train.h"
#include "report/page.h"

namespace sinew::apps {

// The System of a plant file; where that is empty, of the first set among the paths; else the usual plant's.
std::shared_ptr<const plant::System> system_for(const std::string& plant_file, const std::vector<std::string>& paths = {});
// The channel of this column (--predict); none where it is empty. Throws InputError where there is no such channel.
std::optional<plant::ChannelId> channel_named(const plant::System& system, const std::string& column);
// The usual plant's columns, all of which are checked in reading, where the task's are among them; else the task's own.
sim::Columns columns_for(const model::Task& task);
// Recordings of sets and files (these with the columns given), as a task sees them. `until_s`: what comes later in a recording
// is left out. Throws InputError where a column of a file is not what its name says: by the plant file, or where that is empty by the
// usual plant, if it has these columns. Sets were simulated, and are taken as they are; of each at most `most_runs`, spread evenly over it,
// and where that leaves some out, it is said on standard error.
inline constexpr std::int64_t usual_most_runs = 4096;
std::vector<model::Series> series_of_paths(const std::vector<std::string>& paths, const sim::Columns& columns, const model::Task& task,
                                           double until_s, model::Missing missing, const std::string& plant_file,
                                           std::int64_t most_runs = usual_most_runs);

// Of --hold-missing and --resample.
model::Missing missing_by(bool hold_missing, bool resample);
void add_resample(CLI::App& command, bool& resample);

// The settings of a file, or the defaults where its name is empty. Throws InputError where the file is of other predictors alone.
model::TrainingFile training_settings(const std::string& predictor, const std::string& settings_file);
// The linear reference fitted to what a predictor was trained on.
model::LinearModel arx_beside(double training_fraction, const std::vector<model::Series>& data);
// The predictor in a file or in the folder of `sinew train`. A file that Keras wrote is read with its sidecar (model/sidecar.h) where
// there is one; where `unsaid` says all else instead, a line says what is taken for granted. `system`: of the sidecar's columns.
std::unique_ptr<model::Predictor> read_predictor_at(const std::string& path, model::Unsaid unsaid = {},
                                                    std::shared_ptr<const plant::System> system = nullptr);

// What a rollout must beat: the first value held, and the ARX where there is one. NaN: it went beyond all bounds.
struct Baselines {
  double hold = 0.0;
  std::optional<double> arx;
};
Baselines baselines_of(const model::Predictor& predictor, const model::Series& series);
// "To hold the first value is 12.3° off, an ARX that was fitted to the same data 4.5°."; what an ARX does not say of an older file.
std::string baseline_sentence(const Baselines& baselines, const std::string& unit);

// How far a rollout of a series and its steps one ahead are to be trusted, by what the weights file keeps.
struct Trust {
  struct Interval {
    double promised_share = 0.0;
    model::Vector<double> open_loop, one_step;  // half widths [samples]
    double inside_open_loop = 0.0, inside_one_step = 0.0;
  };
  std::optional<Interval> interval;  // none: the file has none
  std::optional<model::Departures> departures;
};
// `whole`: the recording, of which the series begins at sample `first`; `history`: samples before it that the predictor was given.
Trust trust_in(const model::AboutPredictor& about, const model::Series& series, const model::Series& whole, model::Index first,
               model::Index history, const model::Vector<double>& open, const model::Vector<double>& step);
// In words, a sentence or two each; what the file lacks is said.
std::string interval_sentence(const Trust& trust, const model::AboutPredictor& about);
std::string departure_sentence(const Trust& trust, const model::AboutPredictor& about, double first_s);
// Whether more lies outside than is usual.
bool leaves_training(const Trust& trust, const model::AboutPredictor& about);
// What is said of departures in JSON: shares, since when, which columns.
nlohmann::ordered_json outside_json(const model::Departures& found, const model::AboutPredictor& about, double first_s);
// Keys `interval` and `outside`, null where there is none.
void put_trust(nlohmann::ordered_json& json, const Trust& trust, const model::AboutPredictor& about, double first_s);

// Weights of a folder (its weights.h5) or of a file.
std::string weights_path(const std::string& model);

// Measured and predicted, error over time, and the prediction against each feature that is measured. With `trust`, the interval is drawn
// round the prediction, and where it is outside of what was trained on is shaded.
std::vector<report::Block> rollout_blocks(const model::Series& series, const model::Vector<double>& predicted, const model::Task& task,
                                          const Trust* trust = nullptr);
// `validated_by`: what its validation error is.
std::vector<report::Block> curve_blocks(const std::vector<model::CurvePoint>& curve, const std::string& validated_by,
                                        const model::Task& task);

// What the predictor is given: "duty A, temperature A".
std::string words_of(const model::Task& task);
// The column's unit as people read it.
std::string unit_words(const sim::Column& column);
// A number in the unit of the column: "training_deg".
std::string key_in_unit(const std::string& what, const sim::Column& column);

}  // namespace sinew::apps

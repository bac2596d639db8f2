// SPDX-License-Identifier: Apache-2.0
// What the commands that train or use a predictor share: reading its data and weights, and its pages.
#pragma once

#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "model/errors.h"
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
// is left out.
std::vector<model::Series> series_of_paths(const std::vector<std::string>& paths, const sim::Columns& columns, const model::Task& task,
                                           double until_s, model::Missing missing);

// The settings of a file, or the defaults where its name is empty; `updates` above 0 replaces those of the stateful method.
// Throws InputError where the file is of the other method, or the method counts no updates.
model::TrainingFile training_settings(const std::string& method, const std::string& settings_file, std::int64_t updates = 0);
// Trains by `method`, with these settings or the defaults.
model::Trained train_by(const std::string& method, const model::TrainingFile& settings, const std::vector<model::Series>& data,
                        const model::TrainingRun& run);
// The linear reference fitted to what `train_by` trains on.
model::LinearModel arx_beside(const std::string& method, const model::TrainingFile& settings, const std::vector<model::Series>& data);

// What a rollout must beat: the first value held, and the ARX where there is one. NaN: it went beyond all bounds.
struct Baselines {
  double hold = 0.0;
  std::optional<double> arx;
};
Baselines baselines_of(const model::Model& predictor, const model::Series& series);
// "To hold the first value is 12.3° off, an ARX that was fitted to the same data 4.5°."; what an ARX does not say of an older file.
std::string baseline_sentence(const Baselines& baselines, const std::string& unit);

// Weights of a folder (its weights.h5) or of a file.
std::string weights_path(const std::string& model);

// Measured and predicted, error over time, and the prediction against each feature that is measured.
std::vector<report::Block> rollout_blocks(const model::Series& series, const model::Vector<double>& predicted, const model::Task& task);
std::vector<report::Block> curve_blocks(const std::vector<model::CurvePoint>& curve, const std::string& method, const model::Task& task);

// What the predictor is given: "duty A, temperature A".
std::string words_of(const model::Task& task);
// The column's unit as people read it.
std::string unit_words(const sim::Column& column);
// A number in the unit of the column: "training_deg".
std::string key_in_unit(const std::string& what, const sim::Column& column);

}  // namespace sinew::apps

// SPDX-License-Identifier: Apache-2.0
// What the commands that train or use a predictor share: reading its data and weights, and its pages.
#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "model/errors.h"
#include "model/train.h"
#include "report/page.h"

namespace sinew::apps {

// Recordings of sets and files, as a case sees them. `until_s`: what comes later in a recording is left out.
std::vector<model::Series> series_of_paths(const std::vector<std::string>& paths, int paper_case, double until_s, model::Missing missing);

// Trains by `method` with the settings of a file, or the defaults where its name is empty.
model::Trained train_by(const std::string& method, const std::string& settings_file, const std::vector<model::Series>& data,
                        const model::TrainingRun& run);

// Weights of a folder (its weights.h5) or of a file.
std::string weights_path(const std::string& model);

// Angle measured and predicted, error over time, and temperature-angle loops where the case has temperatures.
std::vector<report::Block> rollout_blocks(const model::Series& series, const model::Vector<double>& predicted, int paper_case);
std::vector<report::Block> curve_blocks(const std::vector<model::CurvePoint>& curve, const std::string& method);

std::string case_words(int paper_case);

}  // namespace sinew::apps

// SPDX-License-Identifier: Apache-2.0
// Least squares on the inputs of the instant alone, the paper's reference (linear.h).
#include "model/linear_predictor.h"

namespace sinew::model {
namespace {

struct LeastSquaresSettings : LinearSettings {
  static constexpr std::string_view name = "least_squares";
};

TrainedPredictor train_least_squares(const TrainingInput& input) {
  const auto settings = input.settings.settings<LeastSquaresSettings>();
  const std::vector<Series> parts = parts_to_fit(input.data, settings.training_fraction);
  AboutPredictor about{.task = input.run.task, .kind = std::string(LeastSquaresSettings::name), .trained_on = {}};
  return {.predictor = std::make_unique<LinearPredictor>(std::move(about), finite(fit_static(parts), parts)),
          .training_fraction = settings.training_fraction};
}

}  // namespace

PredictorKind make_least_squares() {
  return {.name = LeastSquaresSettings::name,
          .words = "least squares on the inputs of the instant",
          .train = train_least_squares,
          .load = load_linear,
          .settings_text = settings_text_of<LeastSquaresSettings>};
}

}  // namespace sinew::model

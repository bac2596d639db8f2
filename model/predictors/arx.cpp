// SPDX-License-Identifier: Apache-2.0
// A linear predictor, fitted to one step ahead (linear.h).
#include "model/linear_predictor.h"

namespace sinew::model {
namespace {

struct ArxSettings : LinearSettings {
  static constexpr std::string_view name = "arx";
};

TrainedPredictor train_arx(const TrainingInput& input) {
  const auto settings = input.settings.settings<ArxSettings>();
  const std::vector<Series> parts = parts_to_fit(input.data, settings.training_fraction);
  LinearModel model = finite(fit_arx(parts), parts);
  AboutPredictor about{.task = input.run.task, .kind = std::string(ArxSettings::name), .trained_on = {}};
  return {.predictor = std::make_unique<LinearPredictor>(std::move(about), std::move(model)),
          .training_fraction = settings.training_fraction};
}

}  // namespace

PredictorKind make_arx() {
  return {.name = ArxSettings::name,
          .words = "linear (ARX), fitted to one step ahead",
          .train = train_arx,
          .load = load_linear,
          .settings_text = settings_text_of<ArxSettings>};
}

}  // namespace sinew::model

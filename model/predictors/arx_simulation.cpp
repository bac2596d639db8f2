// SPDX-License-Identifier: Apache-2.0
// A linear predictor, fitted to the error of its rollout (linear.h).
#include "model/linear_predictor.h"

namespace sinew::model {
namespace {

struct ArxSimulationSettings : LinearSettings {
  static constexpr std::string_view name = "arx_simulation";
};

TrainedPredictor train_arx_simulation(const TrainingInput& input) {
  const auto settings = input.settings.settings<ArxSimulationSettings>();
  const std::vector<Series> parts = parts_to_fit(input.data, settings.training_fraction);
  LinearModel model = finite(fit_arx_simulation(parts, input.run.should_stop), parts);
  AboutPredictor about{.task = input.run.task, .kind = std::string(ArxSimulationSettings::name), .trained_on = {}};
  return {.predictor = std::make_unique<LinearPredictor>(std::move(about), std::move(model)),
          .training_fraction = settings.training_fraction};
}

}  // namespace

PredictorKind make_arx_simulation() {
  return {.name = ArxSimulationSettings::name,
          .words = "linear (ARX), fitted to the error of its rollout",
          .train = train_arx_simulation,
          .load = load_linear,
          .settings_text = settings_text_of<ArxSimulationSettings>};
}

}  // namespace sinew::model

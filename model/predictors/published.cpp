// SPDX-License-Identifier: Apache-2.0
// The LSTM as Sabelhaus et al. 2022 published it (train.h).
#include "model/lstm_predictor.h"

namespace sinew::model {
namespace {

TrainedPredictor train_published_kind(const TrainingInput& input) {
  const auto settings = input.settings.settings<PublishedSettings>();
  TrainingRun run = input.run;
  run.from = lstm_to_go_on_from(input, PublishedSettings::name);
  Trained trained = train_published(input.data, settings, run);
  return {std::make_unique<LstmPredictor>(std::move(trained.model)), std::move(trained.curve), trained.best_update,
          settings.training_fraction, "one step ahead, on what follows the training part"};
}

}  // namespace

PredictorKind make_published() {
  return {.name = PublishedSettings::name,
          .words = "LSTM as published, without memory",
          .train = train_published_kind,
          .load = load_lstm,
          .settings_text = settings_text_of<PublishedSettings>,
          .goes_on = true};
}

}  // namespace sinew::model

// SPDX-License-Identifier: Apache-2.0
// The LSTM with a state that is carried on, trained mostly on its own output (train.h).
#include "model/lstm_predictor.h"

namespace sinew::model {
namespace {

TrainedPredictor train_stateful_kind(const TrainingInput& input) {
  auto settings = input.settings.settings<StatefulSettings>();
  if (input.run.updates) settings.updates = *input.run.updates;
  TrainingRun run = input.run;
  run.from = lstm_to_go_on_from(input, StatefulSettings::name);
  Trained trained = train_stateful(input.data, settings, run);
  return {std::make_unique<LstmPredictor>(std::move(trained.model)), std::move(trained.curve), trained.best_update,
          settings.training_fraction, "in open loop, on what was set aside"};
}

}  // namespace

PredictorKind make_stateful() {
  return {.name = StatefulSettings::name,
          .words = "LSTM with memory, trained in open loop",
          .train = train_stateful_kind,
          .load = load_lstm,
          .settings_text = settings_text_of<StatefulSettings>,
          .counts_updates = true,
          .goes_on = true};
}

}  // namespace sinew::model

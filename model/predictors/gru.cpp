// SPDX-License-Identifier: Apache-2.0
// A GRU in the place of the LSTM, trained as `stateful` is (train.h): a quarter fewer weights of its layer.
#include "model/lstm_predictor.h"

namespace sinew::model {
namespace {

struct GruSettings : StatefulSettings {
  static constexpr std::string_view name = "gru";
};

TrainedPredictor train_gru(const TrainingInput& input) {
  auto settings = input.settings.settings<GruSettings>();
  if (input.run.updates) settings.updates = *input.run.updates;
  TrainingRun run = input.run;
  run.from = lstm_to_go_on_from(input, GruSettings::name);
  Trained trained = train_stateful(input.data, settings, run, Cell::gru);
  return {std::make_unique<LstmPredictor>(std::move(trained.model)), std::move(trained.curve), trained.best_update,
          settings.training_fraction, "in open loop, on what was set aside"};
}

}  // namespace

PredictorKind make_gru() {
  return {.name = GruSettings::name,
          .words = "GRU with memory, trained in open loop",
          .train = train_gru,
          .load = load_lstm,
          .settings_text = settings_text_of<GruSettings>,
          .counts_updates = true,
          .goes_on = true};
}

}  // namespace sinew::model

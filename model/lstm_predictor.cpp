// SPDX-License-Identifier: Apache-2.0
#include "model/lstm_predictor.h"

#include "model/task_json.h"

namespace sinew::model {

LstmPredictor::LstmPredictor(Model model)
    : Predictor({model.task, model.method, model.trained_on, model.arx}), model_(std::move(model)), loop_(model_) {}

void LstmPredictor::begin(const Series& history) {
  loop_.begin(history.y(0), history.v.col(0));
  for (Index k = 1; k < history.samples(); ++k)
    history.is_measured(k - 1) ? loop_.one_step(history.v.col(k), history.y(k - 1)) : loop_.open_loop(history.v.col(k));
  if (history.samples() > 1) loop_.correct(history.y(history.samples() - 1));
}

double LstmPredictor::step(const Eigen::Ref<const Vector<double>>& v, std::optional<double> y_before) {
  return y_before ? loop_.one_step(v, *y_before) : loop_.open_loop(v);
}

Hdf5File LstmPredictor::save(Layout layout) const {
  Model said = model_;
  said.trained_on = about_.trained_on;
  said.arx = about_.arx;
  return file_of(said, layout);
}

std::unique_ptr<Predictor> LstmPredictor::copy() const { return std::make_unique<LstmPredictor>(*this); }

std::unique_ptr<Predictor> load_lstm(const Hdf5File& file, const std::string& name, const Unsaid& unsaid) {
  return std::make_unique<LstmPredictor>(model_in(file, name, unsaid));
}

const Model* lstm_to_go_on_from(const TrainingInput& input, std::string_view kind) {
  if (!input.from) return nullptr;
  const auto* lstm = dynamic_cast<const LstmPredictor*>(input.from);
  if (!lstm || lstm->about().kind != kind) complain("", "--from", input.from->about().kind, "cannot go on as " + std::string(kind));
  return &lstm->model();
}

}  // namespace sinew::model

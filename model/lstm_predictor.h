// SPDX-License-Identifier: Apache-2.0
// A recurrent network, LSTM or GRU, as a Predictor, whatever it was trained by.
#pragma once

#include "model/network_loop.h"
#include "model/predictor.h"

namespace sinew::model {

class LstmPredictor : public Predictor {
 public:
  explicit LstmPredictor(Model model);
  // With more than one sample of history, the state follows what was measured; the memoryless network has none.
  void begin(const Series& history) override;
  double step(const Eigen::Ref<const Vector<double>>& v, std::optional<double> y_before) override;
  Hdf5File save(Layout layout) const override;
  std::unique_ptr<Predictor> copy() const override;
  const Model& model() const { return model_; }

 private:
  Model model_;
  NetworkLoop loop_;
};

std::unique_ptr<Predictor> load_lstm(const Hdf5File& file, const std::string& name, const Unsaid& unsaid);
// The model that training is to go on from: null where none is given. Throws InputError where it is of another kind.
const Model* lstm_to_go_on_from(const TrainingInput& input, std::string_view kind);

}  // namespace sinew::model

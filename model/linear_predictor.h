// SPDX-License-Identifier: Apache-2.0
// A linear model as a Predictor, whatever it was fitted to.
#pragma once

#include "model/linear.h"
#include "model/predictor.h"

namespace sinew::model {

struct LinearSettings {
  double training_fraction = 0.67;
  template <class Self, class Visitor>
  static void fields(Self& self, Visitor&& visit) {
    visit(self.training_fraction, sim::Key{"training_fraction", {0.05, 1.0}, "of each recording, from its beginning"});
  }
};

class LinearPredictor : public Predictor {
 public:
  LinearPredictor(AboutPredictor about, LinearModel model);
  void begin(const Series& history) override;
  double step(const Eigen::Ref<const Vector<double>>& v, std::optional<double> y_before) override;
  Hdf5File save(Layout layout) const override;
  std::unique_ptr<Predictor> copy() const override;
  const LinearModel& model() const { return model_; }

 private:
  LinearModel model_;
  Vector<double> row_;  // as model_.coefficients
};

// The parts of recordings that a fit sees. Throws InputError where one is too short.
std::vector<Series> parts_to_fit(const std::vector<Series>& recordings, double training_fraction);
// `model` as it is; throws InputError where it has no finite solution: too little was measured in a row.
LinearModel finite(LinearModel model, const std::vector<Series>& recordings);
std::unique_ptr<Predictor> load_linear(const Hdf5File& file, const std::string& name, const Unsaid& unsaid);

}  // namespace sinew::model

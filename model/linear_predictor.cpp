// SPDX-License-Identifier: Apache-2.0
#include "model/linear_predictor.h"

#include <cmath>

#include "model/task_json.h"
#include "sim/input_error.h"

namespace sinew::model {

LinearPredictor::LinearPredictor(AboutPredictor about, LinearModel model)
    : Predictor(std::move(about)), model_(std::move(model)), row_(model_.coefficients.size()) {}

// Between steps the row holds y(t-i) in its head, and v(t-i) behind the place of v(t): what the next step needs, moved by one already.
void LinearPredictor::begin(const Series& history) {
  const Index n = model_.order, K = history.v.rows(), last = history.samples() - 1;
  for (Index i = 1; i <= n; ++i) row_(i - 1) = history.y(std::max(Index{0}, last + 1 - i));
  for (Index i = 0; i <= n; ++i) row_.segment(n + i * K, K) = history.v.col(std::max(Index{0}, last + 1 - std::max(Index{1}, i)));
  row_(row_.size() - 1) = 1.0;
}

double LinearPredictor::step(const Eigen::Ref<const Vector<double>>& v, std::optional<double> y_before) {
  const Index n = model_.order, K = v.size();
  row_.segment(n, K) = v;
  if (y_before && n > 0) row_(0) = *y_before;
  const double y = model_.coefficients.dot(row_);
  for (Index i = n - 1; i > 0; --i) row_(i) = row_(i - 1);
  if (n > 0) row_(0) = y;
  for (Index i = n; i > 0; --i)
    for (Index k = 0; k < K; ++k) row_(n + i * K + k) = row_(n + (i - 1) * K + k);
  return y;
}

Hdf5File LinearPredictor::save(Layout) const { return described_file(about_, json_of(model_).dump()); }

std::unique_ptr<Predictor> LinearPredictor::copy() const { return std::make_unique<LinearPredictor>(*this); }

std::vector<Series> parts_to_fit(const std::vector<Series>& recordings, double training_fraction) {
  const std::vector<Series> parts = training_parts(recordings, training_fraction);
  for (const Series& one : parts)
    if (one.samples() < 20)
      throw sim::InputError({.file = one.name,
                             .key = "samples for training",
                             .value = std::to_string(one.samples()),
                             .advice = "is too short; at least 20 are needed"});
  return parts;
}

LinearModel finite(LinearModel model, const std::vector<Series>& recordings) {
  if (model.coefficients.allFinite()) return model;
  throw sim::InputError({.file = recordings.front().name + (recordings.size() > 1 ? " and others" : ""),
                         .advice = "the linear fit has no finite solution: too few samples were measured in a row"});
}

std::unique_ptr<Predictor> load_linear(const Hdf5File& file, const std::string& name, const Unsaid& unsaid) {
  std::string own;
  AboutPredictor about = read_description(file, name, unsaid, own);
  LinearModel model = linear_of_json(nlohmann::ordered_json::parse(own), about.task, name);
  return std::make_unique<LinearPredictor>(std::move(about), std::move(model));
}

}  // namespace sinew::model

// SPDX-License-Identifier: Apache-2.0
#include "model/network_loop.h"

#include <algorithm>
#include <span>

#include "sim/parallel.h"

namespace sinew::model {

NetworkLoop::NetworkLoop(const Model& model)
    : weights_(model.weights),
      scaling_(model.scaling),
      memoryless_(model.memoryless()),
      x_(Vector<float>::Zero(weights_.shape.inputs)),
      z_(weights_.shape.gates() * weights_.shape.hidden),
      q_(weights_.shape.cell == Cell::gru ? z_.size() : 0),
      c_(Vector<float>::Zero(weights_.shape.hidden)),
      h_(c_),
      r_(weights_.shape.dense) {}

void NetworkLoop::begin(double y, const Eigen::Ref<const Vector<double>>& v) {
  c_.setZero();
  h_.setZero();
  const Index K = scaling_.v_offset.size();
  x_.head(K) = ((v - scaling_.v_offset).array() / scaling_.v_span.array()).cast<float>();
  x_(2 * K) = static_cast<float>(scaling_.scaled_y(y));
}

double NetworkLoop::step(const Eigen::Ref<const Vector<double>>& v) {
  const Index K = scaling_.v_offset.size(), H = weights_.shape.hidden;
  for (Index k = 0; k < K; ++k) x_(K + k) = x_(k);
  x_.head(K) = ((v - scaling_.v_offset).array() / scaling_.v_span.array()).cast<float>();
  z_ = weights_.bias();
  z_.noalias() += weights_.input() * x_;
  if (weights_.shape.cell == Cell::gru) {
    q_ = weights_.recurrent_bias();
    q_.noalias() += weights_.recurrent() * h_;
    z_.head(2 * H) = (z_.head(2 * H) + q_.head(2 * H)).array().logistic();
    z_.tail(H) = (z_.tail(H).array() + z_.segment(H, H).array() * q_.tail(H).array()).tanh();
    h_.array() = z_.head(H).array() * h_.array() + (1.0F - z_.head(H).array()) * z_.tail(H).array();
  } else {
    lstm_step();
  }
  r_ = weights_.dense_bias();
  r_.noalias() += weights_.dense() * h_;
  float y = weights_.output_bias()(0, 0) + weights_.output().row(0).transpose().dot(r_.cwiseMax(0.0F));
  if (weights_.shape.output_relu) y = std::max(y, 0.0F);
  x_(2 * K) = y;
  return scaling_.y(y);
}

void NetworkLoop::lstm_step() {
  const Index H = weights_.shape.hidden;
  if (!memoryless_) z_.noalias() += weights_.recurrent() * h_;
  const auto i = z_.head(H).array().logistic(), f = z_.segment(H, H).array().logistic(), o = z_.tail(H).array().logistic();
  const auto g = z_.segment(2 * H, H).array().tanh();
  if (memoryless_)
    c_.array() = i * g;
  else
    c_.array() = f * c_.array() + i * g;
  h_.array() = o * c_.array().tanh();
}

double NetworkLoop::open_loop(const Eigen::Ref<const Vector<double>>& v) { return step(v); }

double NetworkLoop::one_step(const Eigen::Ref<const Vector<double>>& v, double y_before) {
  correct(y_before);
  return step(v);
}

void NetworkLoop::correct(double y) { x_(x_.size() - 1) = static_cast<float>(scaling_.scaled_y(y)); }

Vector<double> rollout(const Model& model, const Series& series) {
  NetworkLoop predictor(model);
  Vector<double> y(series.samples());
  y(0) = series.y(0);
  predictor.begin(series.y(0), series.v.col(0));
  for (Index k = 1; k < series.samples(); ++k) y(k) = predictor.open_loop(series.v.col(k));
  return y;
}

namespace {

constexpr Index stretch_steps = 50;

// Of a group; of a series that has ended already the last features go on.
std::vector<Vector<double>> side_by_side(const Model& model, std::span<const Series> group) {
  const Scaling& scaling = model.scaling;
  const Shape& shape = model.weights.shape;
  const auto B = static_cast<Index>(group.size());
  const Index K = scaling.v_offset.size();
  std::vector<Vector<double>> y;
  Index longest = 0;
  State<float> state(shape, B);
  for (Index s = 0; s < B; ++s) {
    const Series& one = group[static_cast<std::size_t>(s)];
    longest = std::max(longest, one.samples());
    y.emplace_back(one.samples())(0) = one.y(0);
    state.last_output(s) = static_cast<float>(scaling.scaled_y(one.y(0)));
  }
  const auto features = [&](const Series& one, Index k) {
    return ((one.v.col(std::min(k, one.samples() - 1)) - scaling.v_offset).array() / scaling.v_span.array()).cast<float>();
  };
  Unrolled<float> network(shape, stretch_steps, B, model.memoryless());
  Stretch<float> stretch{
      Matrix<float>(2 * K, stretch_steps * B), Matrix<float>::Zero(B, stretch_steps), Matrix<float>::Ones(B, stretch_steps), {}, {}};
  for (Index from = 1; from < longest; from += stretch_steps) {
    for (Index t = 0; t < stretch_steps; ++t)
      for (Index s = 0; s < B; ++s) {
        const Series& one = group[static_cast<std::size_t>(s)];
        stretch.exogenous.col(t * B + s) << features(one, from + t), features(one, from + t - 1);
      }
    network.forward(model.weights, stretch, state);
    for (Index s = 0; s < B; ++s) {
      Vector<double>& own = y[static_cast<std::size_t>(s)];
      for (Index t = 0; t < std::min(stretch_steps, own.size() - from); ++t) own(from + t) = scaling.y(network.outputs()(s, t));
    }
  }
  return y;
}

}  // namespace

std::vector<Vector<double>> rollouts(const Model& model, const std::vector<Series>& series, int threads) {
  std::vector<Vector<double>> all(series.size());
  sim::in_parallel((series.size() + at_once - 1) / at_once, threads, [&](std::size_t g) {
    const std::span<const Series> group = std::span(series).subspan(g * at_once, std::min(at_once, series.size() - g * at_once));
    std::ranges::move(side_by_side(model, group), all.begin() + static_cast<std::ptrdiff_t>(g * at_once));
  });
  return all;
}

Vector<double> one_step_ahead(const Model& model, const Series& series) {
  NetworkLoop predictor(model);
  Vector<double> y(series.samples());
  y(0) = series.y(0);
  predictor.begin(series.y(0), series.v.col(0));
  for (Index k = 1; k < series.samples(); ++k) y(k) = predictor.one_step(series.v.col(k), series.y(k - 1));
  return y;
}

}  // namespace sinew::model

// SPDX-License-Identifier: Apache-2.0
#include "model/network.h"

#include <Eigen/QR>
#include <cmath>

#include "sim/random.h"

namespace sinew::model {
namespace {

template <class Block>
void draw_glorot(Block block, const sim::RandomStream& chance) {
  const double limit = std::sqrt(6.0 / static_cast<double>(block.rows() + block.cols()));
  std::uint64_t n = 0;
  for (Index j = 0; j < block.cols(); ++j)
    for (Index i = 0; i < block.rows(); ++i) block(i, j) = static_cast<float>(limit * (2.0 * chance.uniform(n++) - 1.0));
}

}  // namespace

Weights<float> first_weights(const Shape& shape, std::uint64_t seed, double longest_memory) {
  Weights<float> weights(shape);
  draw_glorot(weights.input(), {seed, "weights.input"});
  draw_glorot(weights.dense(), {seed, "weights.dense"});
  draw_glorot(weights.output(), {seed, "weights.output"});
  const bool gru = shape.cell == Cell::gru;
  if (!gru) weights.bias().middleRows(shape.hidden, shape.hidden).setOnes();
  if (longest_memory > 2.0) {
    const sim::RandomStream memory(seed, "weights.memory");
    for (Index k = 0; k < shape.hidden; ++k) {
      const double forget = std::log(1.0 + (longest_memory - 2.0) * memory.uniform(static_cast<std::uint64_t>(k)));
      weights.bias()(gru ? k : shape.hidden + k, 0) = static_cast<float>(forget);
      if (!gru) weights.bias()(k, 0) = static_cast<float>(-forget);
    }
  }
  // Q of a matrix of normal deviates, with the signs that make it uniform among orthogonal matrices (Mezzadri 2007).
  const sim::RandomStream chance(seed, "weights.recurrent");
  Matrix<double> normal(shape.gates() * shape.hidden, shape.hidden);
  std::uint64_t n = 0;
  for (double& entry : normal.reshaped()) entry = chance.normal(n++);
  const Eigen::HouseholderQR<Matrix<double>> qr(normal);
  Matrix<double> q = qr.householderQ() * Matrix<double>::Identity(shape.gates() * shape.hidden, shape.hidden);
  for (Index j = 0; j < shape.hidden; ++j)
    if (qr.matrixQR()(j, j) < 0.0) q.col(j) *= -1.0;
  weights.recurrent() = q.cast<float>();
  return weights;
}

template <class S>
Unrolled<S>::Unrolled(const Shape& shape, Index steps, Index streams, bool memoryless)
    : shape_(shape),
      steps_(steps),
      streams_(streams),
      memoryless_(memoryless),
      inputs_(shape.inputs, steps * streams),
      gates_(shape.gates() * shape.hidden, steps * streams),
      q_g_(shape.cell == Cell::gru ? shape.hidden : 0, steps * streams),
      c_(Matrix<S>::Zero(shape.hidden, (steps + 1) * streams)),
      h_(c_),
      tanh_c_(shape.hidden, steps * streams),
      r_(shape.dense, steps * streams),
      dr_(shape.dense, steps * streams),
      y_(streams, steps),
      dy_(streams, steps),
      dz_(shape.gates() * shape.hidden, streams),
      dh_(shape.hidden, streams),
      dc_(shape.hidden, streams),
      dc_next_(shape.hidden, streams) {}

template <class S>
void Unrolled<S>::lstm_forward(Index t, const Weights<S>& weights) {
  const Index H = shape_.hidden, B = streams_;
  auto z = gates_.middleCols(t * B, B);
  if (!memoryless_) z.noalias() += weights.recurrent() * h_.middleCols(t * B, B);
  z.topRows(2 * H) = z.topRows(2 * H).array().logistic();
  z.middleRows(2 * H, H) = z.middleRows(2 * H, H).array().tanh();
  z.bottomRows(H) = z.bottomRows(H).array().logistic();
  const auto i = z.topRows(H).array(), f = z.middleRows(H, H).array(), g = z.middleRows(2 * H, H).array(), o = z.bottomRows(H).array();
  auto c = c_.middleCols((t + 1) * B, B).array();
  if (memoryless_)
    c = i * g;
  else
    c = f * c_.middleCols(t * B, B).array() + i * g;
  tanh_c_.middleCols(t * B, B) = c.tanh();
  h_.middleCols((t + 1) * B, B) = o * tanh_c_.middleCols(t * B, B).array();
}

template <class S>
void Unrolled<S>::gru_forward(Index t, const Weights<S>& weights) {
  const Index H = shape_.hidden, B = streams_;
  auto z = gates_.middleCols(t * B, B);
  const auto before = h_.middleCols(t * B, B);
  const auto U = weights.recurrent();
  const auto own_bias = weights.recurrent_bias();
  z.topRows(2 * H).noalias() += U.topRows(2 * H) * before;
  z.topRows(2 * H).colwise() += own_bias.col(0).head(2 * H);
  z.topRows(2 * H) = z.topRows(2 * H).array().logistic();
  auto q_g = q_g_.middleCols(t * B, B);
  q_g.noalias() = U.bottomRows(H) * before;
  q_g.colwise() += own_bias.col(0).tail(H);
  z.bottomRows(H) = (z.bottomRows(H).array() + z.middleRows(H, H).array() * q_g.array()).tanh();
  const auto u = z.topRows(H).array();
  h_.middleCols((t + 1) * B, B) = u * before.array() + (S(1) - u) * z.bottomRows(H).array();
}

template <class S>
void Unrolled<S>::lstm_backward(Index t) {
  const Index H = shape_.hidden, B = streams_;
  auto z = gates_.middleCols(t * B, B);
  const auto i = z.topRows(H).array(), f = z.middleRows(H, H).array(), g = z.middleRows(2 * H, H).array(), o = z.bottomRows(H).array(),
             tc = tanh_c_.middleCols(t * B, B).array();
  dc_.array() = dc_next_.array() + dh_.array() * o * (S(1) - tc.square());
  dz_.topRows(H) = dc_.array() * g * i * (S(1) - i);
  if (memoryless_)
    dz_.middleRows(H, H).setZero();
  else
    dz_.middleRows(H, H) = dc_.array() * c_.middleCols(t * B, B).array() * f * (S(1) - f);
  dz_.middleRows(2 * H, H) = dc_.array() * i * (S(1) - g.square());
  dz_.bottomRows(H) = dh_.array() * tc * o * (S(1) - o);
  if (!memoryless_) dc_next_.array() = dc_.array() * f;
  z = dz_;
}

template <class S>
void Unrolled<S>::gru_backward(Index t, const Weights<S>& weights) {
  const Index H = shape_.hidden, B = streams_;
  auto z = gates_.middleCols(t * B, B);
  auto q_g = q_g_.middleCols(t * B, B);
  const auto u = z.topRows(H).array(), r = z.middleRows(H, H).array(), g = z.bottomRows(H).array();
  dz_.topRows(H) = dh_.array() * (h_.middleCols(t * B, B).array() - g) * u * (S(1) - u);
  dz_.bottomRows(H) = dh_.array() * (S(1) - u) * (S(1) - g.square());
  dz_.middleRows(H, H) = dz_.bottomRows(H).array() * q_g.array() * r * (S(1) - r);
  q_g = dz_.bottomRows(H).array() * r;
  dc_next_ = dh_.array() * u;
  const auto U = weights.recurrent();
  dc_next_.noalias() += U.topRows(2 * H).transpose() * dz_.topRows(2 * H);
  dc_next_.noalias() += U.bottomRows(H).transpose() * q_g;
  z = dz_;
}

template <class S>
void Unrolled<S>::forward(const Weights<S>& weights, const Stretch<S>& stretch, State<S>& state) {
  const Index B = streams_, last = shape_.inputs - 1;
  const auto W = weights.input();
  if (!memoryless_) {
    c_.leftCols(B) = state.c;
    h_.leftCols(B) = state.h;
  }
  inputs_.topRows(last) = stretch.exogenous;
  gates_.noalias() = W.leftCols(last) * stretch.exogenous;
  gates_.colwise() += weights.bias().col(0);
  for (Index t = 0; t < steps_; ++t) {
    const auto free = stretch.free.col(t).array();
    const Eigen::Map<const Vector<S>> own(t > 0 ? y_.col(t - 1).data() : state.last_output.data(), B);
    inputs_.row(last).segment(t * B, B) = (free * own.array() + (S(1) - free) * stretch.y_before.col(t).array()).matrix().transpose();
    auto z = gates_.middleCols(t * B, B);
    z.noalias() += W.col(last) * inputs_.row(last).segment(t * B, B);
    shape_.cell == Cell::gru ? gru_forward(t, weights) : lstm_forward(t, weights);
    auto r = r_.middleCols(t * B, B);
    r.noalias() = weights.dense() * h_.middleCols((t + 1) * B, B);
    r.colwise() += weights.dense_bias().col(0);
    r = r.cwiseMax(S(0));
    y_.col(t).noalias() = r.transpose() * weights.output().transpose();
    y_.col(t).array() += weights.output_bias()(0, 0);
    if (shape_.output_relu) y_.col(t) = y_.col(t).cwiseMax(S(0));
  }
  if (!memoryless_) {
    state.c = c_.rightCols(B);
    state.h = h_.rightCols(B);
  }
  state.last_output = y_.col(steps_ - 1);
}

template <class S>
S Unrolled<S>::backward(const Weights<S>& weights, const Stretch<S>& stretch, Weights<S>& gradient) {
  const Index H = shape_.hidden, B = streams_, last = shape_.inputs - 1;
  const auto U = weights.recurrent();
  const Matrix<S> error = y_ - stretch.target;
  dy_ = S(2) * stretch.weight.cwiseProduct(error);
  dc_next_.setZero();
  for (Index t = steps_ - 1; t >= 0; --t) {
    // What the step after fed back of this one's output. dz_ is still that step's.
    if (t + 1 < steps_) dy_.col(t).array() += stretch.free.col(t + 1).array() * (dz_.transpose() * weights.input().col(last)).array();
    if (shape_.output_relu) dy_.col(t).array() *= (y_.col(t).array() > S(0)).template cast<S>();
    auto dr = dr_.middleCols(t * B, B);
    dr.noalias() = weights.output().transpose() * dy_.col(t).transpose();
    dr.array() *= (r_.middleCols(t * B, B).array() > S(0)).template cast<S>();
    dh_.noalias() = weights.dense().transpose() * dr;
    if (shape_.cell == Cell::gru)
      dh_ += dc_next_;  // what the step after wants of h
    else if (!memoryless_ && t + 1 < steps_)
      dh_.noalias() += U.transpose() * dz_;
    shape_.cell == Cell::gru ? gru_backward(t, weights) : lstm_backward(t);
  }
  gradient.input().noalias() += gates_ * inputs_.transpose();
  gradient.bias() += gates_.rowwise().sum();
  gradient.dense().noalias() += dr_ * h_.rightCols(steps_ * B).transpose();
  gradient.dense_bias() += dr_.rowwise().sum();
  for (Index t = 0; t < steps_; ++t) gradient.output().noalias() += (r_.middleCols(t * B, B) * dy_.col(t)).transpose();
  gradient.output_bias()(0, 0) += dy_.sum();
  if (shape_.cell == Cell::gru) {
    const auto before = h_.leftCols(steps_ * B).transpose();
    gradient.recurrent().topRows(2 * H).noalias() += gates_.topRows(2 * H) * before;
    gradient.recurrent().bottomRows(H).noalias() += q_g_ * before;
    gradient.recurrent_bias().topRows(2 * H) += gates_.topRows(2 * H).rowwise().sum();
    gradient.recurrent_bias().bottomRows(H) += q_g_.rowwise().sum();
  } else if (!memoryless_) {
    gradient.recurrent().noalias() += gates_ * h_.leftCols(steps_ * B).transpose();
  }
  return stretch.weight.cwiseProduct(error).cwiseProduct(error).sum();
}

template class Unrolled<float>;
template class Unrolled<double>;

template <class S>
void Adam<S>::update(Vector<S>& weights, const Vector<S>& gradient, const AdamSettings& settings, double rate_factor) {
  const Index size = m_.size();
  const auto n = static_cast<double>(updates_);
  const auto b1 = static_cast<S>(settings.beta1), b2 = static_cast<S>(settings.beta2);
  const auto rate = static_cast<S>(rate_factor * settings.rate / (1.0 + settings.decay * n) *
                                   std::sqrt(1.0 - std::pow(settings.beta2, n + 1.0)) / (1.0 - std::pow(settings.beta1, n + 1.0)));
  const auto g = gradient.head(size).array();
  m_.array() = b1 * m_.array() + (S(1) - b1) * g;
  v_.array() = b2 * v_.array() + (S(1) - b2) * g.square();
  weights.head(size).array() -= rate * m_.array() / (v_.array().sqrt() + static_cast<S>(settings.epsilon));
  ++updates_;
}

template class Adam<float>;
template class Adam<double>;

}  // namespace sinew::model

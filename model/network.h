// SPDX-License-Identifier: Apache-2.0
// The network of Sabelhaus et al. 2022: an LSTM layer, a dense layer with ReLU, one output. A GRU layer may stand in its place.
//
//   z(t) = W x(t) + U h(t-1) + b,      stacked by gate: input, forget, cell, output
//   c(t) = s(z_f) c(t-1) + s(z_i) tanh(z_c),      h(t) = s(z_o) tanh(c(t)),      s the logistic function
//   r(t) = max(0, D h(t) + d),      y(t) = e r(t) + e_0, cut at 0 where the shape says so
//
// The GRU, gates stacked as update, reset, candidate, with a bias b' of its own on the recurrent side (Keras's reset_after=True):
//
//   p(t) = W x(t) + b,  q(t) = U h(t-1) + b',   u = s(p_u + q_u),  r = s(p_r + q_r),  g = tanh(p_g + r q_g)
//   h(t) = u h(t-1) + (1 - u) g
//
// Source: Cho et al. 2014, arXiv:1406.1078, in the form of cuDNN; Hochreiter and Schmidhuber 1997, Neural Computation 9(8), with the forget
// gate of Gers et al. 2000; gates and names as in Keras 2. The last of the inputs is y at the step before: measured, or the network's own
// output, fed back.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <utility>

namespace sinew::model {

using Index = Eigen::Index;
template <class S>
using Matrix = Eigen::Matrix<S, Eigen::Dynamic, Eigen::Dynamic>;
template <class S>
using Vector = Eigen::Matrix<S, Eigen::Dynamic, 1>;

// Rows of W, U and b are stacked by gate in this order.
enum class Gate { input, forget, cell, output };
enum class Cell { lstm, gru };

struct Shape {
  Index inputs = 0;  // the fed-back y, the last one, included
  Index hidden = 0;
  Index dense = 0;
  bool output_relu = false;
  Cell cell = Cell::lstm;
  Index gates() const { return cell == Cell::gru ? 3 : 4; }
  Index rest() const {  // all but U
    return gates() * hidden * (inputs + 1) + dense * (hidden + 1) + dense + 1 + (cell == Cell::gru ? gates() * hidden : 0);
  }
  Index size() const { return rest() + gates() * hidden * hidden; }
  friend bool operator==(const Shape&, const Shape&) = default;
};

// All weights in one vector, in the order W, b, of a GRU b', D, d, e, e_0, U; G gates (4 or 3) of H rows; matrices are columns one after
// the other. U is last, so that who leaves it alone can work on the head.
template <class S>
struct Weights {
  Shape shape;
  Vector<S> all;

  Weights() = default;
  explicit Weights(const Shape& of) : shape(of), all(Vector<S>::Zero(of.size())) {}

  auto input() { return matrix(*this, 0, shape.gates() * shape.hidden, shape.inputs); }  // W [GH x I]
  auto input() const { return matrix(*this, 0, shape.gates() * shape.hidden, shape.inputs); }
  auto bias() { return matrix(*this, at_bias(), shape.gates() * shape.hidden, 1); }  // b [GH x 1]
  auto bias() const { return matrix(*this, at_bias(), shape.gates() * shape.hidden, 1); }
  auto dense() { return matrix(*this, at_dense(), shape.dense, shape.hidden); }  // D [D x H]
  auto dense() const { return matrix(*this, at_dense(), shape.dense, shape.hidden); }
  auto dense_bias() { return matrix(*this, at_dense_bias(), shape.dense, 1); }  // d [D x 1]
  auto dense_bias() const { return matrix(*this, at_dense_bias(), shape.dense, 1); }
  auto output() { return matrix(*this, at_output(), 1, shape.dense); }  // e [1 x D]
  auto output() const { return matrix(*this, at_output(), 1, shape.dense); }
  auto output_bias() { return matrix(*this, at_output() + shape.dense, 1, 1); }  // e_0 [1 x 1]
  auto output_bias() const { return matrix(*this, at_output() + shape.dense, 1, 1); }
  auto recurrent_bias() {
    return matrix(*this, at_bias() + shape.gates() * shape.hidden, shape.gates() * shape.hidden, 1);
  }  // b' of a GRU [GH x 1]
  auto recurrent_bias() const { return matrix(*this, at_bias() + shape.gates() * shape.hidden, shape.gates() * shape.hidden, 1); }
  auto recurrent() { return matrix(*this, shape.rest(), shape.gates() * shape.hidden, shape.hidden); }  // U [GH x H]
  auto recurrent() const { return matrix(*this, shape.rest(), shape.gates() * shape.hidden, shape.hidden); }

 private:
  Index at_bias() const { return shape.gates() * shape.hidden * shape.inputs; }
  Index at_dense() const { return at_bias() + (shape.cell == Cell::gru ? 2 : 1) * shape.gates() * shape.hidden; }
  Index at_dense_bias() const { return at_dense() + shape.dense * shape.hidden; }
  Index at_output() const { return at_dense_bias() + shape.dense; }
  template <class Self>
  static auto matrix(Self& self, Index from, Index rows, Index cols) {
    using Plain = std::conditional_t<std::is_const_v<Self>, const Matrix<S>, Matrix<S>>;
    return Eigen::Map<Plain>(self.all.data() + from, rows, cols);
  }
};

// Keras's initial weights: W, D and e uniform (Glorot and Bengio 2010), U orthogonal, biases 0 and 1 at the forget gate.
// With a `longest_memory` > 2 [steps], biases with which cells forget over times up to there (chrono initialization, Tallec
// and Ollivier 2018): log of a number uniform in [1, longest_memory - 1] at the forget gate, its negative at the input gate; of a GRU, at
// the update gate, all of whose biases are else 0.
Weights<float> first_weights(const Shape& shape, std::uint64_t seed, double longest_memory = 0.0);

// What is carried from step to step of several streams at once. Zero: nothing is remembered.
template <class S>
struct State {
  Matrix<S> c, h;         // [H x streams]; a GRU has no c
  Vector<S> last_output;  // [streams], what would be fed back next
  State() = default;
  State(const Shape& shape, Index streams) : c(Matrix<S>::Zero(shape.hidden, streams)), h(c), last_output(Vector<S>::Zero(streams)) {}
};

// What enters a stretch of `steps` steps of several streams. Column t * streams + s is step t of stream s.
template <class S>
struct Stretch {
  Matrix<S> exogenous;       // [I - 1 x steps * streams]
  Matrix<S> y_before;        // [streams x steps], measured
  Matrix<S> free;            // [streams x steps], 1: the own output is fed back in its stead; 0: it is used
  Matrix<S> target, weight;  // [streams x steps]; the loss is sum of weight * (y - target)^2
};

// The network over a stretch, forwards, and backwards through time and through the fed-back y (Werbos 1990). Keeps what
// the way back needs.
template <class S>
class Unrolled {
 public:
  // `memoryless`: the state is zero before every step and left alone, as in the published code; U then takes no part.
  Unrolled(const Shape& shape, Index steps, Index streams, bool memoryless = false);

  void forward(const Weights<S>& weights, const Stretch<S>& stretch, State<S>& state);
  // [streams x steps]
  const Matrix<S>& outputs() const { return y_; }
  // After `forward` with the same weights and stretch: the loss, and its derivative added to `gradient`.
  S backward(const Weights<S>& weights, const Stretch<S>& stretch, Weights<S>& gradient);

 private:
  Shape shape_;
  Index steps_, streams_;
  bool memoryless_;
  Matrix<S> inputs_;  // [I x steps * streams]
  Matrix<S> gates_;   // [GH x steps * streams], after their functions; on the way back dL/dz
  Matrix<S> q_g_;     // [H x steps * streams] of a GRU; on the way back dL/dq_g
  Matrix<S> c_, h_;   // [H x (steps + 1) * streams], the first block is what was before
  Matrix<S> tanh_c_;  // [H x steps * streams]
  Matrix<S> r_, dr_;  // [D x steps * streams]
  Matrix<S> y_, dy_;  // [streams x steps]
  Matrix<S> dz_, dh_, dc_, dc_next_;

  // Step t from gates_, which hold W x + b, to h_; and back, from dL/dh in dh_ to dL/dz in dz_ and gates_.
  void lstm_forward(Index t, const Weights<S>& weights);
  void gru_forward(Index t, const Weights<S>& weights);
  void lstm_backward(Index t);
  void gru_backward(Index t, const Weights<S>& weights);
};

extern template class Unrolled<float>;
extern template class Unrolled<double>;

// Adam (Kingma and Ba 2015, algorithm 1 with the rearranged step of section 2) as Keras's optimizer of old:
//   rate_n = rate / (1 + decay n) at update n = 0, 1, ...;  w -= rate_n sqrt(1 - b2^(n+1)) / (1 - b1^(n+1)) m / (sqrt(v) + epsilon)
struct AdamSettings {
  double rate = 1e-3, decay = 0.0, beta1 = 0.9, beta2 = 0.999, epsilon = 1e-7;
};

template <class S>
class Adam {
 public:
  explicit Adam(Index size) : m_(Vector<S>::Zero(size)), v_(m_) {}
  // Updates the first entries of `weights`, as many as there are moments. `rate_factor`: of a schedule.
  void update(Vector<S>& weights, const Vector<S>& gradient, const AdamSettings& settings, double rate_factor = 1.0);
  std::int64_t updates() const { return updates_; }

 private:
  Vector<S> m_, v_;
  std::int64_t updates_ = 0;
};

extern template class Adam<float>;
extern template class Adam<double>;

}  // namespace sinew::model

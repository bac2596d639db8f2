// SPDX-License-Identifier: Apache-2.0
#include "model/network.h"

#include <doctest/doctest.h>

#include <cmath>

#include "sim/random.h"

namespace model_network_test {

using namespace sinew::model;

namespace {

// Small, and with every path in use: two streams of which one feeds itself from the second step on.
struct Small {
  sinew::model::Shape shape;
  Index steps = 4, streams = 2;
  Weights<double> weights{shape};
  Stretch<double> stretch;
  State<double> state{shape, streams};

  explicit Small(bool output_relu = false, Cell cell = Cell::lstm) : shape{3, 4, 5, output_relu, cell} {
    const sinew::sim::RandomStream chance(7, "small network");
    std::uint64_t n = 0;
    const auto draw = [&](auto&& block) {
      for (auto& entry : block.reshaped()) entry = 0.5 * chance.normal(n++);
    };
    draw(weights.all);
    stretch = {Matrix<double>(2, steps * streams), Matrix<double>(streams, steps), Matrix<double>::Zero(streams, steps),
               Matrix<double>(streams, steps), Matrix<double>::Constant(streams, steps, 0.3)};
    draw(stretch.exogenous);
    draw(stretch.y_before);
    draw(stretch.target);
    draw(state.c);
    draw(state.h);
    draw(state.last_output);
    stretch.free.row(1).setOnes();
  }
  double loss(const Weights<double>& with, bool memoryless = false) const {
    Unrolled<double> network(shape, steps, streams, memoryless);
    State<double> carried = state;
    network.forward(with, stretch, carried);
    return stretch.weight.cwiseProduct((network.outputs() - stretch.target).cwiseAbs2()).sum();
  }
};

void check_gradient(const Small& small, bool memoryless) {
  Unrolled<double> network(small.shape, small.steps, small.streams, memoryless);
  State<double> carried = small.state;
  network.forward(small.weights, small.stretch, carried);
  Weights<double> gradient(small.shape);
  const double loss = network.backward(small.weights, small.stretch, gradient);
  CHECK(loss == doctest::Approx(small.loss(small.weights, memoryless)).epsilon(1e-14));
  Index off = 0;
  for (Index k = 0; k < small.weights.all.size(); ++k) {
    const double step = 1e-6;
    Weights<double> up = small.weights, down = small.weights;
    up.all(k) += step;
    down.all(k) -= step;
    const double difference = (small.loss(up, memoryless) - small.loss(down, memoryless)) / (2.0 * step);
    off += std::abs(difference - gradient.all(k)) > 1e-8 * (1.0 + std::abs(difference));
  }
  CHECK(off == 0);
}

}  // namespace

TEST_CASE("network: the gradient of every weight is that of differences, through time and through the fed-back angle") {
  check_gradient(Small{}, false);
}
TEST_CASE("network: the same with an output that is cut at zero") { check_gradient(Small{true}, false); }
TEST_CASE("network: the same of a GRU, with its bias on either side") {
  check_gradient(Small(false, Cell::gru), false);
  check_gradient(Small(true, Cell::gru), false);
}
TEST_CASE("network: a step of a GRU of one unit, by hand") {
  // p = (0.1, 0.2, 0.3) + 0.5 (1, -1, 2), q = (0.4, 0.1, -0.2) 0.5 + (0.05, 0, 0.3):
  // u = s(0.6 + 0.25), r = s(-0.3 + 0.05), g = tanh(1.3 + r 0.2), h = u 0.5 + (1 - u) g, y = max(0, 2 h - 0.1) 3 + 0.2.
  const sinew::model::Shape shape{1, 1, 1, false, Cell::gru};
  Weights<double> w(shape);
  w.input() << 1.0, -1.0, 2.0;
  w.bias() << 0.1, 0.2, 0.3;
  w.recurrent() << 0.4, 0.1, -0.2;
  w.recurrent_bias() << 0.05, 0.0, 0.3;
  w.dense() << 2.0;
  w.dense_bias() << -0.1;
  w.output() << 3.0;
  w.output_bias() << 0.2;
  State<double> state(shape, 1);
  state.h << 0.5;
  const Matrix<double> none = Matrix<double>::Zero(1, 1);
  Stretch<double> stretch{Matrix<double>(0, 1), Matrix<double>::Constant(1, 1, 0.5), none, none, none};
  Unrolled<double> network(shape, 1, 1);
  network.forward(w, stretch, state);
  CHECK(state.h(0, 0) == doctest::Approx(0.614573176).epsilon(1e-8));
  CHECK(network.outputs()(0, 0) == doctest::Approx(3.587439056).epsilon(1e-8));
}
TEST_CASE("network: without memory the recurrent weights have no gradient, and the others are those of differences") {
  check_gradient(Small{}, true);
  const Small small;
  Weights<double> other = small.weights;
  other.recurrent().setConstant(3.0);
  CHECK(small.loss(small.weights, true) == small.loss(other, true));
}
TEST_CASE("network: two stretches, the state carried, give what one of their length gives") {
  const Small small;
  Unrolled<double> whole(small.shape, 4, 2), half(small.shape, 2, 2);
  State<double> carried = small.state;
  whole.forward(small.weights, small.stretch, carried);
  State<double> again = small.state;
  for (Index part = 0; part < 2; ++part) {
    const Stretch<double> cut{small.stretch.exogenous.middleCols(part * 4, 4), small.stretch.y_before.middleCols(part * 2, 2),
                              small.stretch.free.middleCols(part * 2, 2), small.stretch.target.middleCols(part * 2, 2),
                              small.stretch.weight.middleCols(part * 2, 2)};
    half.forward(small.weights, cut, again);
    CHECK((half.outputs() - whole.outputs().middleCols(part * 2, 2)).cwiseAbs().maxCoeff() < 1e-15);
  }
  CHECK((carried.h - again.h).cwiseAbs().maxCoeff() < 1e-15);
}
TEST_CASE("adam: the first update moves every weight by the rate, against its gradient") {
  // By hand: m = (1 - b1) g, v = (1 - b2) g^2, so the step is rate * g / (|g| + epsilon / sqrt(1 - b2)).
  Adam<double> adam(2);
  Vector<double> w(2), g(2);
  w << 1.0, -1.0;
  g << 0.5, -20.0;
  adam.update(w, g, {0.01, 0.9, 0.9, 0.999, 1e-12});
  CHECK(w(0) == doctest::Approx(0.99).epsilon(1e-9));
  CHECK(w(1) == doctest::Approx(-0.99).epsilon(1e-9));
  // The second has rate 0.01 / 1.9; a gradient that stays has the same m and v once their bias is taken out.
  adam.update(w, g, {0.01, 0.9, 0.9, 0.999, 1e-12});
  CHECK(w(0) == doctest::Approx(0.99 - 0.01 / 1.9).epsilon(1e-9));
}
TEST_CASE("first weights: those of Keras") {
  const Weights<float> w = first_weights({5, 8, 6, true}, 3);
  CHECK((w.recurrent().transpose() * w.recurrent() - Matrix<float>::Identity(8, 8)).cwiseAbs().maxCoeff() < 1e-6F);
  CHECK(w.bias().middleRows(8, 8) == Matrix<float>::Ones(8, 1));
  CHECK(w.bias().topRows(8).isZero());
  CHECK(w.input().cwiseAbs().maxCoeff() <= std::sqrt(6.0F / (32.0F + 5.0F)));
  CHECK(w.input().cwiseAbs().maxCoeff() > 0.8F * std::sqrt(6.0F / (32.0F + 5.0F)));
  CHECK(first_weights({5, 8, 6, true}, 3).all == w.all);
  CHECK(first_weights({5, 8, 6, true}, 4).all != w.all);
}

}  // namespace model_network_test

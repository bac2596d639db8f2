// SPDX-License-Identifier: Apache-2.0
#include <doctest/doctest.h>

#include <nlohmann/json.hpp>

#include "model/network.h"
#include "sim/text.h"

namespace model_torch_test {

using namespace sinew::model;

namespace {

using Json = nlohmann::json;

// PyTorch keeps weights [out x in], as we do, biases as lists.
template <class Block>
void fill(Block block, const Json& from) {
  for (Index i = 0; i < block.rows(); ++i)
    for (Index j = 0; j < block.cols(); ++j) {
      const Json& row = from.at(static_cast<std::size_t>(i));
      block(i, j) = row.is_array() ? row.at(static_cast<std::size_t>(j)).get<double>() : row.get<double>();
    }
}

Weights<double> weights_from(const Json& json, const sinew::model::Shape& shape) {
  Weights<double> w(shape);
  fill(w.input(), json.at("input"));
  fill(w.recurrent(), json.at("recurrent"));
  fill(w.bias(), json.at("bias"));
  fill(w.dense(), json.at("dense"));
  fill(w.dense_bias(), json.at("dense_bias"));
  fill(w.output(), json.at("output"));
  fill(w.output_bias(), json.at("output_bias"));
  return w;
}

}  // namespace

TEST_CASE("network: outputs, gradients and one step of Adam are PyTorch's (tests/model/reference.py)") {
  const Json cases = Json::parse(sinew::sim::read_file(SINEW_SOURCE_DIR "/tests/model/reference.json"));
  REQUIRE(cases.size() == 3);
  for (const Json& one : cases) {
    const bool memoryless = one.at("memoryless");
    CAPTURE(memoryless);
    const sinew::model::Shape shape{one.at("inputs"), one.at("hidden"), one.at("dense"), one.at("output_relu")};
    const Index T = one.at("steps"), B = one.at("streams");
    Weights<double> w = weights_from(one.at("weights"), shape);
    Stretch<double> stretch{Matrix<double>(shape.inputs - 1, T * B), Matrix<double>(B, T), Matrix<double>::Zero(B, T), Matrix<double>(B, T),
                            Matrix<double>::Constant(B, T, 1.0 / static_cast<double>(T * B))};
    State<double> state(shape, B);
    Matrix<double> expected(B, T);
    for (Index t = 0; t < T; ++t)
      for (Index s = 0; s < B; ++s) {
        const auto tt = static_cast<std::size_t>(t), ss = static_cast<std::size_t>(s);
        for (Index i = 0; i + 1 < shape.inputs; ++i)
          stretch.exogenous(i, t * B + s) = one.at("exogenous").at(tt).at(ss).at(static_cast<std::size_t>(i));
        stretch.y_before(s, t) = one.at("before").at(tt).at(ss);
        stretch.target(s, t) = one.at("target").at(tt).at(ss);
        expected(s, t) = one.at("outputs").at(tt).at(ss);
      }
    stretch.free.row(1).setOnes();
    for (Index s = 0; s < B; ++s) {
      state.last_output(s) = one.at("last_output").at(static_cast<std::size_t>(s));
      for (Index k = 0; k < shape.hidden; ++k) {
        state.h(k, s) = one.at("h").at(static_cast<std::size_t>(s)).at(static_cast<std::size_t>(k));
        state.c(k, s) = one.at("c").at(static_cast<std::size_t>(s)).at(static_cast<std::size_t>(k));
      }
    }
    Unrolled<double> network(shape, T, B, memoryless);
    network.forward(w, stretch, state);
    // Eigen's vectorised logistic and tanh in double agree with the library's to a few units in the last place.
    CHECK((network.outputs() - expected).cwiseAbs().maxCoeff() < 1e-12);
    Weights<double> gradient(shape);
    const double loss = network.backward(w, stretch, gradient);
    CHECK(loss == doctest::Approx(one.at("loss").get<double>()).epsilon(1e-12));
    CHECK((gradient.all - weights_from(one.at("gradient"), shape).all).cwiseAbs().maxCoeff() < 1e-12);
    // PyTorch adds epsilon after the bias of v is taken out: at the first step ours is smaller by sqrt(1 - b2).
    Adam<double> adam(shape.size());
    adam.update(w.all, gradient.all, {one.at("rate"), 0.0, 0.9, 0.999, 1e-8 * std::sqrt(1.0 - 0.999)});
    // A weight whose gradient is rounding alone may go either way: those are left out.
    const Vector<double> after = weights_from(one.at("after_adam"), shape).all;
    for (Index k = 0; k < w.all.size(); ++k)
      if (std::abs(gradient.all(k)) > 1e-12) CHECK(w.all(k) == doctest::Approx(after(k)).epsilon(1e-7));
  }
}

}  // namespace model_torch_test

// SPDX-License-Identifier: Apache-2.0
// The messages are written by their field numbers: they are frozen, and neither libprotobuf nor libonnx would give the same bytes in
// each version, or stand beside another copy of itself in a Python process. tests/cli/test_predict.py reads them with ONNX's own code.
#include "model/onnx_file.h"

#include <bit>
#include <cstring>

#include "model/weights_file.h"
#include "sim/manifest.h"
#include "sim/text.h"

namespace sinew::model {
namespace {

// A message of Protocol Buffers, as its bytes. Fields stand in the order of the calls.
class Message {
 public:
  Message& number(int field, std::int64_t value) {
    varint(static_cast<std::uint64_t>(field) << 3);
    varint(static_cast<std::uint64_t>(value));
    return *this;
  }
  Message& text(int field, std::string_view bytes) {
    varint(static_cast<std::uint64_t>(field) << 3 | 2);
    varint(bytes.size());
    bytes_ += bytes;
    return *this;
  }
  Message& message(int field, const Message& inner) { return text(field, inner.bytes_); }
  const std::string& bytes() const { return bytes_; }

 private:
  void varint(std::uint64_t value) {
    for (; value >= 0x80; value >>= 7) bytes_ += static_cast<char>(value | 0x80);
    bytes_ += static_cast<char>(value);
  }
  std::string bytes_;
};

constexpr std::int64_t ir_version = 7, operator_set = 13;
constexpr std::int64_t type_float = 1, type_int64 = 7;  // TensorProto.DataType
constexpr std::int64_t attribute_int = 2;               // AttributeProto.AttributeType

using Names = std::vector<std::string>;
using Extents = std::vector<std::int64_t>;
constexpr std::int64_t any_number = -1;  // the dimension that is left open

class Graph {
 public:
  // NodeProto. An empty name stands for an optional input or output that is left out.
  void node(const char* operation, const Names& inputs, const Names& outputs,
            const std::vector<std::pair<const char*, std::int64_t>>& attributes = {}) {
    Message node;
    for (const std::string& name : inputs) node.text(1, name);
    for (const std::string& name : outputs) node.text(2, name);
    node.text(3, outputs.back()).text(4, operation);
    for (const auto& [name, value] : attributes) node.message(5, Message().text(1, name).number(3, value).number(20, attribute_int));
    graph_.message(1, node);
  }
  // TensorProto: a constant, its last index running fastest.
  template <class T>
  void constant(const std::string& name, const Extents& extents, const std::vector<T>& values) {
    static_assert(std::endian::native == std::endian::little, "raw_data is little-endian");
    static_assert(std::is_same_v<T, float> || std::is_same_v<T, std::int64_t>);
    Message tensor;
    for (const std::int64_t extent : extents) tensor.number(1, extent);
    tensor.number(2, std::is_same_v<T, float> ? type_float : type_int64).text(8, name);
    tensor.text(9, {reinterpret_cast<const char*>(values.data()), values.size() * sizeof(T)});
    constants_.push_back(tensor);
  }
  void input(const std::string& name, const Extents& extents, const std::string& words) {
    values_.emplace_back(11, value(name, extents, words));
  }
  void output(const std::string& name, const Extents& extents, const std::string& words) {
    values_.emplace_back(12, value(name, extents, words));
  }
  // GraphProto, once all is there.
  Message message(const std::string& name) const {
    Message graph = graph_;
    graph.text(2, name);
    for (const Message& constant : constants_) graph.message(5, constant);
    for (const auto& [field, value] : values_) graph.message(field, value);
    return graph;
  }

 private:
  static Message value(const std::string& name, const Extents& extents, const std::string& words) {
    Message shape;
    for (const std::int64_t extent : extents)
      shape.message(1, extent == any_number ? Message().text(2, "streams") : Message().number(1, extent));
    const Message type = Message().message(1, Message().number(1, type_float).message(2, shape));
    return Message().text(1, name).message(2, type).text(3, words);
  }
  Message graph_;
  std::vector<Message> constants_;
  std::vector<std::pair<int, Message>> values_;
};

template <class Block>
std::vector<float> row_by_row(const Block& block) {
  std::vector<float> values;
  for (Index i = 0; i < block.rows(); ++i)
    for (Index j = 0; j < block.cols(); ++j) values.push_back(static_cast<float>(block(i, j)));
  return values;
}

// ONNX stacks input, output, forget, cell; we input, forget, cell, output.
template <class Block>
std::vector<float> gates_of_onnx(const Block& block) {
  const Index H = block.rows() / 4;
  std::vector<float> values;
  for (const Gate gate : {Gate::input, Gate::output, Gate::forget, Gate::cell}) {
    const std::vector<float> rows = row_by_row(block.middleRows(static_cast<Index>(gate) * H, H));
    values.insert(values.end(), rows.begin(), rows.end());
  }
  return values;
}

std::string columns_in_words(const Task& task) {
  std::string names;
  for (const Feature& feature : task.features) names += (names.empty() ? "" : ",") + feature.column.name;
  return names;
}

}  // namespace

std::string to_onnx(const Model& model) {
  const Weights<float>& weights = model.weights;
  const Shape& shape = weights.shape;
  const Index K = model.scaling.v_offset.size(), H = shape.hidden, D = shape.dense;
  const std::string columns = columns_in_words(model.task), y = model.task.predicted.name;
  const bool carried = !model.memoryless();

  Graph graph;
  graph.input("v", {any_number, K}, columns + ", in these units");
  graph.input("v_before", {any_number, K}, "v one step before");
  graph.input("y_before", {any_number, 1}, y + " one step before: measured, or the y of that step");
  if (carried) {
    graph.input("h", {1, any_number, H}, "h_next of the step before; zero to begin with");
    graph.input("c", {1, any_number, H}, "c_next of the step before; zero to begin with");
  }
  graph.constant("v_offset", {K}, row_by_row(model.scaling.v_offset));
  graph.constant("v_span", {K}, row_by_row(model.scaling.v_span));
  graph.constant<float>("y_offset", {1}, {static_cast<float>(model.scaling.y_offset)});
  graph.constant<float>("y_span", {1}, {static_cast<float>(model.scaling.y_span)});
  const auto scale = [&](const std::string& name, const std::string& of) {
    graph.node("Sub", {name, of + "_offset"}, {name + "_from_offset"});
    graph.node("Div", {name + "_from_offset", of + "_span"}, {name + "_scaled"});
  };
  scale("v", "v");
  scale("v_before", "v");
  scale("y_before", "y");
  graph.node("Concat", {"v_scaled", "v_before_scaled", "y_before_scaled"}, {"x"}, {{"axis", 1}});

  graph.constant<std::int64_t>("time_axis", {1}, {0});
  graph.constant("kernel", {1, 4 * H, shape.inputs}, gates_of_onnx(weights.input()));
  graph.constant("recurrent_kernel", {1, 4 * H, H}, gates_of_onnx(weights.recurrent()));
  std::vector<float> bias = gates_of_onnx(weights.bias());  // that of the kernel; the recurrent kernel's is zero
  bias.resize(static_cast<std::size_t>(8 * H), 0.0F);
  graph.constant("bias", {1, 8 * H}, bias);
  graph.node("Unsqueeze", {"x", "time_axis"}, {"x_of_one_step"});
  if (carried)
    graph.node("LSTM", {"x_of_one_step", "kernel", "recurrent_kernel", "bias", "", "h", "c"}, {"", "h_next", "c_next"},
               {{"hidden_size", H}});
  else
    graph.node("LSTM", {"x_of_one_step", "kernel", "recurrent_kernel", "bias"}, {"", "h_next"}, {{"hidden_size", H}});
  graph.node("Squeeze", {"h_next", "time_axis"}, {"h_of_one_step"});

  graph.constant("dense_kernel", {D, H}, row_by_row(weights.dense()));
  graph.constant("dense_bias", {D}, row_by_row(weights.dense_bias()));
  graph.constant("output_kernel", {1, D}, row_by_row(weights.output()));
  graph.constant("output_bias", {1}, row_by_row(weights.output_bias()));
  graph.node("Gemm", {"h_of_one_step", "dense_kernel", "dense_bias"}, {"r_linear"}, {{"transB", 1}});
  graph.node("Relu", {"r_linear"}, {"r"});
  graph.node("Gemm", {"r", "output_kernel", "output_bias"}, {shape.output_relu ? "y_linear" : "y_scaled"}, {{"transB", 1}});
  if (shape.output_relu) graph.node("Relu", {"y_linear"}, {"y_scaled"});
  graph.node("Mul", {"y_scaled", "y_span"}, {"y_from_offset"});
  graph.node("Add", {"y_from_offset", "y_offset"}, {"y"});
  graph.output("y", {any_number, 1}, y);
  if (carried) {
    graph.output("h_next", {1, any_number, H}, "h of the next step");
    graph.output("c_next", {1, any_number, H}, "c of the next step");
  }

  Message file;  // ModelProto
  file.number(1, ir_version).text(2, "sinew").text(3, sim::this_build().version);
  file.text(6, "One step of " + sim::shortest(period_s) + " s of the LSTM " + model.method + ", case " +
                   std::to_string(model.task.paper_case) + ", trained on " + model.trained_on);
  file.message(7, graph.message("lstm"));
  file.message(8, Message().text(1, "").number(2, operator_set));
  const auto say = [&](const std::string& key, const std::string& value) { file.message(14, Message().text(1, key).text(2, value)); };
  say("inputs", columns);
  say("output", y);
  say("sample_period_s", sim::shortest(period_s));
  say("sinew", file_of(model).text_attributes.at("/").at("sinew"));
  return file.bytes();
}

}  // namespace sinew::model

// SPDX-License-Identifier: Apache-2.0
#include "model/weights_file.h"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "model/task_json.h"
#include "sim/input_error.h"
#include "sim/manifest.h"
#include "sim/text.h"

namespace sinew::model {
namespace {

using Json = nlohmann::ordered_json;

// A weight in Keras's terms: the name in its layer, and where it lies in ours. Keras keeps the transpose, its last index
// running fastest: the same numbers in the same order.
struct Tensor {
  std::string layer, keras2, keras3;
  std::vector<std::uint64_t> extents;
  Index from = 0;
};

const char* layer_of(Cell cell) { return cell == Cell::gru ? "gru" : "lstm"; }

std::vector<Tensor> tensors_of(const Shape& shape) {
  const std::string layer = layer_of(shape.cell), cell = layer + "/" + layer + "_cell/";
  const auto G = static_cast<std::uint64_t>(shape.gates());
  const auto H = static_cast<std::uint64_t>(shape.hidden), I = static_cast<std::uint64_t>(shape.inputs),
             D = static_cast<std::uint64_t>(shape.dense);
  const Weights<float> w(shape);
  const auto at = [&](const auto& block) { return static_cast<Index>(block.data() - w.all.data()); };
  // A GRU's two biases are one array in Keras.
  const std::vector<std::uint64_t> bias =
      shape.cell == Cell::gru ? std::vector<std::uint64_t>{2, G * H} : std::vector<std::uint64_t>{G * H};
  return {{layer, cell + "kernel:0", "cell/vars/0", {I, G * H}, at(w.input())},
          {layer, cell + "recurrent_kernel:0", "cell/vars/1", {H, G * H}, at(w.recurrent())},
          {layer, cell + "bias:0", "cell/vars/2", bias, at(w.bias())},
          {"dense", "dense/kernel:0", "vars/0", {H, D}, at(w.dense())},
          {"dense", "dense/bias:0", "vars/1", {D}, at(w.dense_bias())},
          {"dense_1", "dense_1/kernel:0", "vars/0", {D, 1}, at(w.output())},
          {"dense_1", "dense_1/bias:0", "vars/1", {1}, at(w.output_bias())}};
}

// Over the weights and over what is said of them, the checksum itself left out.
std::string checksum(const Weights<float>& weights, Json json) {
  json.erase("sha256");
  std::string bytes = json.dump();
  bytes.append(reinterpret_cast<const char*>(weights.all.data()), static_cast<std::size_t>(weights.all.size()) * sizeof(float));
  return sim::sha256(bytes);
}

Json said(const Model& model) {
  Json json{{"format", 1},
            {"case", model.task.paper_case},
            {"method", model.method},
            {"sample_period_s", period_s},
            {"output_relu", model.weights.shape.output_relu}};
  json.update(json_of(model.task, &model.scaling));
  json["trained_on"] = model.trained_on;
  if (model.arx) json["arx"] = json_of(*model.arx);
  json["made_by"] = "sinew " + sim::this_build().version;
  json["sha256"] = checksum(model.weights, json);
  return json;
}

// What tf.keras.models.load_model needs to build the network.
std::string keras_config(const Model& model) {
  const Shape& shape = model.weights.shape;
  const Json input_shape = model.memoryless() ? Json{nullptr, 1, shape.inputs} : Json{1, nullptr, shape.inputs};
  const auto dense = [](const char* name, Index units, const char* activation) {
    return Json{
        {"class_name", "Dense"},
        {"config",
         {{"name", name}, {"trainable", true}, {"dtype", "float32"}, {"units", units}, {"activation", activation}, {"use_bias", true}}}};
  };
  Json layers = Json::array();
  layers.push_back({{"class_name", "InputLayer"},
                    {"config",
                     {{"batch_input_shape", input_shape},
                      {"dtype", "float32"},
                      {"sparse", false},
                      {"ragged", false},
                      {"name", std::string(layer_of(model.weights.shape.cell)) + "_input"}}}});
  const bool gru = shape.cell == Cell::gru;
  Json recurrent{{"name", layer_of(shape.cell)},
                 {"trainable", true},
                 {"batch_input_shape", input_shape},
                 {"dtype", "float32"},
                 {"return_sequences", false},
                 {"return_state", false},
                 {"go_backwards", false},
                 {"stateful", !model.memoryless()},
                 {"unroll", false},
                 {"time_major", false},
                 {"units", shape.hidden},
                 {"activation", "tanh"},
                 {"recurrent_activation", "sigmoid"},
                 {"use_bias", true}};
  if (!gru) recurrent["unit_forget_bias"] = true;
  recurrent.update({{"dropout", 0.0}, {"recurrent_dropout", 0.0}, {"implementation", 2}});
  if (gru) recurrent["reset_after"] = true;
  layers.push_back({{"class_name", gru ? "GRU" : "LSTM"}, {"config", recurrent}});
  layers.push_back(dense("dense", shape.dense, "relu"));
  layers.push_back(dense("dense_1", 1, shape.output_relu ? "relu" : "linear"));
  return Json{{"class_name", "Sequential"}, {"config", {{"name", "sequential"}, {"layers", layers}}}}.dump();
}

std::string text_of(const std::vector<std::uint64_t>& extents) {
  std::string text = "[";
  for (std::size_t i = 0; i < extents.size(); ++i) text += (i ? ", " : "") + std::to_string(extents[i]);
  return text + "]";
}

// Where the weights of a file stand, one path a tensor in the order of tensors_of; layers may have other names in Keras
// ("lstm_3"), and are told by their order and number of weights.
std::vector<std::string> paths_in(const Hdf5File& file, const std::string& name) {
  std::vector<std::string> paths;
  for (const char* const at : {"/model_weights", "/"}) {
    const std::string root = at;
    const auto lists = file.list_attributes.find(root);
    if (lists == file.list_attributes.end() || !lists->second.count("layer_names")) continue;
    for (const std::string& layer : lists->second.at("layer_names")) {
      const std::string group = (root == "/" ? "" : root) + "/" + layer;
      const auto of_layer = file.list_attributes.find(group);
      if (of_layer == file.list_attributes.end() || !of_layer->second.count("weight_names")) continue;
      for (const std::string& weight : of_layer->second.at("weight_names")) paths.push_back(group + "/" + weight);
    }
    break;
  }
  if (paths.empty()) {
    for (const auto& [path, array] : file.arrays)
      if (path.find("/vars/") != std::string::npos && path.rfind("/layers/", 0) == 0)
        paths.push_back(path);  // sorted: dense, dense_1, gru or lstm
    if (paths.size() == 7) paths = {paths[4], paths[5], paths[6], paths[0], paths[1], paths[2], paths[3]};
  }
  if (paths.size() != 7)
    complain(name, "layers", std::to_string(paths.size()) + " weights",
             "must be an LSTM or a GRU layer, a dense layer and an output, 7 weights in all, in a layout of Keras 2 or 3");
  return paths;
}

// Weights alone do not say it: the published network has a ReLU there.
bool output_relu_of(const Hdf5File& file, const std::string& name, const std::string& method) {
  const auto root = file.text_attributes.find("/");
  if (root == file.text_attributes.end() || !root->second.count("model_config")) return method == "published";
  try {
    const Json config = Json::parse(root->second.at("model_config"));
    std::string last;
    for (const Json& layer : config.at("config").at("layers")) {
      const std::string kind = layer.at("class_name");
      if (kind == "LSTM" || kind == "GRU") {
        const Json& c = layer.at("config");
        if (kind == "GRU" && !c.value("reset_after", true))
          complain(name, "model_config", "reset_after: false", "the reset gate must act after the recurrent weights, as Keras 2 has it");
        if (c.value("activation", "tanh") != "tanh" || c.value("recurrent_activation", "sigmoid") != "sigmoid")
          complain(name, "model_config", c.value("recurrent_activation", ""),
                   "the " + kind + " must have Keras's own activations, tanh and sigmoid");
      } else if (kind == "Dense") {
        if (!last.empty() && last != "relu") complain(name, "model_config", last, "the activation of the dense layer must be relu");
        last = layer.at("config").value("activation", "linear");
      } else if (kind != "InputLayer") {
        complain(name, "model_config", kind, "is a layer that this architecture does not have");
      }
    }
    if (last != "relu" && last != "linear") complain(name, "model_config", last, "the output's activation must be relu or linear");
    return last == "relu";
  } catch (const Json::exception& e) {
    complain(name, "model_config", "", std::string("is no configuration of Keras: ") + e.what());
  }
}

}  // namespace

std::string to_hdf5(const Model& model, Layout layout) { return to_bytes(file_of(model, layout)); }

Hdf5File file_of(const Model& model, Layout layout) {
  Hdf5File file;
  const std::string root = layout == Layout::keras2 ? "/model_weights" : "/layers";
  for (const Tensor& tensor : tensors_of(model.weights.shape)) {
    const std::string inside = layout == Layout::keras2 ? tensor.keras2 : tensor.keras3;
    Hdf5Array& array = file.arrays[root + "/" + tensor.layer + "/" + inside];
    array.extents = tensor.extents;
    std::size_t count = 1;
    for (const auto extent : tensor.extents) count *= extent;
    for (std::size_t i = 0; i < count; ++i) array.values.push_back(model.weights.all(tensor.from + static_cast<Index>(i)));
    if (layout == Layout::keras2) file.list_attributes[root + "/" + tensor.layer]["weight_names"].push_back(inside);
  }
  if (layout == Layout::keras2) {
    file.text_attributes["/"] = {{"model_config", keras_config(model)}, {"keras_version", "2.11.0"}, {"backend", "tensorflow"}};
    file.text_attributes[root] = {{"keras_version", "2.11.0"}, {"backend", "tensorflow"}};
    file.list_attributes[root]["layer_names"] = {layer_of(model.weights.shape.cell), "dense", "dense_1"};
  }
  file.text_attributes["/"]["sinew"] = said(model).dump();
  return file;
}

Model read_model(const std::filesystem::path& path, const Unsaid& unsaid) {
  return model_in(parse_hdf5(sim::read_file(path), path.string()), path.string(), unsaid);
}

Model model_in(const Hdf5File& file, const std::string& name, const Unsaid& unsaid) {
  const std::vector<std::string> paths = paths_in(file, name);
  const auto array = [&](std::size_t i) -> const Hdf5Array& {
    const auto found = file.arrays.find(paths[i]);
    if (found == file.arrays.end()) complain(name, paths[i], "", "this weight is missing");
    return found->second;
  };
  // A GRU has a bias on either side.
  const Cell cell = array(2).extents.size() == 2 ? Cell::gru : Cell::lstm;
  const std::uint64_t gates = cell == Cell::gru ? 3 : 4;
  if (array(0).extents.size() != 2 || array(0).extents[1] % gates != 0 || array(0).extents[1] == 0)
    complain(name, paths[0], text_of(array(0).extents), "must be [inputs, " + std::to_string(gates) + " hidden]");
  if (array(3).extents.size() != 2) complain(name, paths[3], text_of(array(3).extents), "must be [hidden, dense]");
  Shape shape{static_cast<Index>(array(0).extents[0]), static_cast<Index>(array(0).extents[1] / gates),
              static_cast<Index>(array(3).extents[1]), output_relu_of(file, name, unsaid.method), cell};
  Model model;
  model.weights = Weights<float>(shape);
  const auto tensors = tensors_of(shape);
  for (std::size_t i = 0; i < tensors.size(); ++i) {
    const Hdf5Array& from = array(i);
    if (from.extents != tensors[i].extents)
      complain(name, paths[i], text_of(from.extents), "must be " + text_of(tensors[i].extents) + " beside the other weights");
    for (std::size_t k = 0; k < from.values.size(); ++k) {
      if (!std::isfinite(from.values[k])) complain(name, paths[i], "not a number", "weights must be finite");
      model.weights.all(tensors[i].from + static_cast<Index>(k)) = static_cast<float>(from.values[k]);
    }
  }
  const auto root = file.text_attributes.find("/");
  if (root != file.text_attributes.end() && root->second.count("sinew")) {
    try {
      const Json json = Json::parse(root->second.at("sinew"));
      model.method = json.at("method");
      if (cell == Cell::gru ? model.method != "gru" : model.method != "published" && model.method != "stateful")
        complain(name, "sinew", model.method, "the method must be published or stateful for an LSTM, gru for a GRU");
      model.weights.shape.output_relu = json.value("output_relu", shape.output_relu);
      model.task = task_of_json(json, name);
      model.scaling = scaling_of_json(json);
      model.trained_on = json.value("trained_on", "");
      if (json.contains("arx")) model.arx = linear_of_json(json.at("arx"), model.task, name);
      if (json.at("sha256") != checksum(model.weights, json))
        complain(name, "sha256", json.at("sha256"), "is not that of what is in the file: weights, scaling or names were changed");
      const auto usable = [](const Vector<double>& offset, const Vector<double>& span) {
        return offset.allFinite() && span.allFinite() && span.minCoeff() > 0.0;
      };
      if (!usable(model.scaling.v_offset, model.scaling.v_span) ||
          !usable(Vector<double>::Constant(1, model.scaling.y_offset), Vector<double>::Constant(1, model.scaling.y_span)))
        complain(name, "span", "", "scaling must be finite, and its spans above 0");
    } catch (const Json::exception& e) {
      complain(name, "sinew", "", std::string("is no description of a model: ") + e.what());
    }
    if (unsaid.task) complain_unless_same(name, model.task, *unsaid.task);
  } else {
    if (!unsaid.task || unsaid.method.empty() || (!unsaid.sidecar && (!unsaid.lowest || !unsaid.highest)))
      complain(name, "sinew", "nothing",
               "a file of Keras says neither the order of its inputs nor their scaling: write them into " + sidecar_of(name).string() +
                   " (docs/prediction.md), or, where they are v(t), v(t-1), y(t-1) and the inputs unscaled, give `sinew rollout` --case, "
                   "--method and --range LOWEST,HIGHEST, the values that are 0 and 1");
    model.task = *unsaid.task;
    model.method = unsaid.method;
    if (cell == Cell::gru) {
      if (model.method == "published") complain(name, paths[0], "a GRU", "the published network is an LSTM");
      model.method = "gru";
    }
    const auto features = static_cast<Index>(model.task.features.size());
    if (unsaid.sidecar) {
      const Arrangement arrangement = arrangement_of(*unsaid.sidecar, model.task);
      if (const auto said_inputs = static_cast<Index>(unsaid.sidecar->inputs.size()); shape.inputs != said_inputs)
        complain(name, paths[0], text_of(array(0).extents), "the file beside it has " + std::to_string(said_inputs) + " inputs");
      model.scaling = arrangement.scaling;
      const Matrix<float> kernel = model.weights.input();
      for (Index place = 0; place < shape.inputs; ++place)
        model.weights.input().col(place) = kernel.col(arrangement.from[static_cast<std::size_t>(place)]);
    } else {
      model.scaling = {Vector<double>::Zero(features), Vector<double>::Ones(features), *unsaid.lowest, *unsaid.highest - *unsaid.lowest};
    }
    model.trained_on = "elsewhere";
  }
  if (const auto features = static_cast<Index>(model.task.features.size()); shape.inputs != 2 * features + 1)
    complain(name, paths[0], text_of(array(0).extents),
             "case " + std::to_string(model.task.paper_case) + " has " + std::to_string(2 * features + 1) + " inputs");
  return model;
}

}  // namespace sinew::model

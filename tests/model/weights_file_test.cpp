// SPDX-License-Identifier: Apache-2.0
#include "model/weights_file.h"

#include <doctest/doctest.h>

#include <filesystem>

#include "model/hdf5_file.h"
#include "model/network_loop.h"
#include "plant/systems.h"
#include "sim/input_error.h"
#include "sim/text.h"

namespace model_weights_file_test {

using namespace sinew;
using namespace sinew::model;

namespace {

Task task_of_case(int paper_case) { return task_of(plant::default_plant().system(), paper_case); }

Model some_model(const std::string& method = "stateful") {
  Model model;
  model.task = task_of_case(4);
  model.method = method;
  model.scaling = {Eigen::Vector4d(0, 25, 0, 26), Eigen::Vector4d(1, 50, 1, 51), -40.0, 90.0};
  model.weights = first_weights({9, 6, 5, method == "published", method == "gru" ? Cell::gru : Cell::lstm}, 3);
  model.trained_on = "nothing";
  return model;
}

struct Folder {
  std::filesystem::path path = std::filesystem::temp_directory_path() / ("sinew_weights_" + std::to_string(::getpid()));
  Folder() { std::filesystem::create_directories(path); }
  ~Folder() { std::filesystem::remove_all(path); }
  std::string write(const std::string& bytes) const {
    sim::write_file_whole(path / "w.h5", bytes);
    return (path / "w.h5").string();
  }
};

std::string message(const std::string& file, const Unsaid& unsaid = {}) {
  try {
    read_model(file, unsaid);
  } catch (const sim::InputError& e) {
    const std::string text = e.what();
    return text.substr(text.find(": ") + 2);  // without the file's name
  }
  return "nothing thrown";
}

}  // namespace

TEST_CASE("weights: both layouts give back the same model, and the same bytes are written twice") {
  const Folder folder;
  for (const std::string method : {"published", "stateful", "gru"})
    for (const Layout layout : {Layout::keras2, Layout::keras3}) {
      const Model model = some_model(method);
      const std::string bytes = to_hdf5(model, layout);
      CHECK(bytes == to_hdf5(model, layout));
      const Model back = read_model(folder.write(bytes));
      CHECK(back.weights.all == model.weights.all);
      CHECK(back.weights.shape == model.weights.shape);
      CHECK(back.method == method);
      CHECK(back.scaling.v_offset == model.scaling.v_offset);
      CHECK(back.scaling.y_span == 90.0);
    }
}
TEST_CASE("weights: a GRU stands in Keras's own names and shapes, and with one bias alone it is refused") {
  const Folder folder;
  const Model model = some_model("gru");
  Hdf5File file = file_of(model);
  const std::string cell = "/model_weights/gru/gru/gru_cell/";
  CHECK(file.arrays.at(cell + "kernel:0").extents == std::vector<std::uint64_t>{9, 18});
  CHECK(file.arrays.at(cell + "recurrent_kernel:0").extents == std::vector<std::uint64_t>{6, 18});
  // reset_after=True: a bias of the inputs, and one of the state.
  Hdf5Array& bias = file.arrays.at(cell + "bias:0");
  CHECK(bias.extents == std::vector<std::uint64_t>{2, 18});
  CHECK(file.text_attributes.at("/").at("model_config").find("\"reset_after\":true") != std::string::npos);
  bias.extents = {18};
  bias.values.resize(18);
  CHECK(message(folder.write(to_bytes(file))).find("must be [inputs, 4 hidden]") != std::string::npos);
}
TEST_CASE("weights: the linear model beside the network is read back, and one of another order is an error") {
  const Folder folder;
  Model model = some_model();
  model.arx = LinearModel{2, Vector<double>::LinSpaced(2 + 4 * 3 + 1, -0.25, 1.5)};  // order 2, four inputs
  const Model read = read_model(folder.write(to_hdf5(model)));
  REQUIRE(read.arx);
  CHECK(read.arx->order == 2);
  CHECK(read.arx->coefficients == model.arx->coefficients);
  model.arx->order = 3;
  CHECK(message(folder.write(to_hdf5(model))) == "arx = 15 coefficients\n  do not belong to order 3");
  model.arx.reset();
  CHECK_FALSE(read_model(folder.write(to_hdf5(model))).arx);
}

TEST_CASE("weights: what is given and what is predicted is read back, whatever the plant") {
  const Folder folder;
  const sim::Column voltage{.name = "voltage_V", .words = "voltage", .unit = "V"},
      level{.name = "level_fraction", .words = "level fraction", .unit = ""}, speed{.name = "speed_m_s", .words = "speed", .unit = "m_s"};
  Model model = some_model();
  model.task = {.paper_case = 2, .features = {{voltage, false}, {level, true}, {speed, true}}, .predicted = speed};
  model.scaling = {Vector<double>{{0.0, 1.0, 2.0}}, Vector<double>{{1.0, 2.0, 3.0}}, -1.0, 2.0};
  model.weights = first_weights({7, 6, 5, false}, 3);
  const Model back = read_model(folder.write(to_hdf5(model)));
  REQUIRE(back.task.features.size() == 3);
  for (std::size_t f = 0; f < 3; ++f) {
    CHECK(back.task.features[f].column == model.task.features[f].column);
    CHECK(back.task.features[f].column.words == model.task.features[f].column.words);
    CHECK(back.task.features[f].column.unit == model.task.features[f].column.unit);
    CHECK(back.task.features[f].measured == model.task.features[f].measured);
  }
  CHECK(back.task.predicted == speed);
  CHECK(to_hdf5(back) == to_hdf5(model));
  CHECK(columns_of(back.task) == sim::Columns{.inputs = {voltage}, .channels = {level, speed}});
  Task other = model.task;
  other.features[0].column.name = "current_A";
  CHECK(message(folder.write(to_hdf5(model)), {other, "", {}, {}}) == "inputs = voltage_V in V\n  must be current_A in V");
}
TEST_CASE("weights: for the usual plant, the file says what it always said") {
  const Hdf5File file = parse_hdf5(to_hdf5(some_model()), "file");
  const std::string& said = file.text_attributes.at("/").at("sinew");
  CHECK(
      said.find(
          R"("inputs":[{"name":"duty_A","unit":"1","offset":0.0,"span":1.0},)"
          R"({"name":"temperature_A_degC","unit":"degC","offset":25.0,"span":50.0},)"
          R"({"name":"duty_B","unit":"1","offset":0.0,"span":1.0},{"name":"temperature_B_degC","unit":"degC","offset":26.0,"span":51.0}],)"
          R"("input_order":"v(t), v(t-1), angle(t-1); a number of the network is (value - offset) / span",)"
          R"("output":{"name":"angle_deg","unit":"deg","offset":-40.0,"span":90.0})") != std::string::npos);
}
TEST_CASE("weights: a file by Keras's save_weights, without a word of ours, is read where the rest is said") {
  // The names and shapes of Keras 2.11: kernel [inputs, 4 units], the weights' groups named after layers that were made before.
  Hdf5File file;
  const auto put = [&](const std::string& layer, const std::string& weight, std::vector<std::uint64_t> extents) {
    Hdf5Array& array = file.arrays["/" + layer + "/" + weight];
    std::size_t count = 1;
    for (const auto e : extents) count *= e;
    array.extents = extents;
    for (std::size_t i = 0; i < count; ++i)
      array.values.push_back(0.01 * static_cast<double>(file.arrays.size()) + 0.001 * static_cast<double>(i));
    file.list_attributes["/" + layer]["weight_names"].push_back(weight);
  };
  put("lstm_2", "lstm_2/lstm_cell_2/kernel:0", {5, 8});
  put("lstm_2", "lstm_2/lstm_cell_2/recurrent_kernel:0", {2, 8});
  put("lstm_2", "lstm_2/lstm_cell_2/bias:0", {8});
  put("dense_4", "dense_4/kernel:0", {2, 3});
  put("dense_4", "dense_4/bias:0", {3});
  put("dense_5", "dense_5/kernel:0", {3, 1});
  put("dense_5", "dense_5/bias:0", {1});
  file.list_attributes["/"]["layer_names"] = {"lstm_2", "dense_4", "dense_5"};
  const Folder folder;
  const std::string name = folder.write(to_bytes(file));
  const Model model = read_model(name, {task_of_case(3), "published", -45.0, 45.0});
  CHECK(model.weights.shape == Shape{5, 2, 3, true});
  // kernel[1][2], input 1 to row 2 of the gates, is the eleventh number: 0.01 + 0.010.
  CHECK(model.weights.input()(2, 1) == doctest::Approx(0.020));
  CHECK(model.weights.dense()(2, 1) == doctest::Approx(0.04 + 0.005));
  CHECK(message(name).starts_with("sinew = nothing\n  a file of Keras says neither the order of its inputs nor their scaling"));
  // In the notebook's order, v(t-1), y(t-1), v(t): our input 0, duty A at t, is their fourth; our last, the angle, their third.
  const auto entry = [](const std::string& column, bool before, double highest) {
    return Sidecar::Entry{.column = column, .before = before, .lowest = 0.0, .highest = highest};
  };
  Sidecar sidecar{3, "published", {}, {.column = "angle_deg", .lowest = -50.0, .highest = 50.0}};
  sidecar.inputs = {entry("duty_A", true, 0.5),
                    entry("duty_B", true, 0.6),
                    {"angle_deg", true, -50.0, 50.0},
                    entry("duty_A", false, 0.5),
                    entry("duty_B", false, 0.6)};
  const Model arranged = read_model(name, {task_of_case(3), "published", {}, {}, sidecar});
  const int theirs[] = {3, 4, 0, 1, 2};
  for (int ours = 0; ours < 5; ++ours) CHECK(arranged.weights.input().col(ours) == model.weights.input().col(theirs[ours]));
  CHECK(arranged.scaling.v_span == Eigen::Vector2d(0.5, 0.6));
  CHECK(arranged.scaling.y_offset == -50.0);
  sidecar.inputs[4] = entry("duty_B", true, 0.6);
  CHECK(message(name, {task_of_case(3), "published", {}, {}, sidecar}).find("duty_B at t-1 stands twice") != std::string::npos);
  sidecar.inputs.pop_back();
  CHECK(message(name, {task_of_case(3), "published", {}, {}, sidecar}).find("lacks duty_B at t") != std::string::npos);
  sidecar.inputs.push_back(entry("duty_B", false, 0.7));
  CHECK(message(name, {task_of_case(3), "published", {}, {}, sidecar}).find("a column has one scaling") != std::string::npos);
  CHECK(message(name, {task_of_case(4), "published", -45.0, 45.0}) ==
        "/lstm_2/lstm_2/lstm_cell_2/kernel:0 = [5, 8]\n  case 4 has 9 inputs");
}
TEST_CASE("weights: what does not fit is an error, never a layer left at zero") {
  const Folder folder;
  const Hdf5File good = parse_hdf5(to_hdf5(some_model()), "good");
  const std::string bias = "/model_weights/lstm/lstm/lstm_cell/bias:0";
  REQUIRE(good.arrays.count(bias) == 1);
  Hdf5File bad = good;
  bad.arrays.erase(bias);
  CHECK(message(folder.write(to_bytes(bad))) == bias + "\n  this weight is missing");
  bad = good;
  bad.arrays[bias].extents = {12};
  bad.arrays[bias].values.resize(12);
  CHECK(message(folder.write(to_bytes(bad))) == bias + " = [12]\n  must be [24] beside the other weights");
  bad = good;
  bad.arrays[bias].values[3] = std::nan("");
  CHECK(message(folder.write(to_bytes(bad))) == bias + " = not a number\n  weights must be finite");
  bad = good;
  bad.arrays[bias].values[3] += 0.5;
  CHECK(message(folder.write(to_bytes(bad))).find("is not that of what is in the file: weights, scaling or names were changed") !=
        std::string::npos);
  bad = good;
  std::string& said = bad.text_attributes["/"]["sinew"];
  said.replace(said.find("\"span\":90.0"), 11, "\"span\":91.0");  // what is said of the weights counts too
  CHECK(message(folder.write(to_bytes(bad))).find("weights, scaling or names were changed") != std::string::npos);
  CHECK(message(folder.write(to_hdf5(some_model())), {task_of_case(2), "", {}, {}}) ==
        "case = 4\n  these are weights of another case than 2");
  const std::string bytes = to_hdf5(some_model());
  CHECK_THROWS_AS(read_model(folder.write(bytes.substr(0, bytes.size() / 2))), sim::InputError);
  CHECK_THROWS_AS(read_model(folder.write("no HDF5 at all")), sim::InputError);
}

}  // namespace model_weights_file_test

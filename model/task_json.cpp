// SPDX-License-Identifier: Apache-2.0
#include "model/task_json.h"

#include <algorithm>

#include "sim/input_error.h"

namespace sinew::model {
namespace {

using TaskJson = nlohmann::ordered_json;

// Numbers without a unit have the unit 1 in the file.
std::string unit_of(const sim::Column& column) { return column.unit.empty() ? "1" : column.unit; }
// Inputs mostly are fractions, and measurements have a unit: the file says which is which where it is otherwise.
bool usually_measured(const sim::Column& column) { return !column.unit.empty(); }

// In words, by the column's name: what stands before its unit.
sim::Column column_of(const std::string& name, const std::string& unit) {
  sim::Column column{.name = name, .words = name, .unit = unit == "1" ? "" : unit};
  if (const std::string ending = "_" + column.unit; !column.unit.empty() && name.ends_with(ending))
    column.words.resize(name.size() - ending.size());
  std::replace(column.words.begin(), column.words.end(), '_', ' ');
  return column;
}

}  // namespace

void complain(const std::string& file, const std::string& key, const std::string& value, const std::string& advice) {
  throw sim::InputError({.file = file, .key = key, .value = value, .advice = advice});
}

nlohmann::ordered_json json_of(const Task& task, const Scaling* scaling) {
  TaskJson json;
  for (std::size_t f = 0; f < task.features.size(); ++f) {
    const auto& [column, measured] = task.features[f];
    TaskJson input{{"name", column.name}, {"unit", unit_of(column)}};
    if (scaling) {
      input["offset"] = scaling->v_offset(static_cast<Index>(f));
      input["span"] = scaling->v_span(static_cast<Index>(f));
    }
    if (measured != usually_measured(column)) input["measured"] = measured;
    json["inputs"].push_back(std::move(input));
  }
  const sim::Column& predicted = task.predicted;
  if (scaling)
    json["input_order"] =
        "v(t), v(t-1), " + column_of(predicted.name, predicted.unit).words + "(t-1); a number of the network is (value - offset) / span";
  json["output"] = {{"name", predicted.name}, {"unit", unit_of(predicted)}};
  if (scaling) {
    json["output"]["offset"] = scaling->y_offset;
    json["output"]["span"] = scaling->y_span;
  }
  return json;
}

nlohmann::ordered_json json_of(const LinearModel& model) {
  const Vector<double>& c = model.coefficients;
  return {{"order", model.order}, {"coefficients", std::vector<double>(c.data(), c.data() + c.size())}};
}

Task task_of_json(const nlohmann::ordered_json& json, const std::string& file) {
  Task task{.paper_case = json.at("case"), .features = {}, .predicted = {}};
  if (task.paper_case < 1 || task.paper_case > 4) complain(file, "case", std::to_string(task.paper_case), "the paper's cases are 1 to 4");
  for (const TaskJson& input : json.at("inputs")) {
    const sim::Column column = column_of(input.at("name"), input.at("unit"));
    task.features.push_back({column, input.value("measured", usually_measured(column))});
  }
  task.predicted = column_of(json.at("output").at("name"), json.at("output").at("unit"));
  return task;
}

Scaling scaling_of_json(const nlohmann::ordered_json& json) {
  const TaskJson &inputs = json.at("inputs"), &output = json.at("output");
  Scaling scaling{Vector<double>(inputs.size()), Vector<double>(inputs.size()), output.at("offset"), output.at("span")};
  for (std::size_t f = 0; f < inputs.size(); ++f) {
    scaling.v_offset(static_cast<Index>(f)) = inputs[f].at("offset");
    scaling.v_span(static_cast<Index>(f)) = inputs[f].at("span");
  }
  return scaling;
}

LinearModel linear_of_json(const nlohmann::ordered_json& json, const Task& task, const std::string& file) {
  const auto coefficients = json.at("coefficients").get<std::vector<double>>();
  const Index order = json.at("order"), features = static_cast<Index>(task.features.size());
  if (order < 0 || order > 1000 || static_cast<Index>(coefficients.size()) != order + features * (order + 1) + 1)
    complain(file, "arx", std::to_string(coefficients.size()) + " coefficients", "do not belong to order " + std::to_string(order));
  return {order, Eigen::Map<const Vector<double>>(coefficients.data(), static_cast<Index>(coefficients.size()))};
}

void complain_unless_same(const std::string& file, const Task& task, const Task& asked_for) {
  if (task.paper_case != asked_for.paper_case)
    complain(file, "case", std::to_string(task.paper_case),
             "these are weights of another case than " + std::to_string(asked_for.paper_case));
  if (task.features.size() != asked_for.features.size())
    complain(file, "inputs", std::to_string(task.features.size()),
             "this plant has " + std::to_string(asked_for.features.size()) + " in case " + std::to_string(task.paper_case));
  const auto compare = [&](const char* key, const sim::Column& column, const sim::Column& wanted) {
    if (column.name != wanted.name || column.unit != wanted.unit)
      complain(file, key, column.name + " in " + unit_of(column), "must be " + wanted.name + " in " + unit_of(wanted));
  };
  for (std::size_t f = 0; f < task.features.size(); ++f) compare("inputs", task.features[f].column, asked_for.features[f].column);
  compare("output", task.predicted, asked_for.predicted);
}

}  // namespace sinew::model

// SPDX-License-Identifier: Apache-2.0
// A task, its scaling and a linear model as JSON: what the files of all predictors say of them.
#pragma once

#include <nlohmann/json.hpp>
#include <string>

#include "model/series.h"

namespace sinew::model {

// Throws InputError.
[[noreturn]] void complain(const std::string& file, const std::string& key, const std::string& value, const std::string& advice);

// Keys inputs, input_order and output; without `scaling`, numbers are in the units of the columns.
nlohmann::ordered_json json_of(const Task& task, const Scaling* scaling = nullptr);
nlohmann::ordered_json json_of(const LinearModel& model);

// Throw InputError or nlohmann::json::exception where the JSON is not of that.
Task task_of_json(const nlohmann::ordered_json& json, const std::string& file);
Scaling scaling_of_json(const nlohmann::ordered_json& json);
LinearModel linear_of_json(const nlohmann::ordered_json& json, const Task& task, const std::string& file);

void complain_unless_same(const std::string& file, const Task& task, const Task& asked_for);

}  // namespace sinew::model

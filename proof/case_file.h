// SPDX-License-Identifier: Apache-2.0
// Reads answers.json and the files of cases/: the one place that knows how they are written.
#pragma once

#include <nlohmann/json.hpp>

#include "proof/case_record.h"

namespace sinew::proof {

// All throw std::runtime_error, or what nlohmann::json throws, for what is no such thing.
Truth read_truth(const nlohmann::ordered_json& answer);
Reported read_reported(const nlohmann::ordered_json& result);

// Both by case id; in the order of the answers, those that have a result.
std::vector<Case> read_cases(const nlohmann::ordered_json& answers, const nlohmann::ordered_json& results);

}  // namespace sinew::proof

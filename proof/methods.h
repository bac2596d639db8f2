// SPDX-License-Identifier: Apache-2.0
// Simpler methods (baselines.h) beside Sinew, on the cases that were put to all of them.
#pragma once

#include "proof/case_record.h"

namespace sinew::proof {

// One figure of several methods; nothing of a method that has no such figure.
struct MethodRow {
  std::string what;
  std::map<std::string, std::optional<double>> by_method;
  bool is_share = true;
};

inline constexpr std::string_view sinew_method = "sinew";  // a key of by_method; the others' are their names

std::vector<MethodRow> methods_of(const std::vector<Case>& cases);

}  // namespace sinew::proof

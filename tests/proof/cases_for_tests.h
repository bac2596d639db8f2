// SPDX-License-Identifier: Apache-2.0
// Cases made by hand.
#pragma once

#include <utility>

#include "proof/case_record.h"

namespace proof_for_tests {

using namespace sinew::proof;

// All in one equation, and well visible.
inline Case concealing(CaseFamily family, const std::vector<std::string>& effects) {
  Case one{.id = "case", .truth = {.family = family, .variant = "plain", .seed = 7, .effects = {}}, .reported = {}};
  for (const std::string& name : effects) one.truth.effects.push_back({name, "thermal", {}});
  one.reported.visibility = 50.0;
  one.reported.place = "mechanics";
  return one;
}

inline Case naming(Case one, const std::vector<std::pair<std::string, double>>& names) {
  one.reported.verdict = names.empty() ? Verdict::unexplained : Verdict::missing_physics;
  for (const auto& [name, probability] : names)
    one.reported.effects.push_back({.name = name, .probability = probability, .strength = "", .parameters = {}});
  return one;
}

}  // namespace proof_for_tests

// SPDX-License-Identifier: Apache-2.0
#include "diagnose/answer.h"

namespace sinew::diagnose {

std::string_view text_of(Verdict verdict) {
  switch (verdict) {
    case Verdict::consistent:
      return "consistent";
    case Verdict::missing_physics:
      return "missing_physics";
    case Verdict::named_in_part:
      return "named_in_part";
    case Verdict::unexplained:
      return "unexplained";
  }
  return "";
}

Verdict verdict_of(const Answer& answer) {
  if (std::holds_alternative<NothingMissing>(answer)) return Verdict::consistent;
  const auto* found = std::get_if<Found>(&answer);
  if (!found || !found->is_named) return Verdict::unexplained;
  return found->leaves_something ? Verdict::named_in_part : Verdict::missing_physics;
}

const std::vector<FoundEffect>& effects_in(const Answer& answer) {
  static const std::vector<FoundEffect> none;
  if (const auto* found = std::get_if<Found>(&answer)) return found->effects;
  const auto* varying = std::get_if<NoConstant>(&answer);
  return varying ? varying->effects : none;
}

const std::vector<FoundLaw>& laws_in(const Answer& answer) {
  static const std::vector<FoundLaw> none;
  const auto* found = std::get_if<Found>(&answer);
  return found ? found->laws : none;
}

const std::vector<FoundApart>& apart_in(const Answer& answer) {
  static const std::vector<FoundApart> none;
  const auto* found = std::get_if<Found>(&answer);
  return found ? found->apart : none;
}

const std::vector<plant::EffectId>& ambiguous_in(const Answer& answer) {
  static const std::vector<plant::EffectId> none;
  if (const auto* found = std::get_if<Found>(&answer)) return found->ambiguous_with;
  const auto* varying = std::get_if<NoConstant>(&answer);
  return varying ? varying->ambiguous_with : none;
}

}  // namespace sinew::diagnose

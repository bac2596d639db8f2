// SPDX-License-Identifier: Apache-2.0
// What is believed of a limb after a diagnosis: the answers that are still possible, and their probabilities.
//
// The diagnosis gives a verdict, the effects it names with a confidence each, and what fits in their place with a loss of log evidence.
// Here that becomes one list whose probabilities sum to 1:
//
// - the named answer, with the product of its effects' confidences, as if each were right or wrong by itself; that parts are not alike is
//   in it as an effect is;
// - each rival, with that probability times exp(-loss);
// - "something else", not in the catalogue or in another form, with what is left.
//
// Where nothing is named and nothing is left over, the list is "nothing is missing" and every effect of the catalogue that may be there at
// its usual strength though it was not found. One effect in so many is expected beforehand, each with 1 / their number; and the odds of
// each against nothing are exp(gain / k) times that, with the gain in log evidence of a fit that has it (usual_strength.h). The k is by how
// much the diagnosis holds gains to be exaggerated: it takes twice a gain below SearchSettings::least_gain for chance, where independent
// normal errors would bring 2 log(effects). By the same odds "nothing" stands beside a name that gains little, and beside "something else"
// where little was to be gained.
#pragma once

#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "diagnose/diagnosis.h"

namespace sinew::investigate {

enum class Kind {
  nothing,         // the plant as given, calibrated
  named,           // effects that an explanation was fitted with
  unseen,          // an effect that is not named, but may be there at its usual strength
  something_else,  // no explanation at hand
};
std::string_view text_of(Kind kind);

// In the key of parts that are not alike, between what the parts are and in what they differ.
inline constexpr std::string_view unlike_in = " unlike in ";

struct Hypothesis {
  Kind kind = Kind::nothing;
  std::vector<plant::EffectId> effects;  // beyond the plant as given
  std::string key;                       // "nothing", "latent_heat", "latent_heat+dry_friction", "something else"
  double probability = 0.0;
  std::shared_ptr<const diagnose::Explanation>
      fitted{};  // of one that is not named: with it, at its usual strength; of the diagnosis' recordings
};

struct Belief {
  std::vector<Hypothesis> all;  // most probable first
  diagnose::Verdict verdict = diagnose::Verdict::consistent;
  std::vector<plant::EffectId> unseen;  // at usual strength these would have gone unnoticed
  double entropy_bit() const;
  const Hypothesis& first() const { return all.front(); }
  // Whether it is one that is not named, and not excluded either.
  static bool may_yet_show(const Hypothesis& one);
};

Belief belief_of(const diagnose::Diagnosis& diagnosis, const diagnose::DiagnosisSettings& settings);

// The k above.
double exaggeration(const diagnose::DiagnosisSettings& settings, std::size_t effects);

}  // namespace sinew::investigate

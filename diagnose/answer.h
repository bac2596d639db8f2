// SPDX-License-Identifier: Apache-2.0
// What a diagnosis says: one of four answers, each with what belongs to it. Text, page and JSON visit it; a verdict is its short word.
#pragma once

#include <optional>
#include <string_view>
#include <variant>
#include <vector>

#include "diagnose/experiment.h"
#include "diagnose/names.h"
#include "diagnose/wander.h"

namespace sinew::diagnose {

enum class Verdict {
  consistent,       // nothing was found, and nothing is left
  missing_physics,  // names, or parts that differ, and nothing is left
  named_in_part,    // names, or parts that differ, and something is left
  unexplained,      // something is missing that has no name
};
std::string_view text_of(Verdict verdict);  // as in diagnosis.json
inline bool something_is_left(Verdict verdict) { return verdict == Verdict::named_in_part || verdict == Verdict::unexplained; }

// Parts that are not alike: each has values of its own (plant/apart.h).
struct FoundApart {
  plant::EffectId effect{};  // of the answer's System
  double log_odds = 0.0;     // of the answer against the best in which they are alike
  Support support{};         // what speaks for it
  double confidence = 0.0;   // probability(support)
  struct Value {
    plant::ParameterId parameter{};  // that parts otherwise share
    std::size_t part;                // of Sharing::parts
    double value, lowest, highest;   // in the units of files; 95 %
  };
  std::vector<Value> values{};  // as in Diagnosis::values
};

// Why what was found may be something else, in another form than the catalogue's.
struct Parsimony {
  std::vector<plant::EffectId> as_good;        // something is left, and these alone explain nearly all, too
  std::vector<plant::EffectId> common_causes;  // what was accepted is of both kinds of sensor; these reach both and explain most
  bool none() const { return as_good.empty() && common_causes.empty(); }
};

// Nothing is missing that could be seen.
struct NothingMissing {};

// Names, curves, parts that differ: at least one of them.
struct Found {
  std::vector<FoundEffect> effects;             // names, strongest first
  std::vector<FoundLaw> laws;                   // curves, in place of names or beside them
  std::vector<FoundApart> apart;                // parts that differ, beside them
  std::vector<plant::EffectId> ambiguous_with;  // what cannot be told from the names
  Parsimony parsimony;
  std::optional<Experiment> experiment;  // where names are ambiguous: what would tell the first pair apart
  bool is_named = false;                 // a name is likely enough to be said, or parts differ
  bool leaves_something = false;         // more than there is where nothing is missing, or than is believed
};

// Something that is no constant: nothing that was tried is the answer, and one thing stands out.
struct NoConstant {
  Wandering course;
  // The name that it may have, without parameters: it is no constant, and the repaired plant does not have it unless as a stand-in.
  std::vector<FoundEffect> effects = {};
  std::vector<plant::EffectId> ambiguous_with = {};
};

// Something that matches nothing that was tried.
struct Unexplained {};

using Answer = std::variant<NothingMissing, Found, NoConstant, Unexplained>;
Verdict verdict_of(const Answer& answer);

// What an answer has of each; empty where it has none.
const std::vector<FoundEffect>& effects_in(const Answer& answer);
const std::vector<FoundLaw>& laws_in(const Answer& answer);
const std::vector<FoundApart>& apart_in(const Answer& answer);
const std::vector<plant::EffectId>& ambiguous_in(const Answer& answer);

}  // namespace sinew::diagnose

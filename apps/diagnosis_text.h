// SPDX-License-Identifier: Apache-2.0
// What a diagnosis says, in plain sentences: the same in the terminal and in the report.
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "apps/words.h"
#include "diagnose/diagnosis.h"

namespace sinew::apps {

// What is odd about a recording, as it was read: a line each.
struct Oddities {
  std::string recording;
  std::vector<std::string> lines;
};

// What was asked, in words that do not depend on where the results go or on the number of threads.
struct DiagnosisInputs {
  std::vector<std::string> training, held_out;  // paths
  std::string plant;
  std::vector<std::string> ignored;  // as given
  std::vector<Oddities> oddities;    // of recordings that have any
  std::int64_t seed = 1;
  diagnose::DiagnosisSettings settings;
};

struct DiagnosisWords {
  std::string verdict;                                           // one sentence
  std::string summary;                                           // how much better it predicts, in one sentence; or empty
  std::vector<std::string> where, what, modelled, better, next;  // paragraphs
};

// The lists of the plant's System.
inline const plant::System& system_of(const diagnose::Diagnosis& diagnosis) { return diagnosis.repaired.system(); }
inline const auto& effects_of(const diagnose::Diagnosis& diagnosis) { return system_of(diagnosis).effects(); }
inline const auto& parameters_of(const diagnose::Diagnosis& diagnosis) { return system_of(diagnosis).parameters(); }
inline const auto& channels_of(const diagnose::Diagnosis& diagnosis) { return system_of(diagnosis).channels(); }
inline const auto& groups_of(const diagnose::Diagnosis& diagnosis) { return system_of(diagnosis).entry_groups(); }
// A weight of a law, drawn as a curve, or of a part's own value, which is said: no number for readers.
inline bool is_weight(const plant::System& system, plant::ParameterId p) {
  const auto& effect = system.parameters()[p].effect;
  return effect && !system.effects()[*effect].is_of_catalogue();
}
// Effects of the catalogue.
inline std::size_t catalogue_size(const diagnose::Diagnosis& diagnosis) { return system_of(diagnosis).without_laws()->effects().size(); }
inline std::string effect_name(const diagnose::Diagnosis& diagnosis, plant::EffectId effect) {
  const auto& info = effects_of(diagnosis)[effect];
  return info.law ? plant::law_words(system_of(diagnosis), system_of(diagnosis).laws()[*info.law]) : std::string(info.name);
}

DiagnosisWords diagnosis_words(const diagnose::Diagnosis& diagnosis, const DiagnosisInputs& inputs);

// Why what was found has no name: "needs a value at the bound of what is allowed". That something is left is none of these.
std::vector<std::string> objection_words(const plant::System& system, const diagnose::Objections& against);
std::string place_words(const plant::System& system, std::string_view place);  // of EffectInfo::place, or of EntryGroup::name
std::string name_and_words(const plant::EffectInfo& effect);  // "the silicone creeps (viscoelasticity), viscoelastic_creep"
std::string windows_words(const diagnose::WorstTime& worst, std::size_t most = 4);  // "214–230 s, 300–305 s and 2 more such times"

// Parameters of the repaired plant that were fitted, without weights of laws; units of files, 95 % intervals within what is allowed.
struct FittedValue {
  plant::ParameterId parameter;
  std::size_t unknown;  // of Diagnosis::values
  double value, lowest, highest;
};
const plant::Sharing& sharing_of(const diagnose::Diagnosis& diagnosis, const diagnose::FoundApart& found);
// Each quantity in which parts are not alike, and its values: "75 degC, 95 % within 74 to 76 (A) and ...".
std::vector<std::pair<std::string, std::string>> apart_quantities(const diagnose::Diagnosis& diagnosis, const diagnose::FoundApart& found);

std::vector<FittedValue> fitted_values(const diagnose::Diagnosis& diagnosis);
// Where each recording begins, of the states that were not known to be at rest; units of files, 95 % intervals.
struct FirstValue {
  std::string recording, state;
  std::string_view unit;
  double value, lowest, highest, at_rest;
  bool told;     // by the recording, and not by what was believed before alone
  bool matters;  // it is told, of what was added, and far from rest
};
std::vector<FirstValue> first_values(const diagnose::Diagnosis& diagnosis);
// Effects that are on in the repaired plant and were not in the given one; those of them that are not named only stand in
// for what is missing.
std::vector<plant::EffectId> added_effects(const diagnose::Diagnosis& diagnosis);
std::vector<plant::EffectId> stand_ins(const diagnose::Diagnosis& diagnosis);
// What a law's values are shown in, and what they are multiplied with for that.
std::pair<std::string, double> law_unit(const diagnose::Diagnosis& diagnosis, const plant::Law& law);
// Effects that were not found, and whether they would have been.
std::vector<diagnose::Visibility> not_found(const diagnose::Diagnosis& diagnosis);

// Whether fitting the other parameters would do the same as the effect, as far as this data shows, to first order: how much of
// it would have been seen is not known then.
bool is_imitated(const diagnose::Visibility& visibility);

// What was held out, in words: "test.csv", "the last 60 s of train.csv".
std::string held_out_words(const diagnose::Diagnosis& diagnosis);

// Correlation of what is left with itself a second later; nothing where that is not known.
std::optional<double> correlation_after_1_s(const std::vector<double>& correlation);

}  // namespace sinew::apps

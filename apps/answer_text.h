// SPDX-License-Identifier: Apache-2.0
// What a diagnosis answers, in words: the headline, and the paragraphs on what is missing. Each kind of answer has its own.
#pragma once

#include <string>
#include <vector>

#include "apps/diagnosis_text.h"

namespace sinew::apps {

inline constexpr double goes_with_share = 0.3;  // of what is left: a variable that accounts for less is not worth a sentence

// One sentence, or a few.
std::string headline(const diagnose::Diagnosis& diagnosis);
std::vector<std::string> what_words(const diagnose::Diagnosis& diagnosis, const DiagnosisInputs& inputs);
// How much of the catalogue was tried.
std::string tried_words(const diagnose::Diagnosis& diagnosis, const diagnose::DiagnosisSettings& settings);

std::string plant_words(const diagnose::Diagnosis& diagnosis);  // "the limb"
std::string variable_words(const diagnose::Dependence& on);     // "temperature A", "the speed of bending"
std::string sharing_words(const plant::Sharing& sharing);       // "the transformation temperatures", "the values of junction"
std::string apart_clause(const plant::Sharing& sharing);        // "the coils are not alike in the transformation temperatures"
// Effects that were found and have values; a law alone stands for the others.
std::size_t fitted_effects(const diagnose::Answer& answer);

}  // namespace sinew::apps

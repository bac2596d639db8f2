// SPDX-License-Identifier: Apache-2.0
// diagnosis.json, and the other files for programs that `diagnose` writes: the repaired plant, its prediction, run.json.
#pragma once

#include <map>
#include <nlohmann/json.hpp>
#include <string>

#include "apps/diagnosis_text.h"

namespace sinew::apps {

// Paths and the SHA-256 of what they hold.
using InputHashes = std::map<std::string, std::string>;

nlohmann::ordered_json support_json(const diagnose::Support& support);
nlohmann::ordered_json chance_json(const diagnose::ProcessNoiseByChance& chance);

// Place, odds, curve and band of physics without a name.
nlohmann::ordered_json law_json(const diagnose::Diagnosis& diagnosis, const diagnose::FoundLaw& found);
// Parts that are not alike: odds, and the values of each with intervals.
nlohmann::ordered_json apart_json(const diagnose::Diagnosis& diagnosis, const diagnose::FoundApart& found);

nlohmann::ordered_json diagnosis_json(const diagnose::Diagnosis& diagnosis, const DiagnosisInputs& inputs, const InputHashes& hashes);

// The repaired plant in YAML; its first lines say what it is, from what, and how far off.
std::string repaired_plant_yaml(const diagnose::Diagnosis& diagnosis, const DiagnosisInputs& inputs);

// What the repaired plant predicts, open loop from the recorded duty alone: of each held-out recording or, without any, of what
// was held out of each training recording, as recordings. heldout_prediction.csv, further ones heldout_prediction_2.csv and on;
// where nothing was held out the first has no rows.
std::map<std::string, std::string> prediction_files(const diagnose::Diagnosis& diagnosis);

// `files`: name and content of each file beside it.
std::string diagnosis_run_json(const diagnose::Diagnosis& d, const DiagnosisInputs& inputs, const InputHashes& hashes,
                               const std::map<std::string, std::string>& files);

}  // namespace sinew::apps

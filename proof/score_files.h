// SPDX-License-Identifier: Apache-2.0
// The score as files: README.md and pictures for people, score.json for programs. Nothing is computed here.
#pragma once

#include <nlohmann/json.hpp>

#include "proof/score.h"

namespace sinew::proof {

nlohmann::ordered_json score_json(const Score& score);

// `command`: what makes these cases again.
std::string score_markdown(const Score& score, const std::string& command);
// A figure in words: "75.9 % (60 of 79)", "1.00".
std::string measured_words(const Figure& figure);

// What was concealed against what was named first.
std::string confusion_svg(const Score& score);
// How often names came true against the probability they were given.
std::string reliability_svg(const Score& score);

}  // namespace sinew::proof

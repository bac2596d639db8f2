// SPDX-License-Identifier: Apache-2.0
// The story of an investigation in sentences: what was believed after each recording, what was asked, what came back.
#pragma once

#include "investigate/investigation.h"

namespace sinew::investigate {

struct Chapter {
  std::string heading;                  // "1. Babbling, 120 s"
  std::vector<std::string> paragraphs;  // what was asked and what came back
};
struct Story {
  std::string end;  // one or two sentences: how it ended, and what is believed now
  std::vector<Chapter> chapters;
  std::vector<std::string> next;  // what to do now
};

Story story_of(const Investigation& investigation, const plant::System& system);
// What is about to be done, and how hot it gets.
std::string announcement_of(const Step& step);
// "latent_heat 64 %, cross_heating 21 %, something else 15 %"
std::string words_of(const Believed& believed);
std::string to_text(const Story& story);

}  // namespace sinew::investigate

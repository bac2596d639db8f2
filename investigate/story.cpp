// SPDX-License-Identifier: Apache-2.0
#include "investigate/story.h"

#include <algorithm>
#include <cmath>
#include <cstdio>

namespace sinew::investigate {
namespace {

constexpr double worth_a_word = 0.01;

template <class... Values>
std::string print(const char* format, Values... values) {
  char text[256];
  std::snprintf(text, sizeof text, format, values...);
  return text;
}

std::string time_words(double duration_s) {
  return duration_s < 90.0 ? print("%.0f s", duration_s)
                           : print("%.0f min %02.0f s", std::floor(duration_s / 60.0), std::fmod(duration_s, 60.0));
}

std::string answer_words(const std::string& key, const plant::System& system) {
  if (key == "nothing") return "nothing is missing from the plant";
  if (key == "something else") return "something is missing that is not in the catalogue, or acts in another form";
  std::string words;
  for (std::size_t from = 0; from <= key.size();) {
    const std::size_t to = std::min(key.find('+', from), key.size());
    const std::string name = key.substr(from, to - from);
    const auto known = std::ranges::find(system.effects(), name, &plant::EffectInfo::name);  // else parts that are not alike
    words += words.empty() ? "" : ", and ";
    if (known != system.effects().end())
      words += std::string(known->words) + " (" + name + ")";
    else
      words += "its " + name.substr(0, name.find(unlike_in)) + " are not alike in " + name.substr(name.find(unlike_in) + unlike_in.size());
    from = to + 1;
  }
  return words;
}

std::string origin_words(const Step& step) {
  return step.origin == "given" ? "A recording that was given" : step.origin == "babbling" ? "Babbling" : "An experiment";
}

}  // namespace

std::string words_of(const Believed& believed) {
  std::string words;
  double rest = 0.0;
  for (const Believed::Answer& answer : believed.answers) {
    if (answer.probability < worth_a_word) {
      rest += answer.probability;
      continue;
    }
    words += (words.empty() ? "" : ", ") + answer.key + print(" %.0f %%", 100.0 * answer.probability);
  }
  if (rest >= worth_a_word) words += print(", others together %.0f %%", 100.0 * rest);
  return words;
}

std::string announcement_of(const Step& step) {
  const Plan& plan = *step.plan;
  std::string words = step.name + ": " + plan.words + "; " + time_words(plan.duration_s);
  if (plan.cool_s > 0.0) words += ", the last " + time_words(plan.cool_s) + " to cool";
  if (std::isfinite(plan.highest_degC)) words += print("; at most %.0f °C expected", plan.highest_degC);
  if (!plan.apart.empty())
    words += ". To tell " + plan.apart + " from " + plan.from + print(": %.1f standard deviations apart", plan.separation) +
             print(", expected to tell %.2f bit", plan.expected_bit);
  return words + ".";
}

Story story_of(const Investigation& investigation, const plant::System& system) {
  Story story;
  const Believed* now = nullptr;
  std::size_t number = 0;
  for (const Step& step : investigation.steps) {
    ++number;
    Chapter chapter;
    chapter.heading =
        std::to_string(number) + ". " + origin_words(step) + (step.status ? ", " + time_words(step.duration_s) : ", not recorded yet");
    if (step.plan) {
      std::string asked = step.plan->apart.empty() ? "" : "Asked: is it " + step.plan->apart + ", or " + step.plan->from + "? ";
      asked += "Done: " + step.plan->words + ".";
      if (!step.plan->apart.empty())
        asked += print(" Chosen among %zu programmes: it was expected to tell %.2f bit", step.plan->tried, step.plan->expected_bit) +
                 print(", with the two %.1f standard deviations apart, and to stay below %.0f °C.", step.plan->separation,
                       step.plan->highest_degC);
      chapter.paragraphs.push_back(asked);
    }
    if (step.status) {
      std::string came = "Recorded: " + step.name + "/" + (step.origin == "given" ? "recording.csv" : "timed.csv");
      if (std::isfinite(step.highest_degC)) came += print(", at most %.1f °C measured", step.highest_degC);
      if (step.lowered > 0) came += print("; the host's supervisor lowered %lld commands", static_cast<long long>(step.lowered));
      came += ".";
      if (*step.status != "finished" && step.origin != "given")
        came += " The session did not end as planned (" +
                (step.why.starts_with(*step.status) ? step.why : *step.status + (step.why.empty() ? "" : ": " + step.why)) + ")" +
                (step.used ? "; what it recorded is used." : "; too short to be used.");
      chapter.paragraphs.push_back(came);
    }
    if (step.after) {
      std::string believed = "Believed then: " + words_of(*step.after) + print(". Open: %.2f bit", step.after->entropy_bit);
      if (now) believed += print(" (before: %.2f)", now->entropy_bit);
      chapter.paragraphs.push_back(believed + ".");
      now = &*step.after;
    }
    story.chapters.push_back(std::move(chapter));
  }
  story.end = investigation.ending ? investigation.ending_words : "It is not over.";
  if (now) {
    const Believed::Answer& first = now->answers.front();
    story.end += print(" Most probable, with %.0f %%: ", 100.0 * first.probability) + answer_words(first.key, system) + ".";
    for (const auto& [name, value] : now->values) story.end += " " + name + print(" = %.3g.", value);
    if (!now->unseen.empty()) {
      std::string unseen;
      for (const std::string& name : now->unseen) unseen += (unseen.empty() ? "" : ", ") + name;
      story.next.push_back("At usual strength these could still go unnoticed: " + unseen + ".");
    }
  }
  if (investigation.ending == Ending::stopped || investigation.ending == Ending::interrupted)
    story.next.push_back("Give the same command again: it goes on from here, with all recordings that are kept.");
  if (!investigation.measure.empty()) {
    std::string what;
    for (const std::string& one : investigation.measure) what += (what.empty() ? "" : "; ") + one;
    story.next.push_back("What would tell is not more duty but another measurement: " + what + ".");
  }
  return story;
}

std::string to_text(const Story& story) {
  std::string text = story.end + "\n";
  for (const Chapter& chapter : story.chapters) {
    text += "\n" + chapter.heading + "\n";
    for (const std::string& paragraph : chapter.paragraphs) text += "  " + paragraph + "\n";
  }
  if (!story.next.empty()) text += "\nWhat next\n";
  for (const std::string& one : story.next) text += "  " + one + "\n";
  return text;
}

}  // namespace sinew::investigate

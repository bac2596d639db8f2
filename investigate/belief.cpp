// SPDX-License-Identifier: Apache-2.0
#include "investigate/belief.h"

#include <algorithm>
#include <cmath>

#include "plant/contains.h"

namespace sinew::investigate {
namespace {

using diagnose::Diagnosis;

// Of an effect's trace: less is imitated by the other parameters, as apps/diagnosis_text.cpp has it.
constexpr double imitated_share = 0.02;
constexpr double seen_root = 5.0;  // Score::smallest_seen is the strength whose statistic is 25 on average

// A further form of an effect goes by the effect's name.
std::string key_of(const plant::System& system, const std::vector<plant::EffectId>& effects) {
  std::string key;
  for (const plant::EffectId e : effects)
    key += (key.empty() ? "" : "+") + std::string(system.effects()[plant::family_of(system.effects(), e)].name);
  return key;
}

// Root of the statistic that the effect would bring on average at its usual strength.
double usual_root(const plant::System& system, const diagnose::Score& score) {
  if (score.smallest_seen <= 0.0) return 0.0;
  const auto& declared = system.parameters()[system.effects()[score.effect].strength].declaration;
  const double usual = std::abs(declared.typical - declared.null_value.value_or(0.0)) * declared.unit.internal_per_unit;
  return seen_root * usual / score.smallest_seen;
}

void add_unseen(Belief& belief, const Diagnosis& diagnosis, const diagnose::DiagnosisSettings& settings) {
  const plant::System& system = diagnosis.search.core.system();
  const diagnose::Scores& scores = diagnosis.search.rounds.back().scores;
  const double count = static_cast<double>(scores.best.size()), divisor = exaggeration(settings, scores.best.size());
  for (const std::size_t s : scores.best) {
    const diagnose::Score& score = scores.all[s];
    const double root = usual_root(system, score);
    const double found = score.two_sided ? std::abs(score.root) : score.root;
    const double probability = std::exp((root * std::min(found, root) - 0.5 * root * root) / divisor) / count;
    const std::string key = key_of(system, {score.effect});
    const auto there = std::find_if(belief.all.begin(), belief.all.end(), [&](const Hypothesis& one) { return one.key == key; });
    if (there == belief.all.end())
      belief.all.push_back({Kind::unseen, {score.effect}, key, probability});
    else
      there->probability += probability;  // another form of it
    if (root < seen_root) belief.unseen.push_back(score.effect);
    if (root < seen_root && score.smallest_seen > 0.0 && score.visible_share < imitated_share) belief.never.push_back(score.effect);
  }
}

void normalise(Belief& belief) {
  double sum = 0.0;
  for (const Hypothesis& one : belief.all) sum += one.probability;
  for (Hypothesis& one : belief.all) one.probability /= sum;
  std::stable_sort(belief.all.begin(), belief.all.end(),
                   [](const Hypothesis& a, const Hypothesis& b) { return a.probability > b.probability; });
}

}  // namespace

std::string_view text_of(Kind kind) {
  switch (kind) {
    case Kind::nothing:
      return "nothing";
    case Kind::named:
      return "named";
    case Kind::unseen:
      return "unseen";
    case Kind::something_else:
      return "something_else";
  }
  return "";
}

double exaggeration(const diagnose::DiagnosisSettings& settings, std::size_t effects) {
  return std::max(1.0, settings.search.least_gain / (2.0 * std::log(std::max<double>(2.0, static_cast<double>(effects)))));
}

std::vector<plant::EffectId> Belief::not_yet_seen() const {
  std::vector<plant::EffectId> effects;
  for (const plant::EffectId e : unseen)
    if (!contains(never, e)) effects.push_back(e);
  return effects;
}

double Belief::entropy_bit() const {
  double sum = 0.0;
  for (const Hypothesis& one : all)
    if (one.probability > 0.0) sum -= one.probability * std::log2(one.probability);
  return sum + 0.0;
}

Belief belief_of(const Diagnosis& diagnosis, const diagnose::DiagnosisSettings& settings) {
  Belief belief;
  belief.verdict = verdict_of(diagnosis.answer);
  const plant::System& system = diagnosis.search.core.system();
  const std::vector<diagnose::FoundEffect>& effects = effects_in(diagnosis.answer);
  if (effects.empty()) {
    if (std::holds_alternative<diagnose::NothingMissing>(diagnosis.answer)) {
      belief.all.push_back({Kind::nothing, {}, "nothing", 1.0});
      add_unseen(belief, diagnosis, settings);
      normalise(belief);
    } else {
      belief.all.push_back({Kind::something_else, {}, "something else", 1.0});
    }
    return belief;
  }
  std::vector<plant::EffectId> named;
  double confidence = 1.0;
  for (const diagnose::FoundEffect& found : effects) {
    named.push_back(found.effect);
    confidence = std::min(confidence, found.confidence);
  }
  std::sort(named.begin(), named.end());
  belief.all.push_back({Kind::named, named, key_of(system, named), confidence});
  double left = 1.0 - confidence;
  for (const diagnose::FoundEffect& found : effects)
    for (const auto& [rival, loss] : found.rivals) {
      std::vector<plant::EffectId> instead = named;
      *std::find(instead.begin(), instead.end(), found.effect) = rival;
      std::sort(instead.begin(), instead.end());
      const std::string key = key_of(system, instead);
      if (std::any_of(belief.all.begin(), belief.all.end(), [&](const Hypothesis& h) { return h.key == key; })) continue;
      const double probability = std::min(left, confidence * std::exp(-std::max(-2.0, loss)));
      if (probability < 1e-6) continue;
      belief.all.push_back({Kind::named, instead, key, probability});
      left -= probability;
    }
  // What is named beside the answer without a loss of evidence: a look-alike of a form, or a cause before both sensors.
  std::vector<plant::EffectId> beside;
  for (const plant::EffectId e : ambiguous_in(diagnosis.answer)) {
    const std::string key = key_of(system, {e});
    if (std::none_of(belief.all.begin(), belief.all.end(), [&](const Hypothesis& h) { return h.key == key; })) beside.push_back(e);
  }
  for (const plant::EffectId e : beside) {
    const double probability = 0.5 * left / static_cast<double>(beside.size());
    belief.all.push_back({Kind::named, {e}, key_of(system, {e}), probability});
  }
  if (!beside.empty()) left *= 0.5;
  belief.all.push_back({Kind::something_else, {}, "something else", std::max(0.0, left)});
  normalise(belief);
  return belief;
}

}  // namespace sinew::investigate

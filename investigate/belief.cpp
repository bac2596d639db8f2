// SPDX-License-Identifier: Apache-2.0
#include "investigate/belief.h"

#include <algorithm>
#include <cmath>

#include "investigate/usual_strength.h"
#include "plant/contains.h"

namespace sinew::investigate {
namespace {

using diagnose::Diagnosis;

constexpr double least_probability = 1e-4;
constexpr double excluded = 12.5;  // nats of log evidence: five standard deviations, as Score::smallest_seen has it

// A further form of an effect goes by the effect's name.
std::string key_of(const plant::System& system, const std::vector<plant::EffectId>& effects) {
  std::string key;
  for (const plant::EffectId e : effects)
    key += (key.empty() ? "" : "+") + std::string(system.effects()[plant::family_of(system.effects(), e)].name);
  return key;
}

// "coils unlike in the transformation temperatures"
std::string key_of_parts(const Diagnosis& diagnosis, const diagnose::FoundApart& found) {
  const plant::System& system = diagnosis.repaired.system();
  const plant::Sharing& sharing = system.sharings()[*system.effects()[found.effect].sharing];
  return std::string(sharing.parts_word) + std::string(unlike_in) + (sharing.effect ? "the values of " : "") + sharing.words;
}

// Of something against nothing, by the gain in log evidence; what is beyond doubt need not overflow.
double odds(double gain, double divisor, std::size_t effects) {
  return std::exp(std::min(gain / divisor, 300.0)) / std::max(1.0, static_cast<double>(effects));
}

// In log posterior, from nothing to whatever explains most: names, laws, and the process noise that is there without them.
double highest_gain(const Diagnosis& diagnosis) {
  const diagnose::Explanation &core = diagnosis.search.core, &best = diagnosis.search.best;
  return 0.5 * core.process_noise + std::max(0.0, best.log_posterior - core.log_posterior);
}

void add_unseen(Belief& belief, const Diagnosis& diagnosis, const diagnose::DiagnosisSettings& settings) {
  const diagnose::Explanation& core = diagnosis.search.core;
  const plant::System& system = core.system();
  const diagnose::Scores& scores = round_from(diagnosis.search, core).scores;
  const double divisor = exaggeration(settings, scores.best.size());
  std::vector<plant::EffectId> effects;
  // What begins at an instant has shown itself, or begins later: no duty asks for it.
  for (const std::size_t s : scores.best)
    if (!system.effects()[scores.all[s].effect].begins_at_an_instant) effects.push_back(scores.all[s].effect);
  const AtUsualStrength fits = at_usual_strength(core, effects, settings.search);
  for (std::size_t i = 0; i < effects.size(); ++i) {
    const auto& fitted = fits.with[i];
    if (!fitted) continue;
    const double gain = fitted->log_evidence - fits.log_evidence_without, probability = odds(gain, divisor, scores.best.size());
    const std::string key = key_of(system, {effects[i]});
    if (gain > -excluded) belief.unseen.push_back(effects[i]);
    const auto there = std::ranges::find(belief.all, key, &Hypothesis::key);
    if (there == belief.all.end()) {
      belief.all.push_back({Kind::unseen, {effects[i]}, key, probability, fitted});
    } else {  // another form of it; the likeliest stands for all
      if (fitted->log_evidence > there->fitted->log_evidence) *there = {Kind::unseen, {effects[i]}, key, there->probability, fitted};
      there->probability += probability;
    }
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

bool Belief::may_yet_show(const Hypothesis& one) { return one.kind == Kind::unseen && one.probability > least_probability; }

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
  const std::size_t count = round_from(diagnosis.search, diagnosis.search.core).scores.best.size();
  const double something = odds(highest_gain(diagnosis), exaggeration(settings, count), count);
  const std::vector<diagnose::FoundApart>& apart = apart_in(diagnosis.answer);
  if (effects.empty() && apart.empty()) {
    if (std::holds_alternative<diagnose::NothingMissing>(diagnosis.answer)) {
      belief.all.push_back({Kind::nothing, {}, "nothing", 1.0});
      add_unseen(belief, diagnosis, settings);
    } else {
      belief.all.push_back({Kind::something_else, {}, "something else", something});
      belief.all.push_back({Kind::nothing, {}, "nothing", 1.0});
    }
    normalise(belief);
    return belief;
  }
  std::vector<plant::EffectId> named;
  double confidence = 1.0;
  for (const diagnose::FoundEffect& found : effects) {
    named.push_back(found.effect);
    confidence *= found.confidence;
  }
  std::sort(named.begin(), named.end());
  // Parts that are not alike are a part of the answer, and of every rival: what acts instead acts beside them.
  std::string unlike;
  std::vector<plant::EffectId> unlike_ids;
  for (const diagnose::FoundApart& found : apart) {
    unlike += (effects.empty() && unlike.empty() ? "" : "+") + key_of_parts(diagnosis, found);
    unlike_ids.push_back(found.effect);
    confidence *= found.confidence;
  }
  std::sort(unlike_ids.begin(), unlike_ids.end());
  const auto with_unlike = [&](std::vector<plant::EffectId> names) {
    names.insert(names.end(), unlike_ids.begin(), unlike_ids.end());
    return names;
  };
  belief.all.push_back({Kind::named, with_unlike(named), key_of(system, named) + unlike, confidence});
  double left = 1.0 - confidence;
  if (const double nothing = std::min(left, 1.0 / (1.0 + something)); nothing > 1e-6) {
    belief.all.push_back({Kind::nothing, {}, "nothing", nothing});
    left -= nothing;
  }
  for (const diagnose::FoundEffect& found : effects)
    for (const auto& [rival, loss] : found.rivals) {
      std::vector<plant::EffectId> instead = named;
      *std::find(instead.begin(), instead.end(), found.effect) = rival;
      std::sort(instead.begin(), instead.end());
      const std::string key = key_of(system, instead) + unlike;
      if (std::any_of(belief.all.begin(), belief.all.end(), [&](const Hypothesis& h) { return h.key == key; })) continue;
      const double probability = std::min(left, confidence * std::exp(-std::max(-2.0, loss)));
      if (probability < 1e-6) continue;
      belief.all.push_back({Kind::named, with_unlike(instead), key, probability});
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

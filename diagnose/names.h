// SPDX-License-Identifier: Apache-2.0
// What was found in a recording, names and laws, and how much of what was tried speaks for each name.
#pragma once

#include "diagnose/confidence.h"
#include "diagnose/free_laws.h"
#include "diagnose/proposals.h"
#include "diagnose/search.h"
#include "diagnose/wander.h"
#include "plant/laws.h"

namespace sinew::diagnose {

// What stands for an effect in the answer: the catalogue's formula; that and a law in its own equation or reading, or a formula of another
// form; or such a law alone, so that none of its parameters has a value.
enum class Form { catalogue, bent, free };
std::string_view text_of(Form form);  // as in diagnosis.json

struct FoundEffect {
  plant::EffectId effect{};
  Support support;          // what speaks for it
  double confidence = 0.0;  // probability(support): that this is what acts
  double chance = 1.0;      // family-wise probability of such a gain
  struct Parameter {
    plant::ParameterId parameter{};
    double value, lowest, highest;  // in the units of files; 95 %
    bool known;                     // not fitted
    double from_belief = 0.0;       // of the value from its prior's centre, in deviations of the prior
  };
  std::vector<Parameter> parameters;                       // as in Diagnosis::values
  std::vector<std::pair<plant::EffectId, double>> rivals;  // effect, loss of log evidence against this one
  Form form = Form::catalogue;
  double explained_by_formula = 0.0;  // share of the misfit, where a law may be its form
};

// Physics without a name that was found: a law of the answer's plant (plant/laws.h), and its curve. Internal units of its entry.
struct FoundLaw {
  plant::EffectId effect{};
  plant::Law law;
  std::string place;
  double log_odds = 0.0;                  // of the answer against the best that has no such law
  std::vector<double> values, deviation;  // at the knots
  std::vector<ClosedForm> forms;          // that lie within the band
};

std::vector<plant::EffectId> names_of(const std::vector<FoundEffect>& found);

// Laws that an explanation has and the core has not.
std::vector<plant::EffectId> laws_of(const Explanation& explanation, const Explanation& core);

FoundLaw found_law(plant::EffectId effect, const Explanation& fit, double log_odds);
// An effect that the search accepted; explained_share: of the misfit, by the answer.
FoundEffect found_by_evidence(plant::EffectId effect, const Search& search, double explained_share);
// An effect whose strength is no constant, so that no parameter of it has a value. A free course in one place can do what physics does in
// any that moves the same channels, so it has its share of these alone.
FoundEffect found_wandering(const Wandering& wandering, const plant::System& system);

// What was tried with laws, by falling log odds: names, and the laws beside them.
struct Tried {
  std::vector<plant::EffectId> names;
  std::vector<plant::Law> laws;
  double log_odds;
};
std::vector<Tried> tried_in(const Search& search);
std::vector<Tried> tried_in(const Proposals& proposals);

// What does in place of an effect of the answer, the others kept: the other, and what it loses of log odds.
std::vector<std::pair<plant::EffectId, double>> rivals_in(const Proposals& proposals, plant::EffectId effect);
// Log odds of the answer against the best that has no such term. Parts that differ can follow nearly anything, so they must beat laws, too,
// that do not pay.
double odds_without(const Proposals& proposals, plant::EffectId term);

// Whether a law could be the name's form; whether one could be the form of none of these.
bool has_law_as_form(const plant::System& system, const std::vector<FoundLaw>& laws, plant::EffectId name);
bool has_law_beside(const plant::System& system, const std::vector<FoundLaw>& laws, const std::vector<plant::EffectId>& names);

// All but what a law of the answer may be the form of and is less likely than not.
std::vector<plant::EffectId> names_said(const plant::System& system, const std::vector<FoundEffect>& found,
                                        const std::vector<FoundLaw>& laws);

// An answer that has laws, or was found by open-loop simulation.
struct Naming {
  const plant::Plant& given;  // in the answer's System
  const Search& search;
  const std::vector<plant::EffectId>& without;  // may not be named
  const std::vector<plant::EffectId>& names;    // that the answer adds
  const std::vector<FoundLaw>& laws;            // of the answer
  double explained_share;
  const Proposals* proposals;  // where it was found by open-loop simulation

  // Whose form a law could be, one of each family, and how probable that is.
  std::vector<std::pair<plant::EffectId, double>> names_for(const plant::Law& law) const;
  // The names of the answer, and of those whose form a law of it could be, the likeliest, with at least this share of the posterior.
  std::vector<FoundEffect> named(const std::vector<Tried>& tried, double least_share) const;

 private:
  double left_by_formula(plant::EffectId name) const;
  double probability_given(const Tried& one, plant::EffectId name) const;
  FoundEffect found_among(const std::vector<Tried>& tried, plant::EffectId name) const;
};

}  // namespace sinew::diagnose

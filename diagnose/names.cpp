// SPDX-License-Identifier: Apache-2.0
#include "diagnose/names.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include "plant/contains.h"

namespace sinew::diagnose {
namespace {

// An effect, and what fits in its place. What goes by the same name is no rival.
FoundEffect described(plant::EffectId effect, const Search& search) {
  const plant::System& system = search.core.system();
  FoundEffect result;
  result.effect = effect;
  if (system.effects()[effect].form_of) result.form = Form::bent;
  if (const auto rivals = search.rivals.find(effect); rivals != search.rivals.end()) result.rivals = rivals->second;
  std::erase_if(result.rivals, [&](const auto& rival) { return has_family(system, {effect}, rival.first); });
  return result;
}

// Whether the one has, beside what the other has, an effect by this name and nothing else.
bool is_one_more(const plant::System& system, const std::vector<plant::EffectId>& before, const std::vector<plant::EffectId>& with,
                 plant::EffectId name) {
  return with.size() == before.size() + 1 && has_family(system, with, name) && !has_family(system, before, name) &&
         std::all_of(before.begin(), before.end(), [&](plant::EffectId e) { return contains(with, e); });
}

}  // namespace

std::string_view text_of(Form form) {
  switch (form) {
    case Form::catalogue:
      return "catalogue";
    case Form::bent:
      return "bent";
    case Form::free:
      return "free";
  }
  return "";
}

std::vector<plant::EffectId> names_of(const std::vector<FoundEffect>& found) {
  std::vector<plant::EffectId> names;
  for (const FoundEffect& one : found) names.push_back(one.effect);
  return names;
}

std::vector<plant::EffectId> laws_of(const Explanation& explanation, const Explanation& core) {
  std::vector<plant::EffectId> laws;
  for (std::size_t e = core.system().effects().size(); e < explanation.system().effects().size(); ++e)
    if (explanation.system().effects()[plant::EffectId{e}].law) laws.push_back(plant::EffectId{e});
  return laws;
}

FoundLaw found_law(plant::EffectId effect, const Explanation& fit, double log_odds) {
  const plant::System& system = fit.system();
  FoundLaw result;
  result.effect = effect;
  result.law = system.laws()[*system.effects()[effect].law];
  result.place = place_of(system, result.law);
  result.log_odds = log_odds;
  const Eigen::VectorXd values = plant::values_of(fit.model(), effect);
  result.values.assign(values.begin(), values.end());
  // The weights are unknowns of one deviation each.
  const auto& parameters = fit.problem->parameters();
  const auto first = std::find(parameters.begin(), parameters.end(), system.effects()[effect].parameters[1]) - parameters.begin();
  const Eigen::Index n = result.law.curve.cols();
  const Eigen::MatrixXd covariance = result.law.curve * fit.covariance.block(first, first, n, n) * result.law.curve.transpose();
  for (Eigen::Index k = 0; k < covariance.rows(); ++k) result.deviation.push_back(std::sqrt(covariance(k, k)));
  result.forms = forms_within(result.law.knots, result.values, result.deviation);
  return result;
}

FoundEffect found_by_evidence(plant::EffectId effect, const Search& search, double explained_share) {
  FoundEffect result = described(effect, search);
  for (const Round& round : search.rounds)
    if (round.accepted && round.candidates.front().effect == effect) {
      result.support.gain = round.gain;
      result.chance = round.chance;
    }
  double others = 1.0;
  for (const auto& [rival, loss] : result.rivals) others += std::exp(-std::clamp(loss, -50.0, 700.0));
  result.support.share = (1.0 - result.chance) / others * explained_share;
  return result;
}

FoundEffect found_wandering(const Wandering& wandering, const plant::System& system) {
  FoundEffect result;
  result.effect = *wandering.of.effect;
  result.support.gain = 2.0 * wandering.gain;
  result.chance = std::erfc(std::sqrt(wandering.gain));
  double likely = 1.0;
  for (const auto& [other, loss] : wandering.others) {
    if (other.effect && has_family(system, {result.effect}, *other.effect)) continue;  // another form of the same
    likely += std::exp(-std::max(0.0, loss));
    if (other.effect) result.rivals.emplace_back(*other.effect, loss);
  }
  result.support.share = wandering.explained_share / likely / static_cast<double>(places_alike(system, wandering.of.place).size());
  return result;
}

std::vector<Tried> tried_in(const Search& search) {
  std::vector<Tried> result;
  for (const Bent& one : search.bent) {
    result.push_back({one.names, {}, one.log_odds});
    const plant::System& system = one.explanation.system();
    for (const plant::EffectId l : laws_of(one.explanation, search.core))
      result.back().laws.push_back(system.laws()[*system.effects()[l].law]);
  }
  result.push_back({{}, {}, search.core.log_evidence});
  return result;
}

std::vector<Tried> tried_in(const Proposals& proposals) {
  std::vector<Tried> result;
  const plant::System& system = *proposals.system;
  for (const Proposal& one : proposals.all) {
    if (!one.counts) continue;
    result.push_back({{}, {}, one.log_odds});
    for (const plant::EffectId e : one.effects)
      if (const plant::EffectInfo& effect = system.effects()[e]; effect.law)
        result.back().laws.push_back(system.laws()[*effect.law]);
      else if (!effect.sharing)
        result.back().names.push_back(e);
  }
  return result;
}

std::vector<std::pair<plant::EffectId, double>> rivals_in(const Proposals& proposals, plant::EffectId effect) {
  std::vector<std::pair<plant::EffectId, double>> rivals;
  const Proposal& best = proposals.all[proposals.answer];
  for (const Proposal& one : proposals.all) {
    if (!one.counts || has_family(*proposals.system, one.effects, effect)) continue;
    const double loss = best.log_odds - one.log_odds;
    if (one.effects.size() != best.effects.size() ||
        std::any_of(best.effects.begin(), best.effects.end(), [&](plant::EffectId e) { return e != effect && !contains(one.effects, e); }))
      continue;
    for (const plant::EffectId other : one.effects)
      if (!contains(best.effects, other) && one.fit.system().effects()[other].is_of_catalogue() &&
          std::none_of(rivals.begin(), rivals.end(), [&](const auto& r) { return r.first == other; }))
        rivals.emplace_back(other, loss);
  }
  return rivals;
}

double odds_without(const Proposals& proposals, plant::EffectId term) {
  std::optional<double> best;
  for (const Proposal& one : proposals.all)
    if (!contains(one.effects, term)) best = std::max(best.value_or(one.log_odds), one.log_odds);
  return best ? proposals.all[proposals.answer].log_odds - *best : 0.0;
}

bool has_law_as_form(const plant::System& system, const std::vector<FoundLaw>& laws, plant::EffectId name) {
  return std::any_of(laws.begin(), laws.end(), [&](const FoundLaw& one) { return is_own(system, {name}, one.law); });
}

bool has_law_beside(const plant::System& system, const std::vector<FoundLaw>& laws, const std::vector<plant::EffectId>& names) {
  return std::any_of(laws.begin(), laws.end(), [&](const FoundLaw& one) { return !is_own(system, names, one.law); });
}

std::vector<plant::EffectId> names_said(const plant::System& system, const std::vector<FoundEffect>& found,
                                        const std::vector<FoundLaw>& laws) {
  std::vector<plant::EffectId> names;
  for (const FoundEffect& one : found)
    if (one.confidence >= doubtful_below || !has_law_as_form(system, laws, one.effect)) names.push_back(one.effect);
  return names;
}

// The share of the misfit that the catalogue's formula leaves where it is added; 1 where it was not worth a fit. In open-loop simulation
// the misfit is the square of how far off a proposal is.
double Naming::left_by_formula(plant::EffectId name) const {
  double least = 1.0;
  if (proposals) {
    for (const Proposal& with : proposals->all)
      for (const Proposal& before : proposals->all)
        if (before.error > 0.0 && is_one_more(given.system(), before.effects, with.effects, name))
          least = std::min(least, std::pow(with.error / before.error, 2));
    return least;
  }
  for (const Round& round : search.rounds)
    for (const Candidate& candidate : round.candidates)
      if (candidate.explanation.usable && has_family(given.system(), {name}, candidate.effect))
        least = std::min(least, 1.0 - share_explained(round.before, candidate.explanation));
  return least;
}

std::vector<std::pair<plant::EffectId, double>> Naming::names_for(const plant::Law& law) const {
  const plant::System& system = given.system();
  std::vector<plant::EffectId> families;
  std::vector<double> left;
  for (const plant::EffectId e : system.effects().ids()) {
    const bool may = system.effects()[e].is_of_catalogue() && !is_left_out(system, e, without) && !given.is_on(e);
    if (!may || !is_own(system, {e}, law) || has_family(system, families, e)) continue;
    families.push_back(e);
    left.push_back(left_by_formula(e));
  }
  const std::vector<double> probabilities = probabilities_of_forms(left);
  std::vector<std::pair<plant::EffectId, double>> result;
  for (std::size_t i = 0; i < families.size(); ++i) result.emplace_back(families[i], probabilities[i]);
  return result;
}

// How probable a name is where an explanation holds. A law in its place, of what it depends on, may be its form, whether or not the
// name is fitted beside it: beside a free curve it has nothing to do.
double Naming::probability_given(const Tried& one, plant::EffectId name) const {
  for (const plant::Law& law : one.laws) {
    const auto candidates = names_for(law);
    for (const auto& [e, probability] : candidates)
      if (has_family(given.system(), {name}, e)) return probability;
  }
  return has_family(given.system(), one.names, name) ? 1.0 : 0.0;
}

// A name among what was tried with laws: its part of the posterior.
FoundEffect Naming::found_among(const std::vector<Tried>& tried, plant::EffectId name) const {
  FoundEffect result = described(name, search);
  double with = 0.0, all = 0.0, best_without = -1e300;
  for (const Tried& one : tried) {
    const double odds = std::exp(one.log_odds - tried.front().log_odds), part = probability_given(one, name);
    all += odds;
    with += part * odds;
    if (part == 0.0) best_without = std::max(best_without, one.log_odds);
  }
  result.support.gain = 2.0 * std::clamp(tried.front().log_odds - best_without, 0.0, 1e6);
  result.chance = 1.0 - with / all;
  result.support.share = with / all * explained_share;
  if (has_law_as_form(given.system(), laws, name)) {
    result.form = contains(names, name) ? Form::bent : Form::free;
    result.explained_by_formula = 1.0 - left_by_formula(name);
    result.support.law_beside = has_law_beside(given.system(), laws, {name});
    result.confidence = probability(result.support);
  }
  return result;
}

std::vector<FoundEffect> Naming::named(const std::vector<Tried>& tried, double least_share) const {
  std::vector<FoundEffect> found;
  for (const plant::EffectId e : names)
    if (!has_law_as_form(given.system(), laws, e)) found.push_back(found_among(tried, e));
  for (const FoundLaw& law : laws) {
    std::optional<FoundEffect> likeliest;
    for (const auto& [e, probability] : names_for(law.law))
      if (FoundEffect one = found_among(tried, e); !likeliest || one.support.share > likeliest->support.share) likeliest = std::move(one);
    if (likeliest && !has_family(given.system(), names_of(found), likeliest->effect)) found.push_back(std::move(*likeliest));
  }
  std::erase_if(found, [&](const FoundEffect& one) { return one.support.share < least_share; });
  return found;
}

}  // namespace sinew::diagnose

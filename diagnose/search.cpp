// SPDX-License-Identifier: Apache-2.0
#include "diagnose/search.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <numeric>
#include <set>
#include <stdexcept>

#include "diagnose/calibrate.h"
#include "diagnose/free_laws.h"
#include "diagnose/proposals.h"
#include "plant/apart.h"
#include "plant/contains.h"
#include "sim/parallel.h"

namespace sinew::diagnose {
namespace {

// Where the fit of one more effect begins: with the shape that scored best and the strength that the score says, `phi`
// from its null in internal units, within reason.
void begin_with(Guess& guess, const plant::System& system, const Score& score, double phi) {
  for (const auto& [key, value] : score.shape) guess.values[key] = value;
  const plant::ParameterId strength = system.effects()[score.effect].strength;
  const auto& declared = system.parameters()[strength].declaration;
  if (declared.kind == plant::Kind::toggle) return;
  const double unit = declared.unit.internal_per_unit;
  const double null = *declared.null_value * unit, typical = declared.typical * unit - null;
  const double most = 2.0 * std::abs(typical), least = 0.1 * std::abs(typical);
  double step = phi;
  if (std::abs(step) < least) step = score.statistic > 0.0 && step != 0.0 ? std::copysign(least, step) : 0.1 * typical;
  guess.values[system.parameters()[strength].key()] = null + std::clamp(step, -most, most);
}

Explanation with_added(const Explanation& at, const Score& score, const Guess& guess, const ExplanationSettings& settings) {
  return explain(with_effect(at.problem->centres(), score.effect), at.problem->data(), guess, settings);
}

bool better(const Candidate& a, const Candidate& b) {
  if (a.explanation.usable != b.explanation.usable) return a.explanation.usable;
  return a.explanation.log_evidence > b.explanation.log_evidence;
}

// Of an effect that is fitted already the better fit stays.
void keep_better(std::vector<Candidate>& candidates, const Candidate& one) {
  const auto there = std::find_if(candidates.begin(), candidates.end(), [&](const Candidate& c) { return c.effect == one.effect; });
  if (there == candidates.end())
    candidates.push_back(one);
  else if (better(one, *there))
    *there = one;
}

class Searcher {
 public:
  Searcher(const plant::Plant& nominal, const std::vector<FitData>& data, const SearchSettings& settings)
      : nominal_(nominal), system_(nominal.system()), data_(data), settings_(settings) {}

  Search run() {
    Search result;
    tell(0.02, "calibrating the core");
    result.core = explain(nominal_, data_, settings_.guess, settings_.fit);
    if (result.core.usable) settle(result.core, settings_.threads);
    if (!result.core.usable) throw std::runtime_error("the plant cannot be integrated over the recordings; is it near this one?");
    result.best = result.core;
    Round first = one_round(result.core, 0, 0.0);
    result.core = first.before;
    if (first.accepted) settle(first);
    result.best = first.accepted ? first.candidates.front().explanation : first.before;
    result.rounds.push_back(std::move(first));
    if (result.rounds.front().accepted) go_on(result);
    if (!nothing_left(result, settings_) || !names_of(result.best).empty()) try_apart(result);
    if (settings_.most_laws >= 1 && !nothing_left(result, settings_)) bend(result);
    if (settings_.most_effects >= 1 && !nothing_left(result, settings_)) try_afresh(result);
    if (settings_.most_effects >= 2 && !nothing_left(result, settings_) && !result.rounds.front().candidates.empty()) try_pairs(result);
    // Rivals matter where there is an answer.
    if (nothing_left(result, settings_) || share_explained(result.core, result.best) > settings_.least_explained_share)
      bend_rivals(result, weigh(result));
    tell(1.0, "done");
    return result;
  }

 private:
  void tell(double share, const std::string& doing) const {
    if (settings_.progress) settings_.progress(share, doing);
  }

  // Enough to see which of many are in the running.
  ExplanationSettings for_a_short_while() const {
    ExplanationSettings settings = settings_.fit;
    settings.most_rounds = 2;
    settings.enough = 1.0;
    return settings;
  }

  // Fits it once more from there; the likelier of the two stays.
  void try_from(const Guess& guess, Explanation& explanation) const {
    const Explanation again = explain(explanation.problem->centres(), data_, guess, settings_.fit);
    if (again.usable && again.log_posterior > explanation.log_posterior) explanation = again;
  }

  // Where much is left a fit may have stuck: held by the large forcings that it began with; by the core's parameters,
  // which went far without the effects; or by forcings that follow the recording whatever the effect does. Once more
  // with small ones, from other first values, from the effects alone, and from least squares of the open-loop simulation; the likeliest
  // stays.
  void settle(Explanation& explanation, int threads) const {
    if (explanation.process_noise <= settings_.settled_process_noise) return;
    const ForcingSize small = small_forcing(system_);
    Guess same = explanation.as_guess(), effects;
    same.forcing = small;
    for (const Unknown& unknown : explanation.problem->unknowns())
      if (unknown.parameter && explanation.system().parameters()[*unknown.parameter].effect)
        effects.values[unknown.name] = same.values[unknown.name];
    const bool has_effects = !effects.values.empty();
    std::vector<Guess> guesses;
    if (has_effects) guesses = {Guess{}, effects};  // the first will be that of the open-loop simulation, which takes longest
    guesses.push_back(same);
    for (Guess& other : with_other_starts(explanation)) {
      other.forcing = small;
      guesses.push_back(std::move(other));
    }
    std::vector<Explanation> again(guesses.size());
    sim::in_parallel(guesses.size(), threads, [&](std::size_t i) {
      if (has_effects && i == 0) {
        guesses[i] = polished(explanation, data_, settings_.fit).of.as_guess();
        guesses[i].forcing = small;
      }
      again[i] = explain(explanation.problem->centres(), data_, guesses[i], settings_.fit);
    });
    for (Explanation& one : again)
      if (one.usable && one.log_posterior > explanation.log_posterior) explanation = std::move(one);
  }

  // Of a round that accepted an effect: all that stand as near to the first as a fit that stuck may be.
  void settle(Round& round) const {
    std::vector<Candidate>& candidates = round.candidates;
    const double near = candidates.front().explanation.log_evidence - 0.5 * settings_.least_gain;
    const auto end = std::find_if(candidates.begin(), candidates.end(), [&](const Candidate& candidate) {
      return !candidate.explanation.usable || candidate.explanation.log_evidence < near;
    });
    const auto near_ones = static_cast<std::size_t>(end - candidates.begin());
    const int each = near_ones > 1 ? 1 : settings_.threads;
    sim::in_parallel(near_ones, settings_.threads, [&](std::size_t i) { settle(candidates[i].explanation, each); });
    std::stable_sort(candidates.begin(), candidates.end(), better);
    round.gain = 2.0 * (candidates.front().explanation.log_posterior - round.before.log_posterior);
    round.chance = family_wise_probability(round.scores, round.gain, settings_.seed);
  }

  // What two effects hardly begin to account for is not in the catalogue: a third would only bend the fit.
  static bool hopeless(const Search& result) { return result.rounds.size() >= 2 && share_explained(result.core, result.best) < 0.5; }

  void go_on(Search& result) const {
    while (result.best.effects().size() < settings_.most_effects + base_count() && !hopeless(result)) {
      Round round = one_round(result.best, result.rounds.size(), result.rounds.front().gain);
      const bool accepted = round.accepted;
      if (accepted) settle(round);
      result.best = accepted ? round.candidates.front().explanation : round.before;
      result.rounds.push_back(std::move(round));
      if (!accepted) break;
    }
  }

  std::size_t base_count() const { return static_cast<std::size_t>(std::count(nominal_.on().begin(), nominal_.on().end(), true)); }

  std::vector<plant::EffectId> candidates_at(const Explanation& at) const { return addable(at.problem->centres(), settings_.without); }

  // Where the best candidate ended, everything else is nearer to the truth than where all began: the effects that look
  // most like it are tried from there, so that a twin does not win because the other's fit got stuck.
  void retry_twins(const Explanation& before, const Scores& scores, std::vector<Candidate>& candidates) const {
    const Candidate& winner = candidates.front();
    if (!winner.explanation.usable || winner.score.column.size() == 0) return;
    std::vector<std::pair<double, std::size_t>> alike;  // -|cos|, index of a score
    for (const std::size_t s : scores.best)
      if (const Score& score = scores.all[s]; score.effect != winner.effect && score.column.size() == winner.score.column.size())
        alike.emplace_back(-std::abs(score.column.dot(winner.score.column)), s);
    std::stable_sort(alike.begin(), alike.end());
    alike.resize(std::min<std::size_t>(alike.size(), 3));
    std::vector<Candidate> again(alike.size());
    const ExplanationSettings shortly = for_a_short_while();
    sim::in_parallel(again.size(), settings_.threads, [&](std::size_t i) {
      const Score& score = scores.all[alike[i].second];
      again[i] = {score.effect, score, {}};
      Guess guess = guess_with(before, score);
      for (const auto& [name, value] : winner.explanation.as_guess().values)
        if (const auto mine = guess.values.find(name); mine != guess.values.end()) mine->second = value;
      const ForcingSize usual = forcing_to_begin_with(system_);
      for (const plant::EntryGroupId g : usual.ids()) guess.forcing[g] = std::max(winner.explanation.forcing[g], 0.1 * usual[g]);
      again[i].explanation = with_added(before, score, guess, shortly);
      if (again[i].explanation.usable && again[i].explanation.log_evidence > winner.explanation.log_evidence - 30.0)
        again[i].explanation = with_added(before, score, again[i].explanation.as_guess(), settings_.fit);
    });
    for (const Candidate& one : again)
      if (one.explanation.usable) keep_better(candidates, one);
    std::stable_sort(candidates.begin(), candidates.end(), better);
  }

  // How far below the best, in log evidence, a fit that has not settled may be and still be in the running.
  static double margin_below(double best, double base) { return std::max(15.0, 0.1 * (best - base)); }

  // Whether the effect brings what is counted from recording to recording.
  static bool goes_on_between(const Explanation& at, plant::EffectId effect) {
    const auto counted = [](const plant::Plant& plant) {
      const plant::States states = plant.states();
      return std::count_if(states.begin(), states.end(),
                           [](const plant::StateInfo& s) { return plant::grows_between_recordings(s.at_start); });
    };
    const plant::Plant& without = at.problem->centres();
    return at.problem->data().size() > 1 && counted(with_effect(without, effect)) > counted(without);
  }

  std::vector<Candidate> fitted(const Explanation& at, const Scores& scores, std::size_t most, double from, double to,
                                const std::string& doing) const {
    std::vector<Candidate> candidates;
    for (const std::size_t s : scores.best) {
      const Score& score = scores.all[s];
      // A score is taken beside all process noise that the plant needs without the effect: a low one excludes nothing. It does not rank
      // what is of a finite step, from a plant that may have gone far without it, nor what grows from recording to recording, as that noise
      // is another one in each.
      if (candidates.size() < most || score.is_difference || goes_on_between(at, score.effect))
        candidates.push_back({score.effect, score, {}});
    }
    // All for a short while, then those that are still in the running.
    ExplanationSettings shortly = for_a_short_while();
    shortly.iterations_per_round = 4;
    std::atomic<std::size_t> done{0};
    sim::in_parallel(candidates.size(), settings_.threads, [&](std::size_t i) {
      candidates[i].explanation = with_added(at, candidates[i].score, guess_with(at, candidates[i].score), shortly);
      tell(from + 0.7 * (to - from) * static_cast<double>(++done) / static_cast<double>(candidates.size()), doing);
    });
    std::stable_sort(candidates.begin(), candidates.end(), better);
    const double best = candidates.empty() ? 0.0 : candidates.front().explanation.log_evidence;
    const double margin = margin_below(best, at.log_evidence);
    sim::in_parallel(candidates.size(), settings_.threads, [&](std::size_t i) {
      Explanation& explanation = candidates[i].explanation;
      if (!explanation.usable || explanation.log_evidence < best - margin) return;
      try_from(explanation.as_guess(), explanation);
    });
    std::stable_sort(candidates.begin(), candidates.end(), better);
    return candidates;
  }

  // The explanation without its last effect, begun where the one with it ended.
  Explanation without_again(const Explanation& with, const Explanation& before) const {
    Guess guess = with.as_guess();
    guess.forcing = before.forcing;
    return explain(before.problem->centres(), data_, guess, settings_.fit);
  }

  Round one_round(const Explanation& before, std::size_t number, double first_gain) const {
    const double from = std::min(0.9, 0.1 + 0.4 * static_cast<double>(number)), to = std::min(0.95, from + 0.35);
    Round round;
    round.before = before;
    round.scores = score(before, candidates_at(before), settings_.threads);
    // Where nothing but noise is left the score test is exact enough to end the search.
    const double largest = round.scores.best.empty() ? 0.0 : round.scores.all[round.scores.best.front()].statistic;
    round.gain = largest;
    round.chance = family_wise_probability(round.scores, largest, settings_.seed);
    if (before.process_noise < settings_.settled_process_noise && largest < 0.6 * settings_.least_gain) return round;
    round.candidates = fitted(before, round.scores, number == 0 ? settings_.refits : settings_.refits / 2, from, to,
                              number == 0 ? "trying effects" : "trying further effects");
    if (round.candidates.empty() || !round.candidates.front().explanation.usable) return round;
    if (2.0 * (round.candidates.front().explanation.log_posterior - before.log_posterior) >= settings_.least_gain)
      retry_twins(before, round.scores, round.candidates);
    const Explanation& best = round.candidates.front().explanation;
    round.gain = 2.0 * (best.log_posterior - before.log_posterior);
    if (round.gain >= settings_.least_gain) {
      const Explanation again = without_again(best, before);
      if (again.usable && again.log_posterior > before.log_posterior) {
        round.before = again;
        round.gain = 2.0 * (best.log_posterior - again.log_posterior);
      }
    }
    round.chance = family_wise_probability(round.scores, round.gain, settings_.seed);
    round.accepted = round.gain >= std::max(settings_.least_gain, settings_.least_share_of_first * first_gain) &&
                     round.chance <= settings_.most_chance && best.log_evidence > round.before.log_evidence;
    return round;
  }

  // A core that had to do without the effect can have gone so far that nothing there points to it: then each effect is
  // fitted from the plant as it was given.
  void try_afresh(Search& result) const {
    const Round& first = result.rounds.front();
    std::vector<Candidate> candidates;
    for (const plant::EffectId e : candidates_at(result.core)) {
      const auto scored =
          std::find_if(first.scores.best.begin(), first.scores.best.end(), [&](std::size_t s) { return first.scores.all[s].effect == e; });
      if (scored != first.scores.best.end()) candidates.push_back({e, first.scores.all[*scored], {}});
    }
    const ExplanationSettings shortly = for_a_short_while();
    std::atomic<std::size_t> done{0};
    sim::in_parallel(candidates.size(), settings_.threads, [&](std::size_t i) {
      const plant::ParameterId strength = system_.effects()[candidates[i].effect].strength;
      const auto& declared = system_.parameters()[strength].declaration;
      Guess guess;
      if (declared.kind != plant::Kind::toggle)
        guess.values[system_.parameters()[strength].key()] =
            0.5 * (*declared.null_value + declared.typical) * declared.unit.internal_per_unit;
      candidates[i].explanation = explain(with_effect(result.core.problem->centres(), candidates[i].effect), data_, guess, shortly);
      tell(0.8 + 0.1 * static_cast<double>(++done) / static_cast<double>(candidates.size()), "trying effects afresh");
    });
    std::stable_sort(candidates.begin(), candidates.end(), better);
    candidates.resize(std::min<std::size_t>(candidates.size(), 3));
    sim::in_parallel(candidates.size(), settings_.threads, [&](std::size_t i) {
      Explanation& explanation = candidates[i].explanation;
      if (!explanation.usable) return;
      try_from(explanation.as_guess(), explanation);
    });
    std::stable_sort(candidates.begin(), candidates.end(), better);
    if (candidates.empty() || !candidates.front().explanation.usable ||
        candidates.front().explanation.log_evidence < result.best.log_evidence + 0.5 * settings_.least_gain)
      return;
    settle(candidates.front().explanation, settings_.threads);
    Search other;
    other.core = result.core;
    Round round;
    round.before = first.before;
    round.scores = first.scores;
    round.candidates = candidates;
    for (const Candidate& candidate : first.candidates) keep_better(round.candidates, candidate);
    std::stable_sort(round.candidates.begin(), round.candidates.end(), better);
    const Explanation best = round.candidates.front().explanation;
    const Explanation again = without_again(best, first.before);
    if (again.usable && again.log_posterior > first.before.log_posterior) other.core = round.before = again;
    round.gain = 2.0 * (best.log_posterior - round.before.log_posterior);
    round.chance = family_wise_probability(round.scores, round.gain, settings_.seed);
    round.accepted = round.gain >= settings_.least_gain && round.chance <= settings_.most_chance;
    if (!round.accepted) return;
    other.best = best;
    other.rounds.push_back(std::move(round));
    go_on(other);
    result = std::move(other);
  }

  static bool contains_all(const std::vector<plant::EffectId>& all, const std::vector<plant::EffectId>& some) {
    return std::all_of(some.begin(), some.end(), [&](plant::EffectId e) { return contains(all, e); });
  }

  bool has_laws(const Explanation& explanation) const { return explanation.system().laws().size() > system_.laws().size(); }

  // Names that an explanation adds to the plant as given.
  std::vector<plant::EffectId> names_of(const Explanation& explanation) const {
    std::vector<plant::EffectId> names;
    for (const plant::EffectId e : explanation.effects())
      if (explanation.system().effects()[e].is_of_catalogue() && !nominal_.is_on(e)) names.push_back(e);
    return names;
  }

  // Every name alike, one of so many. A law that is the form of a name is as likely as not, and one term with it; any other is one of all
  // cells. Each term must gain what an effect must.
  double log_prior(const Explanation& explanation, double cells) const {
    const auto& effects = explanation.system().effects();
    const std::vector<plant::EffectId> names = names_of(explanation);
    const double term = 0.5 * settings_.least_gain;
    double sum = -(std::log(static_cast<double>(system_.effects().size())) + term) * static_cast<double>(names.size());
    for (std::size_t e = system_.effects().size(); e < effects.size(); ++e)
      if (!effects[plant::EffectId{e}].law)
        sum -= explanation.problem->centres().is_on(plant::EffectId{e}) ? std::log(2.0) + term : 0.0;
      else
        sum -= is_own(explanation.system(), names, explanation.system().laws()[*effects[plant::EffectId{e}].law]) ? std::log(2.0)
                                                                                                                  : std::log(cells) + term;
    return sum;
  }

  // Where no laws are tried.
  double log_odds(const Explanation& one) const { return one.log_evidence + log_prior(one, 1.0); }

  static bool is_apart(const Explanation& explanation) {
    const std::vector<plant::EffectId> on = explanation.effects();
    return std::any_of(on.begin(), on.end(), [&](plant::EffectId e) { return explanation.system().effects()[e].sharing.has_value(); });
  }

  // What is left, or what names make up for, may be that parts are not alike (plant/apart.h): beside the best names so far, the next best,
  // and nothing, one kind of values that each part has of its own. That is the plant's own physics, so that it is asked before laws; taken
  // where it leaves nothing.
  void try_apart(Search& result) const {
    const std::vector<plant::EffectId> names = names_of(result.best);
    const bool enough = nothing_left(result, settings_);  // only fewer names can do better
    std::vector<Explanation> parents;
    if (!enough) parents.push_back(result.best);
    if (!names.empty()) parents.push_back(result.core);
    if (!enough || names.size() > 1)
      for (const Candidate& candidate : result.rounds.front().candidates)
        if (parents.size() <= settings_.apart_names && candidate.explanation.usable && names_of(candidate.explanation) != names)
          parents.push_back(candidate.explanation);
    const std::shared_ptr<const plant::System> system = plant::with_parts_apart(nominal_.shared_system());
    std::vector<std::pair<const Explanation*, plant::EffectId>> tried;
    for (const Explanation& parent : parents)
      for (const plant::EffectId e : system->effects().ids()) {
        const plant::EffectInfo& effect = system->effects()[e];
        if (!effect.sharing || !plant::may_differ(nominal_, system->sharings()[*effect.sharing])) continue;
        if (!effect.needs || parent.problem->centres().is_on(*effect.needs)) tried.emplace_back(&parent, e);
      }
    // From where the parent ended, and from the plant as it was given: a parent that had to do without can have gone far.
    const ExplanationSettings shortly = for_a_short_while();
    std::vector<Explanation> apart(tried.size());
    sim::in_parallel(tried.size(), settings_.threads, [&](std::size_t i) {
      const auto& [parent, e] = tried[i];
      const plant::Plant plant = with_effect(plant::carried_into(parent->problem->centres(), system), e);
      apart[i] = explain(plant, data_, parent->as_guess(), shortly);
      const Explanation afresh = explain(plant, data_, {}, shortly);
      if (afresh.usable && (!apart[i].usable || afresh.log_evidence > apart[i].log_evidence)) apart[i] = afresh;
    });
    std::erase_if(apart, [](const Explanation& one) { return !one.usable; });
    std::stable_sort(apart.begin(), apart.end(), [&](const Explanation& a, const Explanation& b) { return log_odds(a) > log_odds(b); });
    if (apart.empty()) return;
    try_from(apart.front().as_guess(), apart.front());
    if (log_odds(apart.front()) < log_odds(result.best) - margin_below(result.best.log_evidence, result.core.log_evidence)) return;
    settle(apart.front(), settings_.threads);
    try_from(apart.front().as_guess(), result.best);  // so that both are settled alike
    if (log_odds(apart.front()) <= log_odds(result.best)) return;
    Search with = result;
    with.apart_log_odds = log_odds(apart.front()) - log_odds(result.best);
    take(with, {names_of(apart.front()), apart.front()});
    if (!nothing_left(with, settings_) || (settings_.is_borne_out && !settings_.is_borne_out(with.best, result.best))) return;
    result = std::move(with);
  }

  // One of the answer's names exchanged, the others kept.
  struct Instead {
    plant::EffectId of, rival;
    Explanation explanation;
  };

  // What one round of laws tries: an explanation and a cell of the screening.
  struct Cell {
    const Explanation* parent;
    LawCandidate law;
  };

  // What is left may follow a law: beside what has a name, which then acts in a form of its own, or beside nothing. Names that did less
  // well in the catalogue's form are asked again, since in a form of their own they may do better.
  // Laws that leave something even so are bent round what is missing elsewhere, and are not taken.
  void bend(Search& result) const {
    Search with = result;
    try_laws(with);
    if (nothing_left(with, settings_)) {
      result = std::move(with);
      return;
    }
    result.bent = std::move(with.bent);
    result.cells = with.cells;
  }

  void try_laws(Search& result) const {
    std::vector<Explanation> parents{result.best};
    if (!names_of(result.best).empty()) parents.push_back(result.core);
    for (const Candidate& candidate : result.rounds.front().candidates) {
      if (parents.size() > settings_.bent_names) break;
      if (candidate.explanation.usable && names_of(candidate.explanation) != names_of(result.best))
        parents.push_back(candidate.explanation);
    }
    double cells = 1.0;
    for (int round = 0; round < settings_.most_laws; ++round) {
      std::vector<Cell> tried;
      for (const Explanation& parent : parents) {
        std::vector<LawCandidate> screened = screen_laws(parent, settings_.threads);
        cells = std::max(cells, static_cast<double>(screened.size()));
        const std::vector<plant::EffectId> names = names_of(parent);
        bool own = names.empty();
        std::size_t taken = 0;
        for (LawCandidate& one : screened) {
          if (one.gain <= 0.0) break;
          const bool is_own = diagnose::is_own(parent.system(), names, one.law);
          if (taken >= settings_.laws && (own || !is_own)) continue;
          own = own || is_own;
          ++taken;
          tried.push_back({&parent, std::move(one)});
        }
      }
      const std::vector<Bent> bent = fitted(tried, cells);
      if (bent.empty()) return;
      result.cells = static_cast<std::size_t>(cells);
      result.bent.insert(result.bent.begin(), bent.begin(), bent.end());
      by_odds(result.bent);
      take_names_out(result, cells);
      const Bent winner = result.bent.front();
      if (share_explained(result.core, winner.explanation) < settings_.least_explained_share) return;
      try_from(winner.explanation.as_guess(), result.best);  // so that both are settled alike
      if (winner.log_odds < result.best.log_evidence + log_prior(result.best, cells)) return;
      if (settings_.is_borne_out && !settings_.is_borne_out(winner.explanation, result.best)) return;
      take(result, winner);
      if (nothing_left(result, settings_)) return;
      parents = {result.best};
    }
  }

  // Each with its law, by falling odds: all for a short while, then those that are still in the running.
  std::vector<Bent> fitted(const std::vector<Cell>& tried, double cells) const {
    std::vector<Bent> bent(tried.size());
    const ExplanationSettings shortly = for_a_short_while();
    std::atomic<std::size_t> done{0};
    sim::in_parallel(tried.size(), settings_.threads, [&](std::size_t i) {
      bent[i] = {names_of(*tried[i].parent), with_law(*tried[i].parent, tried[i].law, shortly)};
      bent[i].gain = log_prior(*tried[i].parent, cells) + tried[i].parent->log_evidence;
      tell(0.8 + 0.1 * static_cast<double>(++done) / static_cast<double>(tried.size()), "trying laws");
    });
    weigh(bent, cells);
    const double highest = bent.empty() ? 0.0 : bent.front().log_odds;
    std::size_t in_the_running = 0;
    while (in_the_running < bent.size() && in_the_running < 4 && bent[in_the_running].log_odds > highest - 100.0) ++in_the_running;
    sim::in_parallel(in_the_running, settings_.threads, [&](std::size_t i) { settle_law(bent[i].explanation); });
    weigh(bent, cells);
    for (Bent& one : bent) one.gain = one.log_odds - one.gain;
    return bent;
  }

  // A rival that does nearly as well in the catalogue's form may do better in one of its own, the same quantity's in the same place: the
  // probability of a name is that of all its forms.
  void bend_rivals(Search& result, const std::vector<Instead>& instead) const {
    if (has_laws(result.best) || is_apart(result.best)) return;
    std::vector<Cell> tried;
    for (const Instead& one : instead) {
      const Explanation& rival = one.explanation;
      if (!rival.usable || share_explained(result.core, rival) < settings_.least_explained_share) continue;
      if (!contains_all(names_of(result.best), {one.of}) || has_family(system_, names_of(result.best), one.rival)) continue;
      const auto own = [&](const plant::Law& law) { return is_own(rival.system(), {one.rival}, law); };
      std::vector<LawCandidate> screened = screen_laws(rival, settings_.threads, own);
      if (!screened.empty() && screened.front().gain > 0.0) tried.push_back({&rival, std::move(screened.front())});
    }
    std::vector<Bent> bent = fitted(tried, 1.0);
    if (bent.empty()) return;
    const double odds = log_odds(result.best);
    for (const Bent& one : bent)
      for (const Instead& rival : instead) {
        if (!contains_all(one.names, {rival.rival}) || contains_all(one.names, {rival.of})) continue;
        for (auto& [effect, loss] : result.rivals[rival.of])
          if (effect == rival.rival) loss = std::min(loss, odds - one.log_odds);
      }
    sort(result.rivals);
    const bool leads = bent.front().log_odds > odds;
    bent.push_back({names_of(result.best), result.best, odds});
    by_odds(bent);
    result.bent = std::move(bent);
    if (!leads || (settings_.is_borne_out && !settings_.is_borne_out(result.bent.front().explanation, result.best))) return;
    take_names_out(result, 1.0);
    const Bent winner = result.bent.front();
    take(result, winner);
    result.rivals.clear();
    static_cast<void>(weigh(result));
  }

  // Without each of its names the best may do as well: begun where it ended, so that all are settled alike.
  void take_names_out(Search& result, double cells) const {
    for (std::size_t names = result.bent.front().names.size(); names > 0; --names) {
      const Bent best = result.bent.front();
      if (best.names.size() != names) return;
      std::vector<Bent> less(names, best);
      sim::in_parallel(names, settings_.threads, [&](std::size_t i) {
        less[i].names.erase(less[i].names.begin() + static_cast<std::ptrdiff_t>(i));
        plant::Plant without = best.explanation.problem->centres();
        without.turn(best.names[i], false);
        less[i].explanation = explain(without, data_, best.explanation.as_guess(), settings_.fit);
      });
      weigh(less, cells);
      result.bent.insert(result.bent.begin(), less.begin(), less.end());
      by_odds(result.bent);
    }
  }

  void weigh(std::vector<Bent>& bent, double cells) const {
    for (Bent& one : bent)
      if (one.explanation.usable) one.log_odds = one.explanation.log_evidence + log_prior(one.explanation, cells);
    by_odds(bent);
  }

  // By falling odds; of the same names and laws the best alone.
  static void by_odds(std::vector<Bent>& bent) {
    std::erase_if(bent, [](const Bent& one) { return !one.explanation.usable; });
    std::stable_sort(bent.begin(), bent.end(), [](const Bent& a, const Bent& b) { return a.log_odds > b.log_odds; });
    std::set<std::pair<std::vector<std::size_t>, std::vector<std::string>>> seen;
    std::erase_if(bent, [&](const Bent& one) {
      std::pair<std::vector<std::size_t>, std::vector<std::string>> terms;
      for (const plant::EffectId e : one.names) terms.first.push_back(e.index);
      for (const plant::Law& law : one.explanation.system().laws()) terms.second.push_back(plant::law_words(one.explanation.system(), law));
      return !seen.insert(std::move(terms)).second;
    });
  }

  Explanation with_law(const Explanation& parent, const LawCandidate& law, const ExplanationSettings& settings) const {
    const plant::Plant plant = plant::with_laws_on(parent.problem->centres(), {law.law});
    const plant::System& system = plant.system();
    const auto& parameters = system.effects()[plant::EffectId{system.effects().size() - 1}].parameters;
    Guess guess = parent.as_guess();
    for (Eigen::Index j = 0; j < law.weights.size(); ++j)
      guess.values[system.parameters()[parameters[static_cast<std::size_t>(j) + 1]].key()] = law.weights(j);
    Explanation linear = explain(plant, data_, guess, settings);
    const Explanation from_nothing = explain(plant, data_, parent.as_guess(), settings);
    return !linear.usable || (from_nothing.usable && from_nothing.log_posterior > linear.log_posterior) ? from_nothing : linear;
  }

  // The last law with its knots where the data are by now, and settled.
  void settle_law(Explanation& explanation) const {
    for (int pass = 0; pass < 2; ++pass) {
      const plant::EffectId law{explanation.system().effects().size() - 1};
      const LawCandidate moved = where_the_data_are(explanation, law);
      if (moved.weights.size() == 0) return;
      plant::Plant plant = plant::carried_into(nominal_, nominal_.shared_system());
      for (const plant::EffectId e : names_of(explanation)) plant = with_effect(plant, e);
      std::vector<plant::Law> laws;
      Guess guess = explanation.as_guess();
      for (std::size_t e = system_.effects().size(); e < law.index; ++e)
        laws.push_back(explanation.system().laws()[*explanation.system().effects()[plant::EffectId{e}].law]);
      laws.push_back(moved.law);
      laws.back().name = std::string(explanation.system().effects()[law].name);
      plant = plant::with_laws_on(plant, laws);
      const auto& parameters = plant.system().effects()[law].parameters;
      for (Eigen::Index j = 0; j < moved.weights.size(); ++j)
        guess.values[plant.system().parameters()[parameters[static_cast<std::size_t>(j) + 1]].key()] = moved.weights(j);
      const Explanation again = explain(plant, data_, guess, settings_.fit);
      if (!again.usable || again.log_evidence < explanation.log_evidence + (pass == 0 ? 0.0 : 3.0)) return;
      explanation = again;
    }
  }

  // The winner is what stands; where its names are not those that were accepted so far, the rounds tell its story.
  void take(Search& result, const Bent& winner) const {
    if (winner.names != names_of(result.best)) {
      Round round = result.rounds.front();
      round.before = result.core;
      round.accepted = !winner.names.empty();
      const auto named = std::find_if(round.candidates.begin(), round.candidates.end(),
                                      [&](const Candidate& c) { return winner.names == std::vector<plant::EffectId>{c.effect}; });
      if (named != round.candidates.end()) {
        std::rotate(round.candidates.begin(), named, named + 1);
        round.gain = 2.0 * (round.candidates.front().explanation.log_posterior - result.core.log_posterior);
        round.chance = family_wise_probability(round.scores, round.gain, settings_.seed);
      }
      result.rounds = {std::move(round)};
    }
    result.best = winner.explanation;
  }

  struct Pair {
    const Score *one, *other;
    double statistic;         // joint
    double phi, other_phi;    // from where each is tried, as begin_with takes it
    bool from_given = false;  // and all else as in the plant as given
  };
  // Those that promise most by their joint score.
  std::vector<Pair> promising(const Round& first) const {
    std::map<std::pair<plant::EffectId, plant::EffectId>, Pair> best;
    const auto& all = first.scores.all;
    for (std::size_t i = 0; i < all.size(); ++i)
      for (std::size_t j = i + 1; j < all.size(); ++j) {
        if (all[i].effect == all[j].effect || all[i].column.size() == 0 || all[j].column.size() == 0) continue;
        const JointScore found = joint(all[i], all[j]);
        auto& kept = best.try_emplace({all[i].effect, all[j].effect}, Pair{&all[i], &all[j], 0.0, 0.0, 0.0}).first->second;
        if (found.statistic > kept.statistic)
          kept = {&all[i], &all[j], found.statistic, all[i].phi_of_root * found.root, all[j].phi_of_root * found.other_root};
      }
    std::vector<Pair> pairs;
    for (const auto& [effects, pair] : best)
      if (pair.statistic > 0.0) pairs.push_back(pair);
    std::stable_sort(pairs.begin(), pairs.end(), [](const Pair& a, const Pair& b) { return a.statistic > b.statistic; });
    if (pairs.size() > settings_.pairs) pairs.resize(settings_.pairs);
    return pairs;
  }

  double typical_phi(plant::EffectId effect) const {
    const auto& declared = system_.parameters()[system_.effects()[effect].strength].declaration;
    return (declared.typical - declared.null_value.value_or(0.0)) * declared.unit.internal_per_unit;
  }

  // An effect, and one that acts on what it brings, of which no score says anything before: a layer round a junction. Alone the one that
  // brings it may look poor. `scores` are those of the second.
  std::vector<Pair> brought(const Search& result, std::vector<Score>& scores) const {
    const Round& first = result.rounds.front();
    std::vector<std::pair<const Score*, plant::EffectId>> found;
    for (const std::size_t s : first.scores.best) {
      const Score& score = first.scores.all[s];
      for (const plant::EffectId e : addable(with_effect(result.core.problem->centres(), score.effect), settings_.without))
        if (system_.effects()[e].needs == score.effect) found.emplace_back(&score, e);
    }
    scores.resize(found.size());
    std::vector<Pair> pairs;
    for (std::size_t i = 0; i < found.size(); ++i) {
      scores[i].effect = found[i].second;
      pairs.push_back({found[i].first, &scores[i], 0.0, typical_phi(found[i].first->effect), typical_phi(found[i].second), true});
    }
    return pairs;
  }

  void try_pairs(Search& result) const {
    const Round& first = result.rounds.front();
    std::vector<Pair> pairs = promising(first);
    std::vector<Score> of_brought;
    for (const Pair& one : brought(result, of_brought)) pairs.push_back(one);
    std::vector<Explanation> tried(pairs.size());
    const ExplanationSettings shortly = for_a_short_while();
    std::atomic<std::size_t> done{0};
    sim::in_parallel(pairs.size(), settings_.threads, [&](std::size_t i) {
      Guess guess = pairs[i].from_given ? Guess{} : result.core.as_guess();
      begin_with(guess, system_, *pairs[i].one, pairs[i].phi);
      begin_with(guess, system_, *pairs[i].other, pairs[i].other_phi);
      tried[i] = explain(with_effect(with_effect(result.core.problem->centres(), pairs[i].one->effect), pairs[i].other->effect), data_,
                         guess, shortly);
      tell(0.8 + 0.1 * static_cast<double>(++done) / static_cast<double>(pairs.size()), "trying pairs of effects");
    });
    std::vector<std::size_t> order(pairs.size());
    std::iota(order.begin(), order.end(), std::size_t{0});
    std::erase_if(order, [&](std::size_t i) { return !tried[i].usable; });
    std::stable_sort(order.begin(), order.end(),
                     [&](std::size_t a, std::size_t b) { return tried[a].log_evidence > tried[b].log_evidence; });
    if (order.size() > 3) order.resize(3);
    sim::in_parallel(order.size(), settings_.threads, [&](std::size_t n) {
      Explanation& explanation = tried[order[n]];
      try_from(explanation.as_guess(), explanation);
    });
    std::stable_sort(order.begin(), order.end(),
                     [&](std::size_t a, std::size_t b) { return tried[a].log_evidence > tried[b].log_evidence; });
    if (order.empty() || tried[order.front()].log_evidence < result.best.log_evidence + 0.5 * settings_.least_gain) return;
    // Told as two rounds: the one of the two that does more alone, then both.
    const Explanation both = tried[order.front()];
    const Pair& pair = pairs[order.front()];
    std::array<Explanation, 2> alone;
    sim::in_parallel(2, settings_.threads, [&](std::size_t i) { alone[i] = reduced(both, (i == 0 ? pair.other : pair.one)->effect); });
    const std::size_t stronger = alone[1].usable && (!alone[0].usable || alone[1].log_posterior > alone[0].log_posterior) ? 1 : 0;
    if (!alone[stronger].usable) return;
    const Score &leading = stronger == 0 ? *pair.one : *pair.other, &following = stronger == 0 ? *pair.other : *pair.one;
    Search other;
    other.core = result.core;
    const auto accept = [&](const Explanation& before, const Score& score, const Explanation& with, const Scores& scores) {
      Round round;
      round.before = before;
      round.scores = scores;
      round.candidates.push_back({score.effect, score, with});
      round.gain = 2.0 * (with.log_posterior - before.log_posterior);
      round.chance = family_wise_probability(round.scores, round.gain, settings_.seed);
      round.accepted = true;
      other.rounds.push_back(std::move(round));
    };
    accept(result.core, leading, alone[stronger], first.scores);
    for (const Candidate& candidate : first.candidates)
      if (candidate.effect != leading.effect) other.rounds.front().candidates.push_back(candidate);
    accept(alone[stronger], following, both, score(alone[stronger], candidates_at(alone[stronger]), settings_.threads));
    for (const Round& round : other.rounds)
      if (round.gain < settings_.least_gain || round.chance > settings_.most_chance) return;
    other.best = both;
    go_on(other);
    result = std::move(other);
  }

  // The plant without an effect, and without what needs it.
  static plant::Plant plant_without(const Explanation& from, plant::EffectId effect) {
    plant::Plant without = from.problem->centres();
    without.turn(effect, false);
    const auto& effects = from.system().effects();
    for (const plant::EffectId e : effects.ids())
      if (effects[e].needs == effect) without.turn(e, false);
    return without;
  }

  Explanation reduced(const Explanation& from, plant::EffectId effect) const {
    const plant::Plant without = plant_without(from, effect);
    Guess guess = from.as_guess();
    const ForcingSize usual = forcing_to_begin_with(system_);
    for (const plant::EntryGroupId g : usual.ids()) guess.forcing[g] = std::max(guess.forcing[g], 0.3 * usual[g]);
    return explain(without, data_, guess, settings_.fit);
  }

  // The round that accepted an effect tells of what took its place.
  void tell_instead(Search& result, plant::EffectId effect, const Candidate& taken, double gain) const {
    for (Round& round : result.rounds) {
      std::vector<Candidate>& candidates = round.candidates;
      if (!round.accepted || candidates.front().effect != effect) continue;
      const auto there =
          std::find_if(candidates.begin(), candidates.end(), [&](const Candidate& candidate) { return candidate.effect == taken.effect; });
      if (there == candidates.end())
        candidates.insert(candidates.begin(), taken);
      else
        std::rotate(candidates.begin(), there, there + 1);
      round.gain = gain;
      round.chance = family_wise_probability(round.scores, gain, settings_.seed);
    }
  }

  // What stands instead of an effect, what came next to it when it was chosen, and the other forms of it, each from where the winner ended,
  // too. An effect that is chosen while another is still missing may do a part of that one's work, better than the true one could alone.
  void settle_alike(std::vector<Candidate>& others, plant::EffectId effect, const Search& result) const {
    const Explanation& winner = result.best;
    const std::vector<plant::EffectId> allowed = candidates_at(winner);
    const auto add = [&](plant::EffectId e) {
      const auto is_it = [&](const Candidate& candidate) { return candidate.effect == e; };
      if (contains_all(allowed, {e}) && std::none_of(others.begin(), others.end(), is_it)) others.push_back({e, {}, {}});
    };
    for (const plant::EffectId e : allowed)
      if (plant::family_of(system_.effects(), e) == plant::family_of(system_.effects(), effect)) add(e);
    for (const Round& round : result.rounds)
      if (round.accepted && round.candidates.front().effect == effect)
        for (std::size_t i = 1; i < std::min<std::size_t>(round.candidates.size(), 3); ++i) add(round.candidates[i].effect);
    sim::in_parallel(others.size(), settings_.threads, [&](std::size_t i) {
      const plant::EffectId e = others[i].effect;
      if (e == effect) return;
      const plant::Plant instead = plant_without(winner, effect);
      Guess guess = winner.as_guess();
      const plant::ParameterId strength = system_.effects()[e].strength;
      const auto& declared = system_.parameters()[strength].declaration;
      if (declared.kind != plant::Kind::toggle)
        guess.values[system_.parameters()[strength].key()] = declared.typical * declared.unit.internal_per_unit;
      const ForcingSize usual = forcing_to_begin_with(system_);
      for (const plant::EntryGroupId g : usual.ids()) guess.forcing[g] = std::max(guess.forcing[g], 0.1 * usual[g]);
      const Explanation again = explain(with_effect(instead, e), data_, guess, settings_.fit);
      Explanation& standing = others[i].explanation;
      if (again.usable && (!standing.usable || again.log_evidence > standing.log_evidence)) standing = again;
    });
    std::erase_if(others, [](const Candidate& candidate) { return !candidate.explanation.usable; });
    std::stable_sort(others.begin(), others.end(), better);
  }

  static constexpr int most_weighings = 3;
  // What fits instead of each effect. Of one alone the first round knows; of several, or beside parts that are not alike, each is taken out
  // again, and the best of the others put in its place.
  std::vector<Instead> weigh(Search& result) const {
    std::vector<Instead> instead;
    const double before = log_odds(result.best);
    const auto mine = [&] { return names_of(result.best); };
    if (has_laws(result.best)) {
      // Of those with laws, the best that has another name in its place, or none.
      for (const plant::EffectId e : mine())
        for (const Bent& other : result.bent)
          for (const plant::EffectId rival : other.names) {
            auto& rivals = result.rivals[e];
            const auto is_it = [&](const auto& r) { return r.first == rival; };
            if (contains_all(mine(), {rival}) || contains_all(other.names, {e}) || std::any_of(rivals.begin(), rivals.end(), is_it))
              continue;
            rivals.emplace_back(rival, std::max(0.0, result.bent.front().log_odds - other.log_odds));
          }
    } else if (mine().size() == 1 && !is_apart(result.best)) {
      for (const Candidate& candidate : result.rounds.front().candidates)
        if (candidate.effect != mine()[0] && candidate.explanation.usable) {
          result.rivals[mine()[0]].emplace_back(candidate.effect, result.best.log_evidence - candidate.explanation.log_evidence);
          instead.push_back({mine()[0], candidate.effect, candidate.explanation});
        }
    } else {
      // What is taken out or exchanged changes what the others gain, and what fits in their place; at last nothing is any more.
      bool changed = true;
      for (int pass = 0; changed && pass < most_weighings; ++pass) {
        changed = false;
        const bool may_change = pass + 1 < most_weighings;
        result.rivals.clear();
        instead.clear();
        for (const plant::EffectId e : mine()) {
          if (!contains_all(mine(), {e})) continue;  // gone with another, which it needs
          const Explanation less = reduced(result.best, e);
          if (!less.usable) continue;
          if (may_change && log_odds(less) > log_odds(result.best)) {
            result.best = less;
            changed = true;
            continue;
          }
          std::vector<Candidate> others =
              fitted(less, score(less, candidates_at(less), settings_.threads), 3, 0.9, 0.97, "weighing rivals");
          settle_alike(others, e, result);
          plant::EffectId kept = e;
          const double with_it = log_odds(result.best);
          if (may_change && !others.empty() && others.front().explanation.usable && log_odds(others.front().explanation) > with_it + 1.0) {
            result.best = others.front().explanation;
            kept = others.front().effect;
            changed = true;
            if (kept != e) {
              result.rivals[kept].emplace_back(e, log_odds(result.best) - with_it);
              tell_instead(result, e, others.front(), 2.0 * (result.best.log_posterior - less.log_posterior));
            }
          }
          for (const Candidate& candidate : others)
            if (candidate.effect != kept && candidate.effect != e && candidate.explanation.usable) {
              result.rivals[kept].emplace_back(candidate.effect, log_odds(result.best) - log_odds(candidate.explanation));
              instead.push_back({kept, candidate.effect, candidate.explanation});
            }
        }
      }
      if (is_apart(result.best)) result.apart_log_odds += log_odds(result.best) - before;
    }
    sort(result.rivals);
    return instead;
  }

  using Rivals = decltype(Search::rivals);
  static void sort(Rivals& rivals) {
    for (auto& [effect, others] : rivals)
      std::stable_sort(others.begin(), others.end(), [](const auto& a, const auto& b) { return a.second < b.second; });
  }

  const plant::Plant& nominal_;
  const plant::System& system_;
  const std::vector<FitData>& data_;
  const SearchSettings& settings_;
};

}  // namespace

Guess guess_with(const Explanation& at, const Score& score) {
  Guess guess = at.as_guess();
  const auto& declared = at.system().parameters()[at.system().effects()[score.effect].strength].declaration;
  begin_with(guess, at.system(), score, score.strength - declared.null_value.value_or(0.0) * declared.unit.internal_per_unit);
  return guess;
}

namespace {

// A quantity as EffectInfo::argument has it: a variable's name without the part that the entry is of, or with "other" for another part's.
std::string argument_of(const plant::System& system, const plant::Law& law) {
  std::string name = system.variables()[law.argument.front()].name;
  for (const plant::Entry& entry : system.entries()) {
    if (entry.group != law.entry) continue;
    for (const plant::Entry& other : system.entries())
      if (const std::string end = " " + other.part; !other.part.empty() && name.ends_with(end)) {
        name = (other.part == entry.part ? "" : "other ") + name.substr(0, name.size() - end.size());
        break;
      }
    break;
  }
  return (law.fading_memory_s > 0.0 ? "memory of " : "") + name;
}

}  // namespace

bool has_family(const plant::System& system, const std::vector<plant::EffectId>& all, plant::EffectId one) {
  return std::any_of(all.begin(), all.end(),
                     [&](plant::EffectId e) { return plant::family_of(system.effects(), e) == plant::family_of(system.effects(), one); });
}

std::string_view place_of(const plant::System& system, const plant::Law& law) {
  const auto& places = system.entry_groups()[law.entry].places;
  const auto of_inputs = [&](const std::vector<plant::VariableId>& of) { return !of.empty() && system.variables()[of.front()].of_inputs; };
  return places[places.size() > 1 && (of_inputs(law.argument) || of_inputs(law.factor)) ? 1 : 0];
}

bool is_own(const plant::System& system, const std::vector<plant::EffectId>& names, const plant::Law& law) {
  return std::any_of(names.begin(), names.end(), [&](plant::EffectId e) {
    const plant::EffectInfo& effect = system.effects()[e];
    return effect.place == place_of(system, law) && effect.argument == argument_of(system, law);
  });
}

double as_good_as_nothing(const Explanation& core, const SearchSettings& settings) {
  return std::max(settings.visible_process_noise, settings.nothing_left_share * core.process_noise);
}

const Round& round_from(const Search& search, const Explanation& at) {
  const std::vector<plant::EffectId> effects = at.effects();
  const auto begins_within = [&](const Round& round) {
    const std::vector<plant::EffectId> before = round.before.effects();
    return std::all_of(before.begin(), before.end(), [&](plant::EffectId e) { return contains(effects, e); });
  };
  const auto last = std::find_if(search.rounds.rbegin(), search.rounds.rend(), begins_within);
  return last == search.rounds.rend() ? search.rounds.front() : *last;
}

bool nothing_left(const Search& search, const SearchSettings& settings) {
  return search.best.process_noise < as_good_as_nothing(search.core, settings);
}

Search search(const plant::Plant& nominal, const std::vector<FitData>& data, const SearchSettings& settings) {
  return Searcher(nominal, data, settings).run();
}

}  // namespace sinew::diagnose

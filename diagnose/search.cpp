// SPDX-License-Identifier: Apache-2.0
#include "diagnose/search.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <numeric>
#include <stdexcept>

#include "diagnose/calibrate.h"
#include "diagnose/proposals.h"
#include "sim/parallel.h"

namespace sinew::diagnose {
namespace {

// Where the fit of one more effect begins: with the shape that scored best and the strength that the score says, `phi`
// from its null in internal units, within reason.
void begin_with(Guess& guess, const plant::System& system, const Score& score, double phi) {
  if (!score.blind)
    for (const auto& [key, value] : score.shape) guess.values[key] = value;
  const plant::ParameterId strength = system.effects()[score.effect].strength;
  const auto& declared = system.parameters()[strength].declaration;
  if (declared.kind == plant::Kind::toggle) return;
  const double unit = declared.unit.internal_per_unit;
  const double null = *declared.null_value * unit, typical = declared.typical * unit - null;
  const double most = 2.0 * std::abs(typical), least = 0.1 * std::abs(typical);
  double step = score.blind ? typical : phi;
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
    if (result.core.usable) settle(result.core);
    if (!result.core.usable) throw std::runtime_error("the plant cannot be integrated over the recordings; is it near this one?");
    result.best = result.core;
    Round first = one_round(result.core, 0, 0.0);
    result.core = first.before;
    if (first.accepted) settle(first.candidates.front().explanation);
    result.best = first.accepted ? first.candidates.front().explanation : first.before;
    result.rounds.push_back(std::move(first));
    if (result.rounds.front().accepted) go_on(result);
    if (settings_.most_effects >= 1 && !nothing_left(result, settings_)) try_afresh(result);
    if (settings_.most_effects >= 2 && !nothing_left(result, settings_) && !result.rounds.front().candidates.empty()) try_pairs(result);
    // Rivals matter where there is an answer.
    if (nothing_left(result, settings_) || share_explained(result.core, result.best) > 0.9) weigh(result);
    tell(1.0, "done");
    return result;
  }

 private:
  void tell(double share, const std::string& doing) const {
    if (settings_.progress) settings_.progress(share, doing);
  }

  // Fits it once more from there; the likelier of the two stays.
  void try_from(const Guess& guess, Explanation& explanation) const {
    const Explanation again = explain(explanation.problem->centres(), data_, guess, settings_.fit);
    if (again.usable && again.log_posterior > explanation.log_posterior) explanation = again;
  }

  // Where much is left a fit may have stuck: held by the large forcings that it began with; by the core's parameters,
  // which went far without the effects; or by forcings that follow the recording whatever the effect does. Once more
  // with small ones, from other first values, from the effects alone, from the whole path's least
  // squares.
  void settle(Explanation& explanation) const {
    if (explanation.unrest <= settings_.settled_unrest) return;
    const ForcingSize small = small_forcing(system_);
    Guess same = explanation.as_guess(), effects;
    same.forcing = small;
    for (const Unknown& unknown : explanation.problem->unknowns())
      if (unknown.parameter && system_.parameters()[*unknown.parameter].effect) effects.values[unknown.name] = same.values[unknown.name];
    try_from(same, explanation);
    if (explanation.unrest <= settings_.settled_unrest) return;
    for (Guess& begun : with_other_starts(explanation)) {
      begun.forcing = small;
      try_from(begun, explanation);
    }
    if (effects.values.empty() || explanation.unrest <= settings_.settled_unrest) return;
    try_from(effects, explanation);
    if (explanation.unrest <= settings_.settled_unrest) return;
    Guess path = polished(explanation, data_, settings_.fit).of.as_guess();
    path.forcing = small;
    try_from(path, explanation);
  }

  // What two effects hardly begin to account for is not in the catalogue: a third would only bend the fit.
  static bool hopeless(const Search& result) { return result.rounds.size() >= 2 && share_explained(result.core, result.best) < 0.5; }

  void go_on(Search& result) const {
    while (result.best.effects().size() < settings_.most_effects + base_count() && !hopeless(result)) {
      Round round = one_round(result.best, result.rounds.size(), result.rounds.front().gain);
      const bool accepted = round.accepted;
      if (accepted) settle(round.candidates.front().explanation);
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
    ExplanationSettings shortly = settings_.fit;
    shortly.most_rounds = 2;
    shortly.enough = 1.0;
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

  std::vector<Candidate> fitted(const Explanation& at, const Scores& scores, std::size_t most, double from, double to,
                                const std::string& doing) const {
    std::vector<Candidate> candidates;
    for (const std::size_t s : scores.best) {
      const Score& score = scores.all[s];
      if (score.blind || (candidates.size() < most && (score.statistic >= 4.0 || candidates.empty())))
        candidates.push_back({score.effect, score, {}});
    }
    // All for a short while, then those that are still in the running.
    ExplanationSettings shortly = settings_.fit;
    shortly.most_rounds = 2;
    shortly.iterations_per_round = 4;
    shortly.enough = 1.0;
    std::atomic<std::size_t> done{0};
    sim::in_parallel(candidates.size(), settings_.threads, [&](std::size_t i) {
      candidates[i].explanation = with_added(at, candidates[i].score, guess_with(at, candidates[i].score), shortly);
      if (candidates[i].score.blind) {  // from a weaker one too
        Guess weaker = guess_with(at, candidates[i].score);
        const plant::ParameterId strength = system_.effects()[candidates[i].effect].strength;
        const auto& declared = system_.parameters()[strength].declaration;
        double& value = weaker.values[system_.parameters()[strength].key()];
        value =
            *declared.null_value * declared.unit.internal_per_unit + 0.3 * (value - *declared.null_value * declared.unit.internal_per_unit);
        const Explanation other = with_added(at, candidates[i].score, weaker, shortly);
        if (other.usable && (!candidates[i].explanation.usable || other.log_posterior > candidates[i].explanation.log_posterior))
          candidates[i].explanation = other;
      }
      tell(from + 0.7 * (to - from) * static_cast<double>(++done) / static_cast<double>(candidates.size()), doing);
    });
    std::stable_sort(candidates.begin(), candidates.end(), better);
    const double best = candidates.empty() ? 0.0 : candidates.front().explanation.log_evidence;
    const double margin = std::max(15.0, 0.1 * (best - at.log_evidence));
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
    if (before.unrest < settings_.settled_unrest && largest < 0.6 * settings_.least_gain) return round;
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
    ExplanationSettings shortly = settings_.fit;
    shortly.most_rounds = 2;
    shortly.enough = 1.0;
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
    settle(candidates.front().explanation);
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

  // Pairs that promise most by their joint score, and the best alone with each effect that the score is blind for.
  struct Pair {
    const Score *one, *other;
    double statistic, root, other_root;
  };
  std::vector<Pair> promising(const Round& first) const {
    std::map<std::pair<plant::EffectId, plant::EffectId>, Pair> best;
    const auto& all = first.scores.all;
    for (std::size_t i = 0; i < all.size(); ++i)
      for (std::size_t j = i + 1; j < all.size(); ++j) {
        if (all[i].effect == all[j].effect || all[i].blind || all[j].blind || all[i].column.size() == 0 || all[j].column.size() == 0)
          continue;
        const JointScore found = joint(all[i], all[j]);
        auto& kept = best.try_emplace({all[i].effect, all[j].effect}, Pair{&all[i], &all[j], 0.0, 0.0, 0.0}).first->second;
        if (found.statistic > kept.statistic) kept = {&all[i], &all[j], found.statistic, found.root, found.other_root};
      }
    std::vector<Pair> pairs;
    for (const auto& [effects, pair] : best)
      if (pair.statistic > 0.0) pairs.push_back(pair);
    std::stable_sort(pairs.begin(), pairs.end(), [](const Pair& a, const Pair& b) { return a.statistic > b.statistic; });
    if (pairs.size() > settings_.pairs) pairs.resize(settings_.pairs);
    for (const std::size_t s : first.scores.best) {
      const Score& blind = first.scores.all[s];
      if (!blind.blind) continue;
      std::size_t partners = 0;
      for (const Candidate& candidate : first.candidates)
        if (candidate.explanation.usable && candidate.effect != blind.effect && !candidate.score.blind && partners++ < 2)
          pairs.push_back({&candidate.score, &blind, 0.0, candidate.score.root, 0.0});
    }
    return pairs;
  }

  void try_pairs(Search& result) const {
    const Round& first = result.rounds.front();
    const std::vector<Pair> pairs = promising(first);
    std::vector<Explanation> tried(pairs.size());
    ExplanationSettings shortly = settings_.fit;
    shortly.most_rounds = 2;
    shortly.enough = 1.0;
    std::atomic<std::size_t> done{0};
    sim::in_parallel(pairs.size(), settings_.threads, [&](std::size_t i) {
      Guess guess = result.core.as_guess();
      begin_with(guess, system_, *pairs[i].one, pairs[i].one->phi_of_root * pairs[i].root);
      begin_with(guess, system_, *pairs[i].other, pairs[i].other->phi_of_root * pairs[i].other_root);
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

  Explanation reduced(const Explanation& from, plant::EffectId effect) const {
    plant::Plant without = from.problem->centres();
    without.turn(effect, false);
    Guess guess = from.as_guess();
    const ForcingSize usual = forcing_to_begin_with(system_);
    for (const plant::EntryGroupId g : usual.ids()) guess.forcing[g] = std::max(guess.forcing[g], 0.3 * usual[g]);
    return explain(without, data_, guess, settings_.fit);
  }

  // What fits instead of each effect. Of one alone the first round knows; of several each is taken out again, and the
  // best of the others put in its place.
  void weigh(Search& result) const {
    const std::vector<plant::EffectId> base = result.core.effects();
    const auto mine = [&] {
      std::vector<plant::EffectId> added;
      for (const plant::EffectId e : result.best.effects())
        if (std::find(base.begin(), base.end(), e) == base.end()) added.push_back(e);
      return added;
    };
    if (mine().size() == 1) {
      for (const Candidate& candidate : result.rounds.front().candidates)
        if (candidate.effect != mine()[0] && candidate.explanation.usable)
          result.rivals[mine()[0]].emplace_back(candidate.effect, result.best.log_evidence - candidate.explanation.log_evidence);
    } else {
      for (const plant::EffectId e : mine()) {
        const Explanation less = reduced(result.best, e);
        if (!less.usable) continue;
        if (less.log_evidence > result.best.log_evidence) {
          result.best = less;
          continue;
        }
        const std::vector<Candidate> others =
            fitted(less, score(less, candidates_at(less), settings_.threads), 3, 0.9, 0.97, "weighing rivals");
        plant::EffectId kept = e;
        const double with_it = result.best.log_evidence;
        if (!others.empty() && others.front().explanation.usable && others.front().explanation.log_evidence > with_it + 1.0) {
          result.best = others.front().explanation;
          kept = others.front().effect;
          if (kept != e) result.rivals[kept].emplace_back(e, result.best.log_evidence - with_it);
        }
        for (const Candidate& candidate : others)
          if (candidate.effect != kept && candidate.effect != e && candidate.explanation.usable)
            result.rivals[kept].emplace_back(candidate.effect, result.best.log_evidence - candidate.explanation.log_evidence);
      }
    }
    for (auto& [effect, others] : result.rivals)
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

double as_good_as_nothing(const Explanation& core, const SearchSettings& settings) {
  return std::max(settings.visible_unrest, settings.nothing_left_share * core.unrest);
}

bool nothing_left(const Search& search, const SearchSettings& settings) {
  return search.best.unrest < as_good_as_nothing(search.core, settings);
}

Search search(const plant::Plant& nominal, const std::vector<FitData>& data, const SearchSettings& settings) {
  return Searcher(nominal, data, settings).run();
}

}  // namespace sinew::diagnose

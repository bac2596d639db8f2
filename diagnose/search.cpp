#include "diagnose/search.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <stdexcept>

#include "diagnose/calibrate.h"

namespace sinew::diagnose {
namespace {

// Where the fit of one more effect begins: all else as it is, the effect with the shape that scored best and the strength that
// the score says, within reason.
Guess guess_with(const Explanation& at, const Score& score) {
  Guess guess = at.as_guess();
  if (!score.blind)
    for (const auto& [key, value] : score.shape) guess.values[key] = value;
  const std::size_t strength = plant::effects()[score.effect].strength;
  const auto& declared = plant::parameters()[strength].declaration;
  if (declared.kind != plant::Kind::toggle) {
    const double unit = declared.unit.internal_per_unit;
    const double null = *declared.null_value * unit, typical = declared.typical * unit - null;
    double step = score.blind ? typical : score.strength - null;
    const double most = 2.0 * std::abs(typical), least = 0.1 * std::abs(typical);
    if (std::abs(step) < least) step = score.statistic > 0.0 && step != 0.0 ? std::copysign(least, step) : 0.1 * typical;
    guess.values[plant::parameters()[strength].key()] = null + std::clamp(step, -most, most);
  }
  return guess;
}

Explanation with_added(const Explanation& at, const Score& score, const Guess& guess, const ExplanationSettings& settings) {
  return explain(with_effect(at.problem->centres(), score.effect), at.problem->data(), guess, settings);
}

bool better(const Candidate& a, const Candidate& b) {
  if (a.explanation.usable != b.explanation.usable) return a.explanation.usable;
  return a.explanation.log_evidence > b.explanation.log_evidence;
}

class Searcher {
 public:
  Searcher(const plant::Limb<double>& nominal, const std::vector<FitData>& data, const SearchSettings& settings)
      : nominal_(nominal), data_(data), settings_(settings) {}

  Search run() {
    Search result;
    tell(0.02, "calibrating the core");
    result.core = explain(nominal_, data_, settings_.guess, settings_.fit);
    // Large forcings at the start can hold the fit where it is: once more from there with small ones.
    if (result.core.usable && result.core.unrest > settings_.settled_unrest) {
      Guess again = result.core.as_guess();
      again.forcing = {0.3, 0.02, 2e-3, 2e-5, 0.02, 4e-4};
      const Explanation second = explain(nominal_, data_, again, settings_.fit);
      if (second.usable && second.log_posterior > result.core.log_posterior) result.core = second;
    }
    if (!result.core.usable) throw std::runtime_error("the plant cannot be integrated over the recordings; is it near this limb?");
    result.best = result.core;
    while (result.best.effects().size() < settings_.most_effects + base_count()) {
      Round round = one_round(result.best, result.rounds.size(), result.rounds.empty() ? 0.0 : result.rounds.front().gain);
      if (result.rounds.empty()) result.core = round.before;
      const bool accepted = round.accepted;
      result.best = accepted ? round.candidates.front().explanation : round.before;
      result.rounds.push_back(std::move(round));
      if (!accepted) break;
      // What two effects hardly begin to account for is not in the catalogue: a third would only bend the fit.
      if (result.rounds.size() >= 2 && left(result) > 0.5) break;
    }
    // Rivals matter where there is an answer.
    if (result.best.unrest < 150.0 || left(result) < 0.1) weigh(result);
    tell(1.0, "done");
    return result;
  }

 private:
  void tell(double share, const std::string& doing) const {
    if (settings_.progress) settings_.progress(share, doing);
  }

  // Share of the core's misfit that the best explanation leaves.
  static double left(const Search& result) {
    return result.core.misfit > 0.0 ? std::max(0.0, result.best.misfit) / result.core.misfit : 0.0;
  }

  std::size_t base_count() const {
    return static_cast<std::size_t>(std::count(nominal_.on.begin(), nominal_.on.end(), true));
  }

  std::vector<std::size_t> candidates_at(const Explanation& at) const {
    const std::vector<std::size_t> on = at.effects();
    std::vector<std::size_t> candidates;
    for (std::size_t e = 0; e < plant::effect_count; ++e)
      if (std::find(on.begin(), on.end(), e) == on.end() &&
          std::find(settings_.without.begin(), settings_.without.end(), e) == settings_.without.end())
        candidates.push_back(e);
    return candidates;
  }

  // Where the best candidate ended, everything else is nearer to the truth than where all began: the effects that look most
  // like it are tried from there, so that a twin does not win because the other's fit got stuck.
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
    in_parallel(again.size(), settings_.threads, [&](std::size_t i) {
      const Score& score = scores.all[alike[i].second];
      again[i] = {score.effect, score, {}};
      Guess guess = guess_with(before, score);
      for (const auto& [name, value] : winner.explanation.as_guess().values)
        if (const auto mine = guess.values.find(name); mine != guess.values.end()) mine->second = value;
      for (std::size_t q = 0; q < forcing_count; ++q) guess.forcing[q] = std::max(winner.explanation.forcing[q], 0.1 * Guess{}.forcing[q]);
      again[i].explanation = with_added(before, score, guess, shortly);
      if (again[i].explanation.usable && again[i].explanation.log_evidence > winner.explanation.log_evidence - 30.0)
        again[i].explanation = with_added(before, score, again[i].explanation.as_guess(), settings_.fit);
    });
    for (const Candidate& one : again) {
      if (!one.explanation.usable) continue;
      const auto there = std::find_if(candidates.begin(), candidates.end(), [&](const Candidate& c) { return c.effect == one.effect; });
      if (there == candidates.end())
        candidates.push_back(one);
      else if (better(one, *there))
        *there = one;
    }
    std::stable_sort(candidates.begin(), candidates.end(), better);
  }

  std::vector<Candidate> fitted(const Explanation& at, const Scores& scores, std::size_t most, double from, double to,
                                const std::string& doing) const {
    std::vector<Candidate> candidates;
    for (const std::size_t s : scores.best) {
      const Score& score = scores.all[s];
      if ((score.blind && at.unrest > settings_.settled_unrest) || (candidates.size() < most && (score.statistic >= 4.0 || candidates.empty())))
        candidates.push_back({score.effect, score, {}});
    }
    // All for a short while, then those that are still in the running.
    ExplanationSettings shortly = settings_.fit;
    shortly.most_rounds = 2;
    shortly.iterations_per_round = 4;
    shortly.enough = 1.0;
    std::atomic<std::size_t> done{0};
    in_parallel(candidates.size(), settings_.threads, [&](std::size_t i) {
      candidates[i].explanation = with_added(at, candidates[i].score, guess_with(at, candidates[i].score), shortly);
      if (candidates[i].score.blind) {  // from a weaker one too
        Guess weaker = guess_with(at, candidates[i].score);
        const std::size_t strength = plant::effects()[candidates[i].effect].strength;
        const auto& declared = plant::parameters()[strength].declaration;
        double& value = weaker.values[plant::parameters()[strength].key()];
        value = *declared.null_value * declared.unit.internal_per_unit + 0.3 * (value - *declared.null_value * declared.unit.internal_per_unit);
        const Explanation other = with_added(at, candidates[i].score, weaker, shortly);
        if (other.usable && (!candidates[i].explanation.usable || other.log_posterior > candidates[i].explanation.log_posterior))
          candidates[i].explanation = other;
      }
      tell(from + 0.7 * (to - from) * static_cast<double>(++done) / static_cast<double>(candidates.size()), doing);
    });
    std::stable_sort(candidates.begin(), candidates.end(), better);
    const double best = candidates.empty() ? 0.0 : candidates.front().explanation.log_evidence;
    const double margin = std::max(15.0, 0.1 * (best - at.log_evidence));
    in_parallel(candidates.size(), settings_.threads, [&](std::size_t i) {
      Explanation& explanation = candidates[i].explanation;
      if (!explanation.usable || explanation.log_evidence < best - margin) return;
      const Explanation further = explain(explanation.problem->centres(), data_, explanation.as_guess(), settings_.fit);
      if (further.usable && further.log_posterior > explanation.log_posterior) explanation = further;
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
    round.accepted = round.gain >= std::max(settings_.least_gain, settings_.least_share_of_first * first_gain) && round.chance <= settings_.most_chance &&
                     best.log_evidence > round.before.log_evidence;
    return round;
  }

  Explanation reduced(const Explanation& from, std::size_t effect) const {
    plant::Limb<double> limb = from.problem->centres();
    limb.on[effect] = false;
    Guess guess = from.as_guess();
    for (std::size_t q = 0; q < forcing_count; ++q) guess.forcing[q] = std::max(guess.forcing[q], 0.3 * Guess{}.forcing[q]);
    return explain(limb, data_, guess, settings_.fit);
  }

  // What fits instead of each effect. Of one alone the first round knows; of several each is taken out again, and the best
  // of the others put in its place.
  void weigh(Search& result) const {
    const std::vector<std::size_t> base = result.core.effects();
    const auto mine = [&] {
      std::vector<std::size_t> added;
      for (const std::size_t e : result.best.effects())
        if (std::find(base.begin(), base.end(), e) == base.end()) added.push_back(e);
      return added;
    };
    if (mine().size() == 1) {
      for (const Candidate& candidate : result.rounds.front().candidates)
        if (candidate.effect != mine()[0] && candidate.explanation.usable)
          result.rivals[mine()[0]].emplace_back(candidate.effect, result.best.log_evidence - candidate.explanation.log_evidence);
    } else {
      for (const std::size_t e : mine()) {
        const Explanation less = reduced(result.best, e);
        if (!less.usable) continue;
        if (less.log_evidence > result.best.log_evidence) {
          result.best = less;
          continue;
        }
        const std::vector<Candidate> others =
            fitted(less, score(less, candidates_at(less), settings_.threads), 3, 0.9, 0.97, "weighing rivals");
        std::size_t kept = e;
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

  const plant::Limb<double>& nominal_;
  const std::vector<FitData>& data_;
  const SearchSettings& settings_;
};

}  // namespace

Search search(const plant::Limb<double>& nominal, const std::vector<FitData>& data, const SearchSettings& settings) {
  return Searcher(nominal, data, settings).run();
}

}  // namespace sinew::diagnose

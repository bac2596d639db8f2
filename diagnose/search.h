// SPDX-License-Identifier: Apache-2.0
// The search for the effects that are missing: score, refit, compare, accept or stop; then what remains.
//
// Round by round: the score test ranks the catalogue at the best explanation so far; the best few are fitted with everything
// else free; the fit without the effect is repeated from where the fit with it ended, so that a poor optimum does not
// pass for a discovery; the effect with the highest evidence is accepted if its gain would hardly ever come by chance among so
// many. Where effects one by one leave something, pairs are fitted at once: of two that hide each other, neither need be the
// best alone. Once two are in, each is taken out again, and exchanged for its rivals.
#pragma once

#include "diagnose/score.h"
#include "plant/laws.h"

namespace sinew::diagnose {

struct SearchSettings {
  ExplanationSettings fit;
  int threads = 2;
  std::uint64_t seed = 1;
  std::size_t refits = 6;  // candidates of the first round that are fitted; half as many later
  std::size_t most_effects = 3;
  double most_chance = 0.01;  // family-wise probability under which a gain counts
  // A gain in twice the log posterior below this counts as chance whatever the linearised null says: what quantised
  // sensors, corners of the hysteresis and air that is not quite as modelled add. Chosen on seeds of development.
  double least_gain = 24.0;
  // A further effect must gain at least this share of what the first one did: beside a strong effect the linearised noise
  // model is off by as much.
  double least_share_of_first = 0.015;
  double settled_process_noise = 40.0;   // process noise below this is nothing
  double visible_process_noise = 250.0;  // process noise of the core above this is missing physics, whether or not it has a name
  // Beside a strong effect the linearised noise model is off: of the core's process noise, this share is as good as nothing.
  double nothing_left_share = 0.002;
  std::size_t pairs = 8;        // fitted at once, where effects one by one leave something
  std::size_t apart_names = 2;  // that parts may differ beside: the best of the first round
  std::size_t bent_names = 4;   // that laws are added to: the best of the first round
  std::size_t laws = 2;         // of the screening's ranking, and the best at the names' own equation, added to each
  int most_laws = 2;
  double least_explained_share = 0.9;    // of the misfit: less is no answer that has laws, nor a rival that is given one
  std::vector<plant::EffectId> without;  // effects that may not be named
  Guess guess;                           // where the calibration of the core begins
  std::function<void(double done_share, const std::string& doing)> progress;
  // Whether what was not fitted is predicted no worse, beyond chance, by the first, which has laws, than by the second; empty: not asked.
  std::function<bool(const Explanation& with, const Explanation& without)> is_borne_out;
};

struct Candidate {
  plant::EffectId effect;  // the one that was added
  Score score;
  Explanation explanation;  // with it
};

struct Round {
  Explanation before;
  Scores scores;                      // at `before`
  std::vector<Candidate> candidates;  // fitted ones, by falling evidence
  double gain = 0.0;                  // 2 (log posterior of the best - that of `before`)
  double chance = 1.0;                // family-wise probability of such a gain
  bool accepted = false;
};

// Names, or none, with laws beside them (free_laws.h): the same physics in a form of its own, or physics without a name.
struct Bent {
  std::vector<plant::EffectId> names;  // beside what the plant has as given
  Explanation explanation;             // in a System that has the laws, too
  double log_odds = 0.0;               // log evidence plus log prior of the terms
  double gain = 0.0;                   // of log odds, by the last law
};

struct Search {
  Explanation core;           // what the plant explains as it is, calibrated
  std::vector<Round> rounds;  // the last one is the one that found nothing more
  Explanation best;
  // Where names alone leave something: what was tried with laws, by falling log odds. `best` is of a System with laws where one of these is
  // it.
  std::vector<Bent> bent;
  std::size_t cells = 0;  // in which a law was sought
  // Where parts of `best` have values of their own: its log odds against the best in which they are alike, less what each term must gain.
  double apart_log_odds = 0.0;
  // For each effect of `best`: what fits instead of it, with the others kept: effect and loss of evidence, by rising loss.
  std::map<plant::EffectId, std::vector<std::pair<plant::EffectId, double>>> rivals;
};

// Where a fit of one more effect begins: all else as it is, the effect as the score says.
Guess guess_with(const Explanation& at, const Score& score);

// Whether one of these is the effect, or another form of it.
bool has_family(const plant::System& system, const std::vector<plant::EffectId>& all, plant::EffectId one);

// Where a law enters. What depends on an input comes from the inputs' side.
std::string_view place_of(const plant::System& system, const plant::Law& law);

// Whether a law enters where one of these names does, and is of what that is a function of: that name in a form of its own.
bool is_own(const plant::System& system, const std::vector<plant::EffectId>& names, const plant::Law& law);

// The process noise below which an explanation leaves nothing, beside the core's.
double as_good_as_nothing(const Explanation& core, const SearchSettings& settings);

// The last round that began with effects of this explanation and no others: its scores say what else could be there.
const Round& round_from(const Search& search, const Explanation& at);

// Whether the best explanation leaves no more than noise.
bool nothing_left(const Search& search, const SearchSettings& settings);

Search search(const plant::Plant& nominal, const std::vector<FitData>& data, const SearchSettings& settings);

}  // namespace sinew::diagnose

// SPDX-License-Identifier: Apache-2.0
// Proposals: plants with effects added, fitted to whole open-loop simulations, and compared by evidence.
//
// Where noise in the state swallows what is missing, the search by forcings (search.h) sees only how well the next seconds follow
// from the last. This one asks how well a plant follows the recordings from its inputs alone:
//
// - All are fitted to thinned recordings (thinned.h), the answer at last to every sample.
// - One yardstick for all that are compared: each channel's deviation is what the best proposal so far leaves, the same share of what
//   each channel shows (error_size.h), times the square root of the samples over which errors are alike, at first as the plant as given
//   leaves them. It shrinks as proposals improve, the same for every rival. Far from the truth it keeps a fit from buying a little error
//   with absurd parameters.
// - The plant as given is fitted from several starts first: a core that is stuck far off makes that measure useless.
// - A beam: at first every effect, and promising pairs, since of two effects that help only together neither is found alone; then what
//   scores best, beside each of the few best proposals. Many short fits, longer ones for what survives (successive halving).
// - Beside effects, parts may differ: in the transformation temperatures, or in the values of an effect (plant/apart.h).
// - Everyone settled alike: what the winner is compared with is fitted again from the winner's own values without the effect, and with
//   another in its place; and the best proposals from several starts drawn from the prior.
// - log evidence (Laplace) plus the log prior of the terms gives each proposal's probability; an effect's is the sum over the proposals
//   that have it. The likelihood in it is that of as many independent errors as the plant as given leaves at first, of unknown size: a
//   proposal is judged by how small an error it comes down to, not by how far below the yardstick it gets. (With the correlation of what
//   the best leaves, which grows shorter with every term, the physical limb got two laws and a worse prediction.)
// - The answer is what is left of the most probable proposal once every term that does not pay is taken out: one without which seconds
//   that were not fitted are predicted no worse, beyond chance (cross-validation, open_loop.h). An effect of the catalogue may stay, too,
//   where the fit is twenty to one for it and those predictions are not against it; a law may not. A name that pays beside that is added: a
//   plant that drifts away leaves hardly an independent error, so that evidence asks for too much; from then on errors are counted as what
//   stands leaves them.
// - Then laws without a name (free_laws.h), on what has a name and on the plant as given: they compete by the same measure, each at
//   the price of one cell in so many, and must pay against the answer that has none.
//
// Source: MacKay 2003, Information Theory, Inference, and Learning Algorithms, chapter 28; Jamieson, Talwalkar 2016, AISTATS
// (successive halving).
#pragma once

#include "diagnose/open_loop.h"

namespace sinew::diagnose {

struct ProposalSettings {
  std::vector<plant::EffectId> without;  // effects that may not be named
  std::size_t most_effects = 4;
  std::size_t most_apart = 2;  // sharings of which each part may have its own (plant/apart.h)
  std::size_t width = 3;       // proposals that are gone on from
  std::size_t scored = 6;      // effects of the score test's ranking that are added to each
  std::size_t pairs = 6;       // of the joint score test's ranking, fitted at first
  std::size_t exchanged = 3;   // for each term of the best, at the end, beside those that begin far
  std::size_t laws = 4;        // of the screening's ranking (free_laws.h), fitted on each plant that laws are sought for
  int most_laws = 2;           // in one proposal
  int starts = 5;              // of the best proposals, at the end
  std::uint64_t seed = 1;
  int threads = 2;
  std::vector<Explanation> begun{};  // found by other means, without laws
  std::function<void(double done_share, const std::string& doing)> progress{};
};

struct Proposal {
  // That are added: in the catalogue's order, then those by which parts differ, then laws; empty: the plant as given.
  std::vector<plant::EffectId> effects;
  Explanation fit;           // least squares under the yardstick
  double error = 0.0;        // how far off it is, as a share of what the channels show (error_size.h)
  double log_odds = 0.0;     // log evidence plus log prior of the terms
  double probability = 0.0;  // among all that count
  bool counts = true;        // not with laws, where these do not pay
};

struct Proposals {
  std::vector<Proposal> all;                    // that count first, most probable first; the plant as given is among them
  std::size_t answer = 0;                       // of `all`
  Explanation fit;                              // of the answer, to every sample
  std::shared_ptr<const void> kept_alive;       // the thinned recordings that the fits in `all` point to
  std::shared_ptr<const plant::System> system;  // with every law that was tried: effects of `all` are ids of it
  std::size_t cells = 0;                        // in which a law was sought
};

// `core`: the plant as given, fitted. `data`: deviations are the sensors' noise.
Proposals propose(const Fitted& core, const std::vector<FitData>& data, const ProposalSettings& settings, const ExplanationSettings& fit);

// Whether an effect may not be named: under its own name, or under that of which it is a form.
bool is_left_out(const plant::System& system, plant::EffectId effect, const std::vector<plant::EffectId>& without);

// Effects that may be added where these are on: that are off, allowed, and not without what they act on.
std::vector<plant::EffectId> addable(const plant::Plant& plant, const std::vector<plant::EffectId>& without);

}  // namespace sinew::diagnose

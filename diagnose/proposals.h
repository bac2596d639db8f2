// SPDX-License-Identifier: Apache-2.0
// Proposals: plants with terms added, each fitted to the recordings from their inputs alone, and compared by evidence.
//
// A term is an effect of the catalogue or a law without a name (free_laws.h). What a plant leaves is compared with one noise model,
// the same for all proposals:
//
//   V = sensors' noise, times a factor + surroundings that are never quite still + an error of each reading that is correlated in time
//
// The factor and the sizes of the last two are found at the best proposal so far, by maximum likelihood (state_noise.h). Far from the truth
// the correlated error is as large as what is missing, so that no fit buys a little likelihood with absurd values; as proposals improve it
// shrinks, for all alike, and where one reaches the sensors' noise it is gone. What is left of it at the end is how much no proposal
// explains.
//
// - The plant as given is fitted from several starts.
// - A beam: to each of the few best proposals terms are added, those that promise most by one linearised fit each, and at first pairs,
//   since of two terms that help only together neither is found alone. Many short fits, longer ones for what survives (successive halving).
// - Everyone is settled alike: whenever the best changes, it, what it is compared with and the plant as given are fitted again under its
//   noise, the smaller ones also from the best's own values without the term.
// - Terms must bear what comes: the last part of the training recordings, predicted from a fit to the rest, as a density with the
//   uncertainty of everything that was fitted. A law must predict it better than the same plant without it, twenty to one; an effect of
//   the catalogue may not predict it worse by as much.
//
// log odds = log evidence (Laplace) + log prior of the terms. Probabilities are the shares of all proposals.
//
// Source: MacKay 2003, Information Theory, Inference, and Learning Algorithms, chapter 28; Kennedy, O'Hagan 2001, JRSS B 63:425
// (a correlated error beside a model's parameters); Jamieson, Talwalkar 2016, AISTATS (successive halving); Dawid 1984, JRSS A 147:278
// (prediction of what comes next as a measure).
#pragma once

#include "diagnose/open_loop.h"

namespace sinew::diagnose {

struct ProposalSettings {
  std::vector<plant::EffectId> without;  // effects that may not be named
  std::size_t most_terms = 4;
  std::size_t width = 3;  // proposals that are gone on from
  std::size_t added = 6;  // terms that are tried on each, by what a linearised fit promises
  std::size_t pairs = 4;  // of the joint score test's ranking, fitted at first
  std::size_t laws = 3;   // cells, of the screening's ranking (free_laws.h)
  int most_laws = 2;      // in one proposal
  int starts = 4;         // of the plant as given, and of the best proposals where much is left
  std::uint64_t seed = 1;
  int threads = 2;
  std::function<void(double done_share, const std::string& doing)> progress;
};

using Terms = std::vector<plant::EffectId>;  // in the order of the System's list; laws last

struct Proposal {
  Terms terms;  // that are added; empty: the plant as given
  Explanation fit;
  double log_odds = 0.0;
  double probability = 0.0;  // among all proposals
};

struct Proposals {
  std::vector<Proposal> all;                    // most probable first; the plant as given is among them
  NoiseModel noise;                             // the one for all
  std::shared_ptr<const plant::System> system;  // with every law that was tried: terms are ids of it
  std::size_t cells = 0;                        // in which a law was sought
  const Proposal& best() const { return all.front(); }
  const Proposal* find(const Terms& terms) const;
  double probability_of(plant::EffectId effect) const;
};

// `nominal`: the plant as given. `data`: deviations are the sensors' noise. Throws std::runtime_error where the plant cannot be
// integrated over the recordings, and Stopped.
Proposals propose(const plant::Plant& nominal, const std::vector<FitData>& data, const ProposalSettings& settings,
                  const ExplanationSettings& fit);

// Effects that may be added where these are on: that are off, allowed, and not without what they act on.
std::vector<plant::EffectId> addable(const plant::Plant& plant, const std::vector<plant::EffectId>& without);

// Log density of the last part of every recording, predicted from a fit of the same plant to what comes before.
double log_density_of_what_comes(const Explanation& at, const ExplanationSettings& settings);

}  // namespace sinew::diagnose

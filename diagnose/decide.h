// SPDX-License-Identifier: Apache-2.0
// From what was found to what is said of it. Nothing here searches, fits, or puts anything into words.
#pragma once

#include <vector>

#include "diagnose/answer.h"
#include "diagnose/search.h"

namespace sinew::diagnose {

// On which the verdict hangs; where each is from: docs/thresholds.md. Those of the search are in SearchSettings.
struct Thresholds {
  double least_explained_share = 0.9;  // of the misfit: with less, the limit for process noise is that of the core
  double ambiguous_loss = 3.0;         // rivals within this much log evidence are in the answer
  // Process noise beyond the ordinary between search.visible_process_noise and this is compared with simulated recordings in which nothing
  // is missing (chance.h).
  double certain_process_noise = 2500.0;
  // Of what a channel's path was off before, squared, at most this may be left after, unless that is no more than ordinary surroundings do
  // (ChannelInfo::ordinary_disturbance), beside twice the sensor's noise.
  double most_left_of_channel = 0.3;
  // A right effect lets the core's parameters come back to what is believed of them. One that pushes them away, by more than
  // this in the sum of their squared distances, is bought with them.
  double most_rise_of_pull = 6.0;
  // What explains so much, in every channel, without a rise of pull is named even where something is left.
  double named_share = 0.75;
  double other_place_loss = 200.0;  // of log evidence: a place whose best candidate loses less may be the one
  double least_share = 0.05;        // a name of which less is believed is none
};

// From what was found, if anything was, to the answer. stands_in: something was put into the plant that is not said; leaves_something: more
// than there is where nothing is missing.
Answer decide(const plant::System& system, Found found, bool stands_in, bool leaves_something);

// How a plant and what is believed of it get on with the recordings it was fitted to, open loop.
struct Agreement {
  PerChannel rmse;    // over what was fitted, units of files
  double pull = 0.0;  // sum of squares of the core's parameters' distances from their priors, in deviations
};

// Whether a channel's path is further off than its sensor's noise and moving air account for.
bool far_off(const plant::System& system, double rmse, plant::ChannelId channel, const PerChannel& noise);
// Of the squared error beyond noise that there was, the share that is left.
double share_left(double was, double is, double noise);

// Why names that were found are not the answer, or not all of it. Empty where they are.
struct Objections {
  bool leaves_too_much = false;            // more than noise and moving air bring
  std::vector<plant::ChannelId> channels;  // whose path it leaves nearly as far off as before
  bool pushes_parameters = false;          // away from what is believed
  bool at_a_bound = false;                 // a shape of an effect
  bool worse_on_held_out = false;          // beyond chance
  bool patchwork = false;                  // more than two effects that leave something: one that is not known is likelier
  bool none() const {
    return !leaves_too_much && channels.empty() && !pushes_parameters && !at_a_bound && !worse_on_held_out && !patchwork;
  }
};
struct WithNames {
  const Explanation& answer;
  const std::vector<plant::EffectId>& names;  // that it adds
  const Agreement& before;                    // of the core
  const Agreement& after;                     // of the answer
};
// noise: of each sensor, units of files.
Objections objections_to(const WithNames& found, bool leaves_too_much, const PerChannel& noise, double visible_process_noise,
                         const Thresholds& thresholds);

// Which of the explanations that the search passed is the answer: all effects that were accepted, if together they leave nothing; without
// the last where that has a value that no plant has, and the others explain nearly all. Otherwise what is left has a name for none of it
// but, perhaps, the first: further ones only bend the fit.
Explanation chosen(const Search& search, const SearchSettings& settings, const Thresholds& thresholds);

// An effect in another form than the catalogue's is fitted by its look-alikes; that one of them fits better says little then.
Parsimony parsimony_of(const std::vector<plant::EffectId>& effects, const Search& search, bool leaves_something,
                       const Thresholds& thresholds);

}  // namespace sinew::diagnose

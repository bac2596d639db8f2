// SPDX-License-Identifier: Apache-2.0
// Where the calibrated core and the recordings part: in which equation, when, and as a function of what.
#pragma once

#include "diagnose/compare.h"
#include "diagnose/explanation.h"
#include "diagnose/held_out.h"

namespace sinew::diagnose {

// Share of the mismatch of the calibrated core that enters in each place, by the smoother.
struct PlaceShare {
  plant::EntryGroupId group;
  double share, lowest, highest;  // of the response's squares, with a 95 % block-bootstrap interval
  double log_likelihood;          // with this forcing and air alone: how well it would account for everything
};

struct Located {
  plant::ChannelId channel{};                    // with the largest error in units of noise
  PerChannel rmse, noise;                        // of what is `before` (held_out.h), on what was fitted
  std::vector<PlaceShare> shares;                // by falling likelihood; the surroundings are not among them
  std::string place;                             // of what was found, or by the forcing that accounts best; empty if consistent
  std::vector<std::string> cannot_be_told_from;  // other places in which it may enter as well
  WorstTime worst;                               // of that channel, on the training recording with the largest error
  std::size_t worst_recording = 0;
  std::string while_words;  // "while <input> cools from 72 to 55 °C", by the part's own words
};

// The places that move the same channels as this one, itself among them.
std::vector<std::string_view> places_alike(const plant::System& system, std::string_view place);

// What speaks for a place.
struct PlaceEvidence {
  std::string name{};                  // the place of the first effect that was named; empty: none was
  double name_probability = 0.0;       // of that effect
  std::vector<std::string> laws{};     // without a name, or the form of one
  std::string forcing;                 // of the single forcing that accounts best for everything
  bool forcing_speaks = false;         // even where there is a name or a law: these were found without regard to forcings
  std::vector<std::string> varying{};  // of what stands out if it is no constant, and of what does nearly as well
};

// The places in which it may enter, first the one that is said. A name says it that is more likely than not; else a law, else what varies,
// else the forcing; but the reading of a channel only after the places that move it, whose doing an error of any course can imitate. If the
// name is sure (0.9), its place stands alone. Else all that speaks for another place is among them, and all that moves the same channels:
// between a beam and the sensor that reads it, say, a curve or a push of any course decides nothing.
std::vector<std::string> places_said(const plant::System& system, const PlaceEvidence& evidence);

// A series against the plant's variable that accounts for most of it, in bins.
struct Dependence {
  std::string variable;  // "temperature A"; empty where there is nothing to account for
  std::string unit;
  double explained_share = 0.0;                 // of the series' variance, by the bins' means, cross-validated
  std::vector<double> centre, mean, deviation;  // of bins
};

// What is left: the smoothed forcing, in internal units, as a function of what.
struct LeftOver : Dependence {
  plant::EntryGroupId group{};
  std::size_t entry = 0;  // index into System::entries()
};

// `recordings`: those that were fitted, as they were read; `predictions`: of these, in their order, and maybe of others after them. How far
// off, in which channel and when is said of what is `before`; `shares` are of the core, without any effect's name. The place is left empty:
// places_said() has it.
Located locate(const Explanation& core, const std::vector<sim::Recording>& recordings, const std::vector<Prediction>& predictions,
               std::uint64_t seed);

// The forcing that accounts best for what an explanation leaves, against the variables that it may depend on.
LeftOver left_over(const Explanation& at, plant::EntryGroupId group);

// The plant's variables at the blocks' first samples: [variables], one value a block. Empty where the plant cannot be integrated.
std::vector<Eigen::VectorXd> variables_of(const Explanation& at);

// `series`: one value a block. `among`: the variables that are asked, best guess first; empty: all.
Dependence depends_on(const Explanation& at, const Eigen::VectorXd& series, const std::vector<plant::VariableId>& among);

}  // namespace sinew::diagnose

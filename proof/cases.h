// SPDX-License-Identifier: Apache-2.0
// The proof on concealed data: which cases there are, and what is true of each.
#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "prove/generator.h"

namespace sinew::proof {

// One concealed case. Seeds of development, on which thresholds were chosen, and reported seeds are apart.
struct ProofCase {
  prove::Kind kind;
  std::uint64_t seed = 0;
  prove::Settings settings;
  std::string variant;          // "plain", the disturbance that comes on top of moving air, or what is otherwise in the recording
  bool removed = false;         // the true effect is taken out of the catalogue beforehand
  bool with_baselines = false;  // simpler methods are put to it, too; they take as long as the diagnosis
  bool with_oracle = false;     // the generator's own law is fitted to it, too (oracle.h)
  bool elsewhere = false;       // nothing is missing, and the recording is of another rate, air, protocol, spread of the core or length
  bool series = false;          // of the limb of two segments in series (prove/series_limb.h)
  std::string family() const;   // by which cases are chosen: of those "elsewhere", or "series_limb"
  std::string id() const;       // unique, fit for a file name
};

// Seeds of each set. Reported seeds that were looked at, and led to a change, are reported no more: the clean ones go on from
// others.
struct FirstSeeds {
  std::uint64_t concealed, clean;
};
inline constexpr FirstSeeds development_seeds{101, 101}, reported_seeds{13001, 15001};

inline constexpr int clean_per_seed = 8;  // three plain, and one under each disturbance
// `seeds` of every case, and `clean` of those in which nothing is missing, over all disturbances, at least eight for each
// seed. Strengths go through 1, 0.5 and 0.25. At the end the further kinds of the generator, and for each seed one recording elsewhere of
// each sort, in which nothing is missing; lengths are the case's own where they are what is otherwise.
std::vector<ProofCase> proof_cases(FirstSeeds first, int seeds, int clean, double training_s, double held_out_s);
// Those of the limb of two segments in series: nothing missing, and each effect that it can conceal, at the strengths of the others.
std::vector<ProofCase> series_proof_cases(FirstSeeds first, int seeds, double training_s, double held_out_s);
// Those of parts that are not alike, at strengths of 1 and 0.5 in turn.
std::vector<ProofCase> unlike_proof_cases(FirstSeeds first, int seeds, double training_s, double held_out_s);
// A dozen, for ./check.
std::vector<ProofCase> few_proof_cases(double training_s, double held_out_s);

// What is true of a case: sealed before any diagnosis begins. Of `concealed` core and effects are read.
nlohmann::ordered_json answer_of(const ProofCase& one, const prove::Concealed& concealed);

}  // namespace sinew::proof

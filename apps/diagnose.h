// SPDX-License-Identifier: Apache-2.0
// What `sinew diagnose` does between reading and writing: of recordings and a plant, the files of the result. The Python module calls
// the same.
#pragma once

#include <functional>
#include <limits>
#include <map>
#include <string>
#include <vector>

#include "apps/diagnosis_json.h"
#include "sim/recording.h"

namespace sinew::apps {

struct DiagnoseRequest {
  std::vector<std::string> training, held_out;  // what they are called in the results: paths
  std::string plant;                            // the same of the plant
  InputHashes hashes;                           // of each of these
  std::vector<std::string> without, ignored, noise;
  double fit_until_s = std::numeric_limits<double>::infinity();
  std::int64_t seed = 1;
  int threads = 1;  // the result does not depend on it
  bool at_rest = false;
  std::function<bool()> should_stop;
  std::function<void(double done_share, const std::string& doing)> progress;  // from one thread at a time
};

struct Diagnosed {
  // diagnosis.json, plant.yaml, report.html, heldout_prediction.csv and further ones, perhaps experiment.yaml, and run.json of them all.
  std::map<std::string, std::string> files;
  std::string oddities, words;  // for the terminal
};

// What `--without` names. Throws InputError where a name is none, or where nothing is left that could be named.
std::vector<plant::EffectId> chosen_effects(const std::vector<std::string>& names, const plant::System& system);

// Throws InputError, and diagnose::Stopped where `should_stop` says so.
Diagnosed diagnosed(const DiagnoseRequest& request, const plant::Plant& nominal, std::vector<sim::Recording> training,
                    std::vector<sim::Recording> held_out);

}  // namespace sinew::apps

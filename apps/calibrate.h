// SPDX-License-Identifier: Apache-2.0
// What `sinew calibrate` does between reading and writing: of recordings and a plant, the files of the result. The Python module calls
// the same.
#pragma once

#include <functional>
#include <limits>
#include <map>
#include <string>
#include <vector>

#include "sim/recording.h"

namespace sinew::apps {

struct CalibrateRequest {
  std::vector<std::string> recordings;  // what they are called in the results: paths
  std::string plant;                    // the same of the plant
  std::vector<std::string> fit, noise, ignored;
  double fit_until_s = std::numeric_limits<double>::infinity();
  int starts = 3;
  std::int64_t seed = 1;
  int threads = 1;  // the result does not depend on it
  bool at_rest = false;
  std::function<bool()> should_stop;
  std::function<void(double done_share)> progress;  // from one thread at a time
};

struct Calibrated {
  std::map<std::string, std::string> files;  // calibration.json, plant.yaml, report.html, figure.svg: names and contents
  std::string words;                         // for the terminal
};

// Names of files of a result, for Outputs::claim.
std::vector<std::string> files_of_calibration();

// Throws InputError, and diagnose::Stopped where `should_stop` says so.
Calibrated calibrated(const CalibrateRequest& request, const plant::Plant& nominal, std::vector<sim::Recording> recordings);

}  // namespace sinew::apps

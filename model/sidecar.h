// SPDX-License-Identifier: Apache-2.0
// What a weights file that Keras wrote does not say, in YAML beside it: order and scaling of the network's inputs.
//
//     format: 1
//     case: 3
//     method: published
//     inputs:                                # one a column of the kernel, in its order; lowest and highest are 0 and 1 of the network
//       - { column: duty_A, at: t-1, lowest: 0, highest: 0.6 }
//       - { column: duty_B, at: t-1, lowest: 0, highest: 0.6 }
//       - { column: angle_deg, at: t-1, lowest: -60, highest: 60 }
//       - { column: duty_A, at: t, lowest: 0, highest: 0.6 }
//       - { column: duty_B, at: t, lowest: 0, highest: 0.6 }
//     output: { column: angle_deg, lowest: -60, highest: 60 }
//
// That is the order of the notebook of Sabelhaus et al. 2022: v(t-1), y(t-1), v(t). A column has one scaling wherever it stands.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "model/series.h"
#include "sim/yaml.h"

namespace sinew::model {

struct Sidecar {
  struct Entry {
    std::string column;
    bool before = false;  // at t-1
    double lowest = 0.0, highest = 1.0;
    sim::YamlValue at_file = {};  // for complaints
  };
  int paper_case = 3;
  std::string method;
  std::vector<Entry> inputs;
  Entry output;
};

// Throw InputError.
Sidecar read_sidecar(const std::filesystem::path& file);
// Where the sidecar of a weights file is looked for: its name and ".yaml".
std::filesystem::path sidecar_of(const std::filesystem::path& weights);

// Which of the network's inputs each of [v(t), v(t-1), y(t-1)] is, and the scaling of the task's columns. Throws InputError where an
// input is missing, stands twice, is none of the task's, or has two scalings.
struct Arrangement {
  std::vector<Index> from;
  Scaling scaling;
};
Arrangement arrangement_of(const Sidecar& sidecar, const Task& task);

}  // namespace sinew::model

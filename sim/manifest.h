// SPDX-License-Identifier: Apache-2.0
// run.json: what made a result. No date, no host, no duration: the same run gives the same bytes.
#pragma once

#include <map>
#include <string>
#include <string_view>

#include "sim/simulation.h"

namespace sinew::sim {

// 64 hexadecimal digits.
std::string sha256(std::string_view bytes);

struct Build {
  std::string version, commit, compiler, libraries;
};
Build this_build();

// `files`: name and content of each file beside run.json; their hashes are kept.
std::string run_json(const Scenario& scenario, const RunResult& result, const std::map<std::string, std::string>& files);

}  // namespace sinew::sim

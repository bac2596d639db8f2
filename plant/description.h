// SPDX-License-Identifier: Apache-2.0
// The structure of a plant as its file describes it: a tree of words. Reading files is sim's business; what may stand in
// the tree is each System's. An error names the path of the value at fault ("limb.coils[1].segment"), and whoever read the
// file adds file, line and column.
#pragma once

#include <stdexcept>
#include <string>
#include <vector>

namespace sinew::plant {

struct Description {
  enum class Kind { empty, scalar, map, list };
  Kind kind = Kind::empty;
  std::string path;
  std::string scalar;
  struct Entry;
  std::vector<Entry> map;
  std::vector<Description> list;
};

struct Description::Entry {
  std::string key;
  Description value;
};

class DescriptionError : public std::runtime_error {
 public:
  DescriptionError(std::string at, const std::string& advice) : std::runtime_error(advice), path(std::move(at)) {}
  std::string path;
};

// A part of a kind that has values of its own of an effect that parts otherwise share; or, where there is no effect, one value of its own
// of what parts share of the core.
struct OwnValues {
  std::string path;      // where the file says so
  std::string effect;    // "latent_heat"
  std::string part;      // "A"
  std::string key = "";  // of the core: "heating_midpoint_A_degC"
};

}  // namespace sinew::plant

// SPDX-License-Identifier: Apache-2.0
// A set of recordings on disk, in parts of a few runs, so many that files stay few; of a set that is not huge each run is one.
//
//     runs/0000.csv    the part that begins with run 0: its recordings, one after another
//     runs/0000.json   where each lies in it, and what was drawn; written first, so that a CSV file without it is not of a set
//     manifest.json    all parts, with hashes; written last
#pragma once

#include <algorithm>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "model/dataset.h"
#include "sim/recording.h"

namespace sinew::model {

// What a set is made from.
struct SetPlan {
  sim::Scenario scenario;
  Domain domain;
  std::string scenario_yaml, domain_text;
  std::int64_t runs = 0;
  std::int64_t most_parts = 16384;

  std::int64_t runs_in_part() const { return (runs + most_parts - 1) / most_parts; }
  std::int64_t parts() const { return (runs + runs_in_part() - 1) / runs_in_part(); }
  struct Runs {
    std::int64_t first, count;
  };
  Runs runs_of(std::int64_t part) const { return {part * runs_in_part(), std::min(runs_in_part(), runs - part * runs_in_part())}; }
  // A hash of all of it, and of the code that makes runs; parts with another mark are not taken over. Of the number of runs only how many
  // share a file counts.
  std::string mark() const;
};

// What the manifest says of a part.
struct SetPart {
  std::string sha256;       // of its JSON file
  std::int64_t failed = 0;  // runs
};

// The part `part` in `folder`; nothing where it is not whole, or made from another plan.
std::optional<SetPart> part_in(const SetPlan& plan, const std::filesystem::path& folder, std::int64_t part);
// Simulates a part's runs and writes its two files, each whole or not at all. The same plan gives the same bytes.
// `should_stop` is asked at every restart of the integrator; a part that is stopped leaves nothing, and nothing is returned.
std::optional<SetPart> make_part(const SetPlan& plan, const std::filesystem::path& folder, std::int64_t part,
                                 const std::function<bool()>& should_stop = {});
// The manifest's text; `parts` are all of the set.
std::string manifest_of(const SetPlan& plan, const std::vector<SetPart>& parts);
// The recordings in HDF5, [samples x columns] arrays /runs/0000 ... Made in memory: for a set whose parts are one run each.
std::string set_in_hdf5(const SetPlan& plan, const std::filesystem::path& folder, const std::string& manifest);

// Calls `visit` with the recordings of a set, one after another, those that failed left out, with the columns of its plant; or with the
// one of a CSV file, with the columns given. Of a set at most `most` runs, spread evenly over it. Returns how many runs it has.
// Throws InputError for a folder without manifest and for a part or a run that is not what the hash of it says.
std::int64_t visit_set(const std::filesystem::path& path, const sim::Columns& columns_of_file, std::int64_t most,
                       const std::function<void(sim::Recording)>& visit);
// The System that a set's runs are of, by its manifest; null for what is no folder.
std::shared_ptr<const plant::System> system_of_set(const std::filesystem::path& path);

}  // namespace sinew::model

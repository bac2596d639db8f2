// SPDX-License-Identifier: Apache-2.0
// A set of recordings on disk: runs/0000.csv ..., each with runs/0000.json beside it, and manifest.json, written last.
#pragma once

#include <filesystem>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "model/dataset.h"
#include "sim/recording.h"

namespace sinew::model {

// What a set is made from. `mark`: a hash of all of it, and of the code that makes runs; runs with
// another mark are not taken over.
struct SetPlan {
  sim::Scenario scenario;
  Domain domain;
  std::string scenario_yaml, domain_text;
  std::int64_t runs = 0;
  std::string mark() const;
};

// Whether run `run` lies in `folder`, whole and made from this plan.
bool is_there(const SetPlan& plan, const std::filesystem::path& folder, std::int64_t run);
// Simulates one run and writes its two files, first the JSON, each whole or not at all. The same plan gives the same bytes.
// `should_stop` is asked at every restart of the integrator; a run that is stopped leaves nothing.
void make_run(const SetPlan& plan, const std::filesystem::path& folder, std::int64_t run, const std::function<bool()>& should_stop = {});
// Gathers all runs: the manifest's text; and the recordings in HDF5, [samples x columns] arrays /runs/0000 ...
std::string manifest_of(const SetPlan& plan, const std::filesystem::path& folder);
std::int64_t failed_runs(const SetPlan& plan, const std::filesystem::path& folder);
std::string set_in_hdf5(const SetPlan& plan, const std::filesystem::path& folder);

// The recordings of a set, those that failed left out, with the columns of its plant; or the one of a CSV file, with the columns
// given. Throws InputError for a folder without manifest and for a run that is not what the manifest's hash says.
std::vector<sim::Recording> read_set(const std::filesystem::path& path, const sim::Columns& columns_of_file);
// The System that a set's runs are of, by its manifest; null for what is no folder.
std::shared_ptr<const plant::System> system_of_set(const std::filesystem::path& path);

}  // namespace sinew::model

// SPDX-License-Identifier: Apache-2.0
// The numeric arrays of an HDF5 file, for maps. (Weights and data sets of the project's own are model/hdf5_file.h's.)
#pragma once

#include <filesystem>
#include <vector>

#include "sim/log_reader.h"

namespace sinew::sim {

// Arrays of one or two dimensions by path without the leading slash: "run/temperature", "run/tags[3]" (as read_mat says of
// matrices). Throws InputError naming the file where it is no such file, or damaged, or without numbers.
std::vector<LogArray> read_hdf5(const std::filesystem::path& path);

}  // namespace sinew::sim

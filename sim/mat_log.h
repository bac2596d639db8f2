// SPDX-License-Identifier: Apache-2.0
// The numeric variables of a MATLAB file (versions 4 to 7.3). mat_log.cpp alone includes the library for that, matio.
#pragma once

#include <filesystem>
#include <vector>

#include "sim/log_reader.h"

namespace sinew::sim {

// Vectors by name; a field of a structure as structure.field; a matrix as its columns, name[1] and so on. Where a matrix is wider
// than long, its rows are the series. What holds no real numbers (text, cells, complex and sparse matrices, more than two
// dimensions) is left out. Throws InputError naming the file where it is no such file, or damaged, or without numbers.
std::vector<LogArray> read_mat(const std::filesystem::path& path);

// A matrix of rows x columns as series along its longer side, named name[k]; a vector, or a single number, is one series.
// The value in row r and column c stands at values[r + c * rows] (by columns) or values[r * columns + c].
void append_series(std::vector<LogArray>& to, const std::string& name, const std::vector<double>& values, std::size_t rows,
                   std::size_t columns, bool by_columns);

}  // namespace sinew::sim

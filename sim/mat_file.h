// SPDX-License-Identifier: Apache-2.0
// A table as a MATLAB file (version 5, little-endian, not compressed): a column vector of doubles for each column.
//
// Source: The MathWorks, MAT-File Format, R2023b, section "Level 5 MAT-File Format".
#pragma once

#include <string>

#include "sim/table.h"

namespace sinew::sim {

// The file's bytes; the same table gives the same. A column's name is that of its variable, with '_' for what cannot stand in one.
// Throws InputError naming the column where two would have one name, where a name is longer than MATLAB's 63 letters, and where a column
// is longer than such a file can hold (2^27 rows).
std::string to_mat(const Table& table);

}  // namespace sinew::sim

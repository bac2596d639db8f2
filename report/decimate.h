// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <span>
#include <vector>

namespace sinew::report {

// Which rows of a long table to draw so that it looks the same: ascending row numbers.
//
// The rows are cut into runs of equal length. Of each run, the rows that hold a column's smallest and largest
// value stay, and a row that is NaN where a column breaks off, so that no peak is lost and no gap is bridged. The
// first and last row always stay. A table of no more than `max_rows` is returned whole; otherwise about `max_rows`
// rows remain, or up to twice as many where gaps are dense.
//
// columns: each of row_count values, NaN for a gap.
std::vector<std::size_t> rows_to_draw(std::size_t row_count, std::span<const std::span<const double>> columns, std::size_t max_rows);

}  // namespace sinew::report

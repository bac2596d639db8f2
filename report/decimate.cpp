// SPDX-License-Identifier: Apache-2.0
#include "report/decimate.h"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace sinew::report {

std::vector<std::size_t> rows_to_draw(std::size_t row_count, std::span<const std::span<const double>> columns, std::size_t max_rows) {
  std::vector<std::size_t> rows;
  if (row_count <= max_rows || columns.empty()) {
    rows.resize(row_count);
    std::iota(rows.begin(), rows.end(), std::size_t{0});
    return rows;
  }
  const std::size_t runs = std::max<std::size_t>(1, max_rows / (2 * columns.size()));
  rows.push_back(0);
  rows.push_back(row_count - 1);
  for (std::size_t run = 0; run < runs; ++run) {
    const std::size_t begin = run * row_count / runs;
    const std::size_t end = (run + 1) * row_count / runs;
    for (const auto column : columns) {
      std::size_t smallest = end;
      std::size_t largest = end;
      std::size_t gap = end;
      for (std::size_t row = begin; row < end; ++row) {
        const double value = column[row];
        if (!std::isfinite(value)) {
          gap = std::min(gap, row);
          continue;
        }
        if (smallest == end || value < column[smallest]) smallest = row;
        if (largest == end || value > column[largest]) largest = row;
      }
      if (smallest != end) rows.push_back(smallest);
      if (largest != end) rows.push_back(largest);
      if (gap == end) continue;
      rows.push_back(gap);
      if (smallest == end) continue;
      const auto [from, to] = std::minmax(smallest, largest);
      for (std::size_t row = from; row < to; ++row) {
        if (std::isfinite(column[row])) continue;
        rows.push_back(row);
        break;
      }
    }
  }
  std::sort(rows.begin(), rows.end());
  rows.erase(std::unique(rows.begin(), rows.end()), rows.end());
  return rows;
}

}  // namespace sinew::report

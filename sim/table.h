// SPDX-License-Identifier: Apache-2.0
// A table of numbers with named columns: what a converted log is, whatever limb or machine it came from.
#pragma once

#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

namespace sinew::sim {

// A missing value is NaN. All columns are of one length.
struct TableColumn {
  std::string name;
  std::vector<double> values;
};

struct Table {
  std::vector<std::string> comments;  // without the "# "
  std::vector<TableColumn> columns;

  std::size_t rows() const { return columns.empty() ? 0 : columns.front().values.size(); }
  // The column of that name, or null.
  const TableColumn* find(std::string_view name) const;
};

// The table as a CSV file with LF line ends: comments first, then the names, then the rows; a missing value is an empty
// field, and every number has the shortest form that reads back the same.
std::string to_csv(const Table& table);

// The median of the values (the lower one of two in the middle); NaN where there is none. No value may be NaN.
double lower_median(std::vector<double> values);

}  // namespace sinew::sim

// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

namespace sinew::report {

enum class Align { left, right };

struct Row {
  std::vector<std::string> cells{};
  bool emphasis = false;
  std::string note{};  // a remark, shown under the row
};

struct Table {
  std::string title{};
  std::vector<std::string> header{};  // may be empty
  std::vector<Row> rows{};
  std::vector<Align> align{};  // empty: columns in which every cell is a number or a dash go right
  std::string caption{};
};

// Alignment of each of the table's columns, as given or as the cells suggest.
std::vector<Align> column_alignment(const Table& table);

}  // namespace sinew::report

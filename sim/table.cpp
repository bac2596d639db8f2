// SPDX-License-Identifier: Apache-2.0
#include "sim/table.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "sim/text.h"

namespace sinew::sim {

const TableColumn* Table::find(std::string_view name) const {
  const auto found = std::find_if(columns.begin(), columns.end(), [&](const TableColumn& c) { return c.name == name; });
  return found == columns.end() ? nullptr : &*found;
}

std::string to_csv(const Table& table) {
  std::string text;
  text.reserve(256 + 12 * table.rows() * table.columns.size());
  for (const std::string& comment : table.comments) {
    for (std::size_t start = 0; start <= comment.size();) {
      const std::size_t end = std::min(comment.find('\n', start), comment.size());
      text.append(end > start ? "# " : "#").append(comment, start, end - start).append(1, '\n');
      start = end + 1;
    }
  }
  for (const TableColumn& column : table.columns) text.append(column.name).append(1, ',');
  if (!table.columns.empty()) text.back() = '\n';
  for (std::size_t row = 0; row < table.rows(); ++row) {
    for (const TableColumn& column : table.columns) {
      if (!std::isnan(column.values[row])) append_shortest(text, column.values[row]);
      text += ',';
    }
    text.back() = '\n';
  }
  return text;
}

double lower_median(std::vector<double> values) {
  if (values.empty()) return std::numeric_limits<double>::quiet_NaN();
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>((values.size() - 1) / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

}  // namespace sinew::sim

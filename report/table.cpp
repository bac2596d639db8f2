// SPDX-License-Identifier: Apache-2.0
#include "report/table.h"

#include <algorithm>
#include <string_view>

namespace sinew::report {

namespace {

// A number, perhaps with a sign, a spread or a unit behind it; or a mark for none.
bool looks_like_number(std::string_view cell) {
  const std::size_t begin = cell.find_first_not_of(' ');
  if (begin == std::string_view::npos) return false;
  cell.remove_prefix(begin);
  for (const std::string_view lead : {"+", "-", "\u2212", "\u00b1", "<", ">", "\u2264", "\u2265", "~", "\u2248"}) {
    if (cell.starts_with(lead) && cell.size() > lead.size()) {
      cell.remove_prefix(lead.size());
      cell.remove_prefix(std::min(cell.find_first_not_of(' '), cell.size()));
    }
  }
  for (const std::string_view mark : {"\u2013", "\u2014", "-", "\u221e", "nan", "NaN"}) {
    if (cell == mark) return true;
  }
  if (cell.empty() || cell.front() < '0' || cell.front() > '9') return false;
  // "12.5 ± 0.3 %" is a number and "3 of 5 recordings" is not: a long word makes it a phrase.
  std::size_t letters = 0;
  for (const char c : cell) {
    const bool letter = (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z');
    letters = letter ? letters + 1 : 0;
    if (letters > 3) return false;
  }
  return true;
}

}  // namespace

std::vector<Align> column_alignment(const Table& table) {
  std::size_t columns = std::max(table.header.size(), table.align.size());
  for (const Row& row : table.rows) columns = std::max(columns, row.cells.size());
  std::vector<Align> align = table.align;
  for (std::size_t column = align.size(); column < columns; ++column) {
    bool any = false;
    bool all = true;
    for (const Row& row : table.rows) {
      if (column >= row.cells.size() || row.cells[column].empty()) continue;
      any = true;
      all = all && looks_like_number(row.cells[column]);
    }
    align.push_back(any && all ? Align::right : Align::left);
  }
  return align;
}

}  // namespace sinew::report

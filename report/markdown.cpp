// SPDX-License-Identifier: Apache-2.0
#include "report/markdown.h"

namespace sinew::report {
namespace {

std::string cell_of(const std::string& text, bool bold) {
  std::string cell;
  for (const char c : text) {
    if (c == '|') cell += '\\';
    cell += c == '\n' ? ' ' : c;
  }
  return bold && !cell.empty() ? "**" + cell + "**" : cell;
}

}  // namespace

std::string to_markdown(const Table& table) {
  std::string text = "|";
  for (const std::string& name : table.header) text += " " + cell_of(name, false) + " |";
  text += "\n|";
  for (std::size_t c = 0; c < table.header.size(); ++c) text += "---|";
  text += "\n";
  for (const Row& row : table.rows) {
    text += "|";
    for (std::size_t c = 0; c < row.cells.size(); ++c) {
      text += " " + cell_of(row.cells[c], row.emphasis);
      if (c + 1 == row.cells.size() && !row.note.empty()) text += (row.cells[c].empty() ? "" : "; ") + cell_of(row.note, false);
      text += " |";
    }
    text += "\n";
  }
  return text;
}

}  // namespace sinew::report

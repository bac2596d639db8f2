// SPDX-License-Identifier: Apache-2.0
#include "report/console.h"

#include <algorithm>
#include <vector>

#include "report/text.h"

namespace sinew::report {

namespace {

constexpr std::size_t gap = 2;            // between columns
constexpr std::size_t least_column = 12;  // no column is wrapped to less

std::vector<std::string> lines_of(std::string_view text, std::size_t width) {
  std::vector<std::string> lines;
  std::string line;
  std::size_t line_width = 0;
  const std::string clean = printable(text);
  std::string_view rest = clean;
  while (!rest.empty()) {
    const std::size_t end = std::min(rest.find_first_of(" \n"), rest.size());
    const std::string_view word = rest.substr(0, end);
    const std::size_t word_width = display_width(word);
    if (!word.empty()) {
      if (line_width > 0 && line_width + 1 + word_width > width) {
        lines.push_back(line);
        line.clear();
        line_width = 0;
      }
      if (line_width > 0) line += ' ', ++line_width;
      line += word;
      line_width += word_width;
    }
    if (end == rest.size()) break;
    if (rest[end] == '\n') {
      lines.push_back(line);
      line.clear();
      line_width = 0;
    }
    rest.remove_prefix(end + 1);
  }
  if (!line.empty() || lines.empty()) lines.push_back(line);
  return lines;
}

std::string spaces(std::size_t count) { return std::string(count, ' '); }

void end_line(std::string& out) {
  out.erase(out.find_last_not_of(' ') + 1);
  out += '\n';
}

}  // namespace

std::string wrap(std::string_view text, std::size_t columns, std::size_t indent) {
  std::string out;
  for (const std::string& line : lines_of(text, columns > indent ? columns - indent : 1)) {
    if (!out.empty()) out += '\n';
    if (!line.empty()) out += spaces(indent) + line;
  }
  return out;
}

std::string to_text(const Table& table, std::size_t columns) {
  const std::vector<Align> align = column_alignment(table);
  const std::size_t count = align.size();
  const bool marked = std::any_of(table.rows.begin(), table.rows.end(), [](const Row& row) { return row.emphasis; });
  const std::size_t margin = marked ? 2 : 0;

  std::vector<std::size_t> widths(count, 0);
  const auto fit = [&widths](const std::vector<std::string>& cells) {
    for (std::size_t i = 0; i < cells.size(); ++i) {
      for (const std::string& line : lines_of(cells[i], static_cast<std::size_t>(-1))) {
        widths[i] = std::max(widths[i], display_width(line));
      }
    }
  };
  fit(table.header);
  for (const Row& row : table.rows) fit(row.cells);

  const auto total = [&] {
    std::size_t sum = margin;
    for (const std::size_t width : widths) sum += width + gap;
    return count > 0 ? sum - gap : sum;
  };
  while (total() > columns) {
    std::size_t widest = count;
    for (std::size_t i = 0; i < count; ++i) {
      if (align[i] == Align::left && widths[i] > least_column && (widest == count || widths[i] > widths[widest])) {
        widest = i;
      }
    }
    if (widest == count) break;
    --widths[widest];
  }

  std::string out;
  const auto put = [&](const std::vector<std::string>& cells, char mark) {
    std::vector<std::vector<std::string>> wrapped(count);
    std::size_t height = 1;
    for (std::size_t i = 0; i < count && i < cells.size(); ++i) {
      wrapped[i] = lines_of(cells[i], widths[i]);
      height = std::max(height, wrapped[i].size());
    }
    for (std::size_t line = 0; line < height; ++line) {
      if (marked) out += line == 0 ? std::string{mark, ' '} : spaces(margin);
      for (std::size_t i = 0; i < count; ++i) {
        const std::string text = line < wrapped[i].size() ? wrapped[i][line] : std::string();
        const std::size_t width = display_width(text);
        const std::string room = spaces(widths[i] > width ? widths[i] - width : 0);
        out += align[i] == Align::right ? room + text : text + room;
        if (i + 1 < count) out += spaces(gap);
      }
      end_line(out);
    }
  };

  if (!table.title.empty()) out += wrap(table.title, columns) + "\n";
  if (!table.header.empty()) {
    put(table.header, ' ');
    out += spaces(margin);
    for (std::size_t i = 0; i < count; ++i) {
      for (std::size_t k = 0; k < widths[i]; ++k) out += "\u2500";
      if (i + 1 < count) out += spaces(gap);
    }
    end_line(out);
  }
  for (const Row& row : table.rows) {
    put(row.cells, row.emphasis ? '*' : ' ');
    if (!row.note.empty()) out += wrap(row.note, columns, margin + 4) + "\n";
  }
  if (!table.caption.empty()) out += wrap(table.caption, columns) + "\n";
  return out;
}

}  // namespace sinew::report

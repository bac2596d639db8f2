// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <string>
#include <string_view>

#include "report/table.h"

namespace sinew::report {

// What a page shows, for a terminal: plain UTF-8 without colours, lines of at most `columns` where words allow.

inline constexpr std::size_t terminal_columns = 100;

// Words filled into lines, each behind `indent` spaces; line feeds of the text stay. No line feed at the end.
std::string wrap(std::string_view text, std::size_t columns = terminal_columns, std::size_t indent = 0);

// The table with aligned columns, ending in a line feed. Where it is too wide, cells of the widest left-aligned
// columns are wrapped. Rows with emphasis are marked by an asterisk; notes stand under their rows.
std::string to_text(const Table& table, std::size_t columns = terminal_columns);

}  // namespace sinew::report

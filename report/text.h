// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <string>
#include <string_view>

namespace sinew::report {

// Text from outside (the name of a channel, the path of a file) on its way into a page, a figure or a terminal.
// All of it is taken as UTF-8; a byte that is none becomes U+FFFD.

// One code point taken from the front of `text`, which must not be empty.
char32_t take_code_point(std::string_view& text);
void append_utf8(std::string& text, char32_t code_point);

// Fit for element content and quoted attributes of HTML and XML alike. Control characters, which XML cannot
// carry, become U+FFFD as well; tab and line feed stay.
std::string escaped(std::string_view text);

// Fit for a terminal: control characters, which could move its cursor or change its state, become U+FFFD; tab
// becomes a space, line feed stays.
std::string printable(std::string_view text);

// Columns that `text` fills in a terminal: 0 for combining marks, 2 for wide East Asian characters and emoji, 1
// for all else (°, ± and µ among them).
std::size_t display_width(std::string_view text);

}  // namespace sinew::report

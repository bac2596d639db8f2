// SPDX-License-Identifier: Apache-2.0
#include "sim/plain_text.h"

#include <cstddef>
#include <cstdint>

namespace sinew::sim {

// The Unicode Standard, version 15, table 3-7: neither longer forms than are needed, nor surrogates, nor beyond U+10FFFF.
bool is_plain_text(std::string_view text) {
  for (std::size_t at = 0; at < text.size();) {
    const auto first = static_cast<unsigned char>(text[at]);
    if (first < 0x20 || first == 0x7f) return false;
    if (first < 0x80) {
      ++at;
      continue;
    }
    const std::size_t more = first >= 0xF0 ? 3 : first >= 0xE0 ? 2 : 1;
    if (first < 0xC2 || first > 0xF4 || at + more >= text.size()) return false;
    std::uint32_t character = first & (0x3Fu >> more);
    for (std::size_t i = 1; i <= more; ++i) {
      const auto next = static_cast<unsigned char>(text[at + i]);
      if ((next & 0xC0u) != 0x80u) return false;
      character = character << 6u | (next & 0x3Fu);
    }
    const std::uint32_t least = more == 3 ? 0x10000u : more == 2 ? 0x800u : 0x80u;
    const bool is_control = character >= 0x80u && character < 0xA0u, breaks_line = character == 0x2028u || character == 0x2029u;
    if (character < least || character > 0x10FFFFu || (character >= 0xD800u && character < 0xE000u) || is_control || breaks_line)
      return false;
    at += more + 1;
  }
  return true;
}

}  // namespace sinew::sim

// SPDX-License-Identifier: Apache-2.0
#include "sim/input_error.h"

#include <algorithm>
#include <utility>
#include <vector>

#include "sim/text.h"

namespace sinew::sim {
namespace {

constexpr std::size_t longest_quoted = 160, longest_path = 4096;

std::string compose(const InputFault& fault) {
  std::string text = printable(fault.file, longest_path);
  if (fault.line > 0) {
    text += text.empty() ? "line " : ":";
    text += std::to_string(fault.line);
    if (fault.column > 0) text += ':' + std::to_string(fault.column);
  }
  const std::string key = printable(fault.key, longest_quoted), value = printable(fault.value, longest_quoted);
  if (!text.empty() && !(key.empty() && value.empty())) text += ": ";
  text += key;
  if (!key.empty() && !value.empty()) text += " = ";
  text += value;
  for (std::string_view rest = fault.advice; !rest.empty();) {
    const std::size_t end = std::min(rest.find('\n'), rest.size());
    if (end > 0) text.append("\n  ").append(rest.substr(0, end));
    rest.remove_prefix(std::min(end + 1, rest.size()));
  }
  return text;
}

std::size_t distance(std::string_view a, std::string_view b) {
  // Rows of the table of distances between a[0..i) and b[0..j), for i - 2, i - 1 and i.
  std::vector<std::size_t> before(b.size() + 1), above(b.size() + 1), row(b.size() + 1);
  for (std::size_t j = 0; j <= b.size(); ++j) above[j] = j;
  for (std::size_t i = 1; i <= a.size(); ++i) {
    row[0] = i;
    for (std::size_t j = 1; j <= b.size(); ++j) {
      const std::size_t replaced = above[j - 1] + (a[i - 1] == b[j - 1] ? 0 : 1);
      row[j] = std::min({replaced, above[j] + 1, row[j - 1] + 1});
      const bool swapped = i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1];
      if (swapped) row[j] = std::min(row[j], before[j - 2] + 1);
    }
    std::swap(before, above);
    std::swap(above, row);
  }
  return above[b.size()];
}

template <class Text>
std::string nearest_of(std::string_view word, std::span<const Text> candidates) {
  const std::size_t allowed = std::max<std::size_t>(2, word.size() / 3);
  const std::string lower = lower_case(word);
  std::string_view best;
  std::pair<std::size_t, std::size_t> least{allowed + 1, 0};
  for (const std::string_view candidate : candidates) {
    const std::size_t longer = std::max(word.size(), candidate.size());
    if (longer - std::min(word.size(), candidate.size()) > allowed) continue;
    const std::size_t apart = distance(lower, lower_case(candidate));
    if (apart > allowed || apart >= longer) continue;
    const std::pair found{apart, distance(word, candidate)};
    if (found < least) {
      least = found;
      best = candidate;
    }
  }
  return std::string(best);
}

}  // namespace

InputError::InputError(InputFault fault) : std::runtime_error(compose(fault)), InputFault(std::move(fault)) {}

std::string printable(std::string_view text, std::size_t longest) {
  constexpr std::string_view digits = "0123456789abcdef";
  const bool cut = text.size() > longest;
  if (cut) {
    // Not in the middle of a character of several bytes (UTF-8).
    while (longest > 0 && (static_cast<unsigned char>(text[longest]) & 0xC0u) == 0x80u) --longest;
    text = text.substr(0, longest);
  }
  std::string shown;
  shown.reserve(text.size());
  for (const char c : text) {
    const auto byte = static_cast<unsigned char>(c);
    if (byte >= 0x20 && byte != 0x7f) {
      shown += c;
    } else {
      shown.append("\\x").append(1, digits[byte / 16]).append(1, digits[byte % 16]);
    }
  }
  return cut ? shown + "..." : shown;
}

std::string nearest(std::string_view word, std::span<const std::string_view> candidates) { return nearest_of(word, candidates); }

std::string nearest(std::string_view word, std::span<const std::string> candidates) { return nearest_of(word, candidates); }

std::string did_you_mean(std::string_view word, std::span<const std::string> candidates) {
  const std::string near = nearest(word, candidates);
  return near.empty() ? "" : "; did you mean " + near + "?";
}

}  // namespace sinew::sim

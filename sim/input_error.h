// SPDX-License-Identifier: Apache-2.0
// What is thrown when an input is wrong: a file, a value in it, an argument. It points at the place.
//
//   scenarios/step.yaml:10:42: plant.effects.thermocouple_lag.time_constant_s = -1.2
//     must lie in [0, 30]; 0 turns thermocouple_lag off
//
// Broken promises of this code are not input errors, nor is what happens on a wire or in a solver.
#pragma once

#include <cstddef>
#include <span>
#include <stdexcept>
#include <string>
#include <string_view>

namespace sinew::sim {

// What is left empty (or 0) is left out of the message.
struct InputFault {
  std::string file{};
  int line = 0;          // from 1; 0: none
  int column = 0;        // from 1, in characters of the line; 0: none
  std::string key{};     // what is wrong: a key, a column, or a few words
  std::string value{};   // what was found there
  std::string advice{};  // what would be right; may be of several lines
};

// what() is `file:line:column: key = value`, then the lines of the advice, each indented by two spaces.
// The parts are kept as they came; in what(), key and value are printable() ones.
class InputError : public std::runtime_error, public InputFault {
 public:
  explicit InputError(InputFault fault);
};

// The text with control characters escaped, as \x1b, and cut after `longest` bytes, with "..." to show it.
std::string printable(std::string_view text, std::size_t longest = 60);

// The candidate closest to `word` in spelling, the first of those equally close; empty if none is close.
// Distance: insertions, deletions, replacements and swaps of neighbours (Damerau-Levenshtein, restricted: no part is
// edited twice), letter case aside; case decides between candidates that are otherwise equally close. Close is a
// distance of at most max(2, a third of the word's length) that leaves something of the word.
std::string nearest(std::string_view word, std::span<const std::string_view> candidates);
std::string nearest(std::string_view word, std::span<const std::string> candidates);
// "; did you mean X?", or nothing where none is close.
std::string did_you_mean(std::string_view word, std::span<const std::string> candidates);

}  // namespace sinew::sim

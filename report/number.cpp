// SPDX-License-Identifier: Apache-2.0
#include "report/number.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>

namespace sinew::report {

namespace {

std::string formatted(double value, std::chars_format format, int precision) {
  std::array<char, 512> buffer{};  // 309 digits of the largest double, 128 decimals, sign and point
  const auto end = std::to_chars(buffer.data(), buffer.data() + buffer.size(), value, format, std::clamp(precision, 0, 128));
  std::string text(buffer.data(), end.ptr);
  if (text.starts_with('-') && text.find_first_of("123456789") == std::string::npos) text.erase(0, 1);
  return text;
}

std::string not_finite(double value) {
  if (std::isnan(value)) return "\u2013";
  return value > 0.0 ? "\u221e" : "-\u221e";
}

}  // namespace

std::string fixed(double value, int decimals) {
  if (!std::isfinite(value)) return not_finite(value);
  return formatted(value, std::chars_format::fixed, decimals);
}

std::string scientific(double value, int digits) {
  if (!std::isfinite(value)) return not_finite(value);
  std::string text = formatted(value, std::chars_format::scientific, digits - 1);
  const std::size_t e = text.find('e');
  std::size_t first = e + 1;
  if (text[first] == '+') {
    text.erase(first, 1);
  } else if (text[first] == '-') {
    ++first;
  }
  while (first + 1 < text.size() && text[first] == '0') text.erase(first, 1);
  return text;
}

std::string significant(double value, int digits) {
  if (!std::isfinite(value)) return not_finite(value);
  digits = std::max(digits, 1);
  if (value == 0.0) return fixed(0.0, digits - 1);
  const std::string rounded = scientific(value, digits);  // its exponent is right after rounding 9.99 to 10.0
  int exponent = 0;
  std::from_chars(rounded.data() + rounded.find('e') + 1, rounded.data() + rounded.size(), exponent);
  if (exponent < -4 || exponent >= 7) return rounded;
  return fixed(value, std::max(0, digits - 1 - exponent));
}

std::string compact(double value, int decimals) {
  std::string text = fixed(value, decimals);
  if (text.find('.') == std::string::npos) return text;
  text.erase(text.find_last_not_of('0') + 1);
  if (text.ends_with('.')) text.pop_back();
  return text;
}

}  // namespace sinew::report

// SPDX-License-Identifier: Apache-2.0
// Words for numbers, units, probabilities and lists, as the terminal and the reports have them. Between a number and its unit stands
// `no_break`, which the terminal shows as a space.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "plant/system.h"

namespace sinew::apps {

inline constexpr char no_break[] = "\u00a0";

std::string capitalised(std::string_view text);
std::string listed(const std::vector<std::string>& parts);        // "a, b and c"
std::string either_words(const std::vector<std::string>& parts);  // "a, b or c"
std::string file_name(const std::string& path);

std::string channel_words(const plant::ChannelInfo& channel);  // "the angle", "temperature A"
// "0.35 °C", "6.1°".
std::string channel_value(const plant::ChannelInfo& channel, double value, int digits = 2);
std::string unit_words(std::string_view unit);  // "N·m/rad", "°C"
std::string with_unit(const std::string& number, std::string_view unit);
// A number, and the ends of its interval, with as many decimals as the interval deserves.
std::string rounded(double value, double lowest, double highest);
std::string interval_words(double value, double lowest, double highest, std::string_view unit);  // "24.6 s [22.1, 27.0]"
std::string percent(double share);
std::string percent_interval(double share, double lowest, double highest);  // "96 % [92, 97]"
// "practically certain (probability 0.998)".
std::string probability_words(double probability);
// How often something happens by chance: "in less than one of a million recordings".
std::string chance_words(double probability);
// Of a loss of log evidence: "120 times less likely".
std::string odds_words(double loss);

}  // namespace sinew::apps

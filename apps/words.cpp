// SPDX-License-Identifier: Apache-2.0
#include "apps/words.h"

#include <algorithm>
#include <cmath>
#include <filesystem>

#include "report/number.h"

namespace sinew::apps {
namespace {

std::string percent_number(double share) {
  if (!std::isfinite(share)) return "–";
  const double hundredths = 100.0 * share;
  // Near all and near nothing a decimal matters.
  if (hundredths > 99.0 && hundredths < 100.0) return report::fixed(std::min(hundredths, 99.9), 1);
  if (const double size = std::abs(hundredths); size > 0.0 && size < 1.0)
    return report::fixed(std::copysign(std::max(size, 0.1), hundredths), 1);
  return report::fixed(hundredths, 0);
}

}  // namespace

std::string capitalised(std::string_view text) {
  std::string copy(text);
  if (!copy.empty()) copy[0] = static_cast<char>(std::toupper(static_cast<unsigned char>(copy[0])));
  return copy;
}

std::string channel_words(const plant::ChannelInfo& channel) { return (channel.part.empty() ? "the " : "") + channel.words; }

std::string channel_value(const plant::ChannelInfo& channel, double value, int digits) {
  return report::significant(value, digits) + (channel.unit_words == "°" ? "" : no_break) + channel.unit_words;
}

std::string unit_words(std::string_view unit) {
  std::string text;
  for (std::size_t i = 0; i < unit.size(); ++i) {
    if (unit.substr(i).starts_with("degC"))
      text += "°C", i += 3;
    else if (unit.substr(i).starts_with("deg"))
      text += "°", i += 2;
    else if (unit.substr(i).starts_with("Ohm"))
      text += "Ω", i += 2;
    else if (unit.substr(i).starts_with("^2"))
      text += "²", ++i;
    else if (unit.substr(i).starts_with("^3"))
      text += "³", ++i;
    else if (unit[i] == '*')
      text += "·";
    else
      text += unit[i];
  }
  return text;
}

std::string with_unit(const std::string& number, std::string_view unit) {
  const std::string words = unit_words(unit);
  if (words.empty()) return number;
  return words == "°" ? number + words : number + no_break + words;
}

std::string rounded(double value, double lowest, double highest) {
  const double width = 0.5 * (highest - lowest);
  if (!(width > 0.0) || !std::isfinite(width)) return report::significant(value, 3);
  const double largest = std::max({std::abs(value), std::abs(lowest), std::abs(highest)});
  if (largest < 1e-3) return report::significant(value, std::clamp(2 + static_cast<int>(std::floor(std::log10(largest / width))), 2, 6));
  return report::fixed(value, std::clamp(1 - static_cast<int>(std::floor(std::log10(width))), 0, 9));
}

std::string interval_words(double value, double lowest, double highest, std::string_view unit) {
  return with_unit(rounded(value, lowest, highest), unit) + " [" + rounded(lowest, lowest, highest) + "," + no_break +
         rounded(highest, lowest, highest) + "]";
}

std::string percent(double share) { return percent_number(share) + no_break + "%"; }

std::string percent_interval(double share, double lowest, double highest) {
  return percent(share) + " [" + percent_number(lowest) + "," + no_break + percent_number(highest) + "]";
}

std::string probability_words(double probability) {
  const char* words = probability >= 0.99   ? "practically certain"
                      : probability >= 0.95 ? "very likely"
                      : probability >= 0.8  ? "likely"
                      : probability > 0.505 ? "more likely than not"
                      : probability >= 0.45 ? "as likely as not"
                      : probability >= 0.2  ? "possible"
                                            : "unlikely";
  const std::string number = probability > 0.999 ? "above 0.999" : report::fixed(probability, probability > 0.99 ? 3 : 2);
  return std::string(words) + " (probability " + number + ")";
}

std::string chance_words(double probability) {
  if (probability < 1e-6) return "in less than one of a million recordings";
  if (probability > 0.5) return "in most recordings";
  const double one_in = 1.0 / probability;
  if (one_in < 10.0) return "in one of " + report::fixed(one_in, 0) + " recordings";
  const double power = std::pow(10.0, std::floor(std::log10(one_in)));
  return "in one of " + report::fixed(std::round(one_in / power) * power, 0) + " recordings";
}

std::string odds_words(double loss) {
  if (loss < 0.0) return "more likely by a factor of " + report::significant(std::exp(std::min(-loss, 13.0)), 2);
  if (loss < 0.4) return "about as likely";
  if (loss > 13.8) return "more than a million times less likely";
  const double factor = std::exp(loss);
  if (factor < 10.0) return report::significant(factor, 2) + " times less likely";
  const double power = std::pow(10.0, std::floor(std::log10(factor)) - 1.0);
  return report::fixed(std::round(factor / power) * power, 0) + " times less likely";
}

std::string listed(const std::vector<std::string>& parts) {
  std::string text;
  for (std::size_t i = 0; i < parts.size(); ++i) text += (i == 0 ? "" : i + 1 == parts.size() ? " and " : ", ") + parts[i];
  return text;
}

std::string either_words(const std::vector<std::string>& parts) {
  std::string text;
  for (std::size_t i = 0; i < parts.size(); ++i) text += (i == 0 ? "" : i + 1 == parts.size() ? " or " : ", ") + parts[i];
  return text;
}

std::string file_name(const std::string& path) {
  const std::filesystem::path file(path);
  // `run` calls all its recordings alike; their folders tell them apart.
  if ((file.filename() == "recording.csv" || file.filename() == "timed.csv") && file.has_parent_path())
    return (file.parent_path().filename() / file.filename()).string();
  return file.filename().string();
}

}  // namespace sinew::apps

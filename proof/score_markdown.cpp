// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>

#include "proof/judged.h"
#include "proof/score_files.h"
#include "report/console.h"
#include "report/markdown.h"
#include "report/number.h"

namespace sinew::proof {
namespace {

using report::fixed;
using report::significant;

constexpr std::size_t line_columns = 140;

std::string percent(double share) { return fixed(100.0 * share, 1) + " %"; }
std::string of_all(const Share& share) { return std::to_string(share.good) + " of " + std::to_string(share.all); }

std::string seeds_words(const Score& score) {
  std::string text;
  if (score.first_seed) text += std::to_string(*score.first_seed) + " on";
  if (score.first_clean_seed) text += (text.empty() ? "" : ", where nothing is missing ") + std::to_string(*score.first_clean_seed) + " on";
  return text + " (what was taken out of the catalogue: 500 more)";
}

std::string head(const Score& score, const std::string& command) {
  return "# Proof on concealed data\n\nMade by `" + command + "`, " + std::to_string(score.cases) + " cases" +
         (score.wanted == score.cases ? "" : " of " + std::to_string(score.wanted) + ", those that have been made") +
         ". Seeds: " + seeds_words(score) + "; docs/diagnosis.md says which were looked at before. In " + std::to_string(score.invisible) +
         " of them the calibrated core leaves nothing to be seen (d' below 5), or calibration absorbs the effect and the answer lists it "
         "by name as one that the recording cannot show, and the answer said that nothing is missing.\n\n";
}

std::string measured_cell(const Figure& figure) {
  if (figure.of() == 0) return "not measured";
  if (std::holds_alternative<Share>(figure.measured)) return measured_words(figure);
  const bool as_percent = std::get<Quantity>(figure.measured).as_percent;
  return (as_percent ? percent(figure.value()) : significant(figure.value(), 3)) + " (of " + std::to_string(figure.of()) + ")";
}

std::string interval_cell(const Figure& figure) {
  const auto* share = std::get_if<Share>(&figure.measured);
  return share && share->all > 0 ? " " + percent(share->interval().lowest) + " to " + percent(share->interval().highest) : "";
}

std::string figures(const Score& score) {
  std::string text = "| figure | measured | 95 % interval | goal | reached |\n|---|---|---|---|---|\n";
  for (const Figure& figure : score.figures)
    text += "| " + figure.what + " | " + measured_cell(figure) + " |" + interval_cell(figure) + " | " + figure.goal.words + " | " +
            (figure.of() == 0   ? "–"
             : figure.reached() ? "yes"
                                : "**no**") +
            " |\n";
  return text + "\n";
}

std::string unlike_words(const Score& score) {
  std::string text;
  if (score.said_unlike.all > 0) text += " Of quantities in which parts differ the answer said so in " + of_all(score.said_unlike) + ".";
  if (score.wrongly_said_unlike.good > 0) text += " Parts that are alike were said to differ in " + of_all(score.wrongly_said_unlike) + ".";
  return text;
}

std::string notes(const Score& score) {
  std::string text;
  if (score.clean > 0)
    text += "Largest gain that an effect had where nothing was concealed: " + significant(score.largest_clean_gain, 3) +
            "; largest process noise of the core: " + significant(score.largest_clean_noise, 3) + ". ";
  text += "Made by";
  for (const auto& [program, count] : score.programs) text += " " + program + " (" + std::to_string(count) + " cases)";
  return text + ". Of the cases in which the held-out error is worse than before, " + std::to_string(score.worse_for_all) +
         " are worse for an oracle (true effect, fitted strength), too: air moved otherwise there. The equation that the answer says first "
         "was right in " +
         of_all(score.place_said_first) + "; the others count where it says that they cannot be told apart." + unlike_words(score) + "\n";
}

std::string cell_of(const MethodRow& row, const std::optional<double>& value) {
  return !value ? "–" : row.is_share ? percent(*value) : significant(*value, 3);
}

std::string methods(const Score& score) {
  if (score.methods.empty()) return "";
  const std::string sinew(sinew_method);
  report::Table table{.header = {"figure", sinew}};
  for (const auto& [method, value] : score.methods.front().by_method)
    if (method != sinew) table.header.push_back(method);
  for (const MethodRow& row : score.methods) {
    report::Row cells{.cells = {row.what}};
    for (std::size_t c = 1; c < table.header.size(); ++c) cells.cells.push_back(cell_of(row, row.by_method.at(table.header[c])));
    table.rows.push_back(cells);
  }
  table.align.assign(table.header.size(), report::Align::left);
  return "\n## Simpler methods on the same cases\n\nOn the first seed of every case. Misnamed counts for Sinew where the confidence is a "
         "half or more; every name that BIC gives counts. SINDy and the Gaussian process correct the core's predictions and name no "
         "effect; what each does "
         "stands in proof/baselines.h.\n\n" +
         report::to_markdown(table);
}

std::string strata(const Score& score) {
  std::string text =
      "\n## By how visible the effect is\n\nd' is the distance, in standard deviations, of the recording from the nearest calibrated "
      "core with its sensors' noise and moving air. Right answers of all; of outside and removed, those that are not confidently "
      "misnamed:\n\n| family |";
  std::string rule = "\n|---|";
  for (const std::string& level : visibility_strata) text += " " + level + " |", rule += "---|";
  text += rule + "\n";
  for (const auto& [family, levels] : score.strata) {
    text += "| " + family + " |";
    for (const std::string& level : visibility_strata) text += " " + (levels.contains(level) ? of_all(levels.at(level)) : "–") + " |";
    text += "\n";
  }
  return text;
}

std::string families(const Score& score) {
  std::string text =
      "\n## What was said, by family\n\nOf several concealed effects any may be named first. The oracle is a fit of the generator's own "
      "law (proof/oracle.h); its share is the median over the cases that have one.\n\n"
      "| family | right name first | wrong name first | something without a name | nothing is missing | failed | any wrong name with 0.5 "
      "or more | with 0.9 or more | share of the oracle's held-out reduction |\n|---|---|---|---|---|---|---|---|---|\n";
  for (const auto& [family, of] : score.by_family) {
    text += "| " + std::string(text_of(family)) + " |";
    for (const int count : {of.right_first, of.wrong_first, of.unknown, of.nothing, of.failed, of.wrong_confident, of.wrong_nearly_certain})
      text += " " + std::to_string(count) + " |";
    text += (of.shares_of_oracle.empty()
                 ? " not measured"
                 : " " + percent(median(of.shares_of_oracle)) + " (of " + std::to_string(of.shares_of_oracle.size()) + ")") +
            " |\n";
  }
  return text;
}

std::string confidence(const Score& score) {
  std::string text =
      "\n## What the confidence is worth\n\nOf the answers of all families that name something, how often the first name is what was "
      "concealed, by the confidence it was given. An effect that was outside of the catalogue, or taken out of it, has no right "
      "name.\n\n| confidence | first name right |\n|---|---|\n";
  for (const ConfidenceClass& one : score.confidence)
    text += "| " + fixed(one.from, 2) + " to " + fixed(one.to, 2) + " | " + of_all(one.right) + " |\n";
  return text;
}

std::string bins(const Reliability& one) {
  std::string text = "\n| probability | mean | came true | 95 % interval |\n|---|---|---|---|\n";
  for (const ReliabilityBin& bin : one.bins)
    text += "| " + fixed(bin.lowest, 3) + " to " + fixed(bin.highest, 3) + " | " + fixed(bin.mean_probability, 3) + " | " +
            percent(bin.came_true.value()) + " (" + of_all(bin.came_true) + ") | " + percent(bin.came_true.interval().lowest) + " to " +
            percent(bin.came_true.interval().highest) + " |\n";
  return text;
}

std::string reliability(const Score& score) {
  std::string text =
      "\n## Whether probabilities mean what they say\n\nEvery name that is given, with its probability, is a forecast; so is \"nothing is "
      "missing\" where it comes with a probability (proof/forecasts.h). Without one it was right in " +
      of_all(score.said_nothing) + "; \"something is missing\" without a name was right, in that no name of the catalogue was, in " +
      of_all(score.said_unknown) +
      ". Brier and log score: less is better. The calibration error is over bins of about equal count; beside it what chance alone makes "
      "of so many forecasts that mean what they say. Picture: reliability.svg.\n\n"
      "| method | forecasts | Brier score | log score | expected calibration error | by chance |\n|---|---|---|---|---|---|\n";
  for (const Reliability& one : score.reliability)
    text += "| " + one.method + " | " + std::to_string(one.forecasts) + " | " +
            (one.forecasts == 0 ? "not measured | | |"
                                : fixed(one.brier, 3) + " | " + fixed(one.log, 3) + " | " + fixed(one.calibration_error, 3) + " | " +
                                      fixed(one.calibration_error_by_chance, 3)) +
            " |\n";
  for (const Reliability& one : score.reliability)
    if (one.forecasts > 0) text += "\n" + one.method + ":\n" + bins(one);
  return text;
}

std::string disturbances(const Score& score) {
  std::string text =
      "\n## Each disturbance\n\nAir moves in all of them. One more may be there: sensors with steps of 0.5 K and 0.25°, gaps, outliers, a "
      "clock that drifts by 1 %, a start in mid-motion.\n\n| disturbance | nothing concealed: no false alarm | an effect of the "
      "catalogue: right name first |\n|---|---|---|\n";
  for (const auto& [variant, families] : score.by_disturbance) {
    text += "| " + variant + " |";
    for (const char* family : {"clean", "catalogue"}) text += " " + (families.contains(family) ? of_all(families.at(family)) : "–") + " |";
    text += "\n";
  }
  return text;
}

std::string effects(const Score& score) {
  std::string text =
      "\n## Each effect of the catalogue\n\nCases that show nothing of it were answered so.\n\n| effect | right name first | cases that "
      "show nothing of it |\n|---|---|---|\n";
  const auto row = [](const std::string& effect, const EffectScore& of) {
    return "| " + effect + " | " + (of.right.all > 0 ? of_all(of.right) : "–") + " | " + (of.hidden > 0 ? std::to_string(of.hidden) : "") +
           " |\n";
  };
  // Those that never show come last.
  for (const bool shown : {true, false})
    for (const auto& [effect, of] : score.by_effect)
      if ((of.right.all > 0) == shown) text += row(effect, of);
  return text;
}

std::string misses(const Score& score) {
  std::string text = "\n## Every miss\n\n| case | what it said | what its numbers say of why | d' |\n|---|---|---|---|\n";
  for (const Miss& miss : score.misses)
    text += "| " + miss.id + " | " + miss.why + " | " + miss.reason + " | " + significant(miss.visibility, 3) + " |\n";
  text += "\n## Every equation that was not right\n\n| case | where it said | where it was |\n|---|---|---|\n";
  for (const Misplaced& one : score.misplaced) text += "| " + one.id + " | " + one.said + " | " + one.truth + " |\n";
  return text;
}

// Paragraphs in lines that an editor shows; tables and headings are a line a row.
std::string filled(const std::string& markdown) {
  std::string text;
  for (std::size_t from = 0; from < markdown.size();) {
    const std::size_t end = std::min(markdown.find('\n', from), markdown.size());
    const std::string line = markdown.substr(from, end - from);
    text += (line.starts_with("|") || line.starts_with("#") ? line : report::wrap(line, line_columns)) + "\n";
    from = end + 1;
  }
  return text;
}

}  // namespace

std::string measured_words(const Figure& figure) {
  const auto* share = std::get_if<Share>(&figure.measured);
  return share ? percent(share->value()) + " (" + of_all(*share) + ")" : significant(figure.value(), 3);
}

std::string score_markdown(const Score& score, const std::string& command) {
  return filled(head(score, command) + figures(score) + notes(score) + methods(score) + strata(score) + families(score) +
                confidence(score) + reliability(score) + disturbances(score) + effects(score) + misses(score));
}

}  // namespace sinew::proof

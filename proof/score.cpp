// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <map>

#include "plant/systems.h"
#include "proof/cases.h"
#include "report/number.h"

namespace sinew::proof {
namespace {

using Json = nlohmann::ordered_json;

// Below this d' a case shows nothing: to say so is right.
constexpr double invisible_below = 5.0;
// A name that is given with less confidence than this is no confident answer.
constexpr double confident = 0.5;
// Bounds of the classes of confidence that are compared with how often the first name is right.
constexpr std::array<double, 5> confidence_classes{0.0, confident, 0.8, 0.95, 1.0};

struct Count {
  int good = 0, all = 0;
  void add(bool is_good) { good += is_good, ++all; }
  double share() const { return all > 0 ? static_cast<double>(good) / all : std::nan(""); }
  // Wilson's interval, 95 %.
  std::array<double, 2> interval() const {
    if (all == 0) return {std::nan(""), std::nan("")};
    constexpr double z = 1.959964;
    const double n = all, p = share(), middle = p + z * z / (2 * n), half = z * std::sqrt(p * (1 - p) / n + z * z / (4 * n * n));
    return {(middle - half) / (1 + z * z / n), (middle + half) / (1 + z * z / n)};
  }
};

double median(std::vector<double> values) {
  if (values.empty()) return std::nan("");
  std::sort(values.begin(), values.end());
  return 0.5 * (values[(values.size() - 1) / 2] + values[values.size() / 2]);
}

Json share_json(const std::string& what, const Count& count, const std::string& goal, bool reached) {
  return {{"what", what},
          {"good", count.good},
          {"of", count.all},
          {"share", count.all ? Json(count.share()) : Json()},
          {"interval", {count.interval()[0], count.interval()[1]}},
          {"goal", goal},
          {"reached", count.all > 0 && reached}};
}
// What a simpler method made of the same cases (baselines.h).
struct Baseline {
  Count right, form, alarms, misnamed, both;
  std::vector<double> reductions;
};

Json number_json(const std::string& what, double value, std::size_t of, const std::string& goal, bool reached) {
  return {{"what", what}, {"value", value}, {"of", of}, {"goal", goal}, {"reached", of > 0 && reached}};
}

std::vector<std::string> names_of(const Json& effects) {
  std::vector<std::string> names;
  for (const Json& effect : effects) names.push_back(effect["name"]);
  return names;
}
// NaN where a plant could not follow the recording to its end.
double number(const Json& value) { return value.is_null() ? std::nan("") : value.get<double>(); }

bool contains(const std::vector<std::string>& names, const std::string& name) {
  return std::find(names.begin(), names.end(), name) != names.end();
}

std::string percent(double share) { return report::fixed(100.0 * share, 1) + " %"; }

// How much of the calibrated core's misfit an effect alone explains, as the first round of the search fitted it; NaN
// where it was not among those that were.
double explained_alone(const Json& result, const std::string& effect) {
  const Json& first = result["rounds"][0];
  const double core = number(result["explanations"][0]["misfit"]);
  if (!(core > 0.0)) return std::nan("");
  if (first.contains("candidates"))
    for (const Json& candidate : first["candidates"])
      if (candidate[0] == effect) return 1.0 - std::max(0.0, number(candidate[2])) / core;
  return std::nan("");
}

std::string alone(const Json& result, const std::string& effect) {
  const double share = explained_alone(result, effect);
  return std::isnan(share) ? effect + " was not among the effects that were fitted" : effect + " alone explains " + percent(share);
}

// What the numbers of a missed case say of why.
std::string reason_of(const std::string& family, const std::vector<std::string>& truth, const std::vector<std::string>& named,
                      const std::vector<std::string>& set, const Json& result) {
  if (result["verdict"] == "failed") return result["why"];
  const double share = number(result["explained_share"]), left = number(result["unrest"][1]);
  std::string text;
  const auto add = [&](const std::string& more) { text += (text.empty() ? "" : "; ") + more; };
  if (!named.empty()) {
    std::string all = named[0];
    for (std::size_t i = 1; i < named.size(); ++i) all += " and " + named[i];
    if (share > 0.995)
      add(all + (named.size() > 1 ? " explain" : " explains") + " all that can be seen in this recording");
    else
      add(all + (named.size() > 1 ? " explain " : " explains ") + percent(share) + " of the misfit, process noise of " +
          report::significant(left, 3) + " is left");
  }
  if (family == "catalogue" || family == "other_form" || family == "pair")
    for (const std::string& name : truth) {
      if (contains(named, name)) continue;
      add(alone(result, name));
      if (contains(set, name)) add("it is in the set of those that cannot be told apart");
    }
  if (family != "pair" && named.empty() && result["verdict"] == "unexplained") {
    if (result.contains("objections") && !result["objections"].empty())
      for (const Json& objection : result["objections"]) add("against what was found: " + objection.get<std::string>());
    else
      add("no name holds, process noise of " + report::significant(left, 3) + " is left");
  }
  return text;
}

}  // namespace

Json score_proof(const Json& answers, const Json& results) {
  Count right, form, alarms, unknown, misnamed, removed_unknown, removed_misnamed, both, one_of_two, contained, place, covered, worse;
  std::map<std::string, Count> right_by_effect;
  std::map<std::string, int> hidden_by_effect;                           // cases of the catalogue that show nothing of it
  std::map<std::string, std::map<std::string, Count>> right_by_variant;  // of a family; clean: no false alarm
  std::vector<double> sizes, errors, reductions;
  std::map<std::string, std::map<std::string, Count>> strata;
  std::map<std::string, std::map<std::string, int>> confusion;
  Json misses = Json::array(), misplaced = Json::array();
  std::array<Count, confidence_classes.size() - 1> right_by_confidence;
  int invisible = 0, cases = 0, worse_for_all = 0, place_said_first = 0;
  double largest_clean_gain = 0.0, largest_clean_unrest = 0.0;
  std::map<std::string, int> programs;
  std::map<std::string, Baseline> others;
  Baseline ours;
  for (const auto& [id, answer] : answers.items()) {
    if (!results.contains(id)) continue;
    const Json& result = results[id];
    ++cases;
    const std::string family = answer["family"], verdict = result["verdict"];
    const std::vector<std::string> truth = names_of(answer["effects"]), named = names_of(result["effects"]);
    std::vector<std::string> set = named;
    for (const Json& name : result["ambiguous_with"]) set.push_back(name);
    const double seen = result["visibility"];
    // Nothing to see, or an effect that calibration absorbs and the answer lists by name as one that this recording
    // cannot show.
    const bool said_by_name = verdict == "consistent" && truth.size() == 1 && contains(result["cannot_be_seen"], truth[0]);
    const bool nothing_to_see = family != "clean" && (seen < invisible_below || said_by_name);
    const std::string first = named.empty() ? (verdict == "consistent" ? "(nothing)" : "(unknown)") : named[0];
    if (!named.empty()) {
      const double confidence = result["effects"][0]["confidence"];
      std::size_t at = 0;
      while (at + 1 < right_by_confidence.size() && confidence >= confidence_classes[at + 1]) ++at;
      right_by_confidence[at].add(family != "removed" && contains(truth, first));
    }
    const bool confidently = !named.empty() && result["effects"][0]["confidence"].get<double>() >= confident;
    const std::string stratum = seen < invisible_below ? "d' < 5" : seen < 20 ? "5 to 20" : seen < 100 ? "20 to 100" : "over 100";
    const std::string sure = named.empty() ? "" : " (" + report::fixed(result["effects"][0]["confidence"].get<double>(), 2) + ")";
    bool good = true;
    std::string why;
    const auto miss = [&](const std::string& reason) { good = false, why = reason; };
    // The equation, or one of a group of which the answer says that they cannot be told apart.
    const auto placed = [&] {
      const bool said_first = result["located"]["place"] == answer["effects"][0]["place"];
      const std::vector<std::string> group = result["located"].value("or", std::vector<std::string>{});
      const bool right_place = said_first || contains(group, answer["effects"][0]["place"].get<std::string>());
      place.add(right_place);
      place_said_first += said_first;
      if (!right_place) misplaced.push_back({{"id", id}, {"said", result["located"]["place"]}, {"truth", answer["effects"][0]["place"]}});
      return right_place;
    };
    ++programs[result.value("made_by", "")];
    if (result.contains("baselines")) {
      const Json& baselines = result["baselines"];
      const auto reduction = [&](double after, Baseline& of) {
        if (!result.contains("normalised_oracle")) return;
        const double before = number(result["normalised_before"]), oracle = number(result["normalised_oracle"]);
        if (before > 1.1 * oracle) of.reductions.push_back((before - after) / (before - oracle));
      };
      const auto names = [&](Baseline& of, const std::vector<std::string>& given, bool counts_as_sure) {
        const std::string name = given.empty() ? "" : given[0];
        if (family == "clean") of.alarms.add(!given.empty());
        if (family == "catalogue" && !nothing_to_see) of.right.add(name == truth[0]);
        if (family == "other_form" && !nothing_to_see) of.form.add(name == truth[0]);
        if ((family == "outside" || family == "removed") && !nothing_to_see) of.misnamed.add(counts_as_sure && !given.empty());
        if (family == "pair") of.both.add(contains(given, truth[0]) && contains(given, truth[1]));
      };
      names(ours, named, confidently);
      names(others["BIC"], baselines["bic"]["effects"].get<std::vector<std::string>>(), true);
      int terms = 0;
      for (const Json& count : baselines["sindy"]["terms"]) terms += count.get<int>();
      if (family == "clean") others["SINDy"].alarms.add(terms > 0);
      reduction(number(result["normalised_after"]), ours);
      reduction(baselines["bic"].value("normalised_after", number(result["normalised_before"])), others["BIC"]);
      reduction(baselines["sindy"]["normalised_after"], others["SINDy"]);
      reduction(baselines["gaussian_process"]["normalised_after"], others["Gaussian process"]);
    }
    if (family == "clean") {
      if (verdict != "failed") {
        for (const Json& round : result["rounds"]) largest_clean_gain = std::max(largest_clean_gain, round["gain"].get<double>());
        largest_clean_unrest = std::max(largest_clean_unrest, number(result["unrest"][0]));
      }
      alarms.add(verdict != "consistent");
      right_by_variant[answer["variant"]][family].add(verdict == "consistent");
      if (verdict != "consistent") miss("false alarm");
      confusion["(nothing)"][first]++;
    } else if (family == "catalogue" || family == "other_form") {
      confusion[(family == "other_form" ? "other form: " : "") + truth[0]][first]++;
      if (nothing_to_see && named.empty() && verdict == "consistent") {
        ++invisible;
        if (family == "catalogue") ++hidden_by_effect[truth[0]];
        strata[family][stratum].add(true);
      } else {
        (family == "catalogue" ? right : form).add(first == truth[0]);
        if (family == "catalogue") {
          right_by_effect[truth[0]].add(first == truth[0]);
          right_by_variant[answer["variant"]][family].add(first == truth[0]);
        }
        strata[family][stratum].add(first == truth[0]);
        contained.add(contains(set, truth[0]));
        sizes.push_back(static_cast<double>(set.size()));
        placed();
        if (first != truth[0]) miss("named " + first + sure);
      }
    } else if (family == "pair") {
      const int hits = static_cast<int>(contains(named, truth[0])) + static_cast<int>(contains(named, truth[1]));
      both.add(hits == 2);
      one_of_two.add(hits >= 1);
      strata[family][stratum].add(hits == 2);
      if (hits < 2) miss("found " + std::to_string(hits) + " of 2, first " + first);
    } else {  // outside, removed
      if (nothing_to_see && verdict == "consistent") {
        ++invisible;
        strata[family][stratum].add(true);
      } else {
        const bool right_place = placed();
        (family == "outside" ? unknown : removed_unknown).add(verdict == "unexplained" || right_place);
        (family == "outside" ? misnamed : removed_misnamed).add(confidently);
        strata[family][stratum].add(!confidently);
        if (confidently)
          miss("confidently misnamed " + first + sure);
        else if (verdict != "unexplained" && !right_place)
          miss("neither unknown nor in the right place: " + first + sure);
      }
      confusion[(family == "outside" ? "outside: " : "removed: ") + truth[0]][first]++;
    }
    // Parameters of effects that are the catalogue's own, where they were named.
    if (family == "catalogue" || family == "pair")
      for (const Json& effect : result["effects"])
        for (const Json& true_effect : answer["effects"]) {
          if (true_effect["name"] != effect["name"] || !effect.contains("parameters")) continue;
          const std::string strength = effect["strength"];
          for (const auto& [name, value] : true_effect["parameters"].items()) {
            if (!effect["parameters"].contains(name) || effect["parameters"][name]["known"].get<bool>()) continue;
            const Json& estimate = effect["parameters"][name];
            const double truth_value = value, estimated = estimate["value"];
            covered.add(truth_value >= estimate["ci95"][0].get<double>() && truth_value <= estimate["ci95"][1].get<double>());
            const double null = effect["null"];
            if (name == strength && truth_value != null) errors.push_back(std::abs(estimated - truth_value) / std::abs(truth_value - null));
          }
        }
    if (!named.empty()) {
      const double was = number(result["normalised_before"]), is = number(result["normalised_after"]);
      worse.add(!std::isnan(was) && !(is <= was));
      worse_for_all += !(is <= was) && result.contains("normalised_oracle") && number(result["normalised_oracle"]) > was;
      if (result.contains("normalised_oracle")) {
        const double before = number(result["normalised_before"]), after = number(result["normalised_after"]),
                     oracle = number(result["normalised_oracle"]);
        if (before > oracle) reductions.push_back((before - after) / (before - oracle));
      }
    }
    if (!good)
      misses.push_back({{"id", id},
                        {"why", why},
                        {"reason", reason_of(family, truth, named, set, result)},
                        {"visibility", seen},
                        {"verdict", verdict},
                        {"truth", truth},
                        {"named", named}});
  }
  std::vector<std::string> worst_effects;
  double worst_share = 2.0;
  for (const auto& [effect, count] : right_by_effect) {
    if (count.share() < worst_share) worst_share = count.share(), worst_effects.clear();
    if (count.share() == worst_share) worst_effects.push_back(effect);
  }
  std::string least;
  for (const std::string& effect : worst_effects) least += (least.empty() ? "" : ", ") + effect;
  if (worst_effects.size() > 1 && worst_effects.size() == right_by_effect.size()) least = "all are alike";
  Json score;
  score["cases"] = cases;
  score["invisible"] = invisible;
  for (const char* part : {"by_effect", "by_disturbance", "strata", "confusion"}) score[part] = Json::object();
  Json& figures = score["figures"];
  figures.push_back(share_json("one concealed effect: right name first", right, "at least 95 %", right.share() >= 0.95));
  figures.push_back(share_json("the effect of " + std::to_string(right_by_effect.size()) + " that is recognised least: " + least,
                               worst_effects.empty() ? Count{} : right_by_effect[worst_effects[0]], "at least 80 %", worst_share >= 0.8));
  figures.push_back(share_json("same physics in another form: right name first", form, "at least 85 %", form.share() >= 0.85));
  figures.push_back(share_json("nothing concealed: false alarms", alarms, "at most 2 %", alarms.share() <= 0.02));
  figures.push_back(
      share_json("outside the catalogue: said to be unknown, or right equation", unknown, "at least 90 %", unknown.share() >= 0.9));
  figures.push_back(share_json("outside the catalogue: confidently misnamed", misnamed, "at most 5 %", misnamed.share() <= 0.05));
  figures.push_back(share_json("taken out of the catalogue: said to be unknown, or right equation", removed_unknown, "at least 90 %",
                               removed_unknown.share() >= 0.9));
  figures.push_back(
      share_json("taken out of the catalogue: confidently misnamed", removed_misnamed, "at most 5 %", removed_misnamed.share() <= 0.05));
  figures.push_back(share_json("two effects: both named", both, "at least 80 %", both.share() >= 0.8));
  figures.push_back(share_json("two effects: one or both named", one_of_two, "at least 97 %", one_of_two.share() >= 0.97));
  figures.push_back(share_json("the set that the answer names contains the truth", contained, "95 ± 3 %", contained.share() >= 0.92));
  figures.push_back(number_json("median size of that set", median(sizes), sizes.size(), "one or two", median(sizes) <= 2.0));
  figures.push_back(share_json("equation right, or among those said to be alike", place, "at least 97 %", place.share() >= 0.97));
  figures.push_back(number_json("strength: median relative error", median(errors), errors.size(), "under 10 %", median(errors) < 0.1));
  figures.push_back(
      share_json("95 % intervals that cover the truth", covered, "92 to 98 %", covered.share() >= 0.92 && covered.share() <= 0.98));
  figures.push_back(number_json("held-out error: median share of the reduction of one who knows the effect", median(reductions),
                                reductions.size(), "at least 95 %", median(reductions) >= 0.95));
  figures.push_back(share_json("held-out error worse than before", worse, "at most 1 %", worse.share() <= 0.01));
  for (const auto& [effect, count] : right_by_effect)
    score["by_effect"][effect] = {{"right", count.good}, {"of", count.all}, {"hidden", 0}};
  for (const auto& [effect, count] : hidden_by_effect) {
    Json& one = score["by_effect"][effect];
    if (one.is_null()) one = {{"right", 0}, {"of", 0}};
    one["hidden"] = count;
  }
  for (const auto& [variant, families] : right_by_variant)
    for (const auto& [family, count] : families) score["by_disturbance"][variant][family] = {{"right", count.good}, {"of", count.all}};
  for (const auto& [family, levels] : strata)
    for (const auto& [level, count] : levels) score["strata"][family][level] = {count.good, count.all};
  for (const auto& [truth, given] : confusion)
    for (const auto& [answer, count] : given) score["confusion"][truth][answer] = count;
  score["confidence"] = Json::array();
  for (std::size_t i = 0; i < right_by_confidence.size(); ++i)
    score["confidence"].push_back({{"from", confidence_classes[i]},
                                   {"to", confidence_classes[i + 1]},
                                   {"right", right_by_confidence[i].good},
                                   {"of", right_by_confidence[i].all}});
  score["worse_for_all"] = worse_for_all;
  score["place_said_first"] = {{"right", place_said_first}, {"of", place.all}};
  score["misses"] = misses;
  score["misplaced"] = misplaced;
  score["programs"] = programs;
  score["clean"] = {{"cases", alarms.all}, {"largest_gain", largest_clean_gain}, {"largest_unrest", largest_clean_unrest}};
  score["baselines"] = Json::array();
  if (!others.empty()) {
    const auto row = [&](const std::string& what, auto&& of) {
      Json one{{"what", what}, {"sinew", of(ours)}};
      for (const auto& [method, baseline] : others) one[method] = of(baseline);
      score["baselines"].push_back(one);
    };
    const auto share = [](const Count& count) { return count.all ? Json(count.share()) : Json(); };
    row("one concealed effect: right name first", [&](const Baseline& b) { return share(b.right); });
    row("same physics in another form: right name first", [&](const Baseline& b) { return share(b.form); });
    row("nothing concealed: false alarms", [&](const Baseline& b) { return share(b.alarms); });
    row("outside or taken out of the catalogue: misnamed", [&](const Baseline& b) { return share(b.misnamed); });
    row("two effects: both named", [&](const Baseline& b) { return share(b.both); });
    row("held-out error: median share of the reduction of one who knows",
        [&](const Baseline& b) { return b.reductions.empty() ? Json() : Json(median(b.reductions)); });
  }
  return score;
}

namespace {

std::string seeds_text(const Json& score) {
  std::string text;
  if (score.contains("first_seed")) text += std::to_string(score["first_seed"].get<std::uint64_t>()) + " on";
  if (score.contains("first_clean_seed"))
    text += (text.empty() ? "" : ", where nothing is missing ") + std::to_string(score["first_clean_seed"].get<std::uint64_t>()) + " on";
  return text + " (what was taken out of the catalogue: 500 more)";
}

}  // namespace

std::string proof_markdown(const Json& score, const std::string& command) {
  std::string text =
      "# Proof on concealed data\n\nMade by `" + command + "`, " + std::to_string(score["cases"].get<int>()) + " cases" +
      (score["wanted"] == score["cases"] ? std::string()
                                         : " of " + std::to_string(score["wanted"].get<int>()) + ", those that have been made") +
      ". Seeds: " + seeds_text(score) + "; docs/diagnosis.md says which were looked at before. In " +
      std::to_string(score["invisible"].get<int>()) +
      " of them the calibrated core leaves nothing to be seen (d' below 5), or calibration absorbs the "
      "effect and the answer lists it by "
      "name as one that the recording cannot show, and the answer said that nothing is missing.\n\n"
      "| figure | measured | 95 % interval | goal | reached |\n|---|---|---|---|---|\n";
  for (const Json& figure : score["figures"]) {
    text += "| " + figure["what"].get<std::string>() + " | ";
    if (figure["of"].get<double>() == 0)
      text += "no case | |";
    else if (figure.contains("share"))
      text += percent(figure["share"]) + " (" + std::to_string(figure["good"].get<int>()) + " of " +
              std::to_string(figure["of"].get<int>()) + ") | " + percent(figure["interval"][0]) + " to " + percent(figure["interval"][1]) +
              " |";
    else
      text += (figure["goal"].get<std::string>().ends_with("%") ? percent(figure["value"]) : report::significant(figure["value"], 3)) +
              " (of " + std::to_string(figure["of"].get<int>()) + ") | |";
    text += " " + figure["goal"].get<std::string>() + " | " +
            (figure["of"].get<double>() == 0 ? "–"
             : figure["reached"].get<bool>() ? "yes"
                                             : "**no**") +
            " |\n";
  }
  text += "\n";
  if (score["clean"]["cases"].get<int>() > 0)
    text += "Largest gain that an effect had where nothing was concealed: " + report::significant(score["clean"]["largest_gain"], 3) +
            "; largest process noise of the core: " + report::significant(score["clean"]["largest_unrest"], 3) + ". ";
  text += "Made by";
  for (const auto& [program, count] : score["programs"].items())
    text += " " + program + " (" + std::to_string(count.get<int>()) + " cases)";
  text += ". Of the cases in which the held-out error is worse than before, " + std::to_string(score["worse_for_all"].get<int>()) +
          " are worse, too, for one who knows the effect: air moved otherwise there. The equation that the answer says first was "
          "right in " +
          std::to_string(score["place_said_first"]["right"].get<int>()) + " of " +
          std::to_string(score["place_said_first"]["of"].get<int>()) + "; the others count where it says that they cannot be told apart.\n";
  if (!score["baselines"].empty()) {
    text +=
        "\n## Simpler methods on the same cases\n\nOn the first seed of every case. Misnamed counts for Sinew where the "
        "confidence is a half or more; BIC gives none. "
        "SINDy and the Gaussian "
        "process correct the core's predictions and name no effect; what each does stands in "
        "proof/baselines.h.\n\n|";
    for (const auto& [column, value] : score["baselines"][0].items())
      text += (column == "what" ? " figure" : " " + column) + std::string(" |");
    text += "\n|";
    for (std::size_t i = 0; i < score["baselines"][0].size(); ++i) text += "---|";
    text += "\n";
    for (const Json& row : score["baselines"]) {
      text += "|";
      for (const auto& [column, value] : row.items())
        text += " " + (column == "what" ? value.get<std::string>() : value.is_null() ? "–" : percent(value)) + " |";
      text += "\n";
    }
  }
  text +=
      "\n## By how visible the effect is\n\nd' is the distance, in standard deviations, of the recording from the "
      "nearest calibrated "
      "core with its sensors' noise and moving air. Right answers of all; of outside and removed, those that are not "
      "confidently misnamed:\n\n| family | d' < 5 | 5 to 20 | 20 to 100 | "
      "over 100 |\n|---|---|---|---|---|\n";
  for (const auto& [family, levels] : score["strata"].items()) {
    text += "| " + family + " |";
    for (const char* level : {"d' < 5", "5 to 20", "20 to 100", "over 100"})
      text += levels.contains(level)
                  ? " " + std::to_string(levels[level][0].get<int>()) + " of " + std::to_string(levels[level][1].get<int>()) + " |"
                  : " – |";
    text += "\n";
  }
  text +=
      "\n## What the confidence is worth\n\nOf the answers of all families that name something, how often the first "
      "name is what was concealed, by the confidence it was given. An effect that was outside of the catalogue, or "
      "taken out of it, has no right name.\n\n| confidence | first name right |\n|---|---|\n";
  for (const Json& one : score["confidence"])
    text += "| " + report::fixed(one["from"], 2) + " to " + report::fixed(one["to"], 2) + " | " + std::to_string(one["right"].get<int>()) +
            " of " + std::to_string(one["of"].get<int>()) + " |\n";
  const auto right_of_all = [](const Json& count) {
    return std::to_string(count["right"].get<int>()) + " of " + std::to_string(count["of"].get<int>());
  };
  text +=
      "\n## Each disturbance\n\nAir moves in all of them. One more may be there: sensors with steps of 0.5 K and 0.25°, gaps, "
      "outliers, a clock that drifts by 1 %, a start in mid-motion.\n\n| disturbance | nothing concealed: no false "
      "alarm | an effect of the catalogue: right name first |\n|---|---|---|\n";
  for (const auto& [variant, families] : score["by_disturbance"].items()) {
    text += "| " + variant + " |";
    for (const char* family : {"clean", "catalogue"})
      text += " " + (families.contains(family) ? right_of_all(families[family]) : "–") + " |";
    text += "\n";
  }
  text +=
      "\n## Each effect of the catalogue\n\nCases that show nothing of it were answered so.\n\n"
      "| effect | right name first | cases that show nothing of it |\n|---|---|---|\n";
  for (const auto& [effect, count] : score["by_effect"].items())
    text += "| " + effect + " | " + (count["of"].get<int>() > 0 ? right_of_all(count) : "–") + " | " +
            (count["hidden"].get<int>() > 0 ? std::to_string(count["hidden"].get<int>()) : "") + " |\n";
  text += "\n## Every miss\n\n| case | what it said | what its numbers say of why | d' |\n|---|---|---|---|\n";
  for (const Json& miss : score["misses"])
    text += "| " + miss["id"].get<std::string>() + " | " + miss["why"].get<std::string>() + " | " + miss["reason"].get<std::string>() +
            " | " + report::significant(miss["visibility"], 3) + " |\n";
  text += "\n## Every equation that was not right\n\n| case | where it said | where it was |\n|---|---|---|\n";
  for (const Json& one : score["misplaced"])
    text += "| " + one["id"].get<std::string>() + " | " + one["said"].get<std::string>() + " | " + one["truth"].get<std::string>() + " |\n";
  return text;
}

namespace {

// Nothing, the catalogue in its order, its other forms, what was taken out of it, what is outside of it, unknown.
std::pair<int, std::size_t> order_of(const std::string& label) {
  if (label == "(nothing)") return {0, 0};
  if (label == "(unknown)") return {5, 0};
  constexpr std::array<std::string_view, 3> prefixes{"other form: ", "removed: ", "outside: "};
  int group = 1;
  std::string name = label;
  for (std::size_t p = 0; p < prefixes.size(); ++p)
    if (label.starts_with(prefixes[p])) {
      group = static_cast<int>(p) + 2;
      name = label.substr(prefixes[p].size());
    }
  std::size_t place = 0;
  const auto& catalogue = plant::default_plant().system().effects().values();
  while (place < catalogue.size() && catalogue[place].name != name) ++place;
  return {group, place};
}

}  // namespace

std::string confusion_svg(const Json& score) {
  std::vector<std::string> rows, columns;
  for (const auto& [truth, given] : score["confusion"].items()) {
    rows.push_back(truth);
    for (const auto& [answer, count] : given.items())
      if (std::find(columns.begin(), columns.end(), answer) == columns.end()) columns.push_back(answer);
  }
  for (auto* labels : {&rows, &columns})
    std::stable_sort(labels->begin(), labels->end(), [](const std::string& a, const std::string& b) { return order_of(a) < order_of(b); });
  constexpr int cell = 24, left = 250, top = 190, beside_last_label = 90;
  const int width = left + cell * static_cast<int>(columns.size()) + beside_last_label,
            height = top + cell * static_cast<int>(rows.size()) + 20;
  std::string svg = "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"" + std::to_string(width) + "\" height=\"" + std::to_string(height) +
                    "\" font-family=\"sans-serif\" font-size=\"11\">\n<rect width=\"100%\" height=\"100%\" fill=\"white\"/>\n"
                    "<text x=\"10\" y=\"20\" font-size=\"14\">What was concealed (rows) and what was named first (columns)</text>\n"
                    "<text x=\"10\" y=\"38\">Cases of one concealed effect, and of none</text>\n";
  for (std::size_t c = 0; c < columns.size(); ++c) {
    const std::string x = std::to_string(left + cell * static_cast<int>(c) + cell / 2 + 3);
    svg += "<text transform=\"translate(" + x + "," + std::to_string(top - 6) + ") rotate(-60)\">" + columns[c] + "</text>\n";
  }
  for (std::size_t r = 0; r < rows.size(); ++r) {
    const int y = top + cell * static_cast<int>(r);
    svg += "<text x=\"" + std::to_string(left - 6) + "\" y=\"" + std::to_string(y + cell / 2 + 4) + "\" text-anchor=\"end\">" + rows[r] +
           "</text>\n";
    int all = 0;
    for (const auto& [answer, count] : score["confusion"][rows[r]].items()) all += count.get<int>();
    for (std::size_t c = 0; c < columns.size(); ++c) {
      const Json& given = score["confusion"][rows[r]];
      const int count = given.contains(columns[c]) ? given[columns[c]].get<int>() : 0;
      const std::string x = std::to_string(left + cell * static_cast<int>(c));
      const std::string shade = report::fixed(static_cast<double>(count) / all, 3);
      svg += "<rect x=\"" + x + "\" y=\"" + std::to_string(y) + "\" width=\"" + std::to_string(cell) + "\" height=\"" +
             std::to_string(cell) + "\" fill=\"#1f5fa8\" fill-opacity=\"" + shade + "\" stroke=\"#ddd\"/>\n";
      if (count > 0)
        svg += "<text x=\"" + std::to_string(left + cell * static_cast<int>(c) + cell / 2) + "\" y=\"" + std::to_string(y + cell / 2 + 4) +
               "\" text-anchor=\"middle\" fill=\"" + (2 * count > all ? "white" : "black") + "\">" + std::to_string(count) + "</text>\n";
    }
  }
  return svg + "</svg>\n";
}

}  // namespace sinew::proof

// SPDX-License-Identifier: Apache-2.0
#include "apps/diagnosis_text.h"

#include <algorithm>
#include <cmath>
#include <filesystem>

#include "apps/comparison_page.h"
#include "report/number.h"
#include "sim/plant_file.h"

namespace sinew::apps {
namespace {

using diagnose::Diagnosis;
using diagnose::doubtful_below;
using diagnose::Verdict;

constexpr double faint_from = 0.3;       // decades below the typical strength from which on it is said
constexpr double alike_below = 3.0;      // of log evidence
constexpr double goes_with_share = 0.3;  // of what is left: a variable that accounts for less is not worth a sentence

// What was found, as clauses.
std::string found_words(const Diagnosis& d, const diagnose::FoundEffect& found) {
  const plant::EffectId name = plant::family_of(effects_of(d), found.effect);
  return std::string(effects_of(d)[name].words) + (found.form == diagnose::Form::catalogue ? "" : ", in a form of its own");
}
std::vector<std::string> found_words(const Diagnosis& d) {
  std::vector<std::string> words;
  for (const auto& found : d.effects) words.push_back(found_words(d, found));
  return words;
}

// The name whose form a law is here, or may be.
const diagnose::FoundEffect* name_of_law(const Diagnosis& d, const diagnose::FoundLaw& law) {
  for (const auto& found : d.effects)
    if (diagnose::is_own(system_of(d), {found.effect}, law.law)) return &found;
  return nullptr;
}

// "the transformation temperatures", "the values of junction"
std::string sharing_words(const plant::Sharing& sharing) { return sharing.effect ? "the values of " + sharing.words : sharing.words; }

// Effects that were found and have values; a law alone stands for the others.
std::size_t fitted_effects(const Diagnosis& d) {
  const auto is_fitted = [](const auto& found) { return found.form != diagnose::Form::free; };
  return static_cast<std::size_t>(std::count_if(d.effects.begin(), d.effects.end(), is_fitted));
}

// Laws without a name that is likely, as clauses.
std::vector<std::string> law_clauses(const Diagnosis& d) {
  std::vector<std::string> words;
  for (const auto& found : d.laws)
    if (const auto* name = name_of_law(d, found); !name || name->confidence < doubtful_below)
      words.push_back(std::string(effects_of(d)[found.effect].words));
  return words;
}

// "the coils are not alike in the transformation temperatures"
std::string apart_clause(const plant::Sharing& sharing) {
  return "the " + std::string(sharing.parts_word) + " are not alike in " + sharing_words(sharing);
}
std::vector<std::string> apart_clauses(const Diagnosis& d) {
  std::vector<std::string> words;
  for (const auto& found : d.apart) words.push_back(apart_clause(sharing_of(d, found)));
  return words;
}
// "..., likely (probability 0.90)"
std::vector<std::string> apart_with_probabilities(const Diagnosis& d) {
  std::vector<std::string> words;
  for (const auto& found : d.apart) words.push_back(apart_clause(sharing_of(d, found)) + ", " + probability_words(found.confidence));
  return words;
}

std::string either_words(const std::vector<std::string>& parts) {
  std::string text;
  for (std::size_t i = 0; i < parts.size(); ++i) text += (i == 0 ? "" : i + 1 == parts.size() ? " or " : ", ") + parts[i];
  return text;
}

std::string plant_words(const Diagnosis& d) { return std::string(system_of(d).words()); }  // "the limb"

// What is no sign of missing physics.
std::string left_open_words(const Diagnosis& d) {
  return system_of(d).surroundings() ? "noise and moving air leave open" : "noise leaves open";
}

// "temperature A", "the speed of bending".
std::string variable_words(const diagnose::Dependence& on) {
  const bool name = on.variable == "time" || on.variable.starts_with("temperature") || on.variable.starts_with("duty");
  return (name ? "" : "the ") + on.variable;
}

// "goes from 0.1 to 0.4 W/K"; "changes by -12 to 40 %".
std::string change_words(const diagnose::Wandering& w) {
  return (w.of.unit == "%" ? "changes by " : "goes from ") + report::significant(w.lowest, 2) + " to " +
         with_unit(report::significant(w.highest, 2), w.of.unit);
}

// The place, or those that it could be.
std::string located_words(const Diagnosis& d) {
  std::vector<std::string> places{place_words(system_of(d), d.located.place)};
  for (const std::string& other : d.located.cannot_be_told_from) places.push_back(place_words(system_of(d), other));
  return either_words(places);
}

std::string rivals_in_headline(const Diagnosis& d) {
  std::vector<std::string> names;
  for (const plant::EffectId e : d.ambiguous_with) names.push_back(std::string(effects_of(d)[e].words));
  return " – or that " + listed(names) + ": this recording cannot tell them apart.";
}

// Where less than half of what was not found would have been seen, "nothing is missing" would say too much; else empty.
std::string too_little_words(const Diagnosis& d) {
  const auto others = not_found(d);
  const auto seen =
      static_cast<std::size_t>(std::count_if(others.begin(), others.end(), [](const auto& other) { return other.can_be_seen; }));
  if (2 * seen >= others.size()) return "";
  return std::string(seen == 0 ? "Nothing" : "Little") +
         " can be said: " + (d.gate.size() > 1 ? "these recordings show" : "this recording shows") + " too little. Of " +
         std::to_string(others.size()) + " effects that could be missing alone " +
         (seen == 0 ? "none would have been seen at its usual size."
                    : "only " + std::to_string(seen) + " would have been seen at usual size, and " +
                          (seen == 1 ? "it is not there." : "none of these is there."));
}

// "that the supply sags, likely (probability 0.90)"
std::vector<std::string> names_with_probabilities(const Diagnosis& d) {
  std::vector<std::string> named;
  for (const auto& found : d.effects) named.push_back("that " + found_words(d, found) + ", " + probability_words(found.confidence));
  return named;
}

bool nearly_explains(const Diagnosis& d) { return d.explained_share >= diagnose::Thresholds{}.least_explained_share; }

// Where nothing else was found.
std::string only_apart_words(const Diagnosis& d) {
  return capitalised(listed(apart_with_probabilities(d))) + ", and the plant takes them to be alike. That takes away " +
         percent(d.explained_share) + (d.by_paths ? " of the squared error beyond noise" : " of what " + left_open_words(d)) +
         (nearly_explains(d) ? "." : "; what else is missing matches no effect in the catalogue.");
}

std::string verdict_words(const Diagnosis& d) {
  switch (d.verdict) {
    case Verdict::consistent:
      if (d.by_chance)
        return "Nothing is missing that could be told from chance: the plant leaves more than it mostly does, but so do some "
               "recordings in which nothing is missing.";
      if (std::string little = too_little_words(d); !little.empty()) return little;
      return "Nothing is missing that could be seen: with its parameters fitted, the plant explains " +
             std::string(d.gate.size() > 1 ? "the recordings" : "the recording") + " to within sensor noise and moving air.";
    case Verdict::missing_physics: {
      if (d.effects.empty() && d.laws.empty()) return only_apart_words(d);
      const bool doubtful =
          std::all_of(d.effects.begin(), d.effects.end(), [](const auto& found) { return found.confidence < doubtful_below; });
      // Several have a probability each.
      const bool one = d.effects.size() == 1, told_apart = d.ambiguous_with.empty();
      std::string text = std::string(doubtful ? "Something is missing, perhaps " : "The plant leaves out ") +
                         (one || !told_apart ? "that " + listed(found_words(d)) : listed(names_with_probabilities(d)));
      if (const auto laws = law_clauses(d); !laws.empty()) text += "; and, without a name, " + listed(laws);
      text += told_apart ? (one ? ": " + probability_words(d.effects.front().confidence) : "") + "." : rivals_in_headline(d);
      return text + (d.apart.empty() ? "" : " And " + listed(apart_with_probabilities(d)) + ".");
    }
    case Verdict::named_in_part: {
      if (d.effects.empty() && d.laws.empty()) return only_apart_words(d);
      const bool names_alone = d.laws.empty() && d.apart.empty() && !d.by_paths;
      const bool nearly = names_alone && d.objections.leaves_too_much && nearly_explains(d);
      return (nearly ? "What is missing looks like an effect in the catalogue, but something is left that its law does not explain: "
                     : "More is missing than the catalogue explains, but part of it has a name: ") +
             listed(names_with_probabilities(d)) + (law_clauses(d).empty() ? "" : "; and without a name, " + listed(law_clauses(d))) +
             (d.apart.empty() ? "" : "; and " + listed(apart_with_probabilities(d))) +
             (!names_alone || d.ambiguous_with.empty() ? "." : rivals_in_headline(d)) + " " +
             (d.effects.size() + d.laws.size() + d.apart.size() > 1 ? "Together they take" : "It takes") + " away " +
             percent(d.explained_share) + (d.by_paths ? " of the squared error beyond noise." : " of what " + left_open_words(d) + ".");
    }
    case Verdict::unexplained: {
      if (d.wandering) {
        const auto& w = *d.wandering;
        const std::string with =
            w.on.explained_share >= goes_with_share ? " changed with " + variable_words(w.on) : " changed from moment to moment";
        const std::string which = w.of.effect == std::nullopt ? "" : " (" + std::string(effects_of(d)[*w.of.effect].words) + ")";
        return "Something is missing that matches no effect in the catalogue. It acts in " + located_words(d) + ": as if " + w.of.words +
               which + " were no constant but" + with + ".";
      }
      if (!d.effects.empty() && !law_clauses(d).empty())
        return "Something is missing that has a place and a curve: " + listed(law_clauses(d)) + ". It may be " +
               listed(names_with_probabilities(d)) +
               (d.ambiguous_with.empty() ? "; if not, it matches no effect in the catalogue." : rivals_in_headline(d));
      if (!d.laws.empty())
        return "Something is missing that matches no effect in the catalogue, but it has a place and a curve: " + listed(law_clauses(d)) +
               ". With " + (d.laws.size() == 1 ? "it " : "them ") + percent(d.explained_share) + " of " +
               (d.by_paths ? "the squared error beyond noise" : "what " + left_open_words(d)) + " goes.";
      return "Something is missing that matches no effect in the catalogue: it seems to enter in " + located_words(d) + ".";
    }
  }
  return "";
}

// A channel that does not answer the inputs says nothing of the plant: that stands before what the others show.
std::string verdict_sentence(const Diagnosis& d) {
  std::vector<std::string> silent;
  for (const auto& notes : d.gate)
    for (const auto& channel : notes.unresponsive)
      silent.push_back(channel.words + (d.gate.size() > 1 ? " (" + notes.recording + ")" : ""));
  if (silent.empty()) return verdict_words(d);
  return "Look at the recording first: " + listed(silent) + ". Apart from that: " + verdict_words(d);
}

// Several groups may have one place: two tanks, two balances of flows.
bool enters_at(const plant::EntryGroup& group, std::string_view place) {
  return group.name == place || std::find(group.places.begin(), group.places.end(), place) != group.places.end();
}

std::string share_of_mismatch(const Diagnosis& d, const diagnose::PlaceShare& share) {
  return std::string(groups_of(d)[share.group].words) + " (share " + report::fixed(share.share, 2) + " [" + report::fixed(share.lowest, 2) +
         "," + no_break + report::fixed(share.highest, 2) + "])";
}

// Where the pushes go that the calibrated plant would need, without any effect in mind.
std::string shares_words(const Diagnosis& d) {
  std::vector<diagnose::PlaceShare> shares = d.located.shares;
  std::stable_sort(shares.begin(), shares.end(), [](const auto& a, const auto& b) { return a.share > b.share; });
  // Where what was found acts is said below, and why it is not seen here.
  const auto is_answer = [&](plant::EntryGroupId group) {
    return std::any_of(d.effects.begin(), d.effects.end(),
                       [&](const auto& found) { return enters_at(groups_of(d)[group], effects_of(d)[found.effect].place); });
  };
  std::vector<std::string> loud, quiet;
  for (const auto& share : shares) {
    if (share.share >= 0.03)
      loud.push_back(share_of_mismatch(d, share));
    else if (!is_answer(share.group))
      quiet.push_back(std::string(groups_of(d)[share.group].words));
  }
  if (loud.empty()) return "";
  std::string text = "Judged by its course alone, without any effect in mind, it enters in " + listed(loud);
  if (!quiet.empty()) text += "; " + listed(quiet) + (quiet.size() == 1 ? " needs" : " need") + " next to nothing";
  return text + ".";
}

bool leads(const Diagnosis& d, std::string_view place) {
  double largest = 0.0, mine = 0.0;
  for (const auto& share : d.located.shares) {
    largest = std::max(largest, share.share);
    if (enters_at(groups_of(d)[share.group], place)) mine = std::max(mine, share.share);
  }
  return mine == largest;
}

// Whether what is before is the better of two fits, channel by channel.
bool has_both_weightings(const Diagnosis& d) {
  const auto& calibrated = d.held_out.calibrated;
  return !added_effects(d).empty() && std::any_of(calibrated.begin(), calibrated.end(), [](double rmse) { return std::isfinite(rmse); });
}

std::vector<std::string> where_words(const Diagnosis& d) {
  const auto& located = d.located;
  const diagnose::PerChannel& rmse = located.rmse;
  const auto off = [&](plant::ChannelId c) {
    return channel_value(channels_of(d)[c], rmse[c]) + " off (noise: " + channel_value(channels_of(d)[c], located.noise[c]) + ")";
  };
  std::vector<std::string> others;
  for (const plant::ChannelId c : channels_of(d).ids())
    if (c != located.channel && std::isfinite(rmse[c])) others.push_back(channels_of(d)[c].words + " is " + off(c));
  std::string first =
      "With its parameters fitted and nothing added, the plant's " + channels_of(d)[located.channel].words + " is " + off(located.channel);
  if (!others.empty()) first += "; " + listed(others);
  first += ".";
  if (has_both_weightings(d))
    first += " These are errors on the data that was fitted; on held-out data, the same plant is what is called before, below.";
  if (d.verdict == Verdict::consistent && d.by_chance) return {first};
  if (d.verdict == Verdict::consistent)
    return {first + (d.process_noise_beyond_ordinary && !d.process_noise_after_refit
                         ? " What is beyond noise is no more than what moving air does that is not the same everywhere."
                         : " What is beyond noise is no more than what moving air does.")};

  std::string when = percent(located.worst.share_of_error) + " of the squared error of " + channel_words(channels_of(d)[located.channel]) +
                     " happens in " + percent(located.worst.share_of_time) + " of the time";
  if (!located.while_words.empty()) when += ", " + located.while_words;
  if (d.gate.size() > 1 && located.worst_recording < d.gate.size()) when += ", in " + file_name(d.gate[located.worst_recording].recording);
  if (!located.worst.windows_s.empty()) when += ": " + windows_words(located.worst);
  when += ".";

  std::string place = shares_words(d);
  if (d.wandering)
    place += std::string(place.empty() ? "" : " ") + "What would explain it best acts in " + place_words(system_of(d), located.place) + ".";
  else if (!d.effects.empty() && effects_of(d)[d.effects.front().effect].place == located.place && !leads(d, located.place))
    place += (place.empty() ? "" : " ") +
             std::string(d.effects.size() == 1 ? "The effect that may explain it, below,"
                                               : "Of the effects that may explain it, below, the strongest") +
             " acts in " + place_words(system_of(d), located.place) +
             ": without a law in mind only pushes of a few seconds are compared, and these do its work best elsewhere.";
  if (!located.cannot_be_told_from.empty()) {
    std::vector<std::string> words;
    for (const std::string& other : located.cannot_be_told_from) words.push_back(place_words(system_of(d), other));
    place += std::string(place.empty() ? "" : " ") + "It may as well enter in " + either_words(words) +
             ": what lasts longer than pushes of a few seconds can act there and look like this.";
  }
  if (place.empty()) return {first + " " + when};
  return {first + " " + when, place};
}

const diagnose::Candidate* candidate_of(const Diagnosis& d, plant::EffectId effect) {
  if (d.search.rounds.empty()) return nullptr;
  for (const auto& candidate : d.search.rounds.front().candidates)
    if (candidate.effect == effect) return &candidate;
  return nullptr;
}

std::string parameter_words(const Diagnosis& d, const diagnose::FoundEffect::Parameter& parameter) {
  const auto& declared = parameters_of(d)[parameter.parameter].declaration;
  std::string text = std::string(declared.symbol.empty() ? declared.name : declared.symbol) + " = ";
  if (declared.kind == plant::Kind::toggle) return std::string(declared.name);
  if (parameter.known) return text + with_unit(report::significant(parameter.value, 3), declared.unit.text) + " (assumed)";
  return text + interval_words(parameter.value, parameter.lowest, parameter.highest, declared.unit.text);
}

std::string parameters_words(const Diagnosis& d, const diagnose::FoundEffect& found) {
  std::vector<std::string> parts;
  for (const auto& parameter : found.parameters) {
    const auto& declared = parameters_of(d)[parameter.parameter].declaration;
    if (declared.kind == plant::Kind::toggle) continue;  // it is on; that has been said
    parts.push_back(parameter_words(d, parameter));
  }
  return listed(parts);
}

// The runner-up is the likeliest of the others, and likely is also what leaves the rest to pushes of a few seconds; so another may explain
// more. Empty where none does.
std::string more_explained_words(const Diagnosis& d, plant::EffectId found, plant::EffectId runner_up) {
  const diagnose::Candidate *likeliest = candidate_of(d, runner_up), *mine = candidate_of(d, found), *most = nullptr;
  if (d.effects.size() != 1 || !likeliest || !mine || !likeliest->explanation.usable) return "";
  const auto share = [&](const diagnose::Candidate& one) { return share_explained(d.search.core, one.explanation); };
  for (const auto& one : d.search.rounds.front().candidates) {
    const plant::EffectId name = plant::family_of(effects_of(d), one.effect);  // another form of it is no rival
    if (name == plant::family_of(effects_of(d), found) || name == plant::family_of(effects_of(d), runner_up)) continue;
    if (!one.explanation.usable) continue;
    if (std::find(d.ambiguous_with.begin(), d.ambiguous_with.end(), one.effect) != d.ambiguous_with.end()) continue;
    if (!most || share(one) > share(*most)) most = &one;
  }
  if (!most || percent(share(*most)) == percent(share(*likeliest)) || share(*most) < share(*likeliest)) return "";
  return " Of the others " + effect_name(d, most->effect) + " explains most, " + percent(share(*most)) + ", but is " +
         odds_words(mine->explanation.log_evidence - most->explanation.log_evidence) + ".";
}

std::string rivals_words(const Diagnosis& d, const diagnose::FoundEffect& found) {
  std::vector<std::pair<plant::EffectId, double>> rivals = found.rivals;
  std::erase_if(rivals, [&](const auto& rival) {
    return std::find(d.ambiguous_with.begin(), d.ambiguous_with.end(), rival.first) != d.ambiguous_with.end();
  });
  std::string text;
  if (!rivals.empty()) {
    const auto& [effect, loss] = rivals.front();
    text = "The runner-up is that " + std::string(effects_of(d)[effect].words) + " (" + effect_name(d, effect) + "): ";
    const diagnose::Candidate* candidate = d.effects.size() == 1 ? candidate_of(d, effect) : nullptr;
    if (candidate && candidate->explanation.usable)
      text += "it explains " + percent(share_explained(d.search.core, candidate->explanation)) + " and is ";
    else
      text += "in its place it is ";
    text += odds_words(loss) + ".";
    text += more_explained_words(d, found.effect, effect);
  }
  return text;
}

// Why a find may be improbable though nothing that was compared comes near it.
std::string what_lowers_words(const diagnose::Support& support) {
  std::vector<std::string> reasons;
  if (support.faint > faint_from)
    reasons.push_back(report::significant(std::pow(10.0, support.faint), 2) + " times weaker than is typical of it");
  if (support.law_beside) reasons.push_back("beside a law without a name");
  if (reasons.empty()) return "";
  return "It is " + listed(reasons) +
         ", as is mostly what stands in for other physics: in trials whose answer was known such finds were right less often, and this "
         "lowers its probability. ";
}

std::string found_paragraph(const Diagnosis& d, const diagnose::FoundEffect& found, bool alone) {
  const auto& info = effects_of(d)[found.effect];
  std::string text = (found.confidence < doubtful_below ? "Perhaps left out: " : "Left out: ") + std::string(info.words) +
                     ". In the catalogue it is " +
                     (info.form_of ? effect_name(d, *info.form_of) + ", here in another form (" + effect_name(d, found.effect) + ")"
                                   : effect_name(d, found.effect)) +
                     ", which acts in " + place_words(system_of(d), info.place) + "; " + probability_words(found.confidence) + ". ";
  if (found.form == diagnose::Form::free) {
    text +=
        "The curve below acts where this effect does, and follows what it follows: it may be the form that the effect has here. That is "
        "likelier the more the catalogue's formula explains by itself: " +
        (found.explained_by_formula > 0.0 ? percent(found.explained_by_formula) : "next to nothing") + ". ";
  } else {
    const std::string sizes = parameters_words(d, found);
    text += "The equation becomes " + std::string(info.equation) + (sizes.empty() ? "" : ", with " + sizes) + ". ";
  }
  if (d.by_paths)
    text += found.support.gain > 0.0
                ? std::string("Without it") +
                      (diagnose::has_law_as_form(system_of(d), d.laws, found.effect) ? ", and without a law that may be its form," : "") +
                      " the best plant that was tried is " + odds_words(0.5 * found.support.gain) + ". "
                : "";
  else if (alone && d.laws.empty())
    text += "Why: it explains " + percent(d.explained_share) + " of what " + left_open_words(d) + ", and chance would bring such a gain " +
            chance_words(found.chance) + ". ";
  else if (d.laws.empty())
    text += "Chance would bring such a gain " + chance_words(found.chance) + ". ";
  text += what_lowers_words(found.support);
  text += rivals_words(d, found);
  return text;
}

// Why what was found is not given as the answer.
std::string no_name_words(const Diagnosis& d, const diagnose::DiagnosisSettings& settings) {
  const std::vector<std::string> reasons = objection_words(system_of(d), d.objections);
  const std::string rule = "A name is given only to what explains " + percent(settings.thresholds.named_share) + " and could not be chance";
  if (reasons.empty()) return rule + ", so none is given.";
  return rule + ", in every channel and with believable parameters; the best that was found " + listed(reasons) + ", so none is given.";
}

// What chance has to do with what is left, where that was asked.
std::string chance_of_the_rest(const Diagnosis& d) {
  const diagnose::ProcessNoiseByChance& chance = *d.by_chance;
  const std::string simulated = std::to_string(chance.drawn) + " simulations in which nothing is missing, with air that varies by " +
                                report::fixed(chance.nuisance, 2) + " K, ";
  return chance.as_large > 0 ? "What is left is more than mostly where nothing is missing, but of " + simulated +
                                   std::to_string(chance.as_large) + " left as much: it may be chance."
                             : "What is left is not much: none of " + simulated + "left as much, but one left " +
                                   percent(chance.largest / chance.process_noise) + " of it.";
}

// "+0.31 W at 25 °C, ... and -0.2 W at 90 °C": ends and middle.
std::string curve_words(const Diagnosis& d, const diagnose::FoundLaw& found) {
  const auto [unit, scale] = law_unit(d, found.law);
  const std::string argument_unit = system_of(d).variables()[found.law.argument.front()].unit;
  std::vector<std::string> points;
  const std::size_t last = found.values.size() - 1;
  for (const std::size_t k : {std::size_t{0}, last / 3, last - last / 3, last}) {
    const double value = scale * found.values[k], half = scale * 1.959964 * found.deviation[k];
    points.push_back(interval_words(value, value - half, value + half, unit) + " at " +
                     with_unit(report::significant(found.law.knots[k], 2), argument_unit));
  }
  return listed(points);
}

std::string law_paragraph(const Diagnosis& d, const diagnose::FoundLaw& found) {
  const diagnose::FoundEffect* name = name_of_law(d, found);
  std::string text = !name                                ? "Left out, without a name: "
                     : name->form == diagnose::Form::free ? "The curve: "
                                                          : "How its form differs from the catalogue's: ";
  text += std::string(effects_of(d)[found.effect].words) +
          (found.law.argument.size() > 1 ? ", the same curve in each part, of that part's own. It is " : ". It is ") +
          curve_words(d, found) + ". Of " + std::to_string(d.by_paths ? d.proposals.cells : d.search.cells) +
          " places and quantities that a law was sought for, each in its best curve, this one lets the plant follow best; " +
          (d.by_paths ? "the best plant without it is " : "without it the answer is ") + odds_words(found.log_odds) + ".";
  std::vector<std::string> forms;
  for (const auto& form : found.forms) forms.push_back(form.words);
  if (forms.empty())
    text += " No simple form that was tried (line, parabola, cube, size, exponential, ramp, saturation, step) lies within its band.";
  else
    text += " Of simple forms " + listed(forms) + (forms.size() == 1 ? " lies" : " lie") + " within its band.";
  return text;
}

std::string apart_paragraph(const Diagnosis& d, const diagnose::FoundApart& found) {
  std::vector<std::string> quantities;
  for (const auto& [name, values] : apart_quantities(d, found)) quantities.push_back(name + " " + values);
  return capitalised(apart_clause(sharing_of(d, found))) + ": " + listed(quantities) + ". " +
         capitalised(probability_words(found.confidence)) + ". The best plant in which all are alike is " + odds_words(found.log_odds) +
         ". Parts are believed to be alike, to half of what is believed of such a quantity; of one that no recording drives, the others "
         "tell.";
}

std::string wandering_words(const Diagnosis& d) {
  const auto& w = *d.wandering;
  std::string text = "Were " + w.of.words + " free to change from moment to moment, that would explain " + percent(w.explained_share) +
                     " of what " + left_open_words(d) + ", more likely than pushes on the single equations";
  if (!w.others.empty())
    text += std::string(w.others.front().second < alike_below ? ", about as likely as " : " or ") + w.others.front().first.words +
            ", the next best";
  text +=
      ". In the " + std::string(d.values.problem->data().size() > 1 ? "recordings " : "recording ") + w.of.words + " " + change_words(w);
  text += w.on.explained_share >= goes_with_share
              ? "; it goes with " + variable_words(w.on) + ", which accounts for " + percent(w.on.explained_share) + " of its course."
              : "; its course follows no single quantity.";
  if (!d.effects.empty())
    text += " So perhaps " + std::string(effects_of(d)[*w.of.effect].words) + ", but not by a constant amount (" +
            probability_words(d.effects.front().confidence) + ").";
  return text;
}

// Whether it counts or not.
const diagnose::Proposal& likeliest_by_fit(const Diagnosis& d) {
  return *std::max_element(d.proposals.all.begin(), d.proposals.all.end(),
                           [](const auto& a, const auto& b) { return a.log_odds < b.log_odds; });
}

// Effects of the most probable plant that were not kept beside the answer's, since they do not help to predict.
std::vector<std::string> fitted_but_idle(const Diagnosis& d) {
  std::vector<std::string> names;
  if (!d.by_paths) return names;
  const auto& kept = d.proposals.all[d.proposals.answer].effects;
  const auto& likeliest = likeliest_by_fit(d).effects;
  const auto is_there = [&](plant::EffectId e) { return std::find(likeliest.begin(), likeliest.end(), e) != likeliest.end(); };
  if (!std::all_of(kept.begin(), kept.end(), is_there)) return names;
  for (const plant::EffectId e : likeliest)
    if (std::find(kept.begin(), kept.end(), e) == kept.end())
      names.push_back(effects_of(d)[e].law       ? std::string(effects_of(d)[e].words)
                      : effects_of(d)[e].sharing ? "that " + std::string(effects_of(d)[e].words)
                                                 : "that " + std::string(effects_of(d)[e].words) + " (" + effect_name(d, e) + ")");
  return names;
}

// How much of the catalogue was tried.
std::string tried_words(const Diagnosis& d, const diagnose::DiagnosisSettings& settings) {
  std::size_t tried = 0;
  std::vector<std::string> given, left_out;
  for (const plant::EffectId e : system_of(d).without_laws()->effects().ids())
    if (d.search.core.problem->centres().is_on(e))
      given.push_back(effect_name(d, e));
    else if (diagnose::is_left_out(system_of(d), e, settings.search.without))
      left_out.push_back(effect_name(d, e));
    else
      ++tried;
  if (given.empty() && left_out.empty()) return "All " + std::to_string(tried) + " effects of the catalogue were tried.";
  return std::to_string(tried) + " of the catalogue's " + std::to_string(catalogue_size(d)) + " effects were tried." +
         (given.empty() ? "" : " The given plant has " + listed(given) + ".") +
         (left_out.empty() ? "" : " Not tried, as asked: " + listed(left_out) + ".");
}

std::vector<std::string> what_words(const Diagnosis& d, const DiagnosisInputs& inputs) {
  std::vector<std::string> text;
  const bool alone = d.effects.size() == 1;
  if (d.verdict == Verdict::consistent) {
    std::string tested = tried_words(d, inputs.settings);
    if (!d.search.rounds.empty() && !d.search.rounds.back().scores.best.empty()) {
      const auto& round = d.search.rounds.back();
      const plant::EffectId best =
          round.candidates.empty() ? round.scores.all[round.scores.best.front()].effect : round.candidates.front().effect;
      tested += " The one that would help most is that " + std::string(effects_of(d)[best].words) + " (" + effect_name(d, best) +
                "); chance alone brings as much " + chance_words(round.chance) + ".";
    }
    text.push_back(tested);
    if (d.by_chance) text.push_back(chance_of_the_rest(d));
    return text;
  }
  if (d.by_chance) text.push_back(chance_of_the_rest(d));
  if (d.by_paths) {
    text.push_back(
        "No effects of the catalogue explain the recording to within noise. What follows was found by open-loop simulation from " +
        input_words(system_of(d)) + " alone: " + std::to_string(d.proposals.all.size()) +
        " plants with effects or laws added, the best of all that were tried, were compared under one measure of error, and each was kept "
        "where seconds that were left out of the fit, a tenth at a time, are predicted better with it, beyond chance. "
        "Together they take away " +
        percent(d.explained_share) + " of the squared error beyond noise.");
    if (const auto more = fitted_but_idle(d); !more.empty())
      text.push_back("Also tried: " + listed(more) + ". The plant with this is " +
                     odds_words(d.proposals.all[d.proposals.answer].log_odds - likeliest_by_fit(d).log_odds) +
                     " than the answer by its fit, but predicts no better what was left out of it.");
  } else if (!d.laws.empty()) {
    text.push_back("The catalogue's own forms leave more than noise. With " + std::string(d.laws.size() == 1 ? "a curve" : "curves") +
                   (fitted_effects(d) > 0 ? " beside what has a name,"
                    : d.effects.empty()   ? ", and no name,"
                                          : " in their place,") +
                   " the plant explains " + percent(d.explained_share) + " of what " + left_open_words(d) +
                   ", and predicts held-out data no worse than without.");
  } else if (d.verdict == Verdict::named_in_part && d.objections.leaves_too_much && !d.effects.empty()) {
    text.push_back("What can be named explains " + percent(d.explained_share) + " of what " + left_open_words(d) +
                   ". What is left is more than "
                   "noise: the effect acts in another form than the catalogue's, is not alone, or is a look-alike of one that "
                   "the catalogue lacks.");
  } else if (d.verdict == Verdict::unexplained) {  // nothing has a name, or only what varies
    std::string start = "Something is missing that matches no effect in the catalogue.";
    const auto& left = d.left_over;
    if (d.wandering) {
      start += " " + wandering_words(d);
    } else if (!left.variable.empty())
      start += " What the plant would need in " + std::string(groups_of(d)[left.group].words) +
               (left.explained_share >= goes_with_share
                    ? " goes with " + variable_words(left) + ", which accounts for " + percent(left.explained_share) + " of it."
                    : " follows no single quantity: the nearest, " + variable_words(left) + ", accounts for only " +
                          percent(left.explained_share) + " of it.");
    text.push_back(start);
    std::vector<std::string> near;
    if (!d.search.rounds.empty())
      for (const auto& candidate : d.search.rounds.front().candidates) {
        if (!candidate.explanation.usable || near.size() == 3) continue;
        near.push_back(std::string(effect_name(d, candidate.effect)) + " explains " +
                       percent(share_explained(d.search.core, candidate.explanation)));
      }
    if (!near.empty())
      text.push_back("Of the catalogue, " + std::string(d.wandering ? "with constant strength, " : "") + listed(near) + " of what " +
                     left_open_words(d) + ". " + no_name_words(d, inputs.settings));
  }
  if (d.wandering) {
    if (!d.ambiguous_with.empty()) {
      std::vector<std::string> names;
      for (const plant::EffectId e : d.ambiguous_with) names.push_back(effect_name(d, e));
      text.push_back("It cannot be told from " + listed(names) + ".");
    }
    return text;
  }
  for (const auto& found : d.effects) text.push_back(found_paragraph(d, found, alone));
  for (const auto& found : d.laws) text.push_back(law_paragraph(d, found));
  for (const auto& found : d.apart) text.push_back(apart_paragraph(d, found));
  if (!alone && !d.effects.empty() && !d.by_paths)
    text.push_back("Together they explain " + percent(d.explained_share) + " of what " + left_open_words(d) + ".");
  if (!d.effects.empty() && !(d.by_paths && d.ambiguous_with.empty())) {
    if (d.ambiguous_with.empty()) {
      text.back() += " Nothing else in the catalogue does as well.";
    } else {
      std::vector<std::string> names;
      for (const plant::EffectId e : d.ambiguous_with)
        names.push_back(std::string(effects_of(d)[e].words) + " (" + effect_name(d, e) + ")");
      std::string why = "Either explains the recording about as well.";
      if (!d.parsimony.as_good.empty())
        why =
            "Neither explains all, so one of them acts in another form than the catalogue's, and that one fits better "
            "says little.";
      else if (!d.parsimony.common_causes.empty())
        why = std::string(alone ? "An effect of the other kind of sensor gained, too. " : "") +
              "Both kinds of sensor off at once would be a coincidence; one cause before both, in another form than the "
              "catalogue's, is as likely.";
      text.push_back("It cannot be told from this: that " + listed(names) + ". " + why);
    }
  }
  return text;
}

std::vector<std::string> moved_parameters(const Diagnosis& d) {
  std::vector<std::string> moved;
  for (const FittedValue& one : fitted_values(d)) {
    const diagnose::Unknown& unknown = d.values.problem->unknowns()[one.unknown];
    if (parameters_of(d)[one.parameter].effect) continue;
    if (std::abs(unknown.coordinate_of(d.values.value(one.unknown))) > 2.0) moved.push_back(unknown.name);
  }
  return moved;
}

bool predicts_better(const Diagnosis& d) {
  double gain = 0.0;
  for (const plant::ChannelId c : channels_of(d).ids())
    if (d.held_out.samples[c] > 0) gain += std::log(d.held_out.before[c] / d.held_out.after[c]);
  return gain > 0.0;
}

std::vector<std::string> modelled_words(const Diagnosis& d) {
  std::string text;
  std::vector<std::string> substitutes;
  for (const plant::EffectId e : stand_ins(d)) substitutes.push_back(effect_name(d, e));
  if (added_effects(d).empty())
    text = "plant.yaml is the plant with all its parameters fitted; nothing is added to it." +
           std::string(d.wandering ? " Nor is what would change: a plant does not know when it will." : "");
  else if (!d.laws.empty())
    text = "plant.yaml is the plant with " +
           std::string(fitted_effects(d) == 0   ? ""
                       : fitted_effects(d) == 1 ? "this effect and "
                                                : "these effects and ") +
           (d.laws.size() == 1 ? "this law" : "these laws") + " (`laws:`) in it, and all parameters fitted again.";
  else if (d.effects.empty() && !d.apart.empty() && substitutes.empty())
    text =
        "plant.yaml is the plant in which " + listed(apart_clauses(d)) + ", each with values of its own, and all parameters fitted again.";
  else if (d.effects.empty() || d.wandering)
    text = "plant.yaml is the plant with all parameters fitted, and with " + listed(substitutes) +
           " switched on as a stand-in: " + (predicts_better(d) ? "it predicts better, but" : "it does not predict better, and") +
           " that is not what " + plant_words(d) + " does.";
  else
    text = "plant.yaml is the plant with " + std::string(d.effects.size() == 1 ? "this effect" : "these effects") +
           (substitutes.empty() ? "" : " and, as a stand-in for what has no name, " + listed(substitutes)) +
           " switched on and all parameters fitted again." +
           (something_is_left(d.verdict) ? " That " + plant_words(d) + " does this is not certain." : "");
  if (!d.apart.empty() && !(d.effects.empty() && d.laws.empty() && substitutes.empty()))
    text += " In it " + listed(apart_clauses(d)) + ", and each has values of its own.";
  text += " `sinew run` and `sinew compare` accept it.";
  for (const plant::ParameterId p : d.flipped_signs)
    text += " The recording says that " + parameters_of(d)[p].key() + " is " + sim::parameter_text(d.repaired, p) +
            ", the other way than in the given plant, and that was used.";
  if (const auto moved = moved_parameters(d); !moved.empty())
    text += " Fitted far from what was believed before, by more than two standard deviations: " + listed(moved) +
            ". Either the given plant is not quite this one, or more is missing.";
  return {text};
}

// What each weighting of the channels makes of one, where that matters.
std::string weightings_words(const Diagnosis& d, plant::ChannelId c) {
  const std::string own = channel_value(channels_of(d)[c], d.held_out.fitted[c]),
                    other = channel_value(channels_of(d)[c], d.held_out.calibrated[c]);
  if (!std::isfinite(d.held_out.calibrated[c]) || own == other) return "";
  return " (" + own + " by the diagnosis' weighting, " + other + " by `calibrate`'s)";
}

bool drives_more(const Diagnosis& d) {
  return std::any_of(d.driven_more.begin(), d.driven_more.end(), [](const auto& inputs) { return !inputs.empty(); });
}

std::string no_judge_words(const Diagnosis& d, const DiagnosisInputs& inputs) {
  if (!drives_more(d)) return "";
  std::vector<std::string> which;
  for (std::size_t r = 0; r < d.driven_more.size(); ++r) {
    std::vector<std::string> driven;
    for (const plant::InputId i : d.driven_more[r]) driven.push_back(system_of(d).inputs()[i].words);
    if (!driven.empty()) which.push_back(file_name(inputs.held_out[r]) + " drives " + listed(driven));
  }
  return listed(which) + ", which training leaves alone: of what belongs there it tells nothing. So whether something predicts worse was " +
         (d.judged_on_blocks ? "asked of two blocks of each training recording instead, which were not fitted."
                             : "asked of what else is held out alone.");
}

std::vector<std::string> better_words(const Diagnosis& d, const DiagnosisInputs& inputs) {
  const auto& held = d.held_out;
  std::vector<std::string> text;
  std::string intro = "On held-out data (" + held_out_words(d) + "), predicted from its " + input_words(system_of(d)) + " alone" +
                      (inputs.held_out.empty() || inputs.settings.start == diagnose::StartPolicy::at_rest
                           ? ""
                           : " but for the first 5 s, which tell how it begins");
  if (!added_effects(d).empty())
    intro +=
        "; before: with nothing added and all parameters fitted, each channel by the weighting of channels that serves it best, the "
        "diagnosis' own or `sinew calibrate`'s";
  text.push_back(intro + ":");
  std::vector<std::string> rough;
  for (const plant::ChannelId c : channels_of(d).ids()) {
    if (held.samples[c] == 0) continue;
    std::string line = channels_of(d)[c].words + ": " + channel_value(channels_of(d)[c], held.before[c]) + " off before" +
                       weightings_words(d, c) + ", " + channel_value(channels_of(d)[c], held.after[c]) + " after; noise alone would give " +
                       channel_value(channels_of(d)[c], held.noise[c]) + ".";
    if (added_effects(d).empty())
      line = channels_of(d)[c].words + ": " + channel_value(channels_of(d)[c], held.nominal[c]) + " off as given, " +
             channel_value(channels_of(d)[c], held.after[c]) + " fitted; noise alone would give " +
             channel_value(channels_of(d)[c], held.noise[c]) + ".";
    else if (!(std::abs(held.gain[c]) > 0.01))
      line += " Nothing changes.";
    else if (held.gain_lowest[c] > 0.0)
      line += " The error falls by " + percent_interval(held.gain[c], held.gain_lowest[c], held.gain_highest[c]) + ".";
    else if (held.gain_highest[c] < 0.0)
      line += " The error GROWS by " + percent_interval(-held.gain[c], -held.gain_highest[c], -held.gain_lowest[c]) + ".";
    else
      line += " No change that could be told from chance.";
    text.push_back("– " + line);
    if (held.after[c] > (d.verdict == Verdict::consistent ? 4.0 : 1.5) * held.noise[c]) rough.push_back(channel_words(channels_of(d)[c]));
  }
  if (text.size() == 1) return {"No data was held out, so nothing can be said about how well the plant predicts."};
  std::string closing;
  const plant::ChannelId c = d.located.channel;
  const auto before = correlation_after_1_s(d.correlation.before[c]), after = correlation_after_1_s(d.correlation.after[c]);
  if (before && after && !added_effects(d).empty())
    closing = "Errors of " + channel_words(channels_of(d)[c]) + " one second apart are alike by " + report::fixed(*before, 2) +
              " before and by " + report::fixed(*after, 2) + " after (1: the same; 0: pure noise).";
  if (!rough.empty() && d.verdict == Verdict::consistent && !drives_more(d))
    closing = "The prediction of " + listed(rough) +
              " is off by much more than noise, although what was fitted is explained: what was kept "
              "back may contain something that the rest does not. Give it to --train to find out.";
  else if (!rough.empty())
    closing += std::string(closing.empty() ? "" : " ") + "The prediction of " + listed(rough) + " is still off by more than noise.";
  if (!closing.empty()) text.push_back(closing);
  if (const std::string no_judge = no_judge_words(d, inputs); !no_judge.empty()) text.push_back(no_judge);
  return text;
}

// "thermocouple_lag from 0.31 s".
std::string smallest_words(const Diagnosis& d, const diagnose::Visibility& visibility) {
  const auto& info = effects_of(d)[visibility.effect];
  const auto& declared = parameters_of(d)[info.strength].declaration;
  if (declared.kind == plant::Kind::toggle) return std::string(info.name);
  return std::string(info.name) + " from " + with_unit(report::significant(visibility.smallest_seen, 2), declared.unit.text);
}

// It, or another form of it.
bool is_found(const Diagnosis& d, plant::EffectId effect) {
  return std::any_of(d.effects.begin(), d.effects.end(), [&](const auto& found) {
    return plant::family_of(effects_of(d), found.effect) == plant::family_of(effects_of(d), effect);
  });
}

std::vector<std::string> next_words(const Diagnosis& d) {
  std::vector<std::string> text;
  std::vector<std::string> seen, imitated, too_small;
  for (const auto& other : not_found(d))
    if (other.can_be_seen)
      seen.push_back(smallest_words(d, other));
    else
      (is_imitated(other) ? imitated : too_small).push_back(std::string(effect_name(d, other.effect)));
  if (!d.ambiguous_with.empty()) {
    // The effect in whose place the first of them would do.
    const auto in_place_of = std::find_if(d.effects.begin(), d.effects.end(), [&](const auto& found) {
      return std::any_of(found.rivals.begin(), found.rivals.end(), [&](const auto& r) { return r.first == d.ambiguous_with.front(); });
    });
    const auto& found = in_place_of == d.effects.end() ? d.effects.front() : *in_place_of;
    std::vector<std::string> names{std::string(effect_name(d, found.effect))};
    for (const plant::EffectId e : d.ambiguous_with) names.push_back(effect_name(d, e));
    if (d.experiment && d.experiment->separation > 0.0) {
      const auto& e = *d.experiment;
      text.push_back("To tell " + std::string(effect_name(d, e.effect)) + " from " + std::string(effect_name(d, e.rival)) +
                     ", run experiment.yaml on " + plant_words(d) + ": " + e.words + ", " + report::fixed(e.duration_s / 60.0, 0) +
                     " minutes, duty up to " + report::fixed(e.largest_share, 2) + ", wires up to " + report::fixed(e.highest, 0) +
                     " °C. The two then differ by " + report::significant(e.separation, 2) +
                     " standard deviations, whatever the other parameters are" +
                     (e.separation < 5.0 ? "; below 5 that is not enough, and several such recordings are needed." : ".") +
                     " Give both recordings to --train.");
    } else {
      text.push_back("To tell " + listed(names) + " apart, record " + plant_words(d) +
                     " once more with a different drive (other amplitudes, longer holds "
                     "and rests) and give both recordings to --train.");
    }
  }
  if (something_is_left(d.verdict)) {
    const auto& left = d.left_over;
    if (d.wandering)
      text.push_back("Look at the course of " + d.wandering->of.words + " in the report, and at what happens at " + plant_words(d) +
                     " when it changes" +
                     (d.wandering->on.explained_share >= goes_with_share
                          ? ": which law would make it change with " + variable_words(d.wandering->on) + "?"
                          : ". A recording with long holds and slow ramps would show on what it depends."));
    else if (!left.variable.empty() && left.explained_share >= goes_with_share)
      text.push_back("Look at the curve of what is left against " + variable_words(left) +
                     " in the report: which assumption of the plant's equation for " + std::string(groups_of(d)[left.group].words) +
                     " could break like this?");
    else
      text.push_back(
          "What is left follows no single quantity that is measured. A recording with long holds and slow ramps would "
          "show "
          "on what it depends.");
  } else if (d.verdict == Verdict::missing_physics && d.ambiguous_with.empty()) {
    std::string more = "Nothing further is found.";
    if (!d.search.rounds.empty() && !d.search.rounds.back().accepted && !d.search.rounds.back().scores.best.empty()) {
      const auto& round = d.search.rounds.back();
      const plant::EffectId best =
          round.candidates.empty() ? round.scores.all[round.scores.best.front()].effect : round.candidates.front().effect;
      more += (is_found(d, best) ? " Another form of " + std::string(effects_of(d)[plant::family_of(effects_of(d), best)].name)
                                 : " The next best effect, " + effect_name(d, best) + ",") +
              " gains what chance alone brings " + chance_words(round.chance) + ".";
    }
    text.push_back(more);
  }
  if (d.verdict == Verdict::consistent && !seen.empty())
    text.push_back("Had one of these been there, it would have been seen: " + listed(seen) + ".");
  std::string hidden;
  if (!imitated.empty())
    hidden = "A little of " + listed(imitated) + " would not show: fitting the other parameters imitates " +
             (imitated.size() == 1 ? "it" : "them") + " to first order. How much would have been seen is not known.";
  if (!too_small.empty() && something_is_left(d.verdict))
    hidden += std::string(hidden.empty() ? "" : " ") + "As long as something is unexplained, nothing can be said about " +
              listed(too_small) + ".";
  else if (!too_small.empty())
    hidden += std::string(hidden.empty() ? "" : " ") + "Of usual size, " + listed(too_small) +
              " would hardly touch this data, so nothing is known of " + (too_small.size() == 1 ? "it." : "them.");
  if (!hidden.empty()) text.push_back(hidden);
  return text;
}

std::vector<std::string> odd_words(const Diagnosis& d) {
  std::string text;
  for (const auto& gate : d.gate)
    for (const std::string& warning : gate.warnings)
      text += std::string(text.empty() ? "Odd about the data: " : "; ") +
              (d.gate.size() > 1 ? "in " + file_name(gate.recording) + " " : "") + warning;
  if (text.empty()) return {};
  return {text + "."};
}

}  // namespace

std::vector<std::string> objection_words(const plant::System& system, const diagnose::Objections& against) {
  std::vector<std::string> words;
  if (!against.channels.empty()) {
    std::vector<std::string> names;
    for (const plant::ChannelId c : against.channels) names.push_back("the prediction of " + system.channels()[c].words);
    words.push_back("leaves " + listed(names) + " far off");
  }
  if (against.pushes_parameters)
    words.push_back("needs parameters of the core that are further from what is believed of them than without it");
  if (against.at_a_bound) words.push_back("needs a value at the bound of what is allowed");
  if (against.patchwork) words.push_back("takes three effects, and one that is not known is likelier than that");
  if (against.worse_on_held_out) words.push_back("makes the prediction of the held-out data worse");
  return words;
}

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

std::string percent_number(double share) {
  if (!std::isfinite(share)) return "–";
  const double hundredths = 100.0 * share;
  // Near all and near nothing a decimal matters.
  if (hundredths > 99.0 && hundredths < 100.0) return report::fixed(std::min(hundredths, 99.9), 1);
  if (const double size = std::abs(hundredths); size > 0.0 && size < 1.0)
    return report::fixed(std::copysign(std::max(size, 0.1), hundredths), 1);
  return report::fixed(hundredths, 0);
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

std::string place_words(const plant::System& system, std::string_view place) {
  std::vector<std::string> words;
  for (const plant::EntryGroup& group : system.entry_groups()) {
    if (!enters_at(group, place)) continue;
    const bool of_input = group.places.size() > 1 && group.places[1] == place && !group.input_words.empty();
    words.emplace_back(of_input ? group.input_words : group.words);
  }
  if (words.empty()) return place.empty() ? "no single equation" : std::string(place);
  return either_words(words);
}

std::string name_and_words(const plant::EffectInfo& effect) { return std::string(effect.name) + ": " + std::string(effect.words); }

std::string file_name(const std::string& path) {
  const std::filesystem::path file(path);
  // `run` calls all its recordings alike; their folders tell them apart.
  if (file.filename() == "recording.csv" && file.has_parent_path()) return (file.parent_path().filename() / file.filename()).string();
  return file.filename().string();
}

std::string listed(const std::vector<std::string>& parts) {
  std::string text;
  for (std::size_t i = 0; i < parts.size(); ++i) text += (i == 0 ? "" : i + 1 == parts.size() ? " and " : ", ") + parts[i];
  return text;
}

std::string windows_words(const diagnose::WorstTime& worst, std::size_t most) {
  std::vector<std::string> windows;
  for (std::size_t i = 0; i < worst.windows_s.size() && i < most; ++i)
    windows.push_back(report::fixed(worst.windows_s[i].first, 0) + "–" + report::fixed(worst.windows_s[i].second, 0) + " s");
  if (worst.windows_s.size() > most) {
    const std::size_t more = worst.windows_s.size() - most;
    windows.push_back(std::to_string(more) + (more == 1 ? " more such time" : " more such times"));
  }
  return listed(windows);
}

bool is_imitated(const diagnose::Visibility& visibility) { return visibility.visible_share < 0.02 && visibility.smallest_seen > 0.0; }

const plant::Sharing& sharing_of(const Diagnosis& d, const diagnose::FoundApart& found) {
  return system_of(d).sharings()[*effects_of(d)[found.effect].sharing];
}

std::vector<std::pair<std::string, std::string>> apart_quantities(const Diagnosis& d, const diagnose::FoundApart& found) {
  const plant::Sharing& sharing = sharing_of(d, found);
  std::vector<std::pair<std::string, std::string>> quantities;
  for (const auto& move : sharing.moves)
    for (const plant::Sharing::Quantity& quantity : move) {
      const plant::Declaration& declared = parameters_of(d)[quantity.parameter].declaration;
      std::vector<std::string> parts;
      for (const auto& one : found.values)
        if (one.parameter == quantity.parameter)
          parts.push_back(interval_words(one.value, one.lowest, one.highest, declared.unit.text) + " (" + sharing.parts[one.part] + ")");
      quantities.emplace_back(declared.name, listed(parts));
    }
  return quantities;
}

std::vector<FittedValue> fitted_values(const diagnose::Diagnosis& d) {
  std::vector<FittedValue> all;
  const auto& unknowns = d.values.problem->unknowns();
  for (std::size_t u = 0; u < unknowns.size(); ++u) {
    if (unknowns[u].parameter == std::nullopt || is_weight(d.values.system(), *unknowns[u].parameter)) continue;
    const plant::ParameterId p = *unknowns[u].parameter;
    const auto& range = d.values.system().parameters()[p].declaration.range;
    const double unit = unknowns[u].internal_per_unit;
    const auto [lowest, highest] = d.values.interval(u, 1.959964);
    all.push_back({p, u, d.values.value(u) / unit, std::max(range.lowest, lowest / unit), std::min(range.highest, highest / unit)});
  }
  return all;
}

std::vector<plant::EffectId> added_effects(const diagnose::Diagnosis& d) {
  const std::vector<plant::EffectId> before = d.search.core.effects();
  std::vector<plant::EffectId> added;
  for (const plant::EffectId e : effects_of(d).ids())
    if (d.repaired.is_on(e) && std::find(before.begin(), before.end(), e) == before.end()) added.push_back(e);
  return added;
}

std::vector<plant::EffectId> stand_ins(const diagnose::Diagnosis& d) {
  std::vector<plant::EffectId> all = added_effects(d);
  if (d.wandering) return all;  // what varies is not what was added, even if by the same name
  std::erase_if(all, [&](plant::EffectId e) {
    const auto is_it = [&](const auto& found) { return found.effect == e; };
    return effects_of(d)[e].law || std::any_of(d.effects.begin(), d.effects.end(), is_it) ||
           std::any_of(d.apart.begin(), d.apart.end(), is_it);
  });
  return all;
}

std::pair<std::string, double> law_unit(const diagnose::Diagnosis& d, const plant::Law& law) {
  if (!law.factor.empty()) return {"%", 100.0};
  const std::string_view unit = groups_of(d)[law.entry].unit;
  if (unit == "rad") return {"°", 1.0 / plant::radians_per_degree};
  if (unit == "Nm") return {"mN·m", 1000.0};
  return {unit_words(unit), 1.0};
}

std::vector<diagnose::Visibility> not_found(const diagnose::Diagnosis& d) {
  std::vector<diagnose::Visibility> all = d.others;
  const std::vector<plant::EffectId> added = added_effects(d);
  std::erase_if(all, [&](const auto& other) {
    return std::find(added.begin(), added.end(), other.effect) != added.end() || is_found(d, other.effect);
  });
  std::sort(all.begin(), all.end(), [](const auto& a, const auto& b) { return a.effect < b.effect; });
  return all;
}

std::string held_out_words(const diagnose::Diagnosis& d) {
  std::vector<std::string> parts;
  for (const auto& prediction : d.predictions) {
    const std::string name = file_name(prediction.recording->name);
    if (!prediction.training) {
      parts.push_back(name);
      continue;
    }
    std::size_t blocks = 0, count = 0;
    double seconds = 0.0;
    for (std::size_t k = 0; k < prediction.held_out.size(); ++k) {
      if (!prediction.held_out[k]) continue;
      ++count;
      if (k == 0 || !prediction.held_out[k - 1])
        ++blocks;
      else
        seconds += prediction.time_s[k] - prediction.time_s[k - 1];
    }
    if (count == 0) continue;
    if (blocks == 1 && prediction.held_out.back())
      parts.push_back("the last " + report::fixed(seconds, 0) + " s of " + name);
    else
      parts.push_back(std::to_string(blocks) + (blocks == 1 ? " block of " : " blocks, together ") + report::fixed(seconds, 0) + " s, of " +
                      name);
  }
  return listed(parts);
}

std::optional<double> correlation_after_1_s(const std::vector<double>& correlation) {
  constexpr auto lag = static_cast<std::size_t>(1.0 / diagnose::correlation_lag_s);
  if (correlation.size() <= lag || !std::isfinite(correlation[lag])) return std::nullopt;
  return correlation[lag];
}

std::string summary_sentence(const Diagnosis& d) {
  const auto& held = d.held_out;
  // The channel that is furthest off; with something put in where most was off, or the one that it changes most.
  plant::ChannelId c = d.located.channel;
  if (added_effects(d).empty())
    for (const plant::ChannelId other : channels_of(d).ids())
      if (held.samples[other] > 0 && !(held.after[other] / held.noise[other] <= held.after[c] / held.noise[c])) c = other;
  if (!d.laws.empty() || (!added_effects(d).empty() && !(held.gain_lowest[c] > 0.0)))
    for (const plant::ChannelId other : channels_of(d).ids())
      if (held.samples[other] > 0 && held.gain[other] > held.gain[c]) c = other;
  if (held.samples[c] == 0) return "";
  if (added_effects(d).empty())
    return "On held-out data, " + channel_words(channels_of(d)[c]) + " is predicted to " + channel_value(channels_of(d)[c], held.after[c]) +
           "; noise alone would give " + channel_value(channels_of(d)[c], held.noise[c]) + ".";
  std::vector<std::string> worse;  // beyond chance
  for (const plant::ChannelId other : channels_of(d).ids())
    if (held.samples[other] > 0 && held.gain_highest[other] < 0.0 && held.gain[other] < -0.01)
      worse.push_back(channel_words(channels_of(d)[other]));
  return "With " +
         std::string(!d.laws.empty() || (d.effects.empty() && !d.apart.empty())
                         ? (fitted_effects(d) + d.laws.size() + d.apart.size() == 1 ? "it" : "them")
                     : d.effects.empty() || d.wandering ? "a stand-in"
                     : d.effects.size() == 1            ? "it"
                                                        : "them") +
         " put in, the error of " + channel_words(channels_of(d)[c]) + " on held-out data goes from " +
         channel_value(channels_of(d)[c], held.before[c]) + " to " + channel_value(channels_of(d)[c], held.after[c]) +
         "; noise alone would give " + channel_value(channels_of(d)[c], held.noise[c]) + "." +
         (worse.empty() ? "" : " It grows for " + listed(worse) + ".");
}

DiagnosisWords diagnosis_words(const Diagnosis& d, const DiagnosisInputs& inputs) {
  std::vector<std::string> where = odd_words(d);  // before anything is read from it
  for (std::string& paragraph : where_words(d)) where.push_back(std::move(paragraph));
  std::vector<std::string> what = what_words(d, inputs);
  if (d.verdict != Verdict::consistent && !inputs.settings.search.without.empty()) what.push_back(tried_words(d, inputs.settings));
  return {verdict_sentence(d), summary_sentence(d),     std::move(where), std::move(what),
          modelled_words(d),   better_words(d, inputs), next_words(d)};
}

}  // namespace sinew::apps

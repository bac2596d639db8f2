// SPDX-License-Identifier: Apache-2.0
#include "apps/answer_text.h"

#include <algorithm>
#include <cmath>

#include "apps/comparison_page.h"
#include "plant/contains.h"
#include "report/number.h"

namespace sinew::apps {
namespace {

using diagnose::Diagnosis;
using diagnose::doubtful_below;
using diagnose::Found;
using diagnose::NoConstant;
using diagnose::NothingMissing;
using diagnose::Unexplained;

constexpr double faint_from = 0.3;       // decades below the typical strength from which on it is said
constexpr double unbelieved_from = 3.0;  // deviations of a value from what is believed of it, from which on it is said
constexpr double alike_below = 3.0;      // of log evidence

// What was found, as clauses.
std::string found_words(const Diagnosis& d, const diagnose::FoundEffect& found) {
  const plant::EffectId name = plant::family_of(effects_of(d), found.effect);
  return std::string(effects_of(d)[name].words) + (found.form == diagnose::Form::catalogue ? "" : ", in a form of its own");
}

std::vector<std::string> found_words(const Diagnosis& d, const Found& answer) {
  std::vector<std::string> words;
  for (const auto& found : answer.effects) words.push_back(found_words(d, found));
  return words;
}

// The name whose form a law is here, or may be.
const diagnose::FoundEffect* name_of_law(const Diagnosis& d, const Found& answer, const diagnose::FoundLaw& law) {
  for (const auto& found : answer.effects)
    if (diagnose::is_own(system_of(d), {found.effect}, law.law)) return &found;
  return nullptr;
}

// Laws without a name that is likely, as clauses.
std::vector<std::string> law_clauses(const Diagnosis& d, const Found& answer) {
  std::vector<std::string> words;
  for (const auto& found : answer.laws)
    if (const auto* name = name_of_law(d, answer, found); !name || name->confidence < doubtful_below)
      words.push_back(std::string(effects_of(d)[found.effect].words));
  return words;
}

// "..., likely (probability 0.90)"
std::vector<std::string> apart_with_probabilities(const Diagnosis& d, const Found& answer) {
  std::vector<std::string> words;
  for (const auto& found : answer.apart) words.push_back(apart_clause(sharing_of(d, found)) + ", " + probability_words(found.confidence));
  return words;
}

std::string noise_words(const Diagnosis& d) { return system_of(d).surroundings() ? "sensor noise and moving air" : "sensor noise"; }

// What is no sign of missing physics.
std::string left_open_words(const Diagnosis& d) {
  return system_of(d).surroundings() ? "noise and moving air leave open" : "noise leaves open";
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

std::string rivals_in_headline(const Diagnosis& d, const Found& answer) {
  std::vector<std::string> names;
  for (const plant::EffectId e : answer.ambiguous_with) names.push_back(std::string(effects_of(d)[e].words));
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
std::vector<std::string> names_with_probabilities(const Diagnosis& d, const Found& answer) {
  std::vector<std::string> named;
  for (const auto& found : answer.effects) named.push_back("that " + found_words(d, found) + ", " + probability_words(found.confidence));
  return named;
}

bool nearly_explains(const Diagnosis& d) { return d.explained_share >= diagnose::Thresholds{}.least_explained_share; }

// Where nothing else was found.
std::string only_apart_words(const Diagnosis& d, const Found& answer) {
  return capitalised(listed(apart_with_probabilities(d, answer))) + ", and the plant takes them to be alike. That takes away " +
         percent(d.explained_share) + (d.by_paths ? " of the squared error beyond noise" : " of what " + left_open_words(d)) +
         (nearly_explains(d) ? "." : "; what else is missing matches no effect in the catalogue.");
}

std::string headline_of(const Diagnosis& d, const NothingMissing&) {
  if (d.by_chance)
    return "Nothing is missing that could be told from chance: the plant leaves more than it mostly does, but so do some recordings in "
           "which nothing is missing.";
  if (std::string little = too_little_words(d); !little.empty()) return little;
  return "Nothing is missing that could be seen: with its parameters fitted, the plant explains " +
         std::string(d.gate.size() > 1 ? "the recordings" : "the recording") + " to within " + noise_words(d) + ".";
}

std::string whole_headline(const Diagnosis& d, const Found& answer) {
  const auto& effects = answer.effects;
  const bool doubtful = std::all_of(effects.begin(), effects.end(), [](const auto& found) { return found.confidence < doubtful_below; });
  // Several have a probability each.
  const bool one = effects.size() == 1, told_apart = answer.ambiguous_with.empty();
  std::string text = std::string(doubtful ? "Something is missing, perhaps " : "The plant leaves out ") +
                     (one || !told_apart ? "that " + listed(found_words(d, answer)) : listed(names_with_probabilities(d, answer)));
  if (const auto laws = law_clauses(d, answer); !laws.empty()) text += "; and, without a name, " + listed(laws);
  text += told_apart ? (one ? ": " + probability_words(effects.front().confidence) : "") + "." : rivals_in_headline(d, answer);
  return text + (answer.apart.empty() ? "" : " And " + listed(apart_with_probabilities(d, answer)) + ".");
}

std::string headline_in_part(const Diagnosis& d, const Found& answer) {
  const bool names_alone = answer.laws.empty() && answer.apart.empty() && !d.by_paths;
  const bool nearly = names_alone && d.objections.leaves_too_much && nearly_explains(d);
  const std::vector<std::string> laws = law_clauses(d, answer);
  std::vector<std::string> parts;
  if (!answer.effects.empty()) parts.push_back(listed(names_with_probabilities(d, answer)));
  if (!laws.empty()) parts.push_back((parts.empty() ? "without a name, " : "and without a name, ") + listed(laws));
  if (!answer.apart.empty()) parts.push_back((parts.empty() ? "" : "and ") + listed(apart_with_probabilities(d, answer)));
  std::string found;
  for (const std::string& part : parts) found += (found.empty() ? "" : "; ") + part;
  return (nearly ? "What is missing looks like an effect in the catalogue, but something is left that its law does not explain: "
                 : std::string("More is missing than the catalogue explains") +
                       (answer.effects.empty() ? ": " : ", but part of it has a name: ")) +
         found + (!names_alone || answer.ambiguous_with.empty() ? "." : rivals_in_headline(d, answer)) + " " +
         (answer.effects.size() + answer.laws.size() + answer.apart.size() > 1 ? "Together they take" : "It takes") + " away " +
         percent(d.explained_share) + (d.by_paths ? " of the squared error beyond noise." : " of what " + left_open_words(d) + ".");
}

// Curves, and no name that is likely.
std::string headline_without_name(const Diagnosis& d, const Found& answer) {
  const std::vector<std::string> laws = law_clauses(d, answer);
  if (!answer.effects.empty() && !laws.empty())
    return "Something is missing that has a place and a curve: " + listed(laws) + ". It may be " +
           listed(names_with_probabilities(d, answer)) +
           (answer.ambiguous_with.empty() ? "; if not, it matches no effect in the catalogue." : rivals_in_headline(d, answer));
  return "Something is missing that matches no effect in the catalogue, but it has a place and a curve: " + listed(laws) + ". With " +
         (answer.laws.size() == 1 ? "it " : "them ") + percent(d.explained_share) + " of " +
         (d.by_paths ? "the squared error beyond noise" : "what " + left_open_words(d)) + " goes.";
}

std::string headline_of(const Diagnosis& d, const Found& answer) {
  if (!answer.is_named) return headline_without_name(d, answer);
  if (answer.effects.empty() && answer.laws.empty()) return only_apart_words(d, answer);
  return answer.leaves_something ? headline_in_part(d, answer) : whole_headline(d, answer);
}

std::string headline_of(const Diagnosis& d, const NoConstant& answer) {
  const auto& of = answer.course.of;
  const auto& on = answer.course.on;
  const std::string which = of.effect ? " (" + std::string(effects_of(d)[*of.effect].words) + ")" : "";
  return "Something is missing that matches no effect in the catalogue. It acts in " + located_words(d) + ": as if " + of.words + which +
         " were no constant but" +
         (on.explained_share >= goes_with_share ? " changed with " + variable_words(on) : " changed from moment to moment") + ".";
}

std::string headline_of(const Diagnosis& d, const Unexplained&) {
  return "Something is missing that matches no effect in the catalogue: it seems to enter in " + located_words(d) + ".";
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
std::string more_explained_words(const Diagnosis& d, const Found& answer, plant::EffectId found, plant::EffectId runner_up) {
  const diagnose::Candidate *likeliest = candidate_of(d, runner_up), *mine = candidate_of(d, found), *most = nullptr;
  if (answer.effects.size() != 1 || !likeliest || !mine || !likeliest->explanation.usable) return "";
  const auto share = [&](const diagnose::Candidate& one) { return share_explained(d.search.core, one.explanation); };
  for (const auto& one : d.search.rounds.front().candidates) {
    const plant::EffectId name = plant::family_of(effects_of(d), one.effect);  // another form of it is no rival
    if (name == plant::family_of(effects_of(d), found) || name == plant::family_of(effects_of(d), runner_up)) continue;
    if (!one.explanation.usable) continue;
    if (contains(answer.ambiguous_with, one.effect)) continue;
    if (!most || share(one) > share(*most)) most = &one;
  }
  if (!most || percent(share(*most)) == percent(share(*likeliest)) || share(*most) < share(*likeliest)) return "";
  return " Of the others " + effect_name(d, most->effect) + " explains most, " + percent(share(*most)) + ", but is " +
         odds_words(mine->explanation.log_evidence - most->explanation.log_evidence) + ".";
}

std::string rivals_words(const Diagnosis& d, const Found& answer, const diagnose::FoundEffect& found) {
  std::vector<std::pair<plant::EffectId, double>> rivals = found.rivals;
  std::erase_if(rivals, [&](const auto& rival) { return contains(answer.ambiguous_with, rival.first); });
  std::string text;
  if (!rivals.empty()) {
    const auto& [effect, loss] = rivals.front();
    text = "The runner-up is that " + std::string(effects_of(d)[effect].words) + " (" + effect_name(d, effect) + "): ";
    const diagnose::Candidate* candidate = answer.effects.size() == 1 ? candidate_of(d, effect) : nullptr;
    if (candidate && candidate->explanation.usable)
      text += "it explains " + percent(share_explained(d.search.core, candidate->explanation)) + " and is ";
    else
      text += "in its place it is ";
    text += odds_words(loss) + ".";
    text += more_explained_words(d, answer, found.effect, effect);
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

// Which of a find's quantities that cannot be nothing lie where none is believed to lie. Its strength is spoken of elsewhere (faint).
std::string unbelieved_words(const Diagnosis& d, const diagnose::FoundEffect& found) {
  std::string text;
  for (const auto& parameter : found.parameters) {
    if (parameter.parameter == effects_of(d)[found.effect].strength || std::abs(parameter.from_belief) < unbelieved_from) continue;
    const auto& declared = parameters_of(d)[parameter.parameter].declaration;
    if (!plant::is_positive(declared)) continue;
    text += std::string(declared.symbol.empty() ? declared.name : declared.symbol) + " lies " +
            report::significant(std::abs(parameter.from_belief), 2) + " standard deviations " +
            (parameter.from_belief < 0.0 ? "below" : "above") + " what is believed of it (" +
            with_unit(report::significant(declared.typical, 2), declared.unit.text) +
            " is typical): so far out the equation may do the work of other physics, and this lowers its probability. ";
  }
  return text;
}

std::string found_paragraph(const Diagnosis& d, const Found& answer, const diagnose::FoundEffect& found) {
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
    text +=
        "The equation becomes " + std::string(info.equation) + (sizes.empty() ? "" : ", with " + sizes) + ". " + unbelieved_words(d, found);
  }
  if (d.by_paths)
    text +=
        found.support.gain > 0.0
            ? std::string("Without it") +
                  (diagnose::has_law_as_form(system_of(d), answer.laws, found.effect) ? ", and without a law that may be its form," : "") +
                  " the best plant that was tried is " + odds_words(0.5 * found.support.gain) + ". "
            : "";
  else if (answer.effects.size() == 1 && answer.laws.empty())
    text += "Why: it explains " + percent(d.explained_share) + " of what " + left_open_words(d) + ", and chance would bring such a gain " +
            chance_words(found.chance) + ". ";
  else if (answer.laws.empty())
    text += "Chance would bring such a gain " + chance_words(found.chance) + ". ";
  text += what_lowers_words(found.support);
  text += rivals_words(d, answer, found);
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
  const std::string simulated =
      std::to_string(chance.drawn) + " simulations in which nothing is missing, " +
      (system_of(d).surroundings() ? "with air that varies by " + report::fixed(chance.nuisance, 2) + " K, " : "");
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

std::string law_paragraph(const Diagnosis& d, const Found& answer, const diagnose::FoundLaw& found) {
  const diagnose::FoundEffect* name = name_of_law(d, answer, found);
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

std::string wandering_words(const Diagnosis& d, const NoConstant& answer) {
  const auto& w = answer.course;
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
  if (!answer.effects.empty())
    text += " So perhaps " + std::string(effects_of(d)[*w.of.effect].words) + ", but not by a constant amount (" +
            probability_words(answer.effects.front().confidence) + ").";
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
  const auto is_there = [&](plant::EffectId e) { return contains(likeliest, e); };
  if (!std::all_of(kept.begin(), kept.end(), is_there)) return names;
  for (const plant::EffectId e : likeliest)
    if (!contains(kept, e))
      names.push_back(effects_of(d)[e].law       ? std::string(effects_of(d)[e].words)
                      : effects_of(d)[e].sharing ? "that " + std::string(effects_of(d)[e].words)
                                                 : "that " + std::string(effects_of(d)[e].words) + " (" + effect_name(d, e) + ")");
  return names;
}

// The effects that come nearest, and why none of them is named.
std::vector<std::string> nearest_words(const Diagnosis& d, const DiagnosisInputs& inputs, const std::string& how) {
  std::vector<std::string> near;
  if (!d.search.rounds.empty())
    for (const auto& candidate : d.search.rounds.front().candidates) {
      if (!candidate.explanation.usable || near.size() == 3) continue;
      near.push_back(effect_name(d, candidate.effect) + " explains " + percent(share_explained(d.search.core, candidate.explanation)));
    }
  if (near.empty()) return {};
  return {"Of the catalogue, " + how + listed(near) + " of what " + left_open_words(d) + ". " + no_name_words(d, inputs.settings)};
}

// How open-loop simulation found what it found.
std::vector<std::string> by_paths_words(const Diagnosis& d) {
  std::vector<std::string> text{
      "No effects of the catalogue explain the recording to within noise. What follows was found by open-loop simulation from " +
      input_words(system_of(d)) + " alone: " + std::to_string(d.proposals.all.size()) +
      " plants with effects or laws added, the best of all that were tried, were compared under one measure of error, and each was kept "
      "where seconds that were left out of the fit, a tenth at a time, are predicted better with it, beyond chance. "
      "Together they take away " +
      percent(d.explained_share) + " of the squared error beyond noise."};
  if (const auto more = fitted_but_idle(d); !more.empty())
    text.push_back("Also tried: " + listed(more) + ". The plant with this is " +
                   odds_words(d.proposals.all[d.proposals.answer].log_odds - likeliest_by_fit(d).log_odds) +
                   " than the answer by its fit, but predicts no better what was left out of it.");
  return text;
}

// Why what was found may be something else.
std::string ambiguous_words(const Diagnosis& d, const Found& answer) {
  std::vector<std::string> names;
  for (const plant::EffectId e : answer.ambiguous_with)
    names.push_back(std::string(effects_of(d)[e].words) + " (" + effect_name(d, e) + ")");
  std::string why = "Either explains the recording about as well.";
  if (!answer.parsimony.as_good.empty())
    why = "Neither explains all, so one of them acts in another form than the catalogue's, and that one fits better says little.";
  else if (!answer.parsimony.common_causes.empty())
    why = std::string(answer.effects.size() == 1 ? "An effect of the other kind of sensor gained, too. " : "") +
          "Both kinds of sensor off at once would be a coincidence; one cause before both, in another form than the catalogue's, is as "
          "likely.";
  return "It cannot be told from this: that " + listed(names) + ". " + why;
}

using Paragraphs = std::vector<std::string>;

void append(Paragraphs& text, Paragraphs more) { text.insert(text.end(), more.begin(), more.end()); }

Paragraphs what_of(const Diagnosis& d, const DiagnosisInputs& inputs, const NothingMissing&) {
  std::string tested = tried_words(d, inputs.settings);
  if (const auto& round = round_from(d.search, d.search.core); !round.scores.best.empty()) {
    const plant::EffectId best =
        round.candidates.empty() ? round.scores.all[round.scores.best.front()].effect : round.candidates.front().effect;
    tested += " The one that would help most is that " + std::string(effects_of(d)[best].words) + " (" + effect_name(d, best) +
              "); chance alone brings as much " + chance_words(round.chance) + ".";
  }
  return {tested};
}

Paragraphs what_of(const Diagnosis& d, const DiagnosisInputs&, const Found& answer) {
  const auto& [effects, laws] = std::tie(answer.effects, answer.laws);
  Paragraphs text;
  if (d.by_paths)
    text = by_paths_words(d);
  else if (!laws.empty())
    text.push_back("The catalogue's own forms leave more than noise. With " + std::string(laws.size() == 1 ? "a curve" : "curves") +
                   (fitted_effects(d.answer) > 0 ? " beside what has a name,"
                    : effects.empty()            ? ", and no name,"
                                                 : " in their place,") +
                   " the plant explains " + percent(d.explained_share) + " of what " + left_open_words(d) +
                   ", and predicts held-out data no worse than without.");
  else if (answer.leaves_something && d.objections.leaves_too_much && !effects.empty())
    text.push_back("What can be named explains " + percent(d.explained_share) + " of what " + left_open_words(d) +
                   ". What is left is more than noise: the effect acts in another form than the catalogue's, is not alone, or is a "
                   "look-alike of one that the catalogue lacks.");
  for (const auto& found : effects) text.push_back(found_paragraph(d, answer, found));
  for (const auto& found : laws) text.push_back(law_paragraph(d, answer, found));
  for (const auto& found : answer.apart) text.push_back(apart_paragraph(d, found));
  if (effects.size() > 1 && !d.by_paths)
    text.push_back("Together they explain " + percent(d.explained_share) + " of what " + left_open_words(d) + ".");
  if (effects.empty()) return text;
  if (!answer.ambiguous_with.empty())
    text.push_back(ambiguous_words(d, answer));
  else if (!d.by_paths)
    text.back() += " Nothing else in the catalogue does as well.";
  return text;
}

Paragraphs what_of(const Diagnosis& d, const DiagnosisInputs& inputs, const NoConstant& answer) {
  Paragraphs text{"Something is missing that matches no effect in the catalogue. " + wandering_words(d, answer)};
  append(text, nearest_words(d, inputs, "with constant strength, "));
  std::vector<std::string> names;
  for (const plant::EffectId e : answer.ambiguous_with) names.push_back(effect_name(d, e));
  if (!names.empty()) text.push_back("It cannot be told from " + listed(names) + ".");
  return text;
}

Paragraphs what_of(const Diagnosis& d, const DiagnosisInputs& inputs, const Unexplained&) {
  if (d.by_paths) return by_paths_words(d);  // what was found is hardly believed
  std::string start = "Something is missing that matches no effect in the catalogue.";
  if (const auto& left = d.left_over; !left.variable.empty())
    start += " What the plant would need in " + std::string(groups_of(d)[left.group].words) +
             (left.explained_share >= goes_with_share
                  ? " goes with " + variable_words(left) + ", which accounts for " + percent(left.explained_share) + " of it."
                  : " follows no single quantity: the nearest, " + variable_words(left) + ", accounts for only " +
                        percent(left.explained_share) + " of it.");
  Paragraphs text{start};
  append(text, nearest_words(d, inputs, ""));
  return text;
}

}  // namespace

// A channel that does not answer the inputs says nothing of the plant: that stands before what the others show.
std::string headline(const Diagnosis& d) {
  std::vector<std::string> silent;
  for (const auto& notes : d.gate)
    for (const auto& channel : notes.unresponsive)
      silent.push_back(channel.words + (d.gate.size() > 1 ? " (" + notes.recording + ")" : ""));
  const std::string answer = std::visit([&](const auto& one) { return headline_of(d, one); }, d.answer);
  if (silent.empty()) return answer;
  return "Look at the recording first: " + listed(silent) + ". Apart from that: " + answer;
}

std::vector<std::string> what_words(const Diagnosis& d, const DiagnosisInputs& inputs) {
  Paragraphs text = std::visit([&](const auto& one) { return what_of(d, inputs, one); }, d.answer);
  if (!d.by_chance) return text;
  const bool last = std::holds_alternative<NothingMissing>(d.answer);
  text.insert(last ? text.end() : text.begin(), chance_of_the_rest(d));
  return text;
}

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

std::string plant_words(const Diagnosis& d) { return std::string(system_of(d).words()); }

std::string variable_words(const diagnose::Dependence& on) {
  const bool name = on.variable == "time" || on.variable.starts_with("temperature") || on.variable.starts_with("duty");
  return (name ? "" : "the ") + on.variable;
}

std::string sharing_words(const plant::Sharing& sharing) { return sharing.effect ? "the values of " + sharing.words : sharing.words; }

std::string apart_clause(const plant::Sharing& sharing) {
  return "the " + std::string(sharing.parts_word) + " are not alike in " + sharing_words(sharing);
}

std::size_t fitted_effects(const diagnose::Answer& answer) {
  const auto is_fitted = [](const auto& found) { return found.form != diagnose::Form::free; };
  const auto& effects = effects_in(answer);
  return static_cast<std::size_t>(std::count_if(effects.begin(), effects.end(), is_fitted));
}

}  // namespace sinew::apps

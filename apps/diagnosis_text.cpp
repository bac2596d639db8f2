// SPDX-License-Identifier: Apache-2.0
#include "apps/diagnosis_text.h"

#include <algorithm>
#include <cmath>

#include "apps/answer_text.h"
#include "apps/comparison_page.h"
#include "plant/contains.h"
#include "plant/integrator.h"
#include "report/number.h"
#include "sim/plant_file.h"

namespace sinew::apps {
namespace {

using diagnose::Diagnosis;
using diagnose::NoConstant;
using diagnose::NothingMissing;

std::vector<std::string> apart_clauses(const Diagnosis& d) {
  std::vector<std::string> words;
  for (const auto& found : apart_in(d.answer)) words.push_back(apart_clause(sharing_of(d, found)));
  return words;
}

// Several groups may have one place: two tanks, two balances of flows.
bool enters_at(const plant::EntryGroup& group, std::string_view place) { return group.name == place || contains(group.places, place); }

std::string share_of_mismatch(const Diagnosis& d, const diagnose::PlaceShare& share) {
  return std::string(groups_of(d)[share.group].words) + " (share " + report::fixed(share.share, 2) + " [" + report::fixed(share.lowest, 2) +
         "," + no_break + report::fixed(share.highest, 2) + "])";
}

// Where the pushes go that the calibrated plant would need, without any effect in mind.
std::string shares_words(const Diagnosis& d) {
  std::vector<diagnose::PlaceShare> shares = d.located.shares;
  std::stable_sort(shares.begin(), shares.end(), [](const auto& a, const auto& b) { return a.share > b.share; });
  // Where what was found acts is said below, and why it is not seen here.
  const auto& effects = effects_in(d.answer);
  const auto is_answer = [&](plant::EntryGroupId group) {
    return std::any_of(effects.begin(), effects.end(),
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
  const bool consistent = std::holds_alternative<NothingMissing>(d.answer);
  if (consistent && d.by_chance) return {first};
  if (consistent)
    return {first + (d.process_noise_beyond_ordinary && !d.process_noise_after_refit
                         ? " What is beyond noise is no more than what moving air does that is not the same everywhere."
                     : !system_of(d).surroundings() ? " What is beyond noise is no more than chance brings."
                                                    : " What is beyond noise is no more than what moving air does.")};

  std::string when = percent(located.worst.share_of_error) + " of the squared error of " + channel_words(channels_of(d)[located.channel]) +
                     " happens in " + percent(located.worst.share_of_time) + " of the time";
  if (!located.while_words.empty()) when += ", " + located.while_words;
  if (d.gate.size() > 1 && located.worst_recording < d.gate.size()) when += ", in " + file_name(d.gate[located.worst_recording].recording);
  if (!located.worst.windows_s.empty()) when += ": " + windows_words(located.worst);
  when += ".";

  std::string place = shares_words(d);
  const auto& effects = effects_in(d.answer);
  if (std::holds_alternative<NoConstant>(d.answer))
    place += std::string(place.empty() ? "" : " ") + "What would explain it best acts in " + place_words(system_of(d), located.place) + ".";
  else if (!effects.empty() && effects_of(d)[effects.front().effect].place == located.place && !leads(d, located.place))
    place += (place.empty() ? "" : " ") +
             std::string(effects.size() == 1 ? "The effect that may explain it, below,"
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

// Of what was added: a recording that begins warm.
std::string first_values_words(const Diagnosis& d) {
  constexpr std::size_t most = 4;
  std::vector<std::string> clauses;
  std::size_t more = 0;
  for (const FirstValue& one : first_values(d)) {
    if (!one.matters) continue;
    if (clauses.size() == most) {
      ++more;
      continue;
    }
    const double beyond = one.value - one.at_rest;
    clauses.push_back((d.gate.size() > 1 ? "in " + file_name(one.recording) + " " : "") + one.state + " is " +
                      interval_words(one.value, one.lowest, one.highest, one.unit) + ", " +
                      with_unit(report::significant(std::abs(beyond), 2), one.unit == "degC" ? "K" : one.unit) +
                      (beyond > 0.0 ? " above" : " below") + " rest");
  }
  if (clauses.empty()) return "";
  return "What was added does not begin at rest: " + listed(clauses) +
         (more > 0 ? "; " + std::to_string(more) + " more such first values are in the report" : "") + ".";
}

std::vector<std::string> modelled_words(const Diagnosis& d) {
  const auto& [effects, laws, apart] = std::tie(effects_in(d.answer), laws_in(d.answer), apart_in(d.answer));
  const bool varies = std::holds_alternative<NoConstant>(d.answer);
  const std::size_t fitted = fitted_effects(d.answer);
  std::string text;
  std::vector<std::string> substitutes;
  for (const plant::EffectId e : stand_ins(d)) substitutes.push_back(effect_name(d, e));
  if (added_effects(d).empty())
    text = "plant.yaml is the plant with all its parameters fitted; nothing is added to it." +
           std::string(varies ? " Nor is what would change: a plant does not know when it will." : "");
  else if (!laws.empty())
    text = "plant.yaml is the plant with " +
           std::string(fitted == 0   ? ""
                       : fitted == 1 ? "this effect and "
                                     : "these effects and ") +
           (laws.size() == 1 ? "this law" : "these laws") + " (`laws:`) in it, and all parameters fitted again.";
  else if (effects.empty() && !apart.empty() && substitutes.empty())
    text =
        "plant.yaml is the plant in which " + listed(apart_clauses(d)) + ", each with values of its own, and all parameters fitted again.";
  else if (effects.empty() || varies)
    text = "plant.yaml is the plant with all parameters fitted, and with " + listed(substitutes) +
           " switched on as a stand-in: " + (predicts_better(d) ? "it predicts better, but" : "it does not predict better, and") +
           " that is not what " + plant_words(d) + " does.";
  else
    text = "plant.yaml is the plant with " + std::string(effects.size() == 1 ? "this effect" : "these effects") +
           (substitutes.empty() ? "" : " and, as a stand-in for what has no name, " + listed(substitutes)) +
           " switched on and all parameters fitted again." +
           (something_is_left(verdict_of(d.answer)) ? " That " + plant_words(d) + " does this is not certain." : "");
  if (!apart.empty() && !(effects.empty() && laws.empty() && substitutes.empty()))
    text += " In it " + listed(apart_clauses(d)) + ", and each has values of its own.";
  text += " `sinew run` and `sinew compare` accept it.";
  for (const plant::ParameterId p : d.flipped_signs)
    text += " The recording says that " + parameters_of(d)[p].key() + " is " + sim::parameter_text(d.repaired, p) +
            ", the other way than in the given plant, and that was used.";
  if (const auto moved = moved_parameters(d); !moved.empty())
    text += " Fitted far from what was believed before, by more than two standard deviations: " + listed(moved) +
            ". Either the given plant is not quite this one, or more is missing.";
  std::vector<std::string> paragraphs{text};
  if (const std::string begins = first_values_words(d); !begins.empty()) paragraphs.push_back(begins);
  return paragraphs;
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
  const bool consistent = std::holds_alternative<NothingMissing>(d.answer);
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
    if (held.after[c] > (consistent ? 4.0 : 1.5) * held.noise[c]) rough.push_back(channel_words(channels_of(d)[c]));
  }
  if (text.size() == 1) return {"No data was held out, so nothing can be said about how well the plant predicts."};
  std::string closing;
  const plant::ChannelId c = d.located.channel;
  const auto before = correlation_after_1_s(d.correlation.before[c]), after = correlation_after_1_s(d.correlation.after[c]);
  if (before && after && !added_effects(d).empty())
    closing = "Errors of " + channel_words(channels_of(d)[c]) + " one second apart are alike by " + report::fixed(*before, 2) +
              " before and by " + report::fixed(*after, 2) + " after (1: the same; 0: pure noise).";
  if (!rough.empty() && consistent && !drives_more(d))
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
  const auto& effects = effects_in(d.answer);
  return std::any_of(effects.begin(), effects.end(), [&](const auto& found) {
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
  const auto& [effects, ambiguous_with] = std::tie(effects_in(d.answer), ambiguous_in(d.answer));
  if (!ambiguous_with.empty()) {
    // The effect in whose place the first of them would do.
    const auto in_place_of = std::find_if(effects.begin(), effects.end(), [&](const auto& found) {
      return std::any_of(found.rivals.begin(), found.rivals.end(), [&](const auto& r) { return r.first == ambiguous_with.front(); });
    });
    const auto& found = in_place_of == effects.end() ? effects.front() : *in_place_of;
    std::vector<std::string> names{std::string(effect_name(d, found.effect))};
    for (const plant::EffectId e : ambiguous_with) names.push_back(effect_name(d, e));
    const auto* answer = std::get_if<diagnose::Found>(&d.answer);
    if (answer && answer->experiment && answer->experiment->separation > 0.0) {
      const auto& e = *answer->experiment;
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
  const diagnose::Verdict verdict = verdict_of(d.answer);
  if (something_is_left(verdict)) {
    const auto& left = d.left_over;
    if (const auto* varying = std::get_if<NoConstant>(&d.answer))
      text.push_back("Look at the course of " + varying->course.of.words + " in the report, and at what happens at " + plant_words(d) +
                     " when it changes" +
                     (varying->course.on.explained_share >= goes_with_share
                          ? ": which law would make it change with " + variable_words(varying->course.on) + "?"
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
  } else if (verdict == diagnose::Verdict::missing_physics && ambiguous_with.empty()) {
    std::string more = "Nothing further is found.";
    if (const auto& round = round_from(d.search, d.chosen); !round.accepted && !round.scores.best.empty()) {
      const plant::EffectId best =
          round.candidates.empty() ? round.scores.all[round.scores.best.front()].effect : round.candidates.front().effect;
      more += (is_found(d, best) ? " Another form of " + std::string(effects_of(d)[plant::family_of(effects_of(d), best)].name)
                                 : " The next best effect, " + effect_name(d, best) + ",") +
              " gains what chance alone brings " + chance_words(round.chance) + ".";
    }
    text.push_back(more);
  }
  if (verdict == diagnose::Verdict::consistent && !seen.empty())
    text.push_back("Had one of these been there, it would have been seen: " + listed(seen) + ".");
  std::string hidden;
  if (!imitated.empty())
    hidden = "A little of " + listed(imitated) + " would not show: fitting the other parameters imitates " +
             (imitated.size() == 1 ? "it" : "them") + " to first order. How much would have been seen is not known.";
  if (!too_small.empty() && something_is_left(verdict))
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

std::string summary_sentence(const Diagnosis& d) {
  const auto& held = d.held_out;
  const auto& [effects, laws, apart] = std::tie(effects_in(d.answer), laws_in(d.answer), apart_in(d.answer));
  // The channel that is furthest off; with something put in where most was off, or the one that it changes most.
  plant::ChannelId c = d.located.channel;
  if (added_effects(d).empty())
    for (const plant::ChannelId other : channels_of(d).ids())
      if (held.samples[other] > 0 && !(held.after[other] / held.noise[other] <= held.after[c] / held.noise[c])) c = other;
  if (!laws.empty() || (!added_effects(d).empty() && !(held.gain_lowest[c] > 0.0)))
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
  // Of these nothing is gained, though they are off by more than noise.
  constexpr double of_noise = 2.0;
  std::vector<std::string> as_before;
  for (const plant::ChannelId other : channels_of(d).ids())
    if (held.samples[other] > 0 && held.gain_lowest[other] <= 0.0 && held.gain_highest[other] >= 0.0 &&
        held.after[other] > of_noise * held.noise[other])
      as_before.push_back(channel_words(channels_of(d)[other]));
  return "With " +
         std::string(!laws.empty() || (effects.empty() && !apart.empty())
                         ? (fitted_effects(d.answer) + laws.size() + apart.size() == 1 ? "it" : "them")
                     : effects.empty() || std::holds_alternative<NoConstant>(d.answer) ? "a stand-in"
                     : effects.size() == 1                                             ? "it"
                                                                                       : "them") +
         " put in, the error of " + channel_words(channels_of(d)[c]) + " on held-out data goes from " +
         channel_value(channels_of(d)[c], held.before[c]) + " to " + channel_value(channels_of(d)[c], held.after[c]) +
         "; noise alone would give " + channel_value(channels_of(d)[c], held.noise[c]) + "." +
         (worse.empty() ? "" : " It grows for " + listed(worse) + ".") +
         (as_before.empty() ? "" : " Of " + listed(as_before) + " no change could be told from chance.");
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

std::vector<FirstValue> first_values(const diagnose::Diagnosis& d) {
  constexpr double far_share = 0.1;  // of the prior's deviation
  const diagnose::FitProblem& problem = *d.values.problem;
  const plant::Plant model = d.values.model();
  const plant::States states = model.states();
  std::vector<std::string> of_added;
  for (const plant::EffectId e : added_effects(d)) of_added.push_back(std::string(effects_of(d)[e].name) + ".");
  std::vector<FirstValue> all;
  for (std::size_t r = 0; r < problem.data().size(); ++r) {
    const plant::Start start{diagnose::elapsed_where_it_begins(states, *problem.data()[r].recording, problem.beginnings().counted_from_s),
                             {}};
    const plant::Integrator at_rest(model, start, problem.numerics());
    for (std::size_t i = 0; i < problem.free_states(r).size(); ++i) {
      const plant::StateId state = problem.free_states(r)[i];
      const std::size_t u = problem.first_start(r) + i;
      const plant::StateInfo& info = states[state];
      const double unit = info.unit.internal_per_unit, rest = at_rest.state()[state.index] / unit;
      const auto [lowest, highest] = d.values.interval(u, 1.959964);
      const diagnose::Unknown& unknown = problem.unknowns()[u];
      const double deviation = unknown.deviation / unit;
      FirstValue one{d.gate[r].recording,
                     info.key,
                     info.unit.text,
                     d.values.value(u) / unit,
                     std::max(lowest, unknown.lowest) / unit,
                     std::min(highest, unknown.highest) / unit,
                     rest,
                     false,
                     false};
      one.told = d.values.deviation(u) / unit < diagnose::untold_share * deviation;
      one.matters = one.told && (rest < one.lowest || rest > one.highest) && std::abs(one.value - rest) > far_share * deviation &&
                    !plant::grows_between_recordings(info.at_start) &&
                    std::ranges::any_of(of_added, [&](const std::string& effect) { return info.key.starts_with(effect); });
      all.push_back(std::move(one));
    }
  }
  return all;
}

std::vector<plant::EffectId> added_effects(const diagnose::Diagnosis& d) {
  const std::vector<plant::EffectId> before = d.search.core.effects();
  std::vector<plant::EffectId> added;
  for (const plant::EffectId e : effects_of(d).ids())
    if (d.repaired.is_on(e) && !contains(before, e)) added.push_back(e);
  return added;
}

std::vector<plant::EffectId> stand_ins(const diagnose::Diagnosis& d) {
  std::vector<plant::EffectId> all = added_effects(d);
  if (std::holds_alternative<NoConstant>(d.answer)) return all;  // what varies is not what was added, even if by the same name
  const auto& [effects, apart] = std::tie(effects_in(d.answer), apart_in(d.answer));
  std::erase_if(all, [&](plant::EffectId e) {
    const auto is_it = [&](const auto& found) { return found.effect == e; };
    return effects_of(d)[e].law || std::any_of(effects.begin(), effects.end(), is_it) || std::any_of(apart.begin(), apart.end(), is_it);
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
  std::erase_if(all, [&](const auto& other) { return contains(added, other.effect) || is_found(d, other.effect); });
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

DiagnosisWords diagnosis_words(const Diagnosis& d, const DiagnosisInputs& inputs) {
  std::vector<std::string> where = odd_words(d);  // before anything is read from it
  for (std::string& paragraph : where_words(d)) where.push_back(std::move(paragraph));
  std::vector<std::string> what = what_words(d, inputs);
  if (!std::holds_alternative<NothingMissing>(d.answer) && !inputs.settings.search.without.empty())
    what.push_back(tried_words(d, inputs.settings));
  return {headline(d), summary_sentence(d), std::move(where), std::move(what), modelled_words(d), better_words(d, inputs), next_words(d)};
}

}  // namespace sinew::apps

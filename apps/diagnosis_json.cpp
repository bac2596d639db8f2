// SPDX-License-Identifier: Apache-2.0
#include "apps/diagnosis_json.h"

#include <algorithm>
#include <cmath>

#include "report/number.h"
#include "sim/manifest.h"
#include "sim/plant_file.h"
#include "sim/recording.h"

namespace sinew::apps {
namespace {

using diagnose::Diagnosis;
using nlohmann::ordered_json;

template <class PerChannel>
ordered_json per_channel(const Diagnosis& d, const PerChannel& values) {
  ordered_json json;
  for (const plant::ChannelId c : channels_of(d).ids()) json[channels_of(d)[c].column] = values[c];  // NaN: null
  return json;
}

std::string name_of(const Diagnosis& d, plant::EffectId effect) { return std::string(effects_of(d)[effect].name); }

std::string family_name(const Diagnosis& d, plant::EffectId effect) { return name_of(d, plant::family_of(effects_of(d), effect)); }

ordered_json names_of(const Diagnosis& d, const std::vector<plant::EffectId>& effects) {
  ordered_json json = ordered_json::array();
  for (const plant::EffectId e : effects) json.push_back(name_of(d, e));
  return json;
}

ordered_json windows_json(const diagnose::WorstTime& worst) {
  ordered_json json = ordered_json::array();
  for (const auto& [from, to] : worst.windows_s) json.push_back({from, to});
  return json;
}

ordered_json effect_json(const Diagnosis& d, const diagnose::FoundEffect& found) {
  const auto& info = effects_of(d)[found.effect];
  ordered_json json{{"name", family_name(d, found.effect)},
                    {"place", info.place},
                    {"confidence", found.confidence},
                    {"form", text_of(found.form)}};
  if (info.form_of) json["by"] = info.name;  // as in plant.yaml
  json["parameters"] = ordered_json::object();
  for (const auto& parameter : found.parameters) {
    const auto& declared = parameters_of(d)[parameter.parameter].declaration;
    ordered_json value{{"value", parameter.value}, {"ci95", {parameter.lowest, parameter.highest}}};
    if (declared.kind == plant::Kind::toggle) value["value"] = parameter.value != 0.0;
    if (parameter.known)
      value["assumed"] = true;
    else
      value["deviations_from_belief"] = parameter.from_belief;
    json["parameters"][std::string(declared.name)] = value;
  }
  json["gain"] = found.support.gain;
  json["chance"] = found.chance;
  json["support"] = support_json(found.support);
  json["rivals"] = ordered_json::array();
  for (const auto& [effect, loss] : found.rivals) json["rivals"].push_back({{"name", name_of(d, effect)}, {"loss_of_log_evidence", loss}});
  return json;
}

ordered_json round_json(const Diagnosis& d, const diagnose::Round& round, const diagnose::Explanation& core) {
  ordered_json json;
  json["before"] = names_of(d, round.before.effects());
  json["accepted"] = round.accepted;
  json["gain"] = round.gain;
  json["chance"] = round.chance;
  json["unrest_before"] = round.before.process_noise;
  json["candidates"] = ordered_json::array();
  for (const auto& candidate : round.candidates) {
    ordered_json one{{"name", name_of(d, candidate.effect)},
                     {"score", candidate.score.statistic},
                     {"fitted", candidate.explanation.usable}};
    if (candidate.explanation.usable) {
      one["gain"] = 2.0 * (candidate.explanation.log_posterior - round.before.log_posterior);
      one["log_evidence"] = candidate.explanation.log_evidence;
      one["explained_share"] = share_explained(core, candidate.explanation);
    }
    json["candidates"].push_back(one);
  }
  json["scores"] = ordered_json::object();
  for (const std::size_t s : round.scores.best) json["scores"][name_of(d, round.scores.all[s].effect)] = round.scores.all[s].statistic;
  return json;
}

ordered_json gate_json(const Diagnosis& d, const diagnose::GateNotes& gate) {
  return {{"recording", gate.recording},
          {"samples", gate.samples},
          {"period_s", gate.period_s},
          {"duration_s", gate.duration_s},
          {"begins_s", gate.begins_s ? ordered_json(*gate.begins_s) : ordered_json()},
          {"reading_period_s", per_channel(d, gate.reading_period_s)},
          {"noise", per_channel(d, gate.noise)},
          {"step", per_channel(d, gate.step)},
          {"outliers", per_channel(d, gate.outliers)},
          {"missing", per_channel(d, gate.missing)},
          {"longest_gap_s", gate.longest_gap_s},
          {"largest_duty_fraction", gate.largest_input},
          {"warnings", gate.warnings}};
}

ordered_json fitted_json(const Diagnosis& d) {
  ordered_json json = ordered_json::object();
  for (const FittedValue& one : fitted_values(d)) {
    const auto& unknown = d.values.problem->unknowns()[one.unknown];
    json[unknown.name] = {{"value", one.value},
                          {"ci95", {one.lowest, one.highest}},
                          {"before", unknown.centre / unknown.internal_per_unit}};
  }
  return json;
}

ordered_json first_values_json(const Diagnosis& d) {
  ordered_json json = ordered_json::array();
  for (const FirstValue& one : first_values(d))
    json.push_back({{"recording", one.recording},
                    {"state", one.state},
                    {"value", one.value},
                    {"ci95", {one.lowest, one.highest}},
                    {"at_rest", one.at_rest},
                    {"told", one.told}});
  return json;
}

ordered_json given_json(const DiagnosisInputs& inputs, const InputHashes& hashes) {
  ordered_json json;
  const auto add = [&](const char* role, const std::string& path) {
    json.push_back({{"role", role}, {"path", path}, {"sha256", hashes.at(path)}});
  };
  for (const std::string& path : inputs.training) add("train", path);
  for (const std::string& path : inputs.held_out) add("heldout", path);
  add("plant", inputs.plant);
  for (const std::string& one : inputs.ignored) json.push_back({{"role", "ignored"}, {"seconds", one}});
  return json;
}

}  // namespace

ordered_json support_json(const diagnose::Support& support) {
  return {{"share", support.share},
          {"gain", support.gain},
          {"faint", support.faint},
          {"law_beside", support.law_beside},
          {"unbelieved", support.unbelieved}};
}

ordered_json chance_json(const diagnose::ProcessNoiseByChance& chance) {
  return {{"drawn", chance.drawn},    {"as_large", chance.as_large}, {"unrest", chance.process_noise},
          {"air_K", chance.nuisance}, {"largest", chance.largest},   {"probability", chance.probability()}};
}

// Values in the unit of the entry's group; of a law that is a share of something, shares.
ordered_json law_json(const Diagnosis& d, const diagnose::FoundLaw& found) {
  const auto variables = [&](const std::vector<plant::VariableId>& of) {
    ordered_json names = ordered_json::array();
    for (const plant::VariableId v : of) names.push_back(system_of(d).variables()[v].name);
    return names;
  };
  const auto& group = groups_of(d)[found.law.entry];
  ordered_json law = {{"entry", group.name},
                      {"argument", variables(found.law.argument)},
                      {"times", variables(found.law.factor)},
                      {"fading_memory_s", found.law.fading_memory_s},
                      {"unit", found.law.factor.empty() ? std::string(group.unit) : ""},
                      {"argument_unit", system_of(d).variables()[found.law.argument.front()].unit},
                      {"knots", found.law.knots},
                      {"values", found.values}};
  ordered_json band = ordered_json::array(), forms = ordered_json::array();
  for (std::size_t k = 0; k < found.values.size(); ++k) {
    const double half = 1.959964 * found.deviation[k];
    band.push_back({found.values[k] - half, found.values[k] + half});
  }
  for (const auto& form : found.forms) forms.push_back({{"form", form.words}, {"error", form.error}});
  law["band"] = band;
  return {{"words", effects_of(d)[found.effect].words},
          {"form", "free"},
          {"place", found.place},
          {"log_odds", found.log_odds},
          {"law", law},
          {"closed_forms", forms}};
}

ordered_json apart_json(const Diagnosis& d, const diagnose::FoundApart& found) {
  const plant::Sharing& sharing = sharing_of(d, found);
  ordered_json values = ordered_json::array();
  for (const auto& one : found.values)
    values.push_back({{"parameter", parameters_of(d)[one.parameter].key()},
                      {"part", sharing.parts[one.part]},
                      {"value", one.value},
                      {"interval", {one.lowest, one.highest}}});
  return {{"words", effects_of(d)[found.effect].words},
          {"effect", sharing.effect ? ordered_json(effects_of(d)[*sharing.effect].name) : ordered_json(nullptr)},
          {"probability", found.confidence},
          {"support", support_json(found.support)},
          {"log_odds", found.log_odds},
          {"values", values}};
}

ordered_json diagnosis_json(const diagnose::Diagnosis& d, const DiagnosisInputs& inputs, const InputHashes& hashes) {
  ordered_json json;
  json["verdict"] = text_of(verdict_of(d.answer));
  json["effects"] = ordered_json::array();
  const auto* varying = std::get_if<diagnose::NoConstant>(&d.answer);
  for (const auto& found : effects_in(d.answer)) {
    json["effects"].push_back(effect_json(d, found));
    if (varying) json["effects"].back()["constant"] = false;
  }
  json["laws"] = ordered_json::array();
  for (const auto& found : laws_in(d.answer)) json["laws"].push_back(law_json(d, found));
  json["apart"] = ordered_json::array();
  for (const auto& found : apart_in(d.answer)) json["apart"].push_back(apart_json(d, found));
  json["ambiguous_with"] = ordered_json::array();
  for (const plant::EffectId e : ambiguous_in(d.answer)) json["ambiguous_with"].push_back(family_name(d, e));
  if (const auto* found = std::get_if<diagnose::Found>(&d.answer); found && found->experiment) {
    const diagnose::Experiment& one = *found->experiment;
    json["experiment"] = {{"effect", effects_of(d)[one.effect].name},
                          {"rival", effects_of(d)[one.rival].name},
                          {"words", one.words},
                          {"duration_s", one.duration_s},
                          {"largest_duty_fraction", one.largest_share},
                          {"hottest_degC", one.highest},
                          {"separation", one.separation}};
  }
  json["located"] = {{"channel", channels_of(d)[d.located.channel].column},
                     {"place", d.located.place},
                     {"windows_s", windows_json(d.located.worst)},
                     {"recording", d.located.worst_recording < d.gate.size() ? d.gate[d.located.worst_recording].recording : ""},
                     {"share_of_time", d.located.worst.share_of_time},
                     {"share_of_error", d.located.worst.share_of_error},
                     {"while", d.located.while_words},
                     {"cannot_be_told_from", d.located.cannot_be_told_from},
                     {"calibrated", per_channel(d, d.located.rmse)},
                     {"noise", per_channel(d, d.located.noise)}};
  ordered_json shares = ordered_json::array();
  for (const auto& share : d.located.shares)
    shares.push_back({{"place", groups_of(d)[share.group].name},
                      {"share", share.share},
                      {"ci95", {share.lowest, share.highest}},
                      {"log_likelihood", share.log_likelihood}});
  json["located"]["shares"] = shares;

  const auto& held = d.held_out;
  ordered_json gain;
  for (const plant::ChannelId c : channels_of(d).ids())
    gain[channels_of(d)[c].column] = {{"value", held.gain[c]}, {"ci95", {held.gain_lowest[c], held.gain_highest[c]}}};
  json["fit"]["heldout"] = {{"before", per_channel(d, held.before)},
                            {"before_by_weighting",
                             {{"diagnose", per_channel(d, held.fitted)}, {"calibrate", per_channel(d, held.calibrated)}}},
                            {"after", per_channel(d, held.after)},
                            {"noise", per_channel(d, held.noise)},
                            {"nominal", per_channel(d, held.nominal)},
                            {"gain", gain},
                            {"samples", per_channel(d, held.samples)},
                            {"kept_back", held_out_words(d)},
                            {"judged_on_blocks", d.judged_on_blocks}};
  ordered_json driven_more = ordered_json::array();
  for (std::size_t r = 0; r < d.driven_more.size(); ++r)
    for (const plant::InputId i : d.driven_more[r])
      driven_more.push_back({{"recording", inputs.held_out[r]}, {"input", system_of(d).inputs()[i].column}});
  json["fit"]["heldout"]["driven_more"] = driven_more;
  json["fit"]["residual_correlation"]["lag_s"] = diagnose::correlation_lag_s;
  for (const plant::ChannelId c : channels_of(d).ids())
    json["fit"]["residual_correlation"][channels_of(d)[c].column] = {{"before", d.correlation.before[c]},
                                                                     {"after", d.correlation.after[c]}};

  json["proposals"] = ordered_json::array();
  for (const auto& one : d.proposals.all)
    json["proposals"].push_back(
        {{"effects", names_of(d, one.effects)}, {"log_odds", one.log_odds}, {"probability", one.probability}, {"counts", one.counts}});
  json["explained_share"] = d.explained_share;
  json["visibility"] = d.visibility;
  json["unrest"] = {{"core", d.search.core.process_noise}};
  if (!d.by_paths) json["unrest"]["repaired"] = d.chosen.process_noise;  // an open-loop simulation fitted by least squares has none
  if (d.process_noise_beyond_ordinary) json["process_noise_beyond_ordinary"] = *d.process_noise_beyond_ordinary;
  if (d.process_noise_after_refit) json["unrest"]["after_refit"] = *d.process_noise_after_refit;
  if (d.by_chance) json["unrest"]["by_chance"] = chance_json(*d.by_chance);
  json["stand_ins"] = names_of(d, stand_ins(d));
  json["fitted"] = fitted_json(d);
  json["first_values"] = first_values_json(d);
  json["flipped_signs"] = ordered_json::array();
  for (const plant::ParameterId p : d.flipped_signs) json["flipped_signs"].push_back(parameters_of(d)[p].key());

  json["would_have_been_seen"] = ordered_json::array();
  json["cannot_be_seen"] = ordered_json::array();
  for (const auto& other : not_found(d)) {
    const auto& strength = parameters_of(d)[effects_of(d)[other.effect].strength].declaration;
    json[other.can_be_seen ? "would_have_been_seen" : "cannot_be_seen"].push_back(
        {{"name", name_of(d, other.effect)},
         {"smallest_seen", !other.can_be_seen && is_imitated(other) ? ordered_json() : ordered_json(other.smallest_seen)},
         {"parameter", strength.name},
         {"unit", strength.unit.text},
         {"visible_share", other.visible_share},
         {"score", other.statistic}});
  }
  const auto& left = d.left_over;
  if (left.variable.empty()) {
    json["left_over"] = nullptr;
  } else {
    const auto& forcing = groups_of(d)[left.group];
    json["left_over"] = {{"place", forcing.name},
                         {"unit", forcing.unit},
                         {"variable", left.variable},
                         {"variable_unit", left.unit},
                         {"explained_share", left.explained_share},
                         {"at", left.centre},
                         {"mean", left.mean},
                         {"deviation", left.deviation}};
    const auto& entries = system_of(d).entries();
    const auto of_group = std::count_if(entries.begin(), entries.end(), [&](const plant::Entry& e) { return e.group == left.group; });
    if (of_group > 1) json["left_over"]["coil"] = entries[left.entry].part;
  }
  if (varying) {
    const diagnose::Wandering& w = varying->course;
    json["wandering"] = {{"what", w.of.words},
                         {"place", w.of.place},
                         {"log_evidence_gain", w.gain},
                         {"explained_share", w.explained_share},
                         {"correlation_time_s", w.correlation_time_s},
                         {"unit", w.of.unit},
                         {"p5_p95", {w.lowest, w.highest}},
                         {"variable", w.on.variable},
                         {"variable_explains", w.on.explained_share},
                         {"others", ordered_json::array()}};
    for (const auto& [other, loss] : w.others)
      json["wandering"]["others"].push_back({{"what", other.words}, {"place", other.place}, {"loss_of_log_evidence", loss}});
  } else {
    json["wandering"] = nullptr;
  }
  json["rounds"] = ordered_json::array();
  for (const auto& round : d.search.rounds) json["rounds"].push_back(round_json(d, round, d.search.core));
  json["doubts"] = ordered_json::array();
  for (const Oddities& of : inputs.oddities) json["doubts"].push_back({{"recording", of.recording}, {"lines", of.lines}});
  json["gate"] = ordered_json::array();
  for (const auto& gate : d.gate) json["gate"].push_back(gate_json(d, gate));
  json["program"] = "sinew " + sim::this_build().version;
  json["commit"] = sim::this_build().commit;
  json["seed"] = inputs.seed;
  json["files"] = given_json(inputs, hashes);
  return json;
}

std::string repaired_plant_yaml(const diagnose::Diagnosis& d, const DiagnosisInputs& inputs) {
  std::vector<std::string> names, trained;
  for (const plant::EffectId e : added_effects(d)) names.push_back(name_of(d, e));
  for (const std::string& path : inputs.training) trained.push_back(file_name(path));
  std::string text = "# Repaired by `sinew diagnose`: " + file_name(inputs.plant) + ", fitted to " + listed(trained) +
                     (names.empty() ? "; no effect was added.\n" : ", with " + listed(names) + " added.\n");
  if (!stand_ins(d).empty())
    text += "# What was added is a stand-in for something that the catalogue does not have.\n";
  else if (something_is_left(verdict_of(d.answer)) && !names.empty())
    text += "# Something is left that this does not explain: what was added is not certain.\n";
  text += "# RMSE on " + held_out_words(d) + ", open loop:\n";
  for (const plant::ChannelId c : channels_of(d).ids())
    if (d.held_out.samples[c] > 0)
      text += "#   " + channels_of(d)[c].words + ": " + report::significant(d.held_out.after[c], 3) + " " + channels_of(d)[c].unit_words +
              " (core alone " + report::significant(d.held_out.before[c], 3) + ", noise " + report::significant(d.held_out.noise[c], 2) +
              ")\n";
  text += "# 95 % intervals of what was fitted:\n";
  for (const FittedValue& one : fitted_values(d))
    text += "#   " + d.values.problem->unknowns()[one.unknown].name + ": [" + rounded(one.lowest, one.lowest, one.highest) + ", " +
            rounded(one.highest, one.lowest, one.highest) + "]\n";
  return text + sim::plant_file_text(plant::as_in_file(d.repaired));
}

std::map<std::string, std::string> prediction_files(const diagnose::Diagnosis& d) {
  const bool held_out =
      std::any_of(d.predictions.begin(), d.predictions.end(), [](const diagnose::Prediction& prediction) { return !prediction.training; });
  sim::Recording nothing;
  nothing.columns = sim::columns_of(system_of(d));
  std::map<std::string, std::string> files;
  const auto add = [&](const sim::Recording& predicted) {
    const std::string number = files.empty() ? "" : "_" + std::to_string(files.size() + 1);
    files["heldout_prediction" + number + ".csv"] = sim::to_csv(predicted);
  };
  for (const diagnose::Prediction& prediction : d.predictions) {
    if (held_out && prediction.training) continue;
    sim::Recording predicted = nothing;
    for (std::size_t k = 0; k < prediction.time_s.size(); ++k) {
      if (!held_out && !prediction.held_out[k]) continue;
      sim::Sample sample = prediction.recording->samples[k];
      for (const plant::ChannelId c : channels_of(d).ids()) diagnose::measured(sample, c) = prediction.after[c][k];
      predicted.samples.push_back(sample);
    }
    if (!predicted.samples.empty()) add(predicted);
  }
  if (files.empty()) add(nothing);
  return files;
}

std::string diagnosis_run_json(const diagnose::Diagnosis& d, const DiagnosisInputs& inputs, const InputHashes& hashes,
                               const std::map<std::string, std::string>& files) {
  const sim::Build build = sim::this_build();
  ordered_json json;
  json["program"] = "sinew " + build.version;
  json["commit"] = build.commit;
  json["compiler"] = build.compiler;
  json["libraries"] = build.libraries;
  json["command"] = "diagnose";
  json["seed"] = inputs.seed;
  const auto& settings = inputs.settings;
  if (settings.fit_until_s < 1e299) json["fit_until_s"] = settings.fit_until_s;
  if (settings.noise) json["noise"] = per_channel(d, *settings.noise);
  json["at_rest"] = settings.start == diagnose::StartPolicy::at_rest;
  json["without"] = names_of(d, settings.search.without);
  json["status"] = "finished";
  json["files"] = given_json(inputs, hashes);
  for (const auto& [name, content] : files) json["sha256"][name] = sim::sha256(content);
  return json.dump(2) + "\n";
}

}  // namespace sinew::apps

// SPDX-License-Identifier: Apache-2.0
#include "apps/diagnosis_page.h"

#include <algorithm>
#include <cmath>

#include "apps/comparison_page.h"
#include "plant/contains.h"
#include "report/number.h"
#include "sim/manifest.h"
#include "sim/plant_file.h"

namespace sinew::apps {
namespace {

using diagnose::Diagnosis;
using diagnose::Prediction;
using diagnose::Verdict;
using report::Block;
using report::Paragraph;
namespace colors = report::okabe_ito;

std::string effect_words(const Diagnosis& d, plant::EffectId effect) { return std::string(effects_of(d)[effect].words); }
std::string with_channel_unit(const plant::ChannelInfo& channel) { return channel.words + " / " + channel.unit_words; }

bool varies(const Diagnosis& d) { return std::holds_alternative<diagnose::NoConstant>(d.answer); }

report::Section section(std::string heading, int depth = 1) {
  report::Section one;
  one.heading = std::move(heading);
  one.depth = depth;
  return one;
}

void add_paragraphs(std::vector<Block>& blocks, const std::vector<std::string>& paragraphs) {
  for (const std::string& text : paragraphs) blocks.push_back(Paragraph{.text = text});
}

using report::line;

std::vector<double> difference(const std::vector<double>& model, const std::vector<double>& measured) {
  std::vector<double> residual(model.size());
  for (std::size_t k = 0; k < model.size(); ++k) residual[k] = model[k] - measured[k];
  return residual;
}

std::vector<report::Band> held_out_bands(const Prediction& prediction) {
  std::vector<report::Band> bands;
  for (std::size_t k = 0; k < prediction.not_fitted.size(); ++k) {
    if (!prediction.not_fitted[k]) continue;
    if (k == 0 || !prediction.not_fitted[k - 1])
      bands.push_back({prediction.time_s[k], prediction.time_s[k], prediction.held_out[k] ? "held out" : "not fitted"});
    bands.back().to_s = prediction.time_s[k];
  }
  return bands;
}

std::vector<report::Band> worst_bands(const diagnose::WorstTime& worst) {
  std::vector<report::Band> bands;
  for (const auto& [from, to] : worst.windows_s) bands.push_back({from, to, "worst"});
  return bands;
}

report::TimePlot time_plot(const Prediction& prediction, std::string title, std::string label, std::vector<report::Series> series,
                           std::vector<report::Band> bands, int height_px) {
  report::TimePlot plot;
  plot.title = std::move(title);
  plot.y_label = std::move(label);
  plot.time_s = prediction.time_s;
  plot.series = std::move(series);
  plot.bands = std::move(bands);
  plot.height_px = height_px;
  plot.time_axis = prediction.recording->name;
  return plot;
}

report::Series noise_band(const Prediction& prediction, double noise) {
  report::Series band = line("noise, ± 2 σ", std::vector<double>(prediction.time_s.size(), 0.0), colors::sky_blue);
  band.lower.assign(prediction.time_s.size(), -2.0 * noise);
  band.upper.assign(prediction.time_s.size(), 2.0 * noise);
  return band;
}

report::TimePlot input_plot(const Diagnosis& d, const Prediction& prediction) {
  const std::string what = input_words(system_of(d));
  return time_plot(prediction, capitalised(what), what, input_lines(system_of(d), *prediction.recording), {}, 100);
}

// --- Where
// -------------------------------------------------------------------------------------------------------------

report::Table place_table(const Diagnosis& d) {
  report::Table table;
  table.title = "Random pushes, with no effect in mind: which equation would they have to enter?";
  table.header = {"equation", "share of the pushes", "95 % interval", "pushes here alone, against the best"};
  const double best = d.located.shares.empty() ? 0.0 : d.located.shares.front().log_likelihood;
  for (const auto& share : d.located.shares) {
    report::Row row;
    row.cells = {std::string(groups_of(d)[share.group].words), report::fixed(share.share, 2),
                 "[" + report::fixed(share.lowest, 2) + ", " + report::fixed(share.highest, 2) + "]",
                 share.log_likelihood == best ? "the best" : odds_words(best - share.log_likelihood)};
    const plant::EntryGroup& group = groups_of(d)[share.group];
    row.emphasis = group.name == d.located.place || (!group.places.empty() && group.places.front() == d.located.place);
    if (row.emphasis) row.cells[0] += " (the answer's)";
    table.rows.push_back(row);
  }
  table.align = {report::Align::left, report::Align::right, report::Align::right, report::Align::left};
  table.caption =
      "Random pushes that last a few seconds were allowed into each equation of the calibrated plant, beside air that moves. Share: how "
      "much of the mismatch the pushes into this equation make, when all are allowed at once. Last column: how well pushes into this "
      "equation alone would account for everything. What is missing is seldom random: what lasts longer may enter elsewhere, and look like "
      "this. Where the answer has a name, that says the equation, not these shares.";
  return table;
}

void add_where(std::vector<Block>& blocks, const Diagnosis& d, const DiagnosisWords& words) {
  blocks.push_back(section("Where the plant and the recording part"));
  add_paragraphs(blocks, words.where);
  if (d.located.worst_recording < d.predictions.size()) {
    const Prediction& prediction = d.predictions[d.located.worst_recording];
    const plant::ChannelId c = d.located.channel;
    const auto bands = worst_bands(d.located.worst);
    blocks.push_back(time_plot(prediction, capitalised(channels_of(d)[c].words) + ": recording and calibrated plant",
                               with_channel_unit(channels_of(d)[c]),
                               {line("recording", prediction.measured[c], colors::black),
                                line("calibrated, nothing added", prediction.before[c], colors::vermillion)},
                               bands, 200));
    for (std::size_t i = 0; i < channels_of(d).size(); ++i) {
      const plant::ChannelId channel{(c.index + i) % channels_of(d).size()};
      blocks.push_back(
          time_plot(prediction, "What is left of " + channel_words(channels_of(d)[channel]),
                    "error / " + channels_of(d)[channel].unit_words,
                    {noise_band(prediction, d.located.noise[channel]),
                     line("plant − recording", difference(prediction.before[channel], prediction.measured[channel]), colors::vermillion)},
                    i == 0 ? bands : std::vector<report::Band>{}, 120));
    }
    blocks.push_back(input_plot(d, prediction));
  }
  if (!std::holds_alternative<diagnose::NothingMissing>(d.answer)) blocks.push_back(place_table(d));
}

// --- What
// --------------------------------------------------------------------------------------------------------------

const diagnose::FoundEffect* found_of(const Diagnosis& d, plant::EffectId effect) {
  const auto& effects = effects_in(d.answer);
  const auto found = std::find_if(effects.begin(), effects.end(), [&](const auto& one) { return one.effect == effect; });
  return found == effects.end() ? nullptr : &*found;
}

report::Table candidate_table(const Diagnosis& d, const diagnose::Round& round, std::size_t number) {
  report::Table table;
  table.title = number == 0 ? "Effects that were put into the plant, one at a time" : "Effects that were put in as well, one at a time";
  table.header = {"effect", "in words", "explains", "against the best", "found"};
  double best = 0.0;
  bool any = false;
  for (const auto& candidate : round.candidates)
    if (candidate.explanation.usable && (!any || candidate.explanation.log_evidence > best)) {
      best = candidate.explanation.log_evidence;
      any = true;
    }
  for (const auto& candidate : round.candidates) {
    const bool usable = candidate.explanation.usable;
    const diagnose::FoundEffect* found = varies(d) ? nullptr : found_of(d, candidate.effect);  // as a constant
    report::Row row;
    row.cells = {effect_name(d, candidate.effect), effect_words(d, candidate.effect),
                 usable ? percent(share_explained(d.search.core, candidate.explanation)) : "could not be fitted",
                 !usable                                      ? "–"
                 : candidate.explanation.log_evidence == best ? "the best"
                                                              : odds_words(best - candidate.explanation.log_evidence),
                 !found                                         ? "no"
                 : found->confidence < diagnose::doubtful_below ? "perhaps"
                                                                : "yes"};
    row.emphasis = found != nullptr;
    table.rows.push_back(row);
  }
  table.align = {report::Align::left, report::Align::left, report::Align::right, report::Align::left, report::Align::left};
  table.caption = std::string("Each was fitted together with all other parameters. Explains: how much it takes away of what ") +
                  (system_of(d).surroundings() ? "sensor noise and moving air leave" : "sensor noise leaves") +
                  " open. Effects that a first look ruled out are in the table of all effects at the end.";
  return table;
}

report::Table rival_table(const Diagnosis& d, const diagnose::FoundEffect& found) {
  report::Table table;
  table.title = "Instead of " + effect_name(d, found.effect);
  table.header = {"effect", "in words", "is"};
  for (const auto& [effect, loss] : found.rivals) {
    report::Row row;
    row.cells = {effect_name(d, effect), effect_words(d, effect), odds_words(loss)};
    row.emphasis = contains(ambiguous_in(d.answer), effect);
    table.rows.push_back(row);
  }
  table.caption = "With the other effects kept. Bold: cannot be told from it by this data.";
  return table;
}

report::ScatterPlot law_plot(const Diagnosis& d, const diagnose::FoundLaw& found) {
  const auto& variable = system_of(d).variables()[found.law.argument.front()];
  const auto [unit, scale] = law_unit(d, found.law);
  report::ScatterPlot plot;
  plot.title = "What is missing: " + plant::law_words(system_of(d), found.law);
  plot.x_label =
      variable.name + (found.law.fading_memory_s > 0.0 ? " less its slow part" : "") + (variable.unit.empty() ? "" : " / " + variable.unit);
  plot.y_label = (found.law.factor.empty() ? std::string(groups_of(d)[found.law.entry].words)
                                           : "change of the " + system_of(d).variables()[found.law.factor.front()].name) +
                 " / " + unit;
  const auto add = [&](std::string name, double deviations, report::ScatterSeries::Style style, std::string color) {
    report::ScatterSeries series;
    series.name = std::move(name);
    series.x = found.law.knots;
    for (std::size_t k = 0; k < found.values.size(); ++k) series.y.push_back(scale * (found.values[k] + deviations * found.deviation[k]));
    series.style = style;
    series.color = std::move(color);
    plot.series.push_back(std::move(series));
  };
  add("fitted", 0.0, report::ScatterSeries::Style::path, colors::vermillion);
  add("95 % band", 1.959964, report::ScatterSeries::Style::dashed, colors::orange);
  add("", -1.959964, report::ScatterSeries::Style::dashed, colors::orange);
  plot.caption =
      "Drawn over the range that the recordings have; beyond it the value at the end is held. Straight between its knots, which lie closer "
      "together where there is more data.";
  return plot;
}

report::Table proposal_table(const Diagnosis& d) {
  constexpr std::size_t most_rows = 12;
  report::Table table;
  table.title = "Plants that were compared by open-loop simulation";
  table.header = {"what was added", "against the best"};
  table.align = {report::Align::left, report::Align::left};
  const auto& all = d.proposals.all;
  for (std::size_t i = 0; i < all.size(); ++i) {
    if (i >= most_rows && !all[i].effects.empty() && i != d.proposals.answer) continue;
    std::vector<std::string> names;
    for (const plant::EffectId e : all[i].effects) names.push_back(effect_name(d, e));
    report::Row row;
    row.cells = {names.empty() ? "none" : listed(names), i == 0           ? "the best"
                                                         : !all[i].counts ? "has a law; none paid"
                                                                          : odds_words(all.front().log_odds - all[i].log_odds)};
    row.emphasis = i == d.proposals.answer;
    table.rows.push_back(row);
  }
  table.caption =
      "Each with all parameters fitted, begun from several values. Bold: the answer, which is chosen by how well it predicts what was left "
      "out of the fit.";
  return table;
}

report::Table bent_table(const Diagnosis& d) {
  constexpr std::size_t most_rows = 12;
  report::Table table;
  table.title = "Names and curves that were compared";
  table.header = {"names", "curves", "against the best"};
  table.align = {report::Align::left, report::Align::left, report::Align::left};
  for (std::size_t i = 0; i < std::min(most_rows, d.search.bent.size()); ++i) {
    const diagnose::Bent& one = d.search.bent[i];
    const plant::System& system = one.explanation.system();
    std::vector<std::string> names, curves;
    for (const plant::EffectId e : one.names) names.push_back(effect_name(d, e));
    for (const plant::EffectId e : one.explanation.effects())
      if (system.effects()[e].law) curves.push_back(plant::law_words(system, system.laws()[*system.effects()[e].law]));
    report::Row row;
    row.cells = {names.empty() ? "none" : listed(names), listed(curves),
                 i == 0 ? "the best" : odds_words(d.search.bent.front().log_odds - one.log_odds)};
    row.emphasis = i == 0 && !laws_in(d.answer).empty();
    table.rows.push_back(row);
  }
  table.caption = laws_in(d.answer).empty()
                      ? "Where the catalogue's own forms leave something, a curve is tried beside them. None of these was kept: "
                        "they leave too much, or predict held-out data no better."
                      : "Where the catalogue's own forms leave something, a curve is tried beside them. Bold: the answer.";
  return table;
}

void add_what(std::vector<Block>& blocks, const Diagnosis& d, const DiagnosisWords& words) {
  blocks.push_back(section(std::holds_alternative<diagnose::NothingMissing>(d.answer) ? "What was looked for" : "What is missing"));
  add_paragraphs(blocks, words.what);
  for (const diagnose::FoundLaw& law : laws_in(d.answer)) blocks.push_back(law_plot(d, law));
  if (d.by_paths)
    blocks.push_back(proposal_table(d));
  else if (!d.search.bent.empty())
    blocks.push_back(bent_table(d));
  for (std::size_t r = 0; r < d.search.rounds.size(); ++r)
    if (!d.search.rounds[r].candidates.empty() && (r == 0 || d.search.rounds[r].accepted))
      blocks.push_back(candidate_table(d, d.search.rounds[r], r));
  if (effects_in(d.answer).size() > 1)
    for (const auto& found : effects_in(d.answer))
      if (!found.rivals.empty()) blocks.push_back(rival_table(d, found));
}

// --- Modelled
// ----------------------------------------------------------------------------------------------------------

report::Table parameter_table(const Diagnosis& d) {
  report::Table table;
  table.title = "Parameters of the repaired plant";
  table.header = {"parameter", "meaning", "believed before", "fitted", "95 % interval"};
  const auto& unknowns = d.values.problem->unknowns();
  const std::vector<plant::EffectId> added = added_effects(d);
  std::vector<report::Row> core;
  for (const auto& [parameter, u, value, low, high] : fitted_values(d)) {
    const auto& unknown = unknowns[u];
    const auto& info = parameters_of(d)[parameter];
    const double unit = unknown.internal_per_unit;
    const bool new_here = info.effect && contains(added, *info.effect);
    report::Row row;
    row.cells = {info.key(), std::string(info.declaration.meaning),
                 rounded(unknown.centre / unit, (unknown.centre - unknown.deviation) / unit, (unknown.centre + unknown.deviation) / unit) +
                     " ± " + report::significant(unknown.deviation / unit, 2),
                 with_unit(rounded(value, low, high), info.declaration.unit.text),
                 "[" + rounded(low, low, high) + ", " + rounded(high, low, high) + "]"};
    row.emphasis = new_here;
    const double moved = unknown.coordinate_of(d.values.value(u));
    if (!new_here && std::abs(moved) > 2.0)
      row.note = report::significant(std::abs(moved), 2) + " standard deviations from what was believed before";
    else if (d.values.deviation(u) > 0.7 * unknown.slope_at(moved))
      row.note = "the data says little about it: mostly what was believed before";
    (new_here ? table.rows : core).push_back(row);
  }
  for (const plant::EffectId e : added)
    for (const plant::ParameterId p : effects_of(d)[e].parameters) {
      if (is_weight(system_of(d), p)) continue;
      const auto& info = parameters_of(d)[p];
      const bool fitted = std::any_of(unknowns.begin(), unknowns.end(), [&](const auto& unknown) { return unknown.parameter == p; });
      if (fitted) continue;
      report::Row row;
      row.cells = {info.key(), std::string(info.declaration.meaning), "–",
                   with_unit(sim::parameter_text(d.repaired, p), info.declaration.unit.text), "assumed, not fitted"};
      row.emphasis = true;
      table.rows.push_back(row);
    }
  table.rows.insert(table.rows.end(), core.begin(), core.end());
  table.align = {report::Align::left, report::Align::left, report::Align::right, report::Align::right, report::Align::right};
  table.caption =
      "Believed before: the given plant's value (for an added effect: a typical one), and one standard deviation. "
      "Bold: what was added.";
  return table;
}

report::Table first_value_table(const Diagnosis& d) {
  report::Table table;
  table.title = "How the recordings begin";
  table.header = {"recording", "state", "at rest", "fitted", "95 % interval"};
  std::string last;
  for (const FirstValue& one : first_values(d)) {
    report::Row row;
    row.cells = {one.recording == last ? "" : file_name(one.recording), one.state, with_unit(report::significant(one.at_rest, 3), one.unit),
                 with_unit(rounded(one.value, one.lowest, one.highest), one.unit),
                 "[" + rounded(one.lowest, one.lowest, one.highest) + ", " + rounded(one.highest, one.lowest, one.highest) + "]"};
    row.emphasis = one.matters;
    if (!one.told) row.note = "the data says little about it: mostly what was believed before";
    last = one.recording;
    table.rows.push_back(std::move(row));
  }
  table.align = {report::Align::left, report::Align::left, report::Align::right, report::Align::right, report::Align::right};
  table.caption = "A recording may begin in mid-motion; what " + std::string(system_of(d).words()) +
                  " was doing then is estimated with the parameters. Bold: of "
                  "what was added, and not at rest.";
  return table;
}

void add_modelled(std::vector<Block>& blocks, const Diagnosis& d, const DiagnosisWords& words) {
  blocks.push_back(section(added_effects(d).empty() ? "The plant, fitted" : "The plant, repaired"));
  add_paragraphs(blocks, words.modelled);
  for (const plant::EffectId e : added_effects(d)) {
    report::Code code;
    code.caption = effect_name(d, e) + ": " + effect_words(d, e);
    code.text = std::string(effects_of(d)[e].equation);
    for (const diagnose::FoundApart& found : apart_in(d.answer))
      if (found.effect == e)
        for (const auto& [name, values] : apart_quantities(d, found)) code.text += (code.text.empty() ? "" : "\n") + name + " = " + values;
    for (const plant::ParameterId p : effects_of(d)[e].parameters) {
      if (is_weight(system_of(d), p)) continue;
      const auto& declared = parameters_of(d)[p].declaration;
      code.text += "\n    " + std::string(declared.symbol.empty() ? declared.name : declared.symbol) + " = " +
                   with_unit(report::significant(d.repaired.get_in_file_units(p), 4), declared.unit.text) + "   " +
                   std::string(declared.meaning) + " (" + std::string(declared.name) + ")";
    }
    blocks.push_back(code);
  }
  blocks.push_back(parameter_table(d));
  if (report::Table begins = first_value_table(d); !begins.rows.empty()) blocks.push_back(std::move(begins));
}

// --- Better
// ------------------------------------------------------------------------------------------------------------

report::Table error_table(const Diagnosis& d) {
  const bool repaired = !added_effects(d).empty();
  const auto& held = d.held_out;
  report::Table table;
  table.title = "Error on held-out data (RMSE)";
  table.header = {"channel", "samples", "as given", "calibrated"};
  if (repaired)
    table.header.insert(table.header.end(), {"as `calibrate` weighs", "repaired", "noise alone", "less error by [95 % interval]"});
  else
    table.header.push_back("noise alone");
  for (const plant::ChannelId c : channels_of(d).ids()) {
    if (held.samples[c] == 0) continue;
    report::Row row;
    row.cells = {with_channel_unit(channels_of(d)[c]), std::to_string(held.samples[c]), report::significant(held.nominal[c], 3),
                 report::significant(repaired ? held.fitted[c] : held.before[c], 3)};
    if (repaired) {
      row.cells.push_back(std::isfinite(held.calibrated[c]) ? report::significant(held.calibrated[c], 3) : "–");
      row.cells.push_back(report::significant(held.after[c], 3));
      row.cells.push_back(report::significant(held.noise[c], 2));
      row.cells.push_back(percent_interval(held.gain[c], held.gain_lowest[c], held.gain_highest[c]));
      if (!(held.gain_lowest[c] > 0.0) && std::abs(held.gain[c]) > 0.01)
        row.note = "whether this channel is predicted better cannot be told from chance";
    } else {
      row.cells.push_back(report::significant(held.noise[c], 2));
    }
    table.rows.push_back(row);
  }
  table.align.assign(table.header.size(), report::Align::right);
  table.align[0] = report::Align::left;
  table.caption =
      "Open loop: the plant is given the recorded inputs and nothing else. As given: the plant file. Calibrated: its "
      "parameters fitted, nothing added" +
      std::string(repaired
                      ? ", with the channels weighed by the diagnosis and as `sinew calibrate` does. Repaired: with what was added. Less "
                        "error: than the better of both, channel by channel."
                      : ".");
  return table;
}

constexpr std::size_t most_recordings = 3;  // that are drawn
constexpr std::size_t most_sliders = 4;

// What was added, with the slider that takes it away: the recordings that are drawn, with its strength at half, and at none.
struct Strength {
  std::string slider;
  std::vector<diagnose::Series> half_way, none;
};

bool is_followed(const diagnose::Series& series) {
  return !series.empty() && std::all_of(series.begin(), series.end(), [](const std::vector<double>& values) {
    return std::all_of(values.begin(), values.end(), [](double value) { return std::isfinite(value); });
  });
}

std::vector<Strength> strengths_of(const Diagnosis& d, const std::vector<std::size_t>& drawn) {
  std::vector<plant::EffectId> added;
  for (const auto& found : effects_in(d.answer))
    if (d.repaired.is_on(found.effect)) added.push_back(found.effect);
  for (const auto& found : laws_in(d.answer)) added.push_back(found.effect);
  std::vector<Strength> result;
  for (const plant::EffectId e : added) {
    if (result.size() == most_sliders) break;
    Strength one{.slider = capitalised(effect_words(d, e)), .half_way = {}, .none = {}};
    for (const std::size_t p : drawn) {
      one.half_way.push_back(diagnose::predicted_at_share(d, p, e, 0.5));
      one.none.push_back(diagnose::predicted_at_share(d, p, e, 0.0));
    }
    if (std::all_of(one.half_way.begin(), one.half_way.end(), is_followed) && std::all_of(one.none.begin(), one.none.end(), is_followed))
      result.push_back(std::move(one));
  }
  return result;
}

void add_prediction(std::vector<Block>& blocks, const Diagnosis& d, const Prediction& prediction, bool repaired,
                    const std::vector<Strength>& strengths, std::size_t drawn) {
  const auto moves = [&](plant::ChannelId c, const std::vector<double>* measured) {
    std::vector<report::Move> result;
    const auto shown = [&](const diagnose::Series& series) { return measured ? difference(series[c], *measured) : series[c]; };
    for (const Strength& one : strengths) result.push_back({one.slider, shown(one.half_way[drawn]), shown(one.none[drawn])});
    return result;
  };
  const auto bands = held_out_bands(prediction);
  for (const plant::ChannelId c : in_reading_order(system_of(d))) {
    std::vector<report::Series> series{line("recording", prediction.measured[c], colors::black)};
    if (repaired) {
      series.push_back(line("before (calibrated)", prediction.before[c], colors::vermillion));
      series.push_back(line("after (repaired)", prediction.after[c], colors::green));
      series.back().moves = moves(c, nullptr);
    } else {
      series.push_back(line("calibrated", prediction.after[c], colors::green));
    }
    blocks.push_back(
        time_plot(prediction, capitalised(channels_of(d)[c].words), with_channel_unit(channels_of(d)[c]), std::move(series), bands, 180));
    std::vector<report::Series> left{noise_band(prediction, d.located.noise[c])};
    if (repaired) left.push_back(line("before − recording", difference(prediction.before[c], prediction.measured[c]), colors::vermillion));
    left.push_back(line(repaired ? "after − recording" : "calibrated − recording", difference(prediction.after[c], prediction.measured[c]),
                        colors::green));
    if (repaired) left.back().moves = moves(c, &prediction.measured[c]);
    blocks.push_back(time_plot(prediction, "What is left of " + channel_words(channels_of(d)[c]), "error / " + channels_of(d)[c].unit_words,
                               std::move(left), bands, 110));
  }
  blocks.push_back(input_plot(d, prediction));
}

report::ScatterPlot correlation_plot(const Diagnosis& d, plant::ChannelId c, bool repaired) {
  report::ScatterPlot plot;
  plot.title = capitalised(channels_of(d)[c].words);
  plot.x_label = "time between two errors / s";
  plot.y_label = "correlation";
  plot.height_px = 220;
  const auto add = [&](std::string name, const std::vector<double>& correlation, std::string color) {
    report::ScatterSeries series;
    series.name = std::move(name);
    for (std::size_t lag = 0; lag < correlation.size(); ++lag) series.x.push_back(diagnose::correlation_lag_s * static_cast<double>(lag));
    series.y = correlation;
    series.color = std::move(color);
    series.style = report::ScatterSeries::Style::path;
    plot.series.push_back(std::move(series));
  };
  if (repaired) add("before", d.correlation.before[c], colors::vermillion);
  add(repaired ? "after" : "calibrated", d.correlation.after[c], colors::green);
  report::ScatterSeries noise;
  noise.name = "pure noise";
  noise.x = {0.0, diagnose::correlation_lag_s, diagnose::correlation_lag_s * static_cast<double>(d.correlation.after[c].size() - 1)};
  noise.y = {1.0, 0.0, 0.0};
  noise.style = report::ScatterSeries::Style::dashed;
  noise.color = colors::sky_blue;
  plot.series.push_back(std::move(noise));
  return plot;
}

void add_better(std::vector<Block>& blocks, const Diagnosis& d, const DiagnosisWords& words) {
  const bool repaired = !added_effects(d).empty();
  blocks.push_back(section(repaired ? "How much better it predicts" : "How well it predicts"));
  std::vector<std::string> lines, rest;
  for (const std::string& text : words.better)
    (text.starts_with("– ") ? lines : rest).push_back(text.starts_with("– ") ? text.substr(std::string("– ").size()) : text);
  if (!rest.empty()) blocks.push_back(Paragraph{.text = rest.front()});
  if (!lines.empty()) {
    blocks.push_back(report::List{.items = lines});
    for (std::size_t i = 1; i < rest.size(); ++i) blocks.push_back(Paragraph{.text = rest[i]});
    blocks.push_back(error_table(d));
  }
  const bool held_out = std::any_of(d.predictions.begin(), d.predictions.end(), [](const auto& p) { return !p.training; });
  std::vector<std::size_t> shown;
  for (std::size_t p = 0; p < d.predictions.size(); ++p)
    if (d.predictions[p].training != held_out && shown.size() < most_recordings) shown.push_back(p);
  const std::vector<Strength> strengths = repaired ? strengths_of(d, shown) : std::vector<Strength>{};
  if (!strengths.empty()) {
    report::Sliders group{
        .heading = "What each part of the answer does",
        .text =
            "Move a slider to take away some of what was added: the curves called after follow, and what is left with them. None, half "
            "and as fitted are simulated. In between a parabola runs through the three, and with several sliders moved what each does "
            "is added: a picture, not a simulation. All other parameters stay as they were fitted, so that none is not the curve called "
            "before: that plant was fitted anew without it."};
    for (const Strength& one : strengths) group.sliders.push_back({.name = one.slider, .low_words = "none", .high_words = "as fitted"});
    blocks.push_back(std::move(group));
  }
  for (std::size_t i = 0; i < shown.size(); ++i) {
    const Prediction& prediction = d.predictions[shown[i]];
    report::Section part = section(file_name(prediction.recording->name), i == 0 ? 2 : 3);
    part.text = prediction.training ? "The plants saw this recording in part: what is shaded was held out."
                                    : "The plants never saw this recording; how it begins was found from its first five seconds.";
    blocks.push_back(part);
    add_prediction(blocks, d, prediction, repaired, strengths, i);
  }
  if (lines.empty()) return;
  report::Section alike = section("Is what is left pure noise?", 2);
  alike.text =
      "Errors of pure noise know nothing of each other: the curve falls to zero at once. A curve that stays up means "
      "that "
      "something lasting is missing, or that the air moves.";
  blocks.push_back(alike);
  for (const plant::ChannelId c : in_reading_order(system_of(d)))
    if (d.held_out.samples[c] > 0 && !d.correlation.after[c].empty()) blocks.push_back(correlation_plot(d, c, repaired));
}

// --- What next
// ---------------------------------------------------------------------------------------------------------

void add_bins(report::ScatterPlot& plot, const diagnose::Dependence& on, double scale) {
  const auto add = [&](std::string name, double deviations, report::ScatterSeries::Style style, std::string color) {
    report::ScatterSeries series;
    series.name = std::move(name);
    series.x = on.centre;
    for (std::size_t b = 0; b < on.mean.size(); ++b) series.y.push_back(scale * (on.mean[b] + deviations * on.deviation[b]));
    series.style = style;
    series.color = std::move(color);
    plot.series.push_back(std::move(series));
  };
  add("mean", 0.0, report::ScatterSeries::Style::path, colors::vermillion);
  add("one deviation more", 1.0, report::ScatterSeries::Style::dashed, colors::orange);
  add("one deviation less", -1.0, report::ScatterSeries::Style::dashed, colors::orange);
}

// The course of what varies in the first recording, and as a function of what.
void add_course(std::vector<Block>& blocks, const Diagnosis& d, const diagnose::NoConstant& of) {
  const diagnose::Wandering& w = of.course;
  const bool relative = w.of.unit == "%";
  const std::string label = (relative ? "change of " : "") + w.of.words + (w.of.unit.empty() ? "" : " / " + unit_words(w.of.unit));
  report::TimePlot course;
  course.title =
      "What changes, over time" +
      (d.predictions.size() > 1 && d.predictions[1].training ? ", in " + file_name(d.predictions.front().recording->name) : std::string());
  course.y_label = label;
  course.time_axis = d.predictions.front().recording->name;
  report::Series series = line("", {}, colors::vermillion);
  series.name = "estimate, with its 95 % interval";
  for (std::size_t i = 0; i < w.time_s.size() && w.recording[i] == 0; ++i) {
    const double half = 1.959964 * w.deviation[i];
    course.time_s.push_back(w.time_s[i]);
    series.y.push_back(w.value[i]);
    series.lower.push_back(w.value[i] - half);
    series.upper.push_back(w.value[i] + half);
  }
  course.series.push_back(std::move(series));
  course.caption =
      "What this would be at each moment, estimated from the whole recording: not something that a simulation could "
      "know beforehand. What it cannot carry, slow pushes on the single equations do.";
  blocks.push_back(course);
  if (w.on.variable.empty()) return;
  report::ScatterPlot plot;
  plot.title = "The same, against " + w.on.variable;
  plot.x_label = w.on.variable + (w.on.unit.empty() ? "" : " / " + w.on.unit);
  plot.y_label = label;
  add_bins(plot, w.on, 1.0);
  plot.caption = "The mean in eight parts of the recording sorted by this quantity. It accounts for " + percent(w.on.explained_share) +
                 " of the course (judged on times from which the curve was not made).";
  blocks.push_back(plot);
}

report::ScatterPlot left_over_plot(const Diagnosis& d, const diagnose::LeftOver& left) {
  const auto& forcing = groups_of(d)[left.group];
  const bool angle = forcing.unit == "rad";
  const double scale = angle ? 1.0 / plant::radians_per_degree : 1.0;
  report::ScatterPlot plot;
  plot.title = "What is missing, against " + left.variable;
  plot.x_label = left.variable + (left.unit.empty() ? "" : " / " + left.unit);
  plot.y_label =
      "missing in " + std::string(forcing.words) + " / " + (angle ? "°" : unit_words(forcing.unit == "Nm" ? "N*m" : forcing.unit));
  add_bins(plot, left, scale);
  plot.caption =
      "What would have to be added to the equation, on average, in eight parts of the recording sorted by this "
      "quantity. It accounts for " +
      percent(left.explained_share) + " of what is missing there (judged on times from which the curve was not made).";
  return plot;
}

// --- Details
// -----------------------------------------------------------------------------------------------------------

report::Table gate_table(const Diagnosis& d) {
  report::Table table;
  table.header = {"recording", "channel", "rows", "readings", "one every [s]", "noise", "smallest step", "outliers"};
  for (const auto& gate : d.gate)
    for (const plant::ChannelId c : channels_of(d).ids()) {
      report::Row row;
      row.cells = {c.index == 0 ? file_name(gate.recording) : "",
                   with_channel_unit(channels_of(d)[c]),
                   std::to_string(gate.samples),
                   std::to_string(gate.samples - gate.missing[c]),
                   report::significant(gate.reading_period_s[c], 2),
                   report::significant(gate.noise[c], 2),
                   report::significant(gate.step[c], 2),
                   std::to_string(gate.outliers[c])};
      if (c.index + 1 == channels_of(d).size()) {
        row.note =
            report::fixed(gate.duration_s, 0) + " s, " + input_words(system_of(d)) + " up to " + report::fixed(gate.largest_input, 2);
        if (const auto first_s = d.gate.front().begins_s; first_s && gate.begins_s && *gate.begins_s != *first_s)
          row.note += ", begins " + report::fixed(std::abs(*gate.begins_s - *first_s), 0) + " s " +
                      (*gate.begins_s > *first_s ? "after" : "before") + " the first";
        for (const std::string& warning : gate.warnings) row.note += ". " + capitalised(warning);
      }
      table.rows.push_back(row);
    }
  table.align.assign(table.header.size(), report::Align::right);
  table.align[0] = table.align[1] = report::Align::left;
  table.caption =
      "Noise: standard deviation of the sensor. Outliers: single samples far from their neighbours; they were passed "
      "over.";
  return table;
}

report::Table effect_table(const Diagnosis& d) {
  report::Table table;
  table.header = {"effect", "in words", "enters in", "answer", "would have been seen from", "a usual size"};
  const std::vector<diagnose::Visibility> others = not_found(d);
  const std::vector<plant::EffectId> substitutes = stand_ins(d), before = d.search.core.effects();
  for (const plant::EffectId e : effects_of(d).ids()) {
    if (!effects_of(d)[e].is_of_catalogue()) continue;
    const auto& info = effects_of(d)[e];
    const auto& strength = parameters_of(d)[info.strength].declaration;
    const bool toggle = strength.kind == plant::Kind::toggle;
    const std::string symbol = std::string(strength.symbol.empty() ? strength.name : strength.symbol) + " = ";
    // Sizes count from the null, which is 0 for all but shares.
    const auto size = [&](double from_null) {
      const double null = *strength.null_value;
      return symbol + with_unit(report::significant(null == 0.0 ? from_null : null - from_null, 2), strength.unit.text);
    };
    report::Row row;
    std::string answer = "not tried", seen = "–";
    const auto other = std::find_if(others.begin(), others.end(), [&](const auto& v) { return v.effect == e; });
    if (const diagnose::FoundEffect* found = found_of(d, e)) {
      answer = varies(d) ? "perhaps, but not constant" : found->confidence < diagnose::doubtful_below ? "perhaps" : "found";
      row.emphasis = true;
    } else if (contains(substitutes, e)) {
      answer = "stands in for what is missing";
    } else if (contains(before, e)) {
      answer = "was in the given plant";
    } else if (contains(ambiguous_in(d.answer), e)) {
      answer = "cannot be told from what was found";
      row.emphasis = true;
    } else if (other != others.end()) {
      answer = other->can_be_seen    ? "not found"
               : is_imitated(*other) ? "a little cannot be seen: imitated by fitting the others"
                                     : "cannot be seen: too faint here";
      if (other->can_be_seen && !toggle) seen = size(other->smallest_seen);
    }
    row.cells = {std::string(info.name),
                 std::string(info.words),
                 place_words(system_of(d), info.place),
                 answer,
                 seen,
                 toggle ? "there or not" : size(std::abs(strength.typical - *strength.null_value))};
    table.rows.push_back(row);
  }
  table.align.assign(table.header.size(), report::Align::left);
  table.caption =
      "Too faint here: an effect of usual size would not be seen in this data, beside its noise and whatever is still "
      "unexplained.";
  return table;
}

}  // namespace

report::Page diagnosis_page(const Diagnosis& d, const DiagnosisInputs& inputs) {
  const DiagnosisWords words = diagnosis_words(d, inputs);
  report::Page page;
  std::vector<std::string> names;
  for (const std::string& path : inputs.training) names.push_back(file_name(path));
  page.title = "Diagnosis of " + listed(names);
  page.lead = words.verdict;
  auto& blocks = page.blocks;
  blocks.push_back(
      Paragraph{.text = "A simulation (" + file_name(inputs.plant) + ") was fitted to recordings of " + std::string(system_of(d).words()) +
                        ". Where the fit fails, the simulation lacks "
                        "some physics. This report says where it fails, which effect is missing, if any, how large that is, how "
                        "well the repaired simulation predicts data that it has not seen, and what could be done next."});
  if (!words.summary.empty())
    blocks.push_back(Paragraph{.text = words.summary,
                               .tone = something_is_left(verdict_of(d.answer)) ? Paragraph::Tone::caution : Paragraph::Tone::finding});
  add_where(blocks, d, words);
  add_what(blocks, d, words);
  add_modelled(blocks, d, words);
  add_better(blocks, d, words);
  blocks.push_back(section("What next"));
  add_paragraphs(blocks, words.next);
  if (const auto* varying = std::get_if<diagnose::NoConstant>(&d.answer))
    add_course(blocks, d, *varying);
  else if (!d.left_over.variable.empty())
    blocks.push_back(left_over_plot(d, d.left_over));

  report::Section data = section("The data");
  data.text = "What was seen of the recordings before any plant was fitted.";
  blocks.push_back(data);
  for (const Oddities& of : inputs.oddities) {
    blocks.push_back(section("What is odd about " + file_name(of.recording), 2));
    blocks.push_back(report::List{.items = of.lines});
  }
  blocks.push_back(gate_table(d));
  report::Section all = section("All effects of the catalogue");
  all.text =
      "An effect that is not found is either not there, or smaller than what this data could have shown, or of a kind "
      "that this "
      "data cannot show at all.";
  blocks.push_back(all);
  blocks.push_back(effect_table(d));

  for (const std::string& path : inputs.training) page.footer.push_back("fitted: " + path);
  for (const std::string& path : inputs.held_out) page.footer.push_back("held out: " + path);
  for (const std::string& one : inputs.ignored) page.footer.push_back("not to be trusted, as given: " + one);
  page.footer.push_back("nominal plant: " + inputs.plant);
  page.footer.push_back("seed " + std::to_string(inputs.seed) + "; sinew " + sim::this_build().version + " (" + sim::this_build().commit +
                        ")");
  return page;
}

}  // namespace sinew::apps

// SPDX-License-Identifier: Apache-2.0
#include "apps/comparison_page.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <sstream>

#include "apps/diagnosis_text.h"
#include "diagnose/columns.h"
#include "diagnose/suitability.h"
#include "plant/contains.h"
#include "report/number.h"
#include "sim/input_error.h"
#include "sim/log_map.h"
#include "sim/text.h"

namespace sinew::apps {
namespace {

using plant::ChannelId;

constexpr std::string_view time_axis = "recording";

std::vector<double> measured_series(const sim::Recording& recording, ChannelId channel) {
  std::vector<double> values;
  for (const auto& sample : recording.samples) values.push_back(diagnose::measured(sample, channel));
  return values;
}

std::vector<report::Band> bands(const diagnose::Comparison& comparison) {
  if (comparison.fit_until_s > comparison.time_s.back()) return {};
  return {{comparison.fit_until_s, comparison.time_s.back(), "not fitted"}};
}

std::string with_unit(const plant::ChannelInfo& channel) {
  return channel.unit_words.empty() ? channel.words : channel.words + " / " + channel.unit_words;
}

report::TimePlot time_plot(const diagnose::Comparison& comparison, std::string title, std::string label,
                           std::vector<report::Series> series) {
  report::TimePlot plot;
  plot.title = std::move(title);
  plot.y_label = std::move(label);
  plot.time_s = comparison.time_s;
  plot.series = std::move(series);
  plot.bands = bands(comparison);
  plot.time_axis = time_axis;
  return plot;
}

using report::line;

report::TimePlot channel_plot(const diagnose::Comparison& comparison, const sim::Recording& recording, ChannelId c) {
  const plant::ChannelInfo& channel = comparison.system->channels()[c];
  return time_plot(comparison, capitalised(channel.words), with_unit(channel),
                   {line("recording", measured_series(recording, c), report::okabe_ito::black),
                    line("model", comparison.model[c], report::okabe_ito::vermillion)});
}

report::TimePlot residual_plot(const diagnose::Comparison& comparison, ChannelId c, std::string color) {
  const double noise = comparison.noise[c];
  report::Series residual = line("model − recording", comparison.residual[c], std::move(color));
  report::Series band = line("noise, ± 2 σ", std::vector<double>(comparison.time_s.size(), 0.0), report::okabe_ito::sky_blue);
  band.lower.assign(comparison.time_s.size(), -2.0 * noise);
  band.upper.assign(comparison.time_s.size(), 2.0 * noise);
  const plant::ChannelInfo& channel = comparison.system->channels()[c];
  report::TimePlot plot =
      time_plot(comparison, "Residual of " + channel.words, "model − recording / " + channel.unit_words, {band, residual});
  plot.height_px = 130;
  return plot;
}

report::TimePlot input_plot(const diagnose::Comparison& comparison, const sim::Recording& recording) {
  const std::string what = input_words(*comparison.system);
  report::TimePlot plot = time_plot(comparison, capitalised(what), what, input_lines(*comparison.system, recording));
  plot.height_px = 110;
  return plot;
}

report::ScatterPlot scatter(const diagnose::Comparison& comparison, std::string title, std::string x, std::string y,
                            std::vector<report::ScatterSeries> series) {
  report::ScatterPlot plot;
  plot.title = std::move(title);
  plot.x_label = std::move(x);
  plot.y_label = std::move(y);
  plot.series = std::move(series);
  for (auto& one : plot.series) one.time_s = comparison.time_s;
  plot.time_axis = time_axis;
  return plot;
}

report::ScatterSeries points(std::string name, std::vector<double> x, std::vector<double> y, std::string color,
                             report::ScatterSeries::Style style = report::ScatterSeries::Style::points) {
  report::ScatterSeries series;
  series.name = std::move(name);
  series.x = std::move(x);
  series.y = std::move(y);
  series.color = std::move(color);
  series.style = style;
  return series;
}

}  // namespace

report::Table error_table(const diagnose::Comparison& comparison) {
  const bool held = comparison.fit_until_s <= comparison.time_s.back();
  report::Table table;
  table.header = {"channel", "samples", "noise", "RMSE", "bias", "largest", "more than noise"};
  const auto add = [&](ChannelId c, const std::string& part, const diagnose::ChannelError& error) {
    report::Row row;
    row.cells = {with_unit(comparison.system->channels()[c]) + part,
                 std::to_string(error.samples),
                 report::significant(comparison.noise[c], 2),
                 report::significant(error.rmse, 3),
                 report::significant(error.bias, 2),
                 report::significant(error.largest, 3),
                 std::isnan(error.rmse) ? "–" : report::fixed(100.0 * error.more_than_noise, 1) + " %"};
    table.rows.push_back(row);
  };
  for (const ChannelId c : comparison.system->channels().ids()) add(c, held ? ", fitted" : "", comparison.fitted[c]);
  if (held)
    for (const ChannelId c : comparison.system->channels().ids()) add(c, ", not fitted", comparison.unfitted[c]);
  table.align.assign(table.header.size(), report::Align::right);
  table.align[0] = report::Align::left;
  table.caption =
      "RMSE of model − recording, open loop. Noise is what the sensor alone does; the last column is the share of the "
      "mean square that noise does not explain.";
  return table;
}

nlohmann::ordered_json channels_json(const diagnose::Comparison& comparison) {
  const auto json_of = [](const diagnose::ChannelError& error) {
    nlohmann::ordered_json json{{"samples", error.samples}};
    if (error.samples > 0) {
      json["rmse"] = error.rmse;
      json["bias"] = error.bias;
      json["largest"] = error.largest;
      json["more_than_noise"] = error.more_than_noise;
    }
    return json;
  };
  nlohmann::ordered_json json;
  for (const ChannelId c : comparison.system->channels().ids())
    json[comparison.system->channels()[c].column] = {{"noise", comparison.noise[c]},
                                                     {"fitted", json_of(comparison.fitted[c])},
                                                     {"not_fitted", json_of(comparison.unfitted[c])}};
  return json;
}

std::vector<std::string> findings(const diagnose::Comparison& comparison) {
  std::vector<std::string> lines;
  for (const ChannelId c : comparison.system->channels().ids()) {
    if (comparison.fitted[c].samples + comparison.unfitted[c].samples == 0) continue;
    const std::string& unit = comparison.system->channels()[c].unit_words;
    const diagnose::ChannelError& error = comparison.fitted[c].samples ? comparison.fitted[c] : comparison.unfitted[c];
    std::string text = "The " + comparison.system->channels()[c].words + " is " + report::significant(error.rmse, 3) + " " + unit +
                       " off (noise: " + report::significant(comparison.noise[c], 2) + " " + unit + ")";
    if (comparison.fitted[c].samples && comparison.unfitted[c].samples)
      text += " where it was fitted and " + report::significant(comparison.unfitted[c].rmse, 3) + " " + unit + " where it was not";
    const auto& worst = comparison.worst[c];
    if (error.more_than_noise > 0.2)
      text += "; " + report::fixed(100.0 * worst.share_of_error, 0) + " % of the squared error happens in " +
              report::fixed(100.0 * worst.share_of_time, 0) + " % of the time: " + windows_words(worst);
    else
      text += ", little or nothing more than noise";
    lines.push_back(text + ".");
  }
  return lines;
}

std::string colour(std::size_t i) {
  const std::array all{report::okabe_ito::blue, report::okabe_ito::orange, report::okabe_ito::green, report::okabe_ito::vermillion,
                       report::okabe_ito::sky_blue};
  return std::string(all[i % all.size()]);
}

std::vector<ChannelId> in_reading_order(const plant::System& system) {
  std::vector<ChannelId> order;
  for (const bool upstream : {false, true})
    for (const ChannelId c : system.channels().ids())
      if ((system.channels()[c].kind == system.upstream_kind()) == upstream) order.push_back(c);
  return order;
}

std::vector<report::Series> input_lines(const plant::System& system, const sim::Recording& recording) {
  std::vector<report::Series> series;
  for (const plant::InputId i : system.inputs().ids()) {
    std::vector<double> values;
    for (const auto& sample : recording.samples) values.push_back(sample.inputs[i.index]);
    series.push_back(line(system.inputs()[i].part, values, colour(i.index),
                          system.inputs()[i].between == plant::Between::held ? report::Series::Style::steps : report::Series::Style::line));
  }
  return series;
}

std::vector<report::Block> comparison_blocks(const diagnose::Comparison& comparison, const sim::Recording& recording) {
  using report::okabe_ito::blue, report::okabe_ito::orange, report::okabe_ito::green;
  std::vector<report::Block> blocks;
  report::Section over_time;
  over_time.heading = "Over time";
  over_time.text = "Open loop: the model is given the recorded " + input_words(*comparison.system) + " and nothing else.";
  blocks.push_back(over_time);
  const plant::System& system = *comparison.system;
  const auto& channels = system.channels();
  const std::vector<ChannelId> order = in_reading_order(system);
  for (const ChannelId c : order) {
    blocks.push_back(channel_plot(comparison, recording, c));
    blocks.push_back(residual_plot(comparison, c, colour(c.index)));
  }
  blocks.push_back(input_plot(comparison, recording));

  report::Section against;
  against.heading = "Where the residual is";
  against.text = "A cloud around zero is noise. A cloud with a shape is something that the model lacks, or has wrong, at that value.";
  blocks.push_back(against);
  const auto name_in_legend = [&](ChannelId c) { return channels[c].part.empty() ? channels[c].words : channels[c].part; };
  std::vector<std::string> kinds;
  for (const auto& channel : channels)
    if (!contains(kinds, channel.kind)) kinds.push_back(channel.kind);
  for (const std::string& kind : kinds) {
    std::vector<report::ScatterSeries> series;
    std::string unit;
    for (const ChannelId c : channels.ids())
      if (channels[c].kind == kind) {
        series.push_back(points(name_in_legend(c), measured_series(recording, c), comparison.residual[c], colour(c.index)));
        unit = channels[c].unit_words;
      }
    blocks.push_back(scatter(comparison, "Residual of the " + kind + (series.size() > 1 ? "s" : "") + " against " + kind,
                             "measured " + kind + " / " + unit, "model − recording / " + unit, std::move(series)));
  }
  // What lies last in the chain of causes, against what drives it.
  std::vector<ChannelId> upstream, downstream;
  for (const ChannelId c : channels.ids()) (channels[c].kind == system.upstream_kind() ? upstream : downstream).push_back(c);
  if (upstream.empty()) return blocks;
  for (const ChannelId c : downstream) {
    std::vector<report::ScatterSeries> series;
    for (const ChannelId by : upstream)
      series.push_back(points(name_in_legend(by), measured_series(recording, by), comparison.residual[c], colour(by.index)));
    blocks.push_back(scatter(comparison, "Residual of the " + channels[c].words + " against " + channels[upstream.front()].kind,
                             "measured " + channels[upstream.front()].kind + " / " + channels[upstream.front()].unit_words,
                             "model − recording / " + channels[c].unit_words, std::move(series)));
  }
  report::Section loops;
  loops.heading =
      capitalised(channels[upstream.front()].kind) + " and " + (downstream.empty() ? std::string() : channels[downstream.front()].kind);
  loops.text = "One against the other, as recorded and as modelled: hysteresis shows as a loop.";
  if (!downstream.empty()) blocks.push_back(loops);
  for (const ChannelId by : upstream)
    for (const ChannelId c : downstream) {
      const std::string of = by.index < channels.size() ? channels[by].kind + " of " + name_in_legend(by) : "";
      blocks.push_back(scatter(
          comparison, capitalised(channels[c].words) + " against " + of, of + " / " + channels[by].unit_words, with_unit(channels[c]),
          {points("recording", measured_series(recording, by), measured_series(recording, c), report::okabe_ito::black,
                  report::ScatterSeries::Style::path),
           points("model", comparison.model[by], comparison.model[c], report::okabe_ito::vermillion, report::ScatterSeries::Style::path)}));
    }
  return blocks;
}

std::vector<report::TimePlot> paper_figure(const diagnose::Comparison& comparison, const sim::Recording& recording) {
  std::vector<report::TimePlot> plots;
  for (const ChannelId c : in_reading_order(*comparison.system)) plots.push_back(channel_plot(comparison, recording, c));
  plots.push_back(input_plot(comparison, recording));
  return plots;
}

std::string input_words(const plant::System& system) {
  const std::string& words = system.inputs()[plant::InputId{0}].words;
  std::string first = words.substr(0, words.rfind(' '));
  for (const auto& input : system.inputs())
    if (!input.words.starts_with(first)) return "inputs";
  return first;
}

diagnose::PerChannel noise_of_option(const std::vector<std::string>& given, const plant::System& system,
                                     const diagnose::PerChannel& estimated) {
  diagnose::PerChannel noise = estimated;
  std::vector<std::string> names, columns;
  std::string all;
  for (const auto& channel : system.channels()) {
    names.push_back(channel.short_name);
    columns.push_back(channel.column);
    all += (all.empty() ? "" : ", ") + channel.short_name;
  }
  const auto refuse = [&](const std::string& value, const std::string& advice) {
    throw sim::InputError({.file = "", .key = "--noise", .value = value, .advice = advice});
  };
  const bool by_name = std::any_of(given.begin(), given.end(), [](const std::string& one) { return one.find('=') != std::string::npos; });
  if (!given.empty() && !by_name && given.size() != system.channels().size())
    refuse(std::to_string(given.size()) + " values", "needs one for each channel (" + all + "), or NAME=VALUE");
  for (std::size_t k = 0; k < given.size(); ++k) {
    const std::size_t equals = given[k].find('=');
    plant::ChannelId channel{k};
    if (by_name) {
      const std::string name = given[k].substr(0, equals);
      auto found = std::find(columns.begin(), columns.end(), name);
      const bool is_column = found != columns.end();
      if (!is_column) found = std::find(names.begin(), names.end(), name);
      if (equals == std::string::npos || (!is_column && found == names.end()))
        refuse(given[k], "no such channel; there are " + all + sim::did_you_mean(name, names));
      channel.index = static_cast<std::size_t>(found - (is_column ? columns : names).begin());
    }
    const std::optional<double> value = sim::parse_number(by_name ? given[k].substr(equals + 1) : given[k]);
    if (!value || !(*value > 0.0) || !std::isfinite(*value)) refuse(given[k], "is not a positive number; a standard deviation is");
    noise[channel] = *value;
  }
  return noise;
}

namespace {

std::string number(double value) { return report::significant(value, 3); }

// Limbs: where a wire does not get as warm as it must to transform by a quarter, most of what makes the limb move is not in the recording.
std::vector<std::string> cold_parts(const plant::Plant& plant, const sim::Recording& recording) {
  const plant::System& system = plant.system();
  const auto midpoint = system.find_parameter("heating_midpoint_degC"), width = system.find_parameter("heating_width_K");
  if (!midpoint || !width) return {};
  const double needed = plant.get_in_file_units(*midpoint) - plant.get_in_file_units(*width);  // 1 / (1 + e) = 0.27
  std::vector<std::string> found;
  for (const ChannelId c : system.channels().ids()) {
    const plant::ChannelInfo& info = system.channels()[c];
    if (info.kind != "temperature" || !info.driven_by) continue;
    double highest = std::nan("");
    bool driven = false;
    for (const sim::Sample& sample : recording.samples) {
      highest = std::fmax(highest, diagnose::measured(sample, c));
      driven = driven || sample.inputs[info.driven_by->index] != recording.samples.front().inputs[info.driven_by->index];
    }
    if (driven && highest < needed)
      found.push_back(info.words + " reaches " + number(highest) + " °C, and this plant's wire is transformed by a quarter at " +
                      number(needed) + " °C: how the wire pulls cannot be learnt from it");
  }
  return found;
}

}  // namespace

std::vector<std::string> doubts_of(const plant::Plant& plant, const sim::Recording& recording, const diagnose::PerChannel& noise,
                                   bool alone) {
  const plant::System& system = plant.system();
  std::vector<std::string> poor, lines;
  if (alone) poor = diagnose::shortcomings(system, recording, noise);
  if (alone)
    for (std::string& one : cold_parts(plant, recording)) poor.push_back(std::move(one));
  for (const std::string& one : poor) lines.push_back("Too poor: " + one + ".");
  if (const auto pauses_s = sim::pauses_of(recording); !pauses_s.empty()) {
    std::string times;
    constexpr std::size_t most = 4;
    for (std::size_t i = 0; i < std::min(most, pauses_s.size()); ++i)
      times += (i == 0 ? "" : ", ") + sim::rounded(pauses_s[i].first, 6) + "–" + sim::rounded(pauses_s[i].second, 6);
    times += " s";
    if (pauses_s.size() > most) times += " and " + std::to_string(pauses_s.size() - most) + " more";
    lines.push_back("Nothing is recorded, nor what the inputs are, at " + times + ": after " +
                    (pauses_s.size() == 1 ? "this pause" : "each pause") + " the state is estimated anew.");
  }
  constexpr std::size_t most_said = 3;  // a channel
  for (const ChannelId c : system.channels().ids()) {
    const plant::ChannelInfo& info = system.channels()[c];
    std::size_t count = 0;
    for (const auto& one : diagnose::suspected_misreadings(system, recording, noise)) {
      if (one.channel != c || ++count > most_said) continue;
      const std::string from = sim::rounded(one.from_s, 6), until = sim::rounded(one.until_s, 6);
      lines.push_back("Suspected misreading: " + info.words + " stands still at " + number(one.stands_at) + " " + info.unit_words +
                      " from " + from + " s, and has leapt by " + number(one.leap) + " " + info.unit_words + " at " + until +
                      " s; `--ignore " + info.column + ":" + from + "-" + until + "` leaves it out.");
    }
    if (count > most_said)
      lines.push_back("And " + std::to_string(count - most_said) + " more such rows of " + info.words +
                      "; where a converter is slower than the logger, `repeats` in the map of `sinew convert` says so.");
  }
  return lines;
}

std::vector<std::string> oddities_of(const plant::Plant& plant, const sim::Recording& recording, const diagnose::PerChannel& noise,
                                     bool alone) {
  std::vector<std::string> lines;
  std::istringstream notes(recording.notes.summary());
  for (std::string line; std::getline(notes, line);) lines.push_back(line);
  for (std::string& doubt : doubts_of(plant, recording, noise, alone)) lines.push_back(std::move(doubt));
  return lines;
}

void count_from_first(std::vector<sim::Recording>& recordings) {
  if (std::ranges::none_of(recordings, [](const sim::Recording& one) { return one.time_zero_s.has_value(); }))
    recordings.front().time_zero_s = 0.0;
}

std::vector<sim::Recording> usable_parts(const sim::Recording& recording) {
  std::vector<sim::Recording> parts = sim::parts_between_pauses(recording);
  if (parts.size() == 1) return parts;
  std::erase_if(parts, [](const sim::Recording& part) { return part.samples.size() < least_samples; });
  return parts.empty() ? std::vector{recording} : parts;
}

void check_fitted_samples(std::size_t count, const std::string& first_recording, const std::string& what_to_do) {
  constexpr std::size_t most = 200'000;
  if (count > most)
    throw sim::InputError({.file = first_recording,
                           .key = "samples to fit",
                           .value = std::to_string(count),
                           .advice = "at most " + std::to_string(most) + " are fitted at once; " + what_to_do +
                                     ", and more than an hour at 10 Hz adds little"});
}

sim::Recording joined(const sim::Recording& recording, const std::vector<sim::Recording>& parts) {
  if (parts.size() == 1 && parts.front().samples.size() == recording.samples.size()) return recording;
  sim::Recording result = recording;
  result.samples.clear();
  for (const sim::Recording& part : parts) result.samples.insert(result.samples.end(), part.samples.begin(), part.samples.end());
  return result;
}

void check_recording(const sim::Recording& recording, const plant::Plant& plant) {
  const bool measured = std::any_of(recording.samples.begin(), recording.samples.end(), [](const sim::Sample& sample) {
    return std::any_of(sample.channels.begin(), sample.channels.end(), [](double value) { return !std::isnan(value); });
  });
  if (!measured) {
    std::string names;
    for (const auto& channel : plant.system().channels()) names += (names.empty() ? "" : ", ") + channel.column;
    throw sim::InputError({.file = recording.name,
                           .key = names,
                           .value = "nothing",
                           .advice = "no row has a measurement: there is nothing to compare a plant with"});
  }
  check_columns(recording, plant);
}

void check_columns(const sim::Recording& recording, const plant::Plant& plant) {
  if (const auto mistaken = diagnose::mistaken_column(plant, recording))
    throw sim::InputError({.file = recording.name, .key = mistaken->column, .value = mistaken->range, .advice = mistaken->why});
}

void check_long_enough(const sim::Recording& recording, double fit_until_s) {
  if (diagnose::samples_until(recording, fit_until_s) >= least_samples) return;
  const std::size_t rows = recording.samples.size();
  if (rows < least_samples)
    throw sim::InputError(
        {.file = recording.name, .key = "rows", .value = std::to_string(rows), .advice = "too few to fit: 20 are the least"});
  throw sim::InputError(
      {.file = recording.name,
       .key = "--fit-until",
       .value = sim::shortest(fit_until_s),
       .advice = "leaves fewer than 20 samples to fit; the recording begins at " + sim::shortest(recording.samples.front().time_s) + " s"});
}

void check_keeps_back(const std::vector<sim::Recording>& recordings, double fit_until_s) {
  const bool keeps = std::any_of(recordings.begin(), recordings.end(), [&](const sim::Recording& one) {
    return diagnose::samples_until(one, fit_until_s) + least_samples <= one.samples.size();
  });
  if (std::isfinite(fit_until_s) && !keeps)
    throw sim::InputError({.file = "",
                           .key = "--fit-until",
                           .value = sim::shortest(fit_until_s),
                           .advice = "leaves fewer than 20 samples after it, of every recording; leave it out"});
}

void check_given_once(const std::vector<std::pair<std::string, std::vector<std::string>>>& recordings) {
  std::vector<std::filesystem::path> seen;
  for (const auto& [option, paths] : recordings)
    for (const std::string& path : paths) {
      const std::filesystem::path file = std::filesystem::weakly_canonical(path);
      if (contains(seen, file))
        throw sim::InputError({.file = "", .key = option, .value = path, .advice = "is given twice; each recording can be used once"});
      seen.push_back(file);
    }
}

sim::Recording read_recording_of(const std::string& path, const plant::Plant& plant) {
  sim::Recording recording = sim::read_recording(path, plant.system());
  check_recording(recording, plant);
  return recording;
}

}  // namespace sinew::apps

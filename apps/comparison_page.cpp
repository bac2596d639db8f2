// SPDX-License-Identifier: Apache-2.0
#include "apps/comparison_page.h"

#include <cmath>

#include "report/number.h"

namespace sinew::apps {
namespace {

using diagnose::channel_count;
using diagnose::channels;

constexpr std::string_view time_axis = "recording";

std::vector<double> measured_series(const sim::Recording& recording, std::size_t channel) {
  std::vector<double> values;
  for (const auto& sample : recording.samples) values.push_back(diagnose::measured(sample, channel));
  return values;
}

std::vector<report::Band> bands(const diagnose::Comparison& comparison) {
  if (comparison.fit_until_s > comparison.time_s.back()) return {};
  return {{comparison.fit_until_s, comparison.time_s.back(), "not fitted"}};
}

std::string name_of(std::size_t channel) { return std::string(channels[channel].words); }
std::string with_unit(std::size_t channel) { return name_of(channel) + " / " + std::string(channels[channel].unit); }

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

report::TimePlot channel_plot(const diagnose::Comparison& comparison, const sim::Recording& recording, std::size_t c) {
  std::string title = name_of(c);
  title[0] = static_cast<char>(std::toupper(static_cast<unsigned char>(title[0])));
  return time_plot(comparison, title, with_unit(c),
                   {line("recording", measured_series(recording, c), report::okabe_ito::black),
                    line("model", comparison.model[c], report::okabe_ito::vermillion)});
}

report::TimePlot residual_plot(const diagnose::Comparison& comparison, std::size_t c, std::string color) {
  const double noise = comparison.noise[c];
  report::Series residual = line("model − recording", comparison.residual[c], std::move(color));
  report::Series band = line("noise, ± 2 σ", std::vector<double>(comparison.time_s.size(), 0.0), report::okabe_ito::sky_blue);
  band.lower.assign(comparison.time_s.size(), -2.0 * noise);
  band.upper.assign(comparison.time_s.size(), 2.0 * noise);
  report::TimePlot plot =
      time_plot(comparison, "Residual of " + name_of(c), "model − recording / " + std::string(channels[c].unit), {band, residual});
  plot.height_px = 130;
  return plot;
}

report::TimePlot duty_plot(const diagnose::Comparison& comparison, const sim::Recording& recording) {
  std::vector<double> a, b;
  for (const auto& sample : recording.samples) {
    a.push_back(sample.duty_fraction[plant::A]);
    b.push_back(sample.duty_fraction[plant::B]);
  }
  report::TimePlot plot = time_plot(comparison, "Duty", "duty",
                                    {line("coil A", a, report::okabe_ito::blue, report::Series::Style::steps),
                                     line("coil B", b, report::okabe_ito::orange, report::Series::Style::steps)});
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

std::string windows_text(const diagnose::WorstTime& worst) {
  std::string text;
  for (std::size_t i = 0; i < worst.windows_s.size() && i < 4; ++i)
    text += (i ? ", " : "") + report::fixed(worst.windows_s[i].first, 0) + "–" + report::fixed(worst.windows_s[i].second, 0);
  text += " s";
  if (worst.windows_s.size() > 4) text += " and " + std::to_string(worst.windows_s.size() - 4) + " more such times";
  return text;
}

}  // namespace

report::Table error_table(const diagnose::Comparison& comparison) {
  const bool held = comparison.fit_until_s <= comparison.time_s.back();
  report::Table table;
  table.header = {"channel", "samples", "noise", "RMSE", "bias", "largest", "more than noise"};
  const auto add = [&](std::size_t c, const std::string& part, const diagnose::ChannelError& error) {
    report::Row row;
    row.cells = {with_unit(c) + part,
                 std::to_string(error.samples),
                 report::significant(comparison.noise[c], 2),
                 report::significant(error.rmse, 3),
                 report::significant(error.bias, 2),
                 report::significant(error.largest, 3),
                 std::isnan(error.rmse) ? "–" : report::fixed(100.0 * error.more_than_noise, 1) + " %"};
    table.rows.push_back(row);
  };
  for (std::size_t c = 0; c < channel_count; ++c) add(c, held ? ", fitted" : "", comparison.fitted[c]);
  for (std::size_t c = 0; held && c < channel_count; ++c) add(c, ", not fitted", comparison.unfitted[c]);
  table.align.assign(table.header.size(), report::Align::right);
  table.align[0] = report::Align::left;
  table.caption = "RMSE of model − recording, open loop. Noise is what the sensor alone does; the last column is the share of the "
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
  for (std::size_t c = 0; c < channel_count; ++c)
    json[std::string(channels[c].column)] = {{"noise", comparison.noise[c]},
                                             {"fitted", json_of(comparison.fitted[c])},
                                             {"not_fitted", json_of(comparison.unfitted[c])}};
  return json;
}

std::vector<std::string> findings(const diagnose::Comparison& comparison) {
  std::vector<std::string> lines;
  for (std::size_t c = 0; c < channel_count; ++c) {
    if (comparison.fitted[c].samples + comparison.unfitted[c].samples == 0) continue;
    const std::string unit(channels[c].unit);
    const diagnose::ChannelError& error = comparison.fitted[c].samples ? comparison.fitted[c] : comparison.unfitted[c];
    std::string text = "The " + name_of(c) + " is " + report::significant(error.rmse, 3) + " " + unit + " off (noise: " +
                       report::significant(comparison.noise[c], 2) + " " + unit + ")";
    if (comparison.fitted[c].samples && comparison.unfitted[c].samples)
      text += " where it was fitted and " + report::significant(comparison.unfitted[c].rmse, 3) + " " + unit + " where it was not";
    const auto& worst = comparison.worst[c];
    if (error.more_than_noise > 0.2)
      text += "; " + report::fixed(100.0 * worst.share_of_error, 0) + " % of the squared error happens in " +
              report::fixed(100.0 * worst.share_of_time, 0) + " % of the time: " + windows_text(worst);
    else
      text += ", little or nothing more than noise";
    lines.push_back(text + ".");
  }
  return lines;
}

std::vector<report::Block> comparison_blocks(const diagnose::Comparison& comparison, const sim::Recording& recording) {
  using report::okabe_ito::blue, report::okabe_ito::orange, report::okabe_ito::green;
  std::vector<report::Block> blocks;
  report::Section over_time;
  over_time.heading = "Over time";
  over_time.text = "Open loop: the model is given the recorded duty and nothing else.";
  blocks.push_back(over_time);
  blocks.push_back(channel_plot(comparison, recording, 2));
  blocks.push_back(residual_plot(comparison, 2, green));
  for (const std::size_t j : plant::coils) {
    blocks.push_back(channel_plot(comparison, recording, j));
    blocks.push_back(residual_plot(comparison, j, j == plant::A ? blue : orange));
  }
  blocks.push_back(duty_plot(comparison, recording));

  report::Section against;
  against.heading = "Where the residual is";
  against.text =
      "A cloud around zero is noise. A cloud with a shape is something that the model lacks, or has wrong, at that "
      "temperature or that angle.";
  blocks.push_back(against);
  const auto angle = measured_series(recording, 2), a = measured_series(recording, 0), b = measured_series(recording, 1);
  blocks.push_back(scatter(comparison, "Residual of the temperatures against temperature", "measured temperature / °C",
                           "model − recording / °C",
                           {points("coil A", a, comparison.residual[0], blue), points("coil B", b, comparison.residual[1], orange)}));
  blocks.push_back(scatter(comparison, "Residual of the angle against angle", "measured angle / °", "model − recording / °",
                           {points("angle", angle, comparison.residual[2], green)}));
  blocks.push_back(scatter(comparison, "Residual of the angle against temperature", "measured temperature / °C",
                           "model − recording / °",
                           {points("coil A", a, comparison.residual[2], blue), points("coil B", b, comparison.residual[2], orange)}));
  report::Section loops;
  loops.heading = "Temperature and angle";
  loops.text = "The hysteresis of each coil, as recorded and as modelled.";
  blocks.push_back(loops);
  for (const std::size_t j : plant::coils) {
    const std::string coil = j == plant::A ? "coil A" : "coil B";
    blocks.push_back(scatter(comparison, "Angle against temperature of " + coil, "temperature of " + coil + " / °C", "angle / °",
                             {points("recording", j == plant::A ? a : b, angle, report::okabe_ito::black,
                                     report::ScatterSeries::Style::path),
                              points("model", comparison.model[j], comparison.model[2], report::okabe_ito::vermillion,
                                     report::ScatterSeries::Style::path)}));
  }
  return blocks;
}

std::vector<report::TimePlot> paper_figure(const diagnose::Comparison& comparison, const sim::Recording& recording) {
  return {channel_plot(comparison, recording, 2), channel_plot(comparison, recording, 0), channel_plot(comparison, recording, 1),
          duty_plot(comparison, recording)};
}

}  // namespace sinew::apps

// SPDX-License-Identifier: Apache-2.0
#include "apps/training.h"

#include "model/set.h"
#include "report/number.h"
#include "sim/input_error.h"

namespace sinew::apps {

using model::Index, model::Series, model::Vector;

std::vector<Series> series_of_paths(const std::vector<std::string>& paths, int paper_case, double until_s, model::Missing missing) {
  std::vector<Series> all;
  for (const std::string& path : paths)
    for (sim::Recording& recording : model::read_set(path)) {
      const auto late = std::find_if(recording.samples.begin(), recording.samples.end(), [&](const sim::Sample& s) { return s.time_s > until_s; });
      recording.samples.erase(late, recording.samples.end());
      if (recording.samples.size() < 2)
        throw sim::InputError({.file = recording.name, .advice = "has fewer than two samples before the time given"});
      all.push_back(model::series_of(recording, paper_case, missing));
    }
  return all;
}

model::Trained train_by(const std::string& method, const std::string& settings_file, const std::vector<Series>& data,
                        const model::TrainingRun& run) {
  model::TrainingFile settings;
  if (!settings_file.empty()) settings = model::read_training(settings_file);
  if ((method == "published" && settings.stateful && !settings.published) || (method == "stateful" && settings.published && !settings.stateful))
    throw sim::InputError({.file = settings_file, .key = "--method", .value = method, .advice = "the file has settings of the other method"});
  return method == "published" ? model::train_published(data, settings.published.value_or(model::PublishedSettings{}), run)
                               : model::train_stateful(data, settings.stateful.value_or(model::StatefulSettings{}), run);
}

std::string weights_path(const std::string& model) {
  const std::filesystem::path path = model;
  return std::filesystem::is_directory(path) ? (path / "weights.h5").string() : model;
}

std::string case_words(int paper_case) {
  static const char* const words[] = {"one coil, duty", "one coil, duty and temperature", "both coils, duty", "both coils, duty and temperature"};
  return words[paper_case - 1];
}

namespace {

std::vector<double> of(const Vector<double>& v) { return {v.data(), v.data() + v.size()}; }

using report::line;

}  // namespace

std::vector<report::Block> rollout_blocks(const Series& series, const Vector<double>& predicted, int paper_case) {
  std::vector<double> time_s;
  for (Index k = 0; k < series.samples(); ++k) time_s.push_back(series.first_s + static_cast<double>(k) * model::period_s);
  report::TimePlot angle;
  angle.title = "Bend angle, measured and predicted from one measured angle";
  angle.y_label = "bend angle / °";
  angle.time_s = time_s;
  angle.series = {line("recording", of(series.angle_deg), report::okabe_ito::black), line("prediction", of(predicted), report::okabe_ito::vermillion)};
  angle.time_axis = "recording";
  // Root mean square over a sliding minute shows drift.
  std::vector<double> drift(time_s.size(), std::nan(""));
  constexpr Index minute = 600;
  double sum = 0.0;
  for (Index k = 0; k < series.samples(); ++k) {
    sum += std::pow(predicted(k) - series.angle_deg(k), 2);
    if (k >= minute) sum -= std::pow(predicted(k - minute) - series.angle_deg(k - minute), 2);
    if (k + 1 >= minute) drift[static_cast<std::size_t>(k)] = std::sqrt(std::max(0.0, sum) / static_cast<double>(minute));
  }
  report::TimePlot error;
  error.title = "Error over time";
  error.y_label = "prediction − recording / °";
  error.time_s = time_s;
  error.series = {line("error", of(predicted - series.angle_deg), report::okabe_ito::green), line("root mean square of the minute before", drift, report::okabe_ito::blue)};
  error.time_axis = "recording";
  error.height_px = 140;
  std::vector<report::Block> blocks{angle, error};
  const auto channels = model::channels_of(paper_case);
  for (std::size_t c = 0; c < channels.size(); ++c) {
    if (!channels[c].temperature) continue;
    const std::string coil = channels[c].coil == plant::A ? "coil A" : "coil B";
    report::ScatterPlot loops;
    loops.title = "Angle against temperature of " + coil;
    loops.x_label = "temperature of " + coil + " / °C";
    loops.y_label = "bend angle / °";
    const std::vector<double> temperature = of(series.v.row(static_cast<Index>(c)).transpose());
    report::ScatterSeries measured, modelled;
    measured.name = "recording";
    measured.x = temperature;
    measured.y = of(series.angle_deg);
    measured.color = report::okabe_ito::black;
    measured.style = report::ScatterSeries::Style::path;
    modelled = measured;
    modelled.name = "prediction";
    modelled.y = of(predicted);
    modelled.color = report::okabe_ito::vermillion;
    loops.series = {measured, modelled};
    blocks.push_back(loops);
  }
  return blocks;
}

std::vector<report::Block> curve_blocks(const std::vector<model::CurvePoint>& curve, const std::string& method) {
  report::ScatterPlot plot;
  plot.title = "Learning curve";
  plot.x_label = "updates";
  plot.y_label = "root mean square error / °";
  report::ScatterSeries training, validation;
  training.name = method == "published" ? "training, one step ahead" : "training, mostly open loop";
  validation.name = method == "published" ? "after the training part, one step ahead" : "set aside, open loop";
  for (const auto& point : curve) {
    training.x.push_back(static_cast<double>(point.update));
    training.y.push_back(point.training_deg);
    validation.x.push_back(static_cast<double>(point.update));
    validation.y.push_back(point.validation_deg);
  }
  training.style = validation.style = report::ScatterSeries::Style::path;
  training.color = report::okabe_ito::blue;
  validation.color = report::okabe_ito::vermillion;
  plot.series = {training, validation};
  return {plot};
}

}  // namespace sinew::apps

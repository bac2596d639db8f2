// SPDX-License-Identifier: Apache-2.0
#include "apps/training.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <filesystem>

#include "apps/comparison_page.h"
#include "apps/words.h"
#include "model/linear.h"
#include "model/set.h"
#include "plant/contains.h"
#include "plant/systems.h"
#include "report/number.h"
#include "sim/input_error.h"
#include "sim/plant_file.h"

namespace sinew::apps {

using model::Index, model::Series, model::Vector;

std::shared_ptr<const plant::System> system_for(const std::string& plant_file, const std::vector<std::string>& paths) {
  if (!plant_file.empty()) return sim::read_plant_file(plant_file).shared_system();
  for (const std::string& path : paths)
    if (auto system = model::system_of_set(path)) return system;
  return plant::default_plant().shared_system();
}

std::optional<plant::ChannelId> channel_named(const plant::System& system, const std::string& column) {
  if (column.empty()) return std::nullopt;
  std::string known;
  for (const plant::ChannelId c : system.channels().ids()) {
    if (system.channels()[c].column == column) return c;
    known += (known.empty() ? "" : ", ") + system.channels()[c].column;
  }
  throw sim::InputError({.file = "", .key = "--predict", .value = column, .advice = "is no channel of this plant; there are " + known});
}

sim::Columns columns_for(const model::Task& task) {
  const sim::Columns needed = model::columns_of(task), usual = sim::columns_of(plant::default_plant().system());
  const auto among = [](const std::vector<sim::Column>& some, const std::vector<sim::Column>& all) {
    return std::all_of(some.begin(), some.end(), [&](const auto& one) { return contains(all, one); });
  };
  return among(needed.inputs, usual.inputs) && among(needed.channels, usual.channels) ? usual : needed;
}

namespace {

// Columns of files that are not what their names say, by a plant that has these columns.
class ColumnCheck {
 public:
  ColumnCheck(const std::string& plant_file, const sim::Columns& columns)
      : is_usual_(plant_file.empty()), plant_(is_usual_ ? plant::default_plant() : sim::read_plant_file(plant_file)) {
    applies_ = sim::columns_of(plant_.system()) == columns;
  }
  void operator()(const sim::Recording& recording) const {
    if (!applies_) return;
    try {
      check_columns(recording, plant_);
    } catch (const sim::InputError& e) {
      sim::InputFault fault = e;
      if (is_usual_) fault.advice += "\nthe plant is the usual one, since none was given; --plant names another";
      throw sim::InputError(std::move(fault));
    }
  }

 private:
  bool is_usual_, applies_ = false;
  plant::Plant plant_;
};

}  // namespace

std::vector<Series> series_of_paths(const std::vector<std::string>& paths, const sim::Columns& columns, const model::Task& task,
                                    double until_s, model::Missing missing, const std::string& plant_file, std::int64_t most_runs) {
  const ColumnCheck check(plant_file, columns);
  std::vector<Series> all;
  for (const std::string& path : paths) {
    const std::int64_t runs = model::visit_set(path, columns, most_runs, [&](sim::Recording recording) {
      if (!std::filesystem::is_directory(path)) check(recording);
      const auto late =
          std::find_if(recording.samples.begin(), recording.samples.end(), [&](const sim::Sample& s) { return s.time_s > until_s; });
      recording.samples.erase(late, recording.samples.end());
      if (recording.samples.size() < 2)
        throw sim::InputError({.file = recording.name, .advice = "has fewer than two samples before the time given"});
      all.push_back(model::series_of(recording, task, missing));
    });
    if (runs > most_runs)
      std::fprintf(stderr, "%s: %lld runs, of which %lld are read, spread evenly over it (--most-runs)\n", path.c_str(),
                   static_cast<long long>(runs), static_cast<long long>(most_runs));
  }
  return all;
}

model::Missing missing_by(bool hold_missing, bool resample) {
  return resample ? model::Missing::resampled : hold_missing ? model::Missing::held : model::Missing::refused;
}

void add_resample(CLI::App& command, bool& resample) {
  command.add_flag(
      "--resample", resample,
      "put recordings of uneven period on the grid of 10 Hz; where nothing was measured for half a second, nothing is counted");
}

model::TrainingFile training_settings(const std::string& predictor, const std::string& settings_file) {
  model::TrainingFile settings;
  if (!settings_file.empty()) settings = model::read_training(settings_file);
  if (!settings.given.empty() && !settings.has(predictor) && !model::predictor_kind(predictor).holds_another)
    throw sim::InputError({.file = settings_file,
                           .key = "--predictor",
                           .value = predictor,
                           .advice = "the file has settings of " + settings.given.begin()->first + ", and none of this one"});
  return settings;
}

model::LinearModel arx_beside(double training_fraction, const std::vector<Series>& data) {
  return model::fit_arx(model::training_parts(data, training_fraction));
}

std::unique_ptr<model::Predictor> read_predictor_at(const std::string& path, model::Unsaid unsaid,
                                                    std::shared_ptr<const plant::System> system) {
  const std::string weights = weights_path(path);
  if (const auto beside = model::sidecar_of(weights); std::filesystem::exists(beside)) {
    unsaid.sidecar = model::read_sidecar(beside);
    if (!system) system = plant::default_plant().shared_system();
    if (!unsaid.task)
      unsaid.task = model::task_of(*system, unsaid.sidecar->paper_case, channel_named(*system, unsaid.sidecar->output.column));
    if (unsaid.method.empty()) unsaid.method = unsaid.sidecar->method;
  } else if (unsaid.lowest) {
    std::fprintf(
        stderr,
        "%s: where Keras wrote it, its inputs are taken to be v(t), v(t-1), y(t-1), and all but y unscaled; %s would say otherwise\n",
        sim::printable(weights).c_str(), sim::printable(beside.string()).c_str());
  }
  return model::read_predictor(weights, unsaid);
}

Baselines baselines_of(const model::Predictor& predictor, const Series& series) {
  const auto error_of = [&](const Vector<double>& predicted) {
    return predicted.allFinite() ? model::errors_of(predicted, series).rmse : std::nan("");
  };
  Baselines baselines{error_of(Vector<double>::Constant(series.samples(), series.y(0))), std::nullopt};
  if (const auto& arx = predictor.about().arx) baselines.arx = error_of(model::rollout(*arx, series));
  return baselines;
}

std::string baseline_sentence(const Baselines& baselines, const std::string& unit) {
  std::string text = "To hold the first value is " + report::significant(baselines.hold, 3) + unit + " off";
  if (!baselines.arx) return text + "; the weights file has no ARX to compare with (`sinew train` writes one).";
  if (std::isnan(*baselines.arx)) return text + "; a linear model (ARX) fitted to the same data diverges.";
  return text + ", and a linear model (ARX) fitted to the same data " + report::significant(*baselines.arx, 3) + unit + ".";
}

Trust trust_in(const model::AboutPredictor& about, const Series& series, const Series& whole, Index first, Index history,
               const Vector<double>& open, const Vector<double>& step) {
  Trust trust;
  using model::Beginning;
  const Beginning beginning = first == 0                                                                  ? Beginning::at_first
                              : static_cast<double>(history) * model::period_s >= model::enough_history_s ? Beginning::after_history
                                                                                                          : Beginning::in_motion;
  if (const auto* steps = about.intervals ? about.intervals->steps_for(beginning) : nullptr) {
    Trust::Interval interval{.promised_share = model::promised_share(*steps),
                             .open_loop = model::half_widths(*steps, false, series.samples()),
                             .one_step = model::half_widths(*steps, true, series.samples())};
    interval.inside_open_loop = model::share_inside(open, interval.open_loop, series);
    interval.inside_one_step = model::share_inside(step, interval.one_step, series);
    trust.interval = std::move(interval);
  }
  if (about.region) {
    const Series before = model::part_of(whole, 0, first + 1);
    trust.departures = model::departures_of(*about.region, series, open, &before);
  }
  return trust;
}

std::string interval_sentence(const Trust& trust, const model::AboutPredictor& about) {
  if (!trust.interval)
    return about.intervals && about.intervals->any()
               ? "The weights file has no intervals for a rollout that begins so."
               : "The weights file has no intervals (`sinew train` keeps some where data are left that it was not trained on).";
  const auto percent = [](double share) { return report::significant(100.0 * share, 3) + " %"; };
  return percent(trust.interval->inside_open_loop) + " of the samples lie inside the interval in open loop, " +
         percent(trust.interval->inside_one_step) + " one step ahead; it was made for " + percent(trust.interval->promised_share) +
         (trust.interval->promised_share < model::interval_share ? ", as it comes from few data." : ".");
}

std::string departure_sentence(const Trust& trust, const model::AboutPredictor& about, double first_s) {
  if (!trust.departures) return "The weights file does not say what was trained on.";
  return model::words_of(*trust.departures, *about.region, about.task, first_s);
}

bool leaves_training(const Trust& trust, const model::AboutPredictor& about) {
  return trust.departures && trust.departures->share() > about.region->usual_share;
}

nlohmann::ordered_json outside_json(const model::Departures& found, const model::AboutPredictor& about, double first_s) {
  const double samples = std::max(1.0, static_cast<double>(found.samples));
  nlohmann::ordered_json outside{{"share", found.share()},
                                 {"share_by_one_column", static_cast<double>(found.alone) / samples},
                                 {"usual_share", about.region->usual_share},
                                 {"leaves_training", found.share() > about.region->usual_share}};
  if (found.outside == 0) return outside;
  const std::vector<std::string> names = model::region_names(about.task);
  outside["first_s"] = first_s + static_cast<double>(found.first) * model::period_s;
  outside["furthest_s"] = first_s + static_cast<double>(found.at) * model::period_s;
  outside["furthest"] = model::words_of(found.furthest, *about.region, about.task);
  for (std::size_t i = 0; i < names.size(); ++i)
    if (found.of_entry[i] > 0) outside["columns"][names[i]] = static_cast<double>(found.of_entry[i]) / samples;
  return outside;
}

void put_trust(nlohmann::ordered_json& json, const Trust& trust, const model::AboutPredictor& about, double first_s) {
  json["interval"] = nullptr;
  json["outside"] = nullptr;
  if (trust.interval)
    json["interval"] = {{"share", model::interval_share},
                        {"promised_share", trust.interval->promised_share},
                        {"inside_open_loop", trust.interval->inside_open_loop},
                        {"inside_one_step", trust.interval->inside_one_step},
                        {key_in_unit("half_width_open_loop_at_end", about.task.predicted), trust.interval->open_loop.tail(1)(0)},
                        {key_in_unit("half_width_one_step_at_end", about.task.predicted), trust.interval->one_step.tail(1)(0)}};
  if (trust.departures) json["outside"] = outside_json(*trust.departures, about, first_s);
}

std::string weights_path(const std::string& model) {
  const std::filesystem::path path = model;
  return std::filesystem::is_directory(path) ? (path / "weights.h5").string() : model;
}

std::string words_of(const model::Task& task) {
  std::string words;
  for (const model::Feature& feature : task.features) words += (words.empty() ? "" : ", ") + feature.column.words;
  return words;
}
std::string unit_words(const sim::Column& column) {
  if (column.unit == "deg") return "°";
  return column.unit == "degC" ? "°C" : column.unit;
}
std::string key_in_unit(const std::string& what, const sim::Column& column) {
  return column.unit.empty() ? what : what + "_" + column.unit;
}

namespace {

std::vector<double> of(const Vector<double>& v) { return {v.data(), v.data() + v.size()}; }

using report::line;

std::string axis(const sim::Column& column) { return column.unit.empty() ? column.words : column.words + " / " + unit_words(column); }

}  // namespace

namespace {

// Stretches of a rollout that lie outside; those with less than five seconds between them are one.
std::vector<report::Band> outside_bands(const std::vector<bool>& is_outside, const std::vector<double>& time_s) {
  constexpr double apart_s = 5.0;
  std::vector<report::Band> bands;
  for (std::size_t k = 0; k < is_outside.size(); ++k) {
    if (!is_outside[k]) continue;
    if (bands.empty() || time_s[k] - bands.back().to_s > apart_s) bands.push_back({time_s[k], time_s[k], "outside of training"});
    bands.back().to_s = time_s[k];
  }
  return bands;
}

}  // namespace

std::vector<report::Block> rollout_blocks(const Series& series, const Vector<double>& predicted, const model::Task& task,
                                          const Trust* trust) {
  std::vector<double> time_s;
  Vector<double> recorded(series.samples());
  for (Index k = 0; k < series.samples(); ++k) {
    time_s.push_back(series.first_s + static_cast<double>(k) * model::period_s);
    recorded(k) = series.measured(k);
  }
  const Vector<double> off = predicted - recorded;
  report::TimePlot both;
  both.title = capitalised(task.predicted.words) + ", measured and predicted from one measured value";
  both.y_label = axis(task.predicted);
  both.time_s = time_s;
  both.series = {line("recording", of(recorded), report::okabe_ito::black),
                 line("prediction", of(predicted), report::okabe_ito::vermillion)};
  both.time_axis = "recording";
  if (trust && trust->interval) {
    both.series.back().name = "prediction, with its " + report::significant(100.0 * trust->interval->promised_share, 2) + " % interval";
    both.series.back().lower = of(predicted - trust->interval->open_loop);
    both.series.back().upper = of(predicted + trust->interval->open_loop);
  }
  if (trust && trust->departures) both.bands = outside_bands(trust->departures->is_outside, time_s);
  // Root mean square over a sliding minute shows drift; of what was measured in it.
  std::vector<double> drift(time_s.size(), std::nan(""));
  constexpr Index minute = 600;
  double sum = 0.0;
  Index measured = 0;
  const auto count = [&](Index k, int sign) {
    if (!series.is_measured(k)) return;
    sum += sign * std::pow(off(k), 2);
    measured += sign;
  };
  for (Index k = 0; k < series.samples(); ++k) {
    count(k, 1);
    if (k >= minute) count(k - minute, -1);
    if (k + 1 >= minute && measured > 0) drift[static_cast<std::size_t>(k)] = std::sqrt(std::max(0.0, sum) / static_cast<double>(measured));
  }
  report::TimePlot error;
  error.title = "Error over time";
  error.y_label = "prediction − recording" + (task.predicted.unit.empty() ? "" : " / " + unit_words(task.predicted));
  error.time_s = time_s;
  error.series = {line("error", of(off), report::okabe_ito::green),
                  line("root mean square of the minute before", drift, report::okabe_ito::blue)};
  error.time_axis = "recording";
  error.height_px = 140;
  std::vector<report::Block> blocks{both, error};
  for (std::size_t f = 0; f < task.features.size(); ++f) {
    const auto& [column, is_measured] = task.features[f];
    if (!is_measured) continue;
    report::ScatterPlot loops;
    loops.title = capitalised(task.predicted.words) + " against " + column.words;
    loops.x_label = axis(column);
    loops.y_label = axis(task.predicted);
    const std::vector<double> against = of(series.v.row(static_cast<Index>(f)).transpose());
    report::ScatterSeries shown, modelled;
    shown.name = "recording";
    shown.x = against;
    shown.y = of(recorded);
    shown.color = report::okabe_ito::black;
    shown.style = report::ScatterSeries::Style::path;
    modelled = shown;
    modelled.name = "prediction";
    modelled.y = of(predicted);
    modelled.color = report::okabe_ito::vermillion;
    loops.series = {shown, modelled};
    blocks.push_back(loops);
  }
  return blocks;
}

std::vector<report::Block> curve_blocks(const std::vector<model::CurvePoint>& curve, const std::string& validated_by,
                                        const model::Task& task) {
  report::ScatterPlot plot;
  plot.title = "Learning curve";
  plot.x_label = "updates";
  plot.y_label = "root mean square error" + (task.predicted.unit.empty() ? "" : " / " + unit_words(task.predicted));
  report::ScatterSeries training, validation;
  training.name = "training";
  validation.name = validated_by;
  for (const auto& point : curve) {
    training.x.push_back(static_cast<double>(point.update));
    training.y.push_back(point.training_error);
    validation.x.push_back(static_cast<double>(point.update));
    validation.y.push_back(point.validation_error);
  }
  training.style = validation.style = report::ScatterSeries::Style::path;
  training.color = report::okabe_ito::blue;
  validation.color = report::okabe_ito::vermillion;
  plot.series = {training, validation};
  return {plot};
}

}  // namespace sinew::apps

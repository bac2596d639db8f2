#include "diagnose/diagnosis.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "diagnose/calibrate.h"
#include "diagnose/open_loop.h"
#include "sim/random.h"
#include "sim/simulation.h"

namespace sinew::diagnose {
namespace {

constexpr double nan = std::numeric_limits<double>::quiet_NaN();
constexpr double bootstrap_block_s = 20.0;
constexpr int bootstrap_draws = 400;
constexpr double two_sided_95 = 1.959964;
constexpr double two_suffice_share = 0.98;  // of the misfit: a third effect is one too many

// Where the training recordings are kept back from, as shares of their duration, when no recording is given to hold
// out.
constexpr std::array<std::pair<double, double>, 2> kept_back_shares{{{0.40, 0.50}, {0.88, 1.0}}};

struct Split {
  sim::Recording fitted;        // with what is not to be fitted masked
  std::size_t sample_count;     // the first so many are fitted
  std::vector<bool> kept_back;  // of the recording's samples
};

Split split(const sim::Recording& gated, double fit_until_s, bool keep_blocks) {
  Split result{gated, gated.samples.size(), std::vector<bool>(gated.samples.size(), false)};
  const std::size_t until = samples_until(gated, fit_until_s);
  if (until < gated.samples.size()) {
    result.sample_count = until;
    for (std::size_t k = until; k < gated.samples.size(); ++k) result.kept_back[k] = true;
    return result;
  }
  if (!keep_blocks) return result;
  const double first_s = gated.samples.front().time_s, duration_s = gated.duration_s();
  for (std::size_t k = 0; k < gated.samples.size(); ++k)
    for (const auto& [from, to] : kept_back_shares) {
      const double time_s = gated.samples[k].time_s - first_s;
      if (time_s < from * duration_s - guard_s || time_s > to * duration_s + guard_s) continue;
      result.kept_back[k] = result.kept_back[k] || (time_s >= from * duration_s && time_s <= to * duration_s);
      result.fitted.samples[k].temperature_degC = {nan, nan};
      result.fitted.samples[k].angle_deg = nan;
    }
  return result;
}

Agreement agreement_of(const Explanation& explanation, const Fitted& path, const std::vector<FitData>& data,
                       const plant::NumericalSettings& numerics) {
  Agreement result;
  const Spread spread = spread_of(path, data, numerics);
  for (std::size_t c = 0; c < channel_count; ++c) {
    double sum = 0.0;
    for (std::size_t r = 0; r < data.size(); ++r)
      sum += std::pow(spread.rmse[r][c], 2) / static_cast<double>(data.size());
    result.rmse[c] = std::sqrt(sum);
  }
  for (std::size_t u = 0; u < explanation.problem->parameters().size(); ++u) {
    if (plant::parameters()[explanation.problem->parameters()[u]].effect != plant::no_effect) continue;
    const double z = explanation.z(static_cast<Eigen::Index>(u));
    result.pull += z * z;
  }
  return result;
}

// A shape that ends at the bound of what is allowed is no value that a limb has. A bound that stands for nothing (no
// heat loss, friction without smoothing) is one.
bool sensible(std::size_t effect, const Explanation& by) {
  for (std::size_t u = 0; u < by.problem->parameters().size(); ++u) {
    const std::size_t p = by.problem->parameters()[u];
    if (plant::parameters()[p].effect != effect || p == plant::effects()[effect].strength) continue;
    const Unknown& unknown = by.problem->unknowns()[u];
    const double margin = 1e-6 * (unknown.highest - unknown.lowest);
    const bool lowest_is_nothing = std::abs(unknown.lowest) < 0.02 * std::abs(unknown.centre);
    if ((by.value(u) <= unknown.lowest + margin && !lowest_is_nothing) || by.value(u) >= unknown.highest - margin)
      return false;
  }
  return true;
}

// Which of the explanations that the search passed is the answer. All effects that were accepted, if together they
// leave nothing; without the last where that has a value that no limb has, or is a third and the two explain nearly
// all. Otherwise what is left has a name for none of it but, perhaps, the first: further ones only bend the fit.
Explanation chosen(const Search& search, const DiagnosisSettings& settings) {
  if (nothing_left(search, settings.search)) {
    const Round* last = nullptr;
    for (const Round& round : search.rounds)
      if (round.accepted) last = &round;
    const auto enough = [&](const Explanation& by) {
      return share_explained(search.core, by) >= settings.least_explained_share;
    };
    const bool third = last && search.rounds.size() > 2 && last == &search.rounds[2] &&
                       share_explained(search.core, last->before) >= two_suffice_share;
    const bool keep =
        !last || (!third && sensible(last->candidates.front().effect, search.best)) || !enough(last->before);
    return keep ? search.best : last->before;
  }
  for (const Round& round : search.rounds)
    if (round.accepted &&
        share_explained(search.core, round.candidates.front().explanation) >= settings.least_explained_share)
      return round.candidates.front().explanation;
  return search.best;
}

// Whether a channel's path is further off than its sensor's noise and moving air account for.
bool far_off(double rmse, std::size_t channel, const PerChannel& noise, const DiagnosisSettings& settings) {
  return rmse > std::hypot(2.0 * noise[channel], settings.as_little[channel]);
}

// Of the squared error beyond noise that there was, the share that is left.
double share_left(double was, double is, double noise) {
  return (is * is - noise * noise) / (was * was - noise * noise);
}

Objections objections_to(const Explanation& answer, const std::vector<std::size_t>& effects, const Diagnosis& diagnosis,
                         bool something_left, const DiagnosisSettings& settings, const PerChannel& noise) {
  Objections result;
  const Agreement &before = diagnosis.agreement_before, &after = diagnosis.agreement_after;
  result.leaves_too_much = something_left;
  for (std::size_t c = 0; c < channel_count; ++c)
    if (far_off(after.rmse[c], c, noise, settings) &&
        share_left(before.rmse[c], after.rmse[c], noise[c]) > settings.most_left_of_channel)
      result.channels.push_back(c);
  result.pushes_parameters = after.pull > before.pull + settings.most_rise_of_pull;
  result.patchwork = effects.size() > 2;
  result.at_a_bound = std::any_of(effects.begin(), effects.end(), [&](std::size_t e) { return !sensible(e, answer); });
  return result;
}

struct Stretch {  // squares of one channel over some seconds of what was kept back
  double nominal = 0.0, before = 0.0, after = 0.0, noise = 0.0;
  std::size_t count = 0;
};

struct Scored {
  HeldOutError error;
  // The 95 % block-bootstrap interval of the sum over channels of (before - after) squares in units of noise.
  double lowest_gain = 0.0, highest_gain = 0.0;
};

Scored score_kept_back(const std::vector<Prediction>& predictions, const std::vector<Series>& nominal,
                       const std::vector<PerChannel>& noise, std::uint64_t seed) {
  Scored result;
  std::vector<double> total(bootstrap_draws, 0.0);
  for (std::size_t c = 0; c < channel_count; ++c) {
    std::vector<Stretch> stretches;
    for (std::size_t p = 0; p < predictions.size(); ++p) {
      const Prediction& prediction = predictions[p];
      double end_s = -1e300;
      // At least a dozen stretches to draw from, but none shorter than 5 s.
      const double kept_s =
          0.1 * static_cast<double>(std::count(prediction.kept_back.begin(), prediction.kept_back.end(), true));
      const double stretch_s = std::clamp(kept_s / 12.0, 5.0, bootstrap_block_s);
      for (std::size_t k = 0; k < prediction.time_s.size(); ++k) {
        if (!prediction.kept_back[k] || std::isnan(prediction.measured[c][k])) continue;
        if (prediction.time_s[k] > end_s) {
          stretches.push_back({});
          end_s = prediction.time_s[k] + stretch_s;
        }
        const auto square = [&](double model) { return square_of_error(model, prediction.measured[c][k]); };
        Stretch& stretch = stretches.back();
        stretch.nominal += square(nominal[p][c][k]);
        stretch.before += square(prediction.before[c][k]);
        stretch.after += square(prediction.after[c][k]);
        stretch.noise += noise[p][c] * noise[p][c];
        ++stretch.count;
      }
    }
    Stretch sum;
    for (const Stretch& s : stretches) {
      sum.nominal += s.nominal, sum.before += s.before, sum.after += s.after, sum.noise += s.noise,
          sum.count += s.count;
    }
    HeldOutError& error = result.error;
    error.samples[c] = sum.count;
    if (sum.count == 0) {
      error.nominal[c] = error.before[c] = error.after[c] = error.noise[c] = error.gain[c] = error.gain_lowest[c] =
          error.gain_highest[c] = nan;
      continue;
    }
    const auto n = static_cast<double>(sum.count);
    const auto rms = [&](double squares) { return squares < lost ? std::sqrt(squares / n) : nan; };
    error.nominal[c] = rms(sum.nominal);
    error.before[c] = rms(sum.before);
    error.after[c] = rms(sum.after);
    error.noise[c] = rms(sum.noise);
    error.gain[c] = 1.0 - error.after[c] / error.before[c];
    const sim::RandomStream chance(seed, "diagnose.gain." + std::to_string(c));
    std::vector<double> gains, differences;
    std::uint64_t index = 0;
    for (int d = 0; d < bootstrap_draws; ++d) {
      double before = 0.0, after = 0.0;
      for (std::size_t i = 0; i < stretches.size(); ++i) {
        const auto pick =
            std::min(stretches.size() - 1,
                     static_cast<std::size_t>(chance.uniform(index++) * static_cast<double>(stretches.size())));
        before += stretches[pick].before;
        after += stretches[pick].after;
      }
      gains.push_back(before > 0.0 ? 1.0 - std::sqrt(after / before) : 0.0);
      differences.push_back(before - after);
    }
    for (int d = 0; d < bootstrap_draws; ++d)
      total[static_cast<std::size_t>(d)] += differences[static_cast<std::size_t>(d)] * n / sum.noise;
    std::sort(gains.begin(), gains.end());
    error.gain_lowest[c] = gains[bootstrap_draws / 40];
    error.gain_highest[c] = gains[bootstrap_draws - 1 - bootstrap_draws / 40];
  }
  std::sort(total.begin(), total.end());
  result.lowest_gain = total[bootstrap_draws / 40];
  result.highest_gain = total[bootstrap_draws - 1 - bootstrap_draws / 40];
  return result;
}

std::vector<double> autocorrelation(const std::vector<Prediction>& predictions, std::size_t channel, bool after) {
  constexpr std::size_t step = 5, lags = 41;  // 0.5 s at 10 Hz, up to 20 s
  std::vector<double> product(lags, 0.0);
  for (const Prediction& prediction : predictions) {
    const auto residual = [&](std::size_t k) {
      return prediction.kept_back[k]
                 ? (after ? prediction.after : prediction.before)[channel][k] - prediction.measured[channel][k]
                 : nan;
    };
    for (std::size_t k = 0; k < prediction.time_s.size(); ++k)
      for (std::size_t lag = 0; lag < lags && k + lag * step < prediction.time_s.size(); ++lag) {
        const double value = residual(k) * residual(k + lag * step);
        if (!std::isnan(value)) product[lag] += value;
      }
  }
  if (product[0] > 0.0)
    for (std::size_t lag = lags; lag-- > 0;) product[lag] /= product[0];
  return product;
}

std::vector<std::size_t> added(const Explanation& explanation, const plant::Limb<double>& nominal) {
  std::vector<std::size_t> effects;
  for (const std::size_t e : explanation.effects())
    if (!nominal.on[e]) effects.push_back(e);
  return effects;
}

// Explanations by one effect alone, as the first round fitted them, that take away at least `share` of the core's
// misfit.
std::vector<std::size_t> enough_alone(const Search& search, double share) {
  std::vector<std::size_t> effects;
  for (const Candidate& candidate : search.rounds.front().candidates)
    if (candidate.explanation.usable && share_explained(search.core, candidate.explanation) >= share)
      effects.push_back(candidate.effect);
  return effects;
}

FoundEffect found(std::size_t effect, const Explanation& by, bool something_left, const Diagnosis& diagnosis,
                  const DiagnosisSettings& settings) {
  FoundEffect result{effect, 0.0, 0.0, 1.0, {}, {}};
  for (const Round& round : diagnosis.search.rounds)
    if (round.accepted && round.candidates.front().effect == effect) {
      result.gain = round.gain;
      result.chance = round.chance;
    }
  const plant::Limb<double> limb = by.limb();
  for (const std::size_t p : plant::effects()[effect].parameters) {
    const auto& declared = plant::parameters()[p].declaration;
    const double value = plant::get_in_file_units(limb, p), unit = declared.unit.internal_per_unit;
    FoundEffect::Parameter parameter{p, value, value, value, true};
    for (std::size_t u = 0; u < by.problem->parameters().size(); ++u)
      if (by.problem->parameters()[u] == p) {
        const double error = two_sided_95 * by.deviation(u) / unit;
        parameter = {p, value, std::max(declared.range.lowest, value - error),
                     std::min(declared.range.highest, value + error), false};
      }
    result.parameters.push_back(parameter);
  }
  if (const auto rivals = diagnosis.search.rivals.find(effect); rivals != diagnosis.search.rivals.end())
    result.rivals = rivals->second;
  double others = 1.0;
  for (const auto& [rival, loss] : result.rivals) others += std::exp(-std::clamp(loss, -50.0, 700.0));
  result.confidence = (1.0 - result.chance) / others * result.gain / (result.gain + settings.doubtful_gain);
  if (something_left) result.confidence *= settings.most_confidence_in_a_form * diagnosis.explained_share;
  else if (diagnosis.by_chance) result.confidence *= diagnosis.explained_share;
  return result;
}

// An effect whose strength is no constant, so that no parameter of it has a value.
FoundEffect found(const Wandering& wandering, const DiagnosisSettings& settings) {
  FoundEffect result{wandering.of.effect, 0.0, 2.0 * wandering.gain, std::erfc(std::sqrt(wandering.gain)), {}, {}};
  double likely = 1.0;
  for (const auto& [other, loss] : wandering.others) {
    likely += std::exp(-std::max(0.0, loss));
    if (other.effect != plant::no_effect) result.rivals.emplace_back(other.effect, loss);
  }
  result.confidence = settings.most_confidence_in_a_lead * wandering.explained_share / likely * result.gain /
                      (result.gain + settings.doubtful_gain);
  return result;
}

}  // namespace

std::string_view text_of(Verdict verdict) {
  switch (verdict) {
    case Verdict::consistent:
      return "consistent";
    case Verdict::missing_physics:
      return "missing_physics";
    case Verdict::unexplained:
      return "unexplained";
  }
  return "";
}

Parsimony parsimony_of(const std::vector<std::size_t>& effects, const Search& search, bool something_left,
                       const DiagnosisSettings& settings) {
  Parsimony result;
  const auto among = [](const std::vector<std::size_t>& all, std::size_t e) {
    return std::find(all.begin(), all.end(), e) != all.end();
  };
  const auto others = [&](double share) {
    std::vector<std::size_t> alone = enough_alone(search, share);
    std::erase_if(alone, [&](std::size_t e) { return among(effects, e); });
    return alone;
  };
  if (something_left) result.as_good = others(settings.least_explained_share);
  if (effects.size() == 2) {
    result.patched = something_left;
    const std::vector<std::size_t> most = enough_alone(search, settings.named_share),
                                   nearly_all = enough_alone(search, settings.least_explained_share);
    result.either_alone = among(most, effects[0]) && among(most, effects[1]) &&
                          (among(nearly_all, effects[0]) || among(nearly_all, effects[1]));
  }
  // Both kinds of sensor off at once is a coincidence, unless something before both is; also where the second was accepted
  // on the way but did not make it into the answer.
  std::vector<std::size_t> accepted = effects;
  for (const Round& round : search.rounds)
    if (round.accepted) accepted.push_back(round.candidates.front().effect);
  const auto at = [&](plant::Place place) {
    return std::any_of(accepted.begin(), accepted.end(),
                       [&](std::size_t e) { return plant::effects()[e].place == place; });
  };
  const auto is_sensor = [](std::size_t e) {
    const plant::Place place = plant::effects()[e].place;
    return place == plant::Place::sensor_temperature || place == plant::Place::sensor_angle;
  };
  if (std::all_of(effects.begin(), effects.end(), is_sensor) && at(plant::Place::sensor_temperature) &&
      at(plant::Place::sensor_angle)) {
    result.common_causes = others(settings.named_share);
    std::erase_if(result.common_causes, is_sensor);
  }
  return result;
}

Diagnosis diagnose(const plant::Limb<double>& nominal, const std::vector<sim::Recording>& training,
                   const std::vector<sim::Recording>& held_out, const DiagnosisSettings& settings) {
  if (training.empty()) throw std::invalid_argument("a diagnosis needs a recording");
  Diagnosis result;
  const PerChannel* given_noise = settings.noise ? &*settings.noise : nullptr;
  std::vector<sim::Recording> gated_training, gated_held_out;
  for (const auto* recordings : {&training, &held_out})
    for (const sim::Recording& recording : *recordings) {
      result.gate.emplace_back();
      (recordings == &training ? gated_training : gated_held_out)
          .push_back(gated(recording, given_noise, result.gate.back()));
    }
  const auto kept = std::make_shared<std::vector<Split>>();
  std::vector<Split>& splits = *kept;
  result.kept_alive = kept;
  for (const sim::Recording& recording : gated_training)
    splits.push_back(split(recording, settings.fit_until_s, held_out.empty()));
  std::vector<FitData> data;
  for (std::size_t r = 0; r < splits.size(); ++r)
    data.push_back({&splits[r].fitted, splits[r].sample_count, result.gate[r].noise});

  SearchSettings search_settings = settings.search;
  search_settings.fit.start = settings.start;
  const plant::Limb<double> given =
      with_signs_of(nominal, data, settings.start, search_settings.fit.numerics, result.flipped_signs);
  result.search = search(given, data, search_settings);
  const Explanation& core = result.search.core;
  result.visibility = std::sqrt(std::max(0.0, core.misfit));

  Explanation answer = chosen(result.search, settings);
  result.explained_share = share_explained(core, answer);

  // The data kept back: core and answer, each from the recording's duty alone.
  const auto& numerics = search_settings.fit.numerics;
  std::vector<Series> nominal_model;
  std::vector<PerChannel> noise;
  const auto path_of = [&](const Explanation& explanation) {
    return explanation.unrest < search_settings.visible_unrest ? fitted(explanation)
                                                               : polished(explanation, data, search_settings.fit);
  };
  const Fitted before = path_of(core);
  Fitted after_fit = answer.effects() == core.effects() ? before : path_of(answer);
  const auto predictions_of = [&](const Fitted& first, const Fitted& second) {
    std::vector<Prediction> predictions;
    nominal_model.clear();
    noise.clear();
    const auto add = [&](const sim::Recording& original, const sim::Recording& clean, std::vector<bool> kept_back,
                         bool is_training, const std::array<plant::Start, 3>& starts, const PerChannel& sensor_noise) {
      Prediction prediction;
      prediction.recording = &original;
      prediction.training = is_training;
      prediction.kept_back = std::move(kept_back);
      for (const sim::Sample& sample : clean.samples) {
        prediction.time_s.push_back(sample.time_s);
        for (std::size_t c = 0; c < channel_count; ++c) prediction.measured[c].push_back(measured(sample, c));
      }
      prediction.before = predict(first.limb, starts[1], clean, numerics);
      prediction.after = predict(second.limb, starts[2], clean, numerics);
      nominal_model.push_back(predict(given, starts[0], clean, numerics));
      noise.push_back(sensor_noise);
      predictions.push_back(std::move(prediction));
    };
    for (std::size_t r = 0; r < training.size(); ++r) {
      // The nominal plant begins as the calibrated one does, but for states that it shares with it.
      add(training[r], gated_training[r], splits[r].kept_back, true,
          {before.starts[r], first.starts[r], second.starts[r]}, result.gate[r].noise);
    }
    for (std::size_t r = 0; r < held_out.size(); ++r) {
      const PerChannel& sensors = result.gate[training.size() + r].noise;
      const sim::Recording& clean = gated_held_out[r];
      std::vector<bool> kept_back(clean.samples.size());
      for (std::size_t k = 0; k < kept_back.size(); ++k)
        kept_back[k] = settings.start == StartPolicy::at_rest ||
                       clean.samples[k].time_s >= clean.samples.front().time_s + settling_s;
      add(held_out[r], clean, kept_back, false,
          {start_of(given, clean, sensors, search_settings.fit),
           start_of(first.limb, clean, sensors, search_settings.fit),
           start_of(second.limb, clean, sensors, search_settings.fit)},
          sensors);
    }
    return predictions;
  };
  result.predictions = predictions_of(before, after_fit);
  Scored scored = score_kept_back(result.predictions, nominal_model, noise, settings.search.seed);

  // Back to the core: what was found is not the answer.
  std::vector<std::size_t> effects = added(answer, given);
  const auto drop = [&] {
    answer = core;
    after_fit = before;
    effects.clear();
    result.by_chance.reset();
    for (Prediction& prediction : result.predictions) prediction.after = prediction.before;
    scored = score_kept_back(result.predictions, nominal_model, noise, settings.search.seed);
  };
  // Where no explanation is one: what brings the whole path nearer, beyond chance where it was not fitted. It is
  // certain where it brings a channel most of the way without parameters that are hard to believe. More is missing even
  // so.
  const auto take_lead = [&] {
    const PathSearch paths{search_settings.without, search_settings.most_effects, search_settings.least_gain,
                           search_settings.threads};
    const Lead lead = follow_paths(before, data, paths, search_settings.fit);
    if (lead.effects.empty()) return;
    const Agreement was = agreement_of(before.of, before, data, numerics),
                    is = agreement_of(lead.path.of, lead.path, data, numerics);
    const PerChannel& sensors = result.gate.front().noise;
    double largest_share = 0.0, sum = 0.0, channels_off = 0.0;
    for (std::size_t c = 0; c < channel_count; ++c) {
      if (!far_off(was.rmse[c], c, sensors, settings)) continue;
      const double share = 1.0 - share_left(was.rmse[c], is.rmse[c], sensors[c]);
      largest_share = std::max(largest_share, share);
      sum += std::max(0.0, share);
      ++channels_off;
    }
    const bool believable =
        is.pull <= settings.most_growth_of_pull * was.pull &&
        std::all_of(lead.effects.begin(), lead.effects.end(), [&](std::size_t e) { return sensible(e, lead.path.of); });
    const bool certain = largest_share >= settings.named_share && believable;
    // As a stand-in it must do better than the one there is.
    if (!certain && !effects.empty() &&
        !better_beyond_chance(cross_validated(after_fit, data, search_settings.threads, search_settings.fit),
                              cross_validated(lead.path, data, search_settings.threads, search_settings.fit)))
      return;
    const std::vector<Prediction> predictions = predictions_of(before, lead.path);
    const Scored kept_back = score_kept_back(predictions, nominal_model, noise, settings.search.seed);
    if (kept_back.highest_gain < 0.0) return;  // the veto of the data kept back
    result.by_chance.reset();
    answer = lead.path.of;
    after_fit = lead.path;
    effects = lead.effects;
    result.predictions = predictions;
    scored = kept_back;
    if (!certain) return;
    result.explained_share = sum / channels_off;
    result.by_paths = true;
    result.agreement_before = was;
    result.agreement_after = is;
    for (std::size_t i = 0; i < effects.size(); ++i) {
      FoundEffect one = found(effects[i], answer, true, result, settings);
      one.gain = lead.gains[i];
      one.chance = std::erfc(std::sqrt(0.5 * one.gain));
      one.confidence = settings.most_confidence_in_a_lead * one.gain / (one.gain + settings.doubtful_gain);
      result.effects.push_back(one);
    }
  };
  result.agreement_before = agreement_of(core, before, data, numerics);
  result.agreement_after = agreement_of(answer, after_fit, data, numerics);
  // An effect that makes it worse where it was not fitted is none. Air that moves differently there can hide a gain
  // that is beyond doubt where it was fitted, so worse must be worse beyond chance.
  if (!effects.empty() && scored.highest_gain < 0.0) {
    drop();
    result.objections.worse_on_kept_back = true;
  }
  bool something_left = true;
  // Whether an explanation leaves more than there is where nothing is missing.
  const auto leaves_something = [&](const Explanation& explanation, double limit) {
    if (explanation.unrest < limit) return false;
    if (explanation.unrest >= settings.certain_unrest) return true;
    if (search_settings.progress) search_settings.progress(0.98, "asking how much is left by chance");
    result.by_chance =
        unrest_by_chance(explanation, data, search_settings.threads, search_settings.seed, search_settings.fit);
    return result.by_chance->as_large == 0;
  };
  if (effects.empty()) {
    result.verdict = leaves_something(core, search_settings.visible_unrest) ? Verdict::unexplained : Verdict::consistent;
  } else {
    const bool explains = result.explained_share >= settings.least_explained_share;
    something_left =
        leaves_something(answer, explains ? as_good_as_nothing(core, search_settings) : search_settings.visible_unrest);
    result.objections = objections_to(answer, effects, result, something_left, settings, result.gate.front().noise);
    result.verdict = result.objections.none() ? Verdict::missing_physics : Verdict::unexplained;
    // What was accepted on the way to an explanation that explains little is not certain.
    Objections rest = result.objections;
    rest.leaves_too_much = rest.leaves_too_much && result.explained_share < settings.named_share;
    if (rest.none())
      for (const std::size_t e : effects)
        result.effects.push_back(found(e, answer, something_left, result, settings));
    else if (scored.lowest_gain <= 0.0 || std::any_of(scored.error.gain_highest.begin(), scored.error.gain_highest.end(),
                                                      [](double gain) { return gain < 0.0; }))
      drop();  // what predicts better even so, and no channel worse, stays as a stand-in, without a name
  }
  if (result.verdict == Verdict::unexplained && result.effects.empty()) take_lead();
  if (answer.effects() == core.effects()) result.explained_share = 0.0;
  result.held_out = scored.error;
  for (std::size_t c = 0; c < channel_count; ++c) {
    result.correlation.before[c] = autocorrelation(result.predictions, c, false);
    result.correlation.after[c] = autocorrelation(result.predictions, c, true);
  }

  std::stable_sort(result.effects.begin(), result.effects.end(),
                   [](const FoundEffect& a, const FoundEffect& b) { return a.gain > b.gain; });
  for (const FoundEffect& effect : result.effects)
    for (const auto& [rival, loss] : effect.rivals)
      if (loss < settings.ambiguous_loss &&
          std::find(result.ambiguous_with.begin(), result.ambiguous_with.end(), rival) == result.ambiguous_with.end() &&
          std::none_of(effects.begin(), effects.end(), [&, r = rival](std::size_t e) { return e == r; }))
        result.ambiguous_with.push_back(rival);
  if (!result.effects.empty()) {
    // What paths suggest is no more than that; but a cause before both sensors would explain those as well.
    result.parsimony = parsimony_of(effects, result.search, something_left && !result.by_paths, settings);
    if (result.by_paths) result.parsimony.either_alone = false;
    if (!result.parsimony.none())
      for (FoundEffect& effect : result.effects) effect.confidence *= 0.5;
    for (const auto* rivals : {&result.parsimony.as_good, &result.parsimony.common_causes})
      for (const std::size_t e : *rivals)
        if (std::find(result.ambiguous_with.begin(), result.ambiguous_with.end(), e) == result.ambiguous_with.end())
          result.ambiguous_with.push_back(e);
  }

  std::optional<Wandering> wandering;
  if (result.verdict == Verdict::unexplained && (result.effects.empty() || result.by_paths)) {
    if (search_settings.progress) search_settings.progress(0.99, "asking what is no constant");
    WanderSettings wander = settings.wander;
    wander.without = search_settings.without;
    wander.threads = search_settings.threads;
    wander.temperatures_are_off = false;
    for (const std::size_t c : {0, 1})
      wander.temperatures_are_off = wander.temperatures_are_off ||
                                    far_off(result.agreement_before.rmse[c], c, result.gate.front().noise, settings);
    wandering = what_wanders(core, wander, search_settings.fit);
    if (!result.by_paths) result.wandering = wandering;
    if (result.wandering && result.wandering->of.effect != plant::no_effect &&
        result.wandering->explained_share >= settings.named_share) {
      result.effects.push_back(found(*result.wandering, settings));
      for (const auto& [rival, loss] : result.effects.front().rivals)
        if (loss < settings.ambiguous_loss) result.ambiguous_with.push_back(rival);
    }
  }
  result.located = locate(core, gated_training, search_settings.fit.most_air_K, settings.search.seed);
  const Forcing forcing = result.located.shares.front().forcing;
  if (result.verdict == Verdict::unexplained)
    result.left_over = left_over(result.effects.empty() || result.wandering ? core : answer, forcing, search_settings.fit.most_air_K);
  if (result.wandering) {
    result.located.place = plant::text_of(result.wandering->of.place);
    auto& group = result.located.cannot_be_told_from;
    group.clear();
    for (const auto& [other, loss] : result.wandering->others)
      if (const std::string place(plant::text_of(other.place));
          loss < settings.other_place_loss && place != result.located.place &&
          std::find(group.begin(), group.end(), place) == group.end())
        group.push_back(place);
  } else if (!result.effects.empty()) {
    result.located.place = plant::text_of(plant::effects()[result.effects.front().effect].place);
    // A name's place is its effect's; but what paths alone suggest is as often a look-alike, which may act elsewhere.
    auto& group = result.located.cannot_be_told_from;
    group.clear();
    if (wandering)
      if (const std::string other(plant::text_of(wandering->of.place)); other != result.located.place)
        group.push_back(other);
  } else if (result.verdict == Verdict::unexplained) {
    const std::vector<std::string> places = places_of(forcing);
    // Heat that depends on the duty comes from the supply's side.
    const bool actuation = forcing == Forcing::heat && result.left_over.variable.starts_with("duty");
    result.located.place = places[actuation ? 1 : 0];
    if (places.size() > 1) result.located.cannot_be_told_from.push_back(places[actuation ? 0 : 1]);
    // What moves the angle alone could sit in the coils, the beam or the bend sensor: without a law none of them is
    // excluded.
    constexpr std::array angle_alone{Forcing::moment, Forcing::angle_reading, Forcing::transformation};
    if (std::find(angle_alone.begin(), angle_alone.end(), forcing) != angle_alone.end())
      for (const Forcing other : angle_alone)
        if (const std::string place = places_of(other).front(); place != result.located.place)
          result.located.cannot_be_told_from.push_back(place);
    auto& group = result.located.cannot_be_told_from;
    std::sort(group.begin(), group.end());
    group.erase(std::unique(group.begin(), group.end()), group.end());
    std::erase(group, result.located.place);
  }

  for (const std::size_t s : result.search.rounds.back().scores.best) {
    const Score& score = result.search.rounds.back().scores.all[s];
    if (answer.limb().on[score.effect]) continue;
    const auto& declared = plant::parameters()[plant::effects()[score.effect].strength].declaration;
    const double typical = std::abs(declared.typical - declared.null_value.value_or(0.0));
    Visibility visibility{score.effect, score.visible_share, score.smallest_seen / declared.unit.internal_per_unit,
                          score.statistic, false};
    visibility.can_be_seen = score.smallest_seen > 0.0 && visibility.smallest_seen <= typical;
    result.others.push_back(visibility);
  }
  if (!result.ambiguous_with.empty() && !result.wandering) {
    const std::size_t effect = result.effects.front().effect, rival = result.ambiguous_with.front();
    for (const Round& round : result.search.rounds)
      for (const Candidate& candidate : round.candidates)
        if (candidate.effect == rival && candidate.explanation.usable && !result.experiment) {
          result.experiment = design_experiment(answer, candidate.explanation, result.gate.front().noise, 0.3, {});
          result.experiment->effect = effect;
          result.experiment->rival = rival;
        }
  }
  result.answer = answer;
  result.repaired = after_fit.limb;
  result.starts = after_fit.starts;
  return result;
}

}  // namespace sinew::diagnose

// SPDX-License-Identifier: Apache-2.0
#include "diagnose/diagnosis.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>
#include <tuple>

#include "diagnose/calibrate.h"
#include "plant/apart.h"
#include "plant/contains.h"
#include "sim/parallel.h"

namespace sinew::diagnose {
namespace {

constexpr double two_sided_95 = 1.959964;
constexpr std::size_t most_samples_at_once = 50'000;  // each fit of an open-loop simulation keeps its path: memory
constexpr std::size_t most_taken_up = 3;              // of a round's explanations, by open-loop simulation

Agreement agreement_of(const Explanation& explanation, const Fitted& path, const std::vector<FitData>& data,
                       const plant::NumericalSettings& numerics) {
  Agreement result;
  const Spread spread = spread_of(path, data, numerics);
  const plant::System& system = explanation.system();
  result.rmse = per_channel(system);
  for (const plant::ChannelId c : result.rmse.ids()) {
    double sum = 0.0, count = 0.0;
    for (std::size_t r = 0; r < data.size(); ++r) {
      sum += spread.count[r][c] * std::pow(spread.rmse[r][c], 2);
      count += spread.count[r][c];
    }
    result.rmse[c] = count > 0.0 ? std::sqrt(sum / count) : spread.rmse.front()[c];
  }
  for (std::size_t u = 0; u < explanation.problem->parameters().size(); ++u) {
    if (system.parameters()[explanation.problem->parameters()[u]].effect) continue;
    const double z = explanation.z(static_cast<Eigen::Index>(u));
    result.pull += z * z;
  }
  return result;
}

// Names that it adds; not its laws.
std::vector<plant::EffectId> added(const Explanation& explanation, const plant::Plant& nominal) {
  std::vector<plant::EffectId> effects;
  for (const plant::EffectId e : explanation.effects())
    if (explanation.system().effects()[e].is_of_catalogue() && !nominal.is_on(e)) effects.push_back(e);
  return effects;
}

// The values that an explanation gives an effect.
std::vector<FoundEffect::Parameter> values_of(plant::EffectId effect, const Explanation& by) {
  std::vector<FoundEffect::Parameter> result;
  const plant::Plant model = by.model();
  for (const plant::ParameterId p : by.system().effects()[effect].parameters) {
    const auto& declared = by.system().parameters()[p].declaration;
    const double value = model.get_in_file_units(p), unit = declared.unit.internal_per_unit;
    FoundEffect::Parameter parameter{p, value, value, value, true, 0.0};
    for (std::size_t u = 0; u < by.problem->parameters().size(); ++u)
      if (by.problem->parameters()[u] == p) {
        const auto [lowest, highest] = by.interval(u, two_sided_95);
        parameter = {p,
                     value,
                     std::max(declared.range.lowest, lowest / unit),
                     std::min(declared.range.highest, highest / unit),
                     false,
                     by.z(static_cast<Eigen::Index>(u))};
      }
    result.push_back(parameter);
  }
  return result;
}

// Values of parts that differ. Errors of shared value and weight go together as the fit says.
std::vector<FoundApart::Value> values_apart_in(plant::EffectId effect, const Explanation& by) {
  const plant::System& system = by.system();
  const auto& fitted = by.problem->parameters();
  const auto unknown_of = [&](plant::ParameterId p) {
    return static_cast<std::size_t>(std::find(fitted.begin(), fitted.end(), p) - fitted.begin());
  };
  std::vector<FoundApart::Value> result;
  for (const plant::ApartValue& one : plant::values_apart(by.model(), effect)) {
    const auto& declared = system.parameters()[one.shared].declaration;
    Eigen::VectorXd slope = Eigen::VectorXd::Zero(by.z.size());
    for (const auto& [p, by_it] : {std::pair(one.shared, one.by_shared), std::pair(one.weight, one.by_weight)})
      if (const std::size_t u = unknown_of(p); u < fitted.size())
        slope(static_cast<Eigen::Index>(u)) = by_it * by.problem->unknowns()[u].slope_at(by.z(static_cast<Eigen::Index>(u)));
    const double deviation = std::sqrt(std::max(0.0, slope.dot(by.covariance * slope))), unit = declared.unit.internal_per_unit;
    const auto allowed = [&](double internal) { return std::clamp(internal / unit, declared.range.lowest, declared.range.highest); };
    result.push_back({one.shared, one.part, allowed(one.value), allowed(one.value - two_sided_95 * deviation),
                      allowed(one.value + two_sided_95 * deviation)});
  }
  return result;
}

// Than is typical of it: Support::faint.
double decades_weaker(const FoundEffect& found, const plant::System& system) {
  const plant::EffectInfo& effect = system.effects()[found.effect];
  double most = 0.0;
  for (const FoundEffect::Parameter& one : found.parameters) {
    if (one.parameter != effect.strength && !contains(effect.own_strengths, one.parameter)) continue;
    const plant::Declaration& declared = system.parameters()[one.parameter].declaration;
    const double null = declared.null_value.value_or(0.0), typical = std::abs(declared.typical - null);
    if (typical > 0.0) most = std::max(most, std::log10(typical / std::max(std::abs(one.value - null), 1e-6 * typical)));
  }
  return most;
}

// Support::unbelieved.
double deviations_squared(const FoundEffect& found, const plant::System& system) {
  double sum = 0.0;
  for (const FoundEffect::Parameter& one : found.parameters)
    if (one.parameter != system.effects()[found.effect].strength && plant::is_positive(system.parameters()[one.parameter].declaration))
      sum += one.from_belief * one.from_belief;
  return sum;
}

// Than it is believed of parts that are not alike, whose weights have a deviation of 1 (plant/apart.h).
double decades_nearer(plant::EffectId apart, const plant::Plant& plant) {
  std::map<plant::ParameterId, std::vector<double>> by_quantity;
  for (const plant::ApartValue& one : plant::values_apart(plant, apart)) by_quantity[one.shared].push_back(plant.get(one.weight));
  double widest = 1e-6;
  for (const auto& [shared, of] : by_quantity) {
    const auto count = static_cast<double>(of.size());
    const double mean = std::accumulate(of.begin(), of.end(), 0.0) / count;
    double sum = 0.0;
    for (const double w : of) sum += (w - mean) * (w - mean);
    widest = std::max(widest, std::sqrt(sum / (count - 1.0)));
  }
  return std::max(0.0, -std::log10(widest));
}

// One diagnosis, step by step. `result_.chosen` is what stands for the time being, `after_` its path.
class Diagnoser {
 public:
  Diagnoser(const plant::Plant& nominal, const std::vector<sim::Recording>& training, const std::vector<sim::Recording>& held_out,
            const DiagnosisSettings& settings)
      : training_(training), held_out_(held_out), settings_(settings), search_(settings.search), given_(nominal) {
    gate();
    search_.fit.start = settings.start;
    if (!search_.fit.start.counted_from_s) search_.fit.start.counted_from_s = gated_training_.front().begins_s();
    given_ = with_signs_of(nominal, data_, search_.fit.start, search_.fit.numerics, result_.flipped_signs);
    search_.is_borne_out = [this](const Explanation& with, const Explanation& without) {
      std::vector<Prediction> predictions = measured_predictions();
      const auto [before, after] = paths_of(without, with);
      const std::vector<Series> predicted = predicted_by(before);
      for (std::size_t p = 0; p < predictions.size(); ++p)
        predictions[p].nominal = predictions[p].fitted = predictions[p].before = predicted[p];
      set_after(predictions, predicted_by(after));
      return judged(std::move(predictions)).highest_total_gain >= 0.0;
    };
  }

  Diagnosis run() {
    result_.search = search(given_, data_, search_);
    result_.visibility = std::sqrt(std::max(0.0, core().misfit));
    result_.chosen = chosen(result_.search, search_, settings_.thresholds);
    result_.explained_share = share_explained(core(), result_.chosen);
    if (result_.chosen.effects() == core().effects())
      before_ = after_ = path_of(core());
    else
      std::tie(before_, after_) = paths_of(core(), result_.chosen);
    effects_ = added(result_.chosen, given_);
    laws_ = laws_of(result_.chosen, core());
    for (const plant::EffectId e : result_.chosen.effects())
      if (result_.chosen.system().effects()[e].sharing) found_.apart.push_back({.effect = e, .log_odds = result_.search.apart_log_odds});
    given_ = plant::carried_into(given_, result_.chosen.problem->centres().shared_system());
    predict_all();
    judge();
    const bool nothing_said = found_.effects.empty() && laws_.empty() && found_.apart.empty();
    if (nothing_said && (!effects_.empty() || leaves_something_)) propose_whole_paths();
    if (result_.chosen.effects() == core().effects()) result_.explained_share = 0.0;
    calibrate_as_given();
    result_.values = after_.of.problem == result_.chosen.problem ? result_.chosen : as_fitted(after_, data_, search_.fit);
    for (FoundEffect& found : found_.effects)
      if (found.form != Form::free) found.parameters = values_of(found.effect, result_.values);
    for (FoundApart& found : found_.apart) found.values = values_apart_in(found.effect, result_.values);
    result_.correlation = correlation_of(result_.predictions);
    believe();
    doubt();
    design();
    result_.answer = decide(system(), std::move(found_), !effects_.empty(), leaves_something_ || dropped_);
    const std::optional<Wandering> wandering = ask_what_wanders();
    place(wandering);
    list_others();
    result_.repaired = plant::carried_into(after_.model, given_.shared_system());
    result_.starts = after_.starts;
    for (std::size_t r = 0; r < held_out_.size(); ++r) result_.starts.push_back(start_there(after_.model, r));
    result_.kept_alive = splits_;
    return std::move(result_);
  }

 private:
  const Explanation& core() const { return result_.search.core; }
  const plant::System& system() const { return given_.system(); }
  const plant::NumericalSettings& numerics() const { return search_.fit.numerics; }
  const PerChannel& sensors() const { return result_.gate.front().noise; }
  void tell(double share, const std::string& doing) const {
    if (search_.progress) search_.progress(share, doing);
  }

  void gate() {
    const PerChannel* given_noise = settings_.noise ? &*settings_.noise : nullptr;
    for (const auto* recordings : {&training_, &held_out_})
      for (const sim::Recording& recording : *recordings) {
        result_.gate.emplace_back();
        (recordings == &training_ ? gated_training_ : gated_held_out_)
            .push_back(gated(system(), recording, given_noise, result_.gate.back()));
      }
    std::vector<FitData> fitted;
    bool whole = true;  // every training recording is fitted to its end
    for (std::size_t r = 0; r < gated_training_.size(); ++r) {
      const sim::Recording& recording = gated_training_[r];
      fitted.push_back({&recording, samples_until(recording, settings_.fit_until_s), result_.gate[r].noise});
      whole = whole && fitted.back().sample_count == recording.samples.size();
    }
    for (const sim::Recording& recording : gated_held_out_) result_.driven_more.push_back(driven_more(system(), recording, fitted));
    const auto judges = [](const std::vector<plant::InputId>& more) { return more.empty(); };
    result_.judged_on_blocks = !held_out_.empty() && whole && std::none_of(result_.driven_more.begin(), result_.driven_more.end(), judges);
    const bool keep_blocks = held_out_.empty() || result_.judged_on_blocks;
    for (const sim::Recording& recording : gated_training_) splits_->push_back(split(recording, settings_.fit_until_s, keep_blocks));
    for (std::size_t r = 0; r < splits_->size(); ++r)
      data_.push_back({&(*splits_)[r].fitted, (*splits_)[r].sample_count, result_.gate[r].noise});
  }

  // Where an explanation leaves something its forcings carry it, and its path must be fitted by itself.
  Fitted path_of(const Explanation& explanation) const {
    return explanation.process_noise < search_.visible_process_noise ? fitted(explanation) : polished(explanation, data_, search_.fit);
  }

  int threads_for_paths() const {
    std::size_t samples = 0;
    for (const FitData& one : data_) samples += one.sample_count;
    return samples < most_samples_at_once ? search_.threads : 1;
  }

  std::pair<Fitted, Fitted> paths_of(const Explanation& one, const Explanation& other) const {
    std::pair<Fitted, Fitted> paths;
    sim::in_parallel(2, threads_for_paths(), [&](std::size_t i) { (i == 0 ? paths.first : paths.second) = path_of(i == 0 ? one : other); });
    return paths;
  }

  plant::Start start_there(const plant::Plant& plant, std::size_t held_out) const {
    return start_of(plant, gated_held_out_[held_out], result_.gate[training_.size() + held_out].noise, search_.fit);
  }

  // Of every recording, training ones first, each from its inputs alone.
  std::vector<Series> predicted_by(const Fitted& path) const {
    std::vector<Series> models;
    for (std::size_t r = 0; r < training_.size(); ++r)
      models.push_back(predict(path.model, path.starts[r], gated_training_[r], numerics()));
    for (std::size_t r = 0; r < held_out_.size(); ++r)
      models.push_back(predict(path.model, start_there(path.model, r), gated_held_out_[r], numerics()));
    return models;
  }

  // Of every recording what was measured, and what of it is held out; no model yet.
  std::vector<Prediction> measured_predictions() const {
    std::vector<Prediction> predictions;
    const auto add = [&](const sim::Recording& original, const sim::Recording& clean) {
      const std::size_t r = predictions.size();
      Prediction prediction;
      prediction.recording = &original;
      prediction.training = r < training_.size();
      prediction.noise = result_.gate[r].noise;
      prediction.measured = Series(system().channels().size(), {});
      for (const sim::Sample& sample : clean.samples) {
        prediction.time_s.push_back(sample.time_s);
        for (const plant::ChannelId c : prediction.measured.ids()) prediction.measured[c].push_back(measured(sample, c));
        const bool settled = sample.time_s >= clean.samples.front().time_s + settling_s;
        prediction.held_out.push_back(!prediction.training && (settled || settings_.start == StartPolicy::at_rest));
      }
      if (prediction.training) prediction.held_out = prediction.not_fitted = (*splits_)[r].held_out;
      // Errors are said of what was asked to be held out.
      if (prediction.training && result_.judged_on_blocks) prediction.held_out.assign(prediction.held_out.size(), false);
      predictions.push_back(std::move(prediction));
    };
    for (std::size_t r = 0; r < training_.size(); ++r) add(training_[r], gated_training_[r]);
    for (std::size_t r = 0; r < held_out_.size(); ++r) add(held_out_[r], gated_held_out_[r]);
    return predictions;
  }

  void predict_all() {
    const std::vector<Series> before = predicted_by(before_);
    result_.predictions = measured_predictions();
    for (std::size_t p = 0; p < result_.predictions.size(); ++p) {
      // The nominal plant begins as the calibrated one does, but for states that it shares with it.
      const bool training = p < training_.size();
      const std::size_t r = training ? p : p - training_.size();
      result_.predictions[p].nominal = predict(given_, training ? before_.starts[r] : start_there(given_, r),
                                               training ? gated_training_[r] : gated_held_out_[r], numerics());
      result_.predictions[p].fitted = result_.predictions[p].before = before[p];
    }
    set_after(result_.predictions, nothing_found() ? before : predicted_by(after_));
    score_held_out();
  }

  static void set_after(std::vector<Prediction>& predictions, const std::vector<Series>& models) {
    for (std::size_t p = 0; p < predictions.size(); ++p) predictions[p].after = models[p];
  }
  // By what may object: not by recordings that drive more than training, but where no other is left by the blocks that were not fitted.
  HeldOutError judged(std::vector<Prediction> predictions) const {
    for (std::size_t p = 0; p < predictions.size(); ++p) {
      std::vector<bool>& held_out = predictions[p].held_out;
      if (p < training_.size())
        held_out = (*splits_)[p].held_out;
      else if (!result_.driven_more[p - training_.size()].empty())
        held_out.assign(held_out.size(), false);
    }
    return error_of(predictions, search_.seed);
  }
  void score_held_out() { result_.held_out = error_of(result_.predictions, search_.seed); }

  bool nothing_found() const { return effects_.empty() && laws_.empty() && found_.apart.empty(); }

  // Back to the core: what was found is not the answer.
  void drop() {
    result_.chosen = core();
    after_ = before_;
    effects_.clear();
    laws_.clear();
    found_.apart.clear();
    result_.by_chance.reset();
    result_.process_noise_after_refit.reset();
    result_.process_noise_beyond_ordinary.reset();
    for (Prediction& prediction : result_.predictions) prediction.after = prediction.before;
    score_held_out();
  }

  // Whether an explanation leaves more than there is where nothing is missing.
  bool leaves_something(const Explanation& explanation, double limit) {
    if (explanation.process_noise < limit) return false;
    result_.process_noise_beyond_ordinary = process_noise_beyond_ordinary(explanation);
    if (*result_.process_noise_beyond_ordinary < limit) return false;
    if (*result_.process_noise_beyond_ordinary >= settings_.thresholds.certain_process_noise) return true;
    tell(0.98, "asking how much is left by chance");
    result_.process_noise_after_refit = process_noise_after_refit(explanation, data_, search_.fit);
    if (*result_.process_noise_after_refit < limit) return false;
    result_.by_chance =
        process_noise_by_chance(explanation, *result_.process_noise_after_refit, data_, search_.threads, search_.seed, search_.fit);
    return result_.by_chance->as_large == 0;
  }

  void judge() {
    result_.agreement_before = agreement_of(core(), before_, data_, numerics());
    result_.agreement_after = agreement_of(result_.chosen, after_, data_, numerics());
    // An effect that makes it worse where it was not fitted is none. Air that moves differently there can hide a gain
    // that is beyond doubt where it was fitted, so worse must be worse beyond chance.
    const HeldOutError by = judged(result_.predictions);
    if (!nothing_found() && by.highest_total_gain < 0.0) {
      drop();
      result_.objections.worse_on_held_out = true;
    }
    if (nothing_found()) {
      leaves_something_ = leaves_something(core(), search_.visible_process_noise);
      return;
    }
    const bool explains = result_.explained_share >= settings_.thresholds.least_explained_share;
    leaves_something_ = leaves_something(result_.chosen, explains ? as_good_as_nothing(core(), search_) : search_.visible_process_noise);
    if (!laws_.empty()) {
      // Evidence has weighed what else was tried in the same way; what the held-out data say against it has been heard.
      result_.objections = {};
      result_.objections.leaves_too_much = leaves_something_;
      for (const plant::EffectId law : laws_) found_.laws.push_back(found_law(law, result_.chosen, result_.search.bent.front().gain));
      found_.effects = naming().named(tried_in(result_.search), settings_.thresholds.least_share);
      return;
    }
    result_.objections =
        objections_to({.answer = result_.chosen, .names = effects_, .before = result_.agreement_before, .after = result_.agreement_after},
                      leaves_something_, sensors(), search_.visible_process_noise, settings_.thresholds);
    // What was accepted on the way to an explanation that explains little is not certain.
    Objections rest = result_.objections;
    rest.leaves_too_much = rest.leaves_too_much && result_.explained_share < settings_.thresholds.named_share;
    const auto& highest = by.gain_highest;
    if (rest.none()) {
      for (const plant::EffectId e : effects_) found_.effects.push_back(found_by_evidence(e, result_.search, result_.explained_share));
      return;
    }
    // Names that predict better even so, and no channel worse, stay as a stand-in, without a name.
    if (effects_.empty() || by.lowest_total_gain <= 0.0 ||
        std::any_of(highest.begin(), highest.end(), [](double gain) { return gain < 0.0; }))
      drop();
    found_.apart.clear();
    leaves_something_ = true;  // what was gained is not explained by what was objected to
  }

  Naming naming() const {
    return {.given = given_,
            .search = result_.search,
            .without = search_.without,
            .names = effects_,
            .laws = found_.laws,
            .explained_share = result_.explained_share,
            .proposals = result_.by_paths ? &result_.proposals : nullptr};
  }

  // Where forcings leave no name that explains: what brings the open-loop simulation nearer (proposals.h), if it also predicts better,
  // beyond chance, what was left out of the fit, and the held-out data no worse.
  void propose_whole_paths() {
    std::vector<Explanation> begun;  // the best of each round of the search
    for (const Round& round : result_.search.rounds)
      for (std::size_t i = 0; i < std::min(round.candidates.size(), most_taken_up); ++i)
        if (const Explanation& one = round.candidates[i].explanation; one.usable && laws_of(one, core()).empty()) begun.push_back(one);
    const ProposalSettings ask{.without = search_.without,
                               .seed = search_.seed,
                               .threads = search_.threads,
                               .begun = std::move(begun),
                               .progress = search_.progress
                                               ? [this](double share, const std::string& doing) { tell(0.9 + 0.08 * share, doing); }
                                               : std::function<void(double, const std::string&)>{}};
    Proposals proposals = propose(before_, data_, ask, search_.fit);
    if (proposals.all.empty() || proposals.all[proposals.answer].effects.empty()) return;
    const Proposal& best = proposals.all[proposals.answer];
    const Fitted path = fitted(proposals.fit);
    std::vector<Prediction> predictions = result_.predictions;
    set_after(predictions, predicted_by(path));
    if (judged(predictions).highest_total_gain < 0.0) return;  // the veto of the held-out data
    const Agreement was = agreement_of(before_.of, before_, data_, numerics()), is = agreement_of(path.of, path, data_, numerics());
    const double share = share_taken_away(was, is);
    result_.by_chance.reset();
    result_.process_noise_after_refit.reset();
    result_.process_noise_beyond_ordinary.reset();
    result_.chosen = path.of;
    after_ = path;
    given_ = plant::carried_into(given_, proposals.system);
    std::vector<plant::EffectId> laws;
    effects_.clear();
    for (const plant::EffectId e : best.effects) {
      const plant::EffectInfo& effect = system().effects()[e];
      if (effect.sharing)
        found_.apart.push_back({.effect = e, .log_odds = odds_without(proposals, e)});
      else
        (effect.law ? laws : effects_).push_back(e);
    }
    result_.predictions = std::move(predictions);
    score_held_out();
    result_.explained_share = share;
    result_.by_paths = true;
    result_.proposals = std::move(proposals);
    result_.agreement_before = was;
    result_.agreement_after = is;
    for (const plant::EffectId e : laws) found_.laws.push_back(found_law(e, result_.proposals.fit, odds_without(result_.proposals, e)));
    found_.effects = naming().named(tried_in(result_.proposals), settings_.thresholds.least_share);
    for (FoundEffect& found : found_.effects) found.rivals = rivals_in(result_.proposals, found.effect);
  }

  // Of the squared error beyond noise: on average over the channels that are far off; of all together where none is.
  double share_taken_away(const Agreement& was, const Agreement& is) const {
    double sum = 0.0, channels_off = 0.0, beyond_was = 0.0, beyond_is = 0.0;
    for (const plant::ChannelId c : was.rmse.ids()) {
      const double noise = sensors()[c];
      const auto beyond = [&](double rmse) { return std::max(0.0, (rmse * rmse - noise * noise) / (noise * noise)); };
      beyond_was += beyond(was.rmse[c]);
      beyond_is += beyond(is.rmse[c]);
      if (!far_off(system(), was.rmse[c], c, sensors())) continue;
      sum += std::max(0.0, 1.0 - share_left(was.rmse[c], is.rmse[c], noise));
      ++channels_off;
    }
    if (channels_off > 0.0) return sum / channels_off;
    return beyond_was > 0.0 ? std::max(0.0, 1.0 - beyond_is / beyond_was) : 0.0;
  }

  bool nothing_added() const { return effects_.empty() && found_.laws.empty() && found_.apart.empty(); }

  // What the plant as given can do by the other weighting of the channels, from the same search effort. What was added must be better than
  // either, channel by channel. Where nothing was, and the plant is wrong, there is one weighting: `calibrate`'s.
  void calibrate_as_given() {
    if (nothing_added() && core().process_noise < search_.visible_process_noise) return;  // both weigh by the sensors' noise
    tell(0.985, "calibrating the plant as given");
    CalibrationSettings calibration;
    calibration.start = search_.fit.start;
    calibration.seed = search_.seed;
    calibration.threads = threads_for_paths();
    calibration.numerics = numerics();
    calibration.should_stop = search_.fit.should_stop;
    calibration.along_the_path = true;
    try {
      const Fitted path = calibrated(given_, data_, calibration);
      const std::vector<Series> models = predicted_by(path);
      for (std::size_t p = 0; p < models.size(); ++p) result_.predictions[p].calibrated = models[p];
      if (nothing_added()) {
        before_ = after_ = path;
        for (std::size_t p = 0; p < models.size(); ++p)
          result_.predictions[p].fitted = result_.predictions[p].before = result_.predictions[p].after = models[p];
      } else {
        choose_before(result_.predictions);
      }
      score_held_out();
    } catch (const std::runtime_error&) {  // nowhere could it be integrated
    }
  }

  void add_rival(plant::EffectId effect) {
    for (const auto& said : {names_of(found_.effects), found_.ambiguous_with})
      if (has_family(system(), said, effect)) return;
    found_.ambiguous_with.push_back(effect);
  }

  // What cannot be told from what was found, and whether it may be something else in another form.
  void doubt() {
    std::stable_sort(found_.effects.begin(), found_.effects.end(),
                     [](const FoundEffect& a, const FoundEffect& b) { return a.support.gain > b.support.gain; });
    if (found_.effects.empty()) return;
    for (const FoundEffect& effect : found_.effects) {
      for (const auto& [rival, loss] : effect.rivals)
        if (loss < settings_.thresholds.ambiguous_loss) add_rival(rival);
      for (const FoundLaw& law : found_.laws) {
        const auto names = naming().names_for(law.law);
        for (const auto& [mine, probability] : names)
          for (const auto& [other, of_other] : names)
            if (has_family(system(), {effect.effect}, mine) && of_other > probability * std::exp(-settings_.thresholds.ambiguous_loss))
              add_rival(other);
      }
    }
    if (names_said(system(), found_.effects, found_.laws).empty()) return;
    // What paths suggest is no more than that; but a cause before both sensors would explain those as well.
    found_.parsimony = parsimony_of(effects_, result_.search, leaves_something_ && !result_.by_paths, settings_.thresholds);
    for (const auto* rivals : {&found_.parsimony.as_good, &found_.parsimony.common_causes})
      for (const plant::EffectId e : *rivals) add_rival(e);
  }

  // How probable each find is. What is hardly believed stands in for something else, and is not said.
  void believe() {
    for (FoundEffect& found : found_.effects) {
      if (!has_law_as_form(system(), found_.laws, found.effect)) {
        found.support.faint = decades_weaker(found, system());
        found.support.unbelieved = deviations_squared(found, system());
      }
      found.support.law_beside = has_law_beside(system(), found_.laws, {found.effect});
      found.confidence = probability(found.support);
    }
    const auto hardly = [&](const auto& found) { return found.confidence < settings_.thresholds.least_share; };
    dropped_ = std::erase_if(found_.effects, hardly) > 0;
    for (FoundApart& found : found_.apart) {
      found.support = {.share = result_.explained_share / (1.0 + std::exp(-found.log_odds)),
                       .gain = 2.0 * found.log_odds,
                       .faint = decades_nearer(found.effect, result_.values.model()),
                       .law_beside = has_law_beside(system(), found_.laws, names_said(system(), found_.effects, found_.laws))};
      found.confidence = probability(found.support);
    }
    if (std::erase_if(found_.apart, hardly) > 0) dropped_ = true;
  }

  std::optional<Wandering> ask_what_wanders() {
    const bool is_unknown = std::holds_alternative<Unexplained>(result_.answer);
    if (!result_.by_paths && !is_unknown) return std::nullopt;
    tell(0.99, "asking what is no constant");
    WanderSettings wander = settings_.wander;
    wander.without = search_.without;
    wander.threads = search_.threads;
    wander.upstream_is_off = false;
    for (const plant::ChannelId c : system().channels().ids())
      wander.upstream_is_off = wander.upstream_is_off || (system().channels()[c].kind == system().upstream_kind() &&
                                                          far_off(system(), result_.agreement_before.rmse[c], c, sensors()));
    std::optional<Wandering> wandering = what_wanders(core(), wander, search_.fit);
    if (!wandering || result_.by_paths) return wandering;
    NoConstant varying{.course = *wandering};
    if (wandering->of.effect && wandering->explained_share >= settings_.thresholds.named_share) {
      varying.effects.push_back(found_wandering(*wandering, system()));
      varying.effects.back().confidence = probability(varying.effects.back().support);
      for (const auto& [rival, loss] : varying.effects.front().rivals)
        if (loss < settings_.thresholds.ambiguous_loss) varying.ambiguous_with.push_back(rival);
    }
    result_.answer = std::move(varying);
    return wandering;
  }

  void place(const std::optional<Wandering>& wandering) {
    result_.located = locate(core(), gated_training_, result_.predictions, search_.seed);
    const plant::EntryGroupId leading = result_.located.shares.front().group;
    const auto& [effects, laws] = std::tie(effects_in(result_.answer), laws_in(result_.answer));
    const auto nothing_in = [](const Answer& answer) {
      return effects_in(answer).empty() && laws_in(answer).empty() && apart_in(answer).empty();
    };
    const auto* varying = std::get_if<NoConstant>(&result_.answer);
    if (something_is_left(verdict_of(result_.answer)))
      result_.left_over = left_over(nothing_in(result_.answer) || varying ? core() : result_.chosen, leading);
    if (std::holds_alternative<NothingMissing>(result_.answer)) {  // of noise no time is the worst
      result_.located.worst = {};
      result_.located.while_words.clear();
      return;
    }
    PlaceEvidence evidence{.forcing = std::string(place_of_forcing(leading)), .forcing_speaks = result_.by_paths};
    if (!effects.empty()) {
      const FoundEffect& likeliest =
          *std::max_element(effects.begin(), effects.end(), [](const auto& a, const auto& b) { return a.confidence < b.confidence; });
      evidence.name = system().effects()[likeliest.effect].place;
      evidence.name_probability = likeliest.confidence;
    }
    for (const FoundLaw& law : laws) evidence.laws.push_back(law.place);
    if (laws.empty())
      for (const FoundApart& apart : apart_in(result_.answer)) evidence.laws.emplace_back(system().effects()[apart.effect].place);
    if (varying)
      for (const auto& [other, loss] : varying->course.others)
        if (loss < settings_.thresholds.other_place_loss) evidence.varying.emplace_back(other.place);
    if (wandering) evidence.varying.emplace(evidence.varying.begin(), wandering->of.place);
    const std::vector<std::string> said = places_said(system(), evidence);
    result_.located.place = said.front();
    result_.located.cannot_be_told_from.assign(said.begin() + 1, said.end());
  }

  // Of a group that enters in two places, the second if what is left goes with an input.
  std::string_view place_of_forcing(plant::EntryGroupId group) const {
    const auto& places = system().entry_groups()[group].places;
    const auto& variables = system().variables();
    const bool of_input = places.size() > 1 && std::any_of(variables.begin(), variables.end(), [&](const plant::VariableInfo& variable) {
                            return variable.of_inputs && variable.name == result_.left_over.variable;
                          });
    return places[of_input ? 1 : 0];
  }

  void list_others() {
    const Scores& scores = round_from(result_.search, result_.chosen).scores;
    for (const std::size_t s : scores.best) {
      const Score& score = scores.all[s];
      if (has_family(system(), result_.chosen.effects(), score.effect)) continue;
      const auto& declared = system().parameters()[system().effects()[score.effect].strength].declaration;
      const double typical = std::abs(declared.typical - declared.null_value.value_or(0.0));
      Visibility visibility{score.effect, score.visible_share, score.smallest_seen / declared.unit.internal_per_unit, score.statistic,
                            false};
      visibility.can_be_seen = score.smallest_seen > 0.0 && visibility.smallest_seen <= typical;
      result_.others.push_back(visibility);
    }
  }

  void design() {
    // Of what was found by open-loop simulation, or with a law, no explanation is at hand that has a rival in its place.
    if (found_.ambiguous_with.empty() || result_.by_paths || !found_.laws.empty()) return;
    const plant::EffectId rival = found_.ambiguous_with.front();
    // Whose rival it is: it stands in that one's place, beside the others.
    const auto owner = std::find_if(found_.effects.begin(), found_.effects.end(), [&](const FoundEffect& found) {
      return std::any_of(found.rivals.begin(), found.rivals.end(), [&](const auto& one) { return one.first == rival; });
    });
    const bool has_owner = owner != found_.effects.end();
    const plant::EffectId instead_of = (has_owner ? *owner : found_.effects.front()).effect;
    std::vector<plant::EffectId> beside;
    for (const FoundEffect& found : found_.effects)
      if (has_owner && found.effect != instead_of) beside.push_back(found.effect);
    for (const Round& round : result_.search.rounds)
      for (const Candidate& candidate : round.candidates) {
        if (found_.experiment || candidate.effect != rival || !candidate.explanation.usable) continue;
        const std::vector<plant::EffectId> of = candidate.explanation.effects();
        if (!std::all_of(beside.begin(), beside.end(), [&](plant::EffectId e) { return contains(of, e); })) continue;
        if (has_owner && contains(of, instead_of)) continue;
        found_.experiment = design_experiment(result_.chosen, candidate.explanation, sensors(), {});
        found_.experiment->effect = instead_of;
        found_.experiment->rival = rival;
      }
  }

  const std::vector<sim::Recording>&training_, &held_out_;
  const DiagnosisSettings& settings_;
  SearchSettings search_;
  plant::Plant given_;
  std::vector<sim::Recording> gated_training_, gated_held_out_;
  std::shared_ptr<std::vector<Split>> splits_ = std::make_shared<std::vector<Split>>();
  std::vector<FitData> data_;
  Fitted before_, after_;
  std::vector<plant::EffectId> effects_;  // that `result_.chosen` adds to the plant as given
  std::vector<plant::EffectId> laws_;     // beside them
  bool leaves_something_ = true;          // `result_.chosen` does
  bool dropped_ = false;                  // something of it is hardly believed
  Found found_;                           // what will be said, as far as it is known
  Diagnosis result_;
};

}  // namespace

Series predicted_at_share(const Diagnosis& diagnosis, std::size_t prediction, plant::EffectId effect, double share) {
  plant::Plant plant = diagnosis.repaired;
  const plant::EffectInfo& info = plant.system().effects()[effect];
  std::vector<plant::ParameterId> strengths = info.own_strengths;
  if (info.law)  // a sum of shapes
    strengths.assign(info.parameters.begin() + 1, info.parameters.end());
  else
    strengths.push_back(info.strength);
  for (const plant::ParameterId p : strengths) {
    const plant::Declaration& declared = plant.system().parameters()[p].declaration;
    if (declared.kind == plant::Kind::toggle) return {};
    const double null = info.law ? 0.0 : declared.null_value.value_or(0.0);
    plant.set(p, null + share * (plant.get(p) - null));
  }
  return predict(plant, diagnosis.starts[prediction], *diagnosis.predictions[prediction].recording, diagnosis.chosen.problem->numerics());
}

Diagnosis diagnose(const plant::Plant& nominal, const std::vector<sim::Recording>& training, const std::vector<sim::Recording>& held_out,
                   const DiagnosisSettings& settings) {
  if (training.empty()) throw std::invalid_argument("a diagnosis needs a recording");
  return Diagnoser(nominal, training, held_out, settings).run();
}

}  // namespace sinew::diagnose

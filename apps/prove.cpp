// SPDX-License-Identifier: Apache-2.0
// sinew prove: puts the diagnosis to the proof on concealed data that an independent generator makes.
#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <numeric>
#include <optional>

#include "apps/app.h"
#include "apps/diagnosis_json.h"
#include "apps/limb_link.h"
#include "apps/outputs.h"
#include "apps/ranks.h"
#include "diagnose/calibrate.h"
#include "diagnose/diagnosis.h"
#include "plant/contains.h"
#include "proof/baselines.h"
#include "proof/case_file.h"
#include "proof/cases.h"
#include "proof/oracle.h"
#include "proof/score_files.h"
#include "prove/series_limb.h"
#include "report/number.h"
#include "sim/input_error.h"
#include "sim/manifest.h"
#include "sim/plant_file.h"
#include "sim/text.h"

namespace sinew::apps {
namespace {

using namespace proof;

using Json = nlohmann::ordered_json;
namespace fs = std::filesystem;

struct ProveArguments {
  std::string out, plant, set = "reported";  // no plant: the paper's limb
  std::vector<std::string> families, kinds;
  int seeds = 5;
  int clean = 0;                 // 0: eight for each seed
  std::uint64_t first_seed = 0;  // 0: of the set
  int threads = usual_threads();
  double training_s = 300.0, held_out_s = 150.0;
  bool few = false, json = false, without_baselines = false, oracle = false, recordings = false, score = false, overwrite = false;
};

// Whether recordings of the limb of two segments in series are recordings of this plant: then the cases are those of that limb.
bool is_series_limb(const plant::System& system) {
  const sim::Columns columns = sim::columns_of(system);
  std::vector<std::string> names{"time_s"};
  for (const auto* part : {&columns.inputs, &columns.channels})
    for (const sim::Column& column : *part) names.push_back(column.name);
  return names == prove::series_columns();
}

sim::Recording recording_of(const std::vector<prove::SeriesSample>& samples, const std::string& name, const plant::System& system) {
  sim::Recording recording{.name = name, .columns = sim::columns_of(system)};
  for (const prove::SeriesSample& s : samples) {
    sim::Sample sample{.time_s = s.time_s,
                       .inputs = {s.duty.begin(), s.duty.end()},
                       .channels = {s.temperature_degC.begin(), s.temperature_degC.end()}};
    sample.channels.insert(sample.channels.end(), s.angle_deg.begin(), s.angle_deg.end());
    recording.samples.push_back(std::move(sample));
  }
  return recording;
}

sim::Recording recording_of(const std::vector<prove::Sample>& samples, const std::string& name) {
  sim::Recording recording{.name = name, .columns = sim::columns_of(plant::default_plant().system())};
  for (const prove::Sample& s : samples) {
    sim::Sample sample{.time_s = s.time_s,
                       .inputs = {s.duty.begin(), s.duty.end()},
                       .channels = {s.temperature_degC.begin(), s.temperature_degC.end()}};
    sample.channels.push_back(s.angle_deg);
    recording.samples.push_back(std::move(sample));
  }
  return recording;
}

Json result_of(const diagnose::Diagnosis& diagnosis) {
  const plant::System& system = diagnosis.repaired.system();
  Json result;
  result["verdict"] = diagnose::text_of(verdict_of(diagnosis.answer));
  result["effects"] = Json::array();
  for (const auto& found : effects_in(diagnosis.answer)) {
    const auto& info = system.effects()[found.effect];
    const auto& strength = system.parameters()[info.strength].declaration;
    Json effect{{"name", system.effects()[plant::family_of(system.effects(), found.effect)].name},
                {"place", info.place},
                {"confidence", found.confidence},
                {"form", diagnose::text_of(found.form)},
                {"gain", found.support.gain},
                {"support", support_json(found.support)},
                {"strength", strength.name},
                {"null", strength.null_value.value_or(0.0)}};
    effect["parameters"] = Json::object();  // none where the strength is no constant, or a law alone stands for it
    for (const auto& p : found.parameters)
      effect["parameters"][std::string(system.parameters()[p.parameter].declaration.name)] = {{"value", p.value},
                                                                                              {"ci95", {p.lowest, p.highest}},
                                                                                              {"known", p.known},
                                                                                              {"deviations_from_belief", p.from_belief}};
    result["effects"].push_back(effect);
  }
  result["ambiguous_with"] = Json::array();
  for (const plant::EffectId e : ambiguous_in(diagnosis.answer))
    result["ambiguous_with"].push_back(system.effects()[plant::family_of(system.effects(), e)].name);
  result["cannot_be_seen"] = Json::array();
  for (const auto& other : diagnosis.others)
    if (!other.can_be_seen) result["cannot_be_seen"].push_back(system.effects()[other.effect].name);
  result["located"] = {{"place", diagnosis.located.place},
                       {"or", diagnosis.located.cannot_be_told_from},
                       {"channel", system.channels()[diagnosis.located.channel].column}};
  result["bent"] = Json::array();
  for (const diagnose::Bent& one : diagnosis.search.bent) {
    const plant::System& with_laws = one.explanation.system();
    Json terms = Json::array();
    for (const plant::EffectId e : one.names) terms.push_back(system.effects()[e].name);
    for (const plant::EffectId e : one.explanation.effects())
      if (with_laws.effects()[e].law) terms.push_back(plant::law_words(with_laws, with_laws.laws()[*with_laws.effects()[e].law]));
    result["bent"].push_back(
        {{"terms", terms}, {"log_odds", one.log_odds}, {"gain", one.gain}, {"process_noise", one.explanation.process_noise}});
  }
  result["laws"] = Json::array();
  for (const auto& found : laws_in(diagnosis.answer)) result["laws"].push_back(law_json(diagnosis, found));
  result["apart"] = Json::array();
  for (const auto& found : apart_in(diagnosis.answer)) result["apart"].push_back(apart_json(diagnosis, found));
  result["visibility"] = diagnosis.visibility;
  result["explained_share"] = diagnosis.explained_share;
  result["objections"] = Json::array();
  if (diagnosis.objections.leaves_too_much) result["objections"].push_back("it leaves too much");
  for (const std::string& words : objection_words(system, diagnosis.objections)) result["objections"].push_back("it " + words);
  result["unrest"] = {diagnosis.search.core.process_noise, diagnosis.search.best.process_noise};
  if (diagnosis.by_chance) result["by_chance"] = chance_json(*diagnosis.by_chance);
  for (const auto& round : diagnosis.search.rounds)
    result["rounds"].push_back({{"best", round.candidates.empty() ? Json() : Json(system.effects()[round.candidates.front().effect].name)},
                                {"gain", round.gain},
                                {"chance", round.chance},
                                {"accepted", round.accepted}});
  for (std::size_t r = 0; r < diagnosis.search.rounds.size(); ++r)
    for (const auto& candidate : diagnosis.search.rounds[r].candidates)
      if (candidate.explanation.usable)
        result["rounds"][r]["candidates"].push_back({system.effects()[candidate.effect].name, candidate.explanation.log_evidence,
                                                     candidate.explanation.misfit, candidate.explanation.process_noise});
  const auto numbers_of = [](const std::vector<plant::EffectId>& effects) {
    std::vector<std::size_t> numbers;
    for (const plant::EffectId e : effects) numbers.push_back(e.index);
    return numbers;
  };
  for (const auto* one : {&diagnosis.search.core, &diagnosis.search.best, &diagnosis.chosen})
    result["explanations"].push_back({{"evidence", one->log_evidence},
                                      {"misfit", one->misfit},
                                      {"unrest", one->process_noise},
                                      {"forcing", one->forcing.values()},
                                      {"effects", numbers_of(one->effects())}});
  for (const auto* one : {&diagnosis.agreement_before, &diagnosis.agreement_after})
    result["agreement"].push_back({{"rmse", one->rmse.values()}, {"pull", one->pull}});
  const auto& error = diagnosis.held_out;
  result["heldout_gain"] = {error.gain_lowest.values(), error.gain_highest.values()};
  result["heldout"] = {{"before", error.before.values()},
                       {"before_by_weighting", {{"diagnose", error.fitted.values()}, {"calibrate", error.calibrated.values()}}},
                       {"after", error.after.values()},
                       {"noise", error.noise.values()}};
  result["normalised_before"] = normalised(error.before, error.noise);
  result["normalised_after"] = normalised(error.after, error.noise);
  return result;
}

std::vector<plant::EffectId> all_effects(const plant::System& system) {
  std::vector<plant::EffectId> all;
  for (const plant::EffectId e : system.effects().ids()) all.push_back(e);
  return all;
}

// What the diagnosis would reach on the held-out recording if it knew the true effects: a fit of just them, begun at the truth.
double refit_with_truth(const plant::Plant& nominal, const prove::Concealed& concealed, const std::vector<sim::Recording>& training,
                        const std::vector<sim::Recording>& held_out, diagnose::DiagnosisSettings settings) {
  const plant::System& system = nominal.system();
  plant::Plant with_truth = nominal;
  diagnose::Guess guess;
  for (const prove::TruthEffect& effect : concealed.effects) {
    with_truth = diagnose::with_effect(with_truth, system.effect(effect.name));
    for (const auto& [name, value] : effect.parameters) {
      const std::string key = effect.name + "." + name;
      guess.values[key] = value * system.parameters()[system.parameter(key)].declaration.unit.internal_per_unit;
    }
  }
  settings.search.without = all_effects(system);
  settings.search.most_laws = 0;
  settings.thresholds.certain_process_noise = 0.0;  // only the fit is wanted
  settings.search.guess = guess;
  const diagnose::Diagnosis known = diagnose::diagnose(with_truth, training, held_out, settings);
  return normalised(known.held_out.after, known.held_out.noise);
}

// A case as it was made. `truth` has core and effects; its rows are in the recordings.
struct Made {
  prove::Concealed truth;
  sim::Recording training, held_out;
};
Made make_case(const ProofCase& one, const plant::System& system) {
  if (one.series) {
    prove::SeriesConcealed concealed = prove::make_series(one.kind, one.seed, one.settings);
    prove::Concealed truth;
    truth.core_parameters = std::move(concealed.core_parameters);
    truth.effects = std::move(concealed.effects);
    return {std::move(truth), recording_of(concealed.training, "training", system), recording_of(concealed.heldout, "held out", system)};
  }
  prove::Concealed concealed = prove::make(one.kind, one.seed, one.settings);
  sim::Recording training = recording_of(concealed.training, "training"), held_out = recording_of(concealed.heldout, "held out");
  return {std::move(concealed), std::move(training), std::move(held_out)};
}

// What a case puts to any method.
struct Given {
  prove::Concealed concealed;
  std::vector<sim::Recording> training, held_out;
  diagnose::DiagnosisSettings settings;

  Given(const ProofCase& one, const plant::System& system, const std::function<bool()>& should_stop) {
    Made all = make_case(one, system);
    concealed = std::move(all.truth);
    training.push_back(std::move(all.training));
    held_out.push_back(std::move(all.held_out));
    settings.search.threads = 1;
    settings.search.fit.should_stop = should_stop;
    if (one.removed)
      for (const auto& effect : concealed.effects) settings.search.without.push_back(plant::default_plant().system().effect(effect.name));
  }
};

// What a recording shows of those samples that count, as the generator writes it.
std::vector<prove::Sample> samples_of(const diagnose::Prediction& prediction, bool held_out) {
  std::vector<prove::Sample> samples;
  for (std::size_t k = 0; k < prediction.time_s.size(); ++k) {
    const sim::Sample& row = prediction.recording->samples[k];
    const auto shown = [&](std::size_t channel) {
      return prediction.held_out[k] == held_out ? prediction.measured[plant::ChannelId{channel}][k] : std::nan("");
    };
    prove::Sample sample{row.time_s, {}, {shown(0), shown(1)}, shown(2)};
    std::copy_n(row.inputs.begin(), sample.duty.size(), sample.duty.begin());
    samples.push_back(sample);
  }
  return samples;
}

// What the generator's own law reaches (proof/oracle.h), begun at the truth, on the samples that count for the diagnosis.
Json oracle_json(const ProofCase& one, const Given& given, const diagnose::Diagnosis& diagnosis) {
  if (one.settings.disturbances.mid_motion) return {{"why_not", "the recording begins in mid-motion"}};
  OracleSettings settings{.noise = {}, .spread = {}, .should_stop = given.settings.search.fit.should_stop};
  const diagnose::PerChannel& noise = diagnosis.held_out.noise;
  std::copy_n(noise.begin(), settings.noise.size(), settings.noise.begin());
  const prove::Concealed& truth = given.concealed;
  const OracleFit fit = fit_oracle(truth.core_parameters, truth.effects, samples_of(diagnosis.predictions.front(), false), settings);
  if (fit.stopped) throw diagnose::Stopped{};
  const OracleChannels rmse = open_loop_rmse(fit, samples_of(diagnosis.predictions.back(), true));
  Json result{{"normalised", normalised(diagnose::PerChannel{std::vector<double>(rmse.begin(), rmse.end())}, noise)},
              {"rmse", rmse},
              {"converged", fit.converged},
              {"effects", Json::array()},
              {"core", fit.core_parameters}};
  for (const prove::TruthEffect& effect : fit.effects)
    result["effects"].push_back({{"name", effect.name}, {"form", effect.form}, {"parameters", effect.parameters}});
  return result;
}

Json diagnose_case(const ProofCase& one, const plant::Plant& nominal, const std::function<bool()>& should_stop) {
  const Given given(one, nominal.system(), should_stop);
  const diagnose::Diagnosis diagnosis = diagnose::diagnose(nominal, given.training, given.held_out, given.settings);
  Json result = result_of(diagnosis);
  if (one.with_baselines) result["baselines"] = baselines(diagnosis, given.settings);
  if (one.with_oracle) result["oracle"] = oracle_json(one, given, diagnosis);
  if (one.family() == "catalogue" || one.family() == "pair" || one.family() == "triple" || (one.series && !one.kind.effects.empty()))
    result["normalised_oracle"] = refit_with_truth(nominal, given.concealed, given.training, given.held_out, given.settings);
  return result;
}

bool lacks_baselines(const ProofCase& one, const Json& kept) { return one.with_baselines && !kept.contains("baselines"); }
bool lacks_oracle(const ProofCase& one, const Json& kept) { return one.with_oracle && !kept.contains("oracle"); }

// A case that has been diagnosed, with what it lacks of the simpler methods and the oracle. They begin from the calibrated core.
Json completed(const ProofCase& one, const plant::Plant& nominal, Json kept, const std::function<bool()>& should_stop) {
  const Given given(one, nominal.system(), should_stop);
  diagnose::DiagnosisSettings core_alone = given.settings;
  core_alone.search.without = all_effects(nominal.system());
  core_alone.search.most_laws = 0;
  core_alone.thresholds.certain_process_noise = 0.0;  // only the fit is wanted
  const diagnose::Diagnosis diagnosis = diagnose::diagnose(nominal, given.training, given.held_out, core_alone);
  if (lacks_baselines(one, kept)) kept["baselines"] = baselines(diagnosis, given.settings);
  if (lacks_oracle(one, kept)) kept["oracle"] = oracle_json(one, given, diagnosis);
  return kept;
}

std::string figures_text(const Score& score) {
  std::string text;
  for (const Figure& figure : score.figures)
    if (figure.of() > 0) text += figure.what + ": " + measured_words(figure) + ", goal " + figure.goal.words + "\n";
  return text;
}

[[noreturn]] void refuse(const std::string& file, const std::string& key, const std::string& value, const std::string& advice) {
  throw sim::InputError({.file = file, .key = key, .value = value, .advice = advice});
}

Json sealed_answers(const fs::path& out) {
  const fs::path file = out / "answers.json";
  const Json sealed = fs::exists(file) ? Json::parse(sim::read_file(file), nullptr, false) : Json();
  return sealed.is_object() ? sealed : Json::object();
}

// Whether answers.json is one that this command wrote.
bool holds_proof(const fs::path& out) {
  const Json sealed = sealed_answers(out);
  return !sealed.empty() &&
         std::all_of(sealed.begin(), sealed.end(), [](const Json& answer) { return answer.is_object() && answer.contains("family"); });
}

// Where those that are there are scored, and nothing else is said: of the clean ones, too, all of them.
ProveArguments with_all_clean(ProveArguments arguments) {
  if (!arguments.score || arguments.clean != 0) return arguments;
  const Json sealed = sealed_answers(arguments.out);
  for (const auto& [id, answer] : sealed.items()) arguments.clean += answer.is_object() && id.starts_with("clean-");
  if (arguments.clean < clean_per_seed * arguments.seeds) arguments.clean = 0;
  return arguments;
}

plant::Plant nominal_of(const ProveArguments& arguments) {
  return arguments.plant.empty() ? plant::default_plant() : sim::read_plant_file(arguments.plant);
}

// The cases that were asked for.
std::vector<ProofCase> cases_of(const ProveArguments& arguments) {
  const int least_clean = clean_per_seed * arguments.seeds;
  if (arguments.clean != 0 && arguments.clean < least_clean)
    refuse("", "--clean", std::to_string(arguments.clean), "at least eight for each seed, here " + std::to_string(least_clean));
  const FirstSeeds first = arguments.first_seed != 0        ? FirstSeeds{arguments.first_seed, arguments.first_seed}
                           : arguments.set == "development" ? development_seeds
                                                            : reported_seeds;
  const bool series = is_series_limb(nominal_of(arguments).system());
  if (series && arguments.few) refuse("", "--few", arguments.plant, "has cases of the limb with two coils, and this plant is another limb");
  std::vector<ProofCase> cases = series          ? series_proof_cases(first, arguments.seeds, arguments.training_s, arguments.held_out_s)
                                 : arguments.few ? few_proof_cases(arguments.training_s, arguments.held_out_s)
                                                 : proof_cases(first, arguments.seeds, std::max(arguments.clean, least_clean),
                                                               arguments.training_s, arguments.held_out_s);
  // Beside the others, where they are asked for.
  const bool unlike = contains(arguments.families, "unlike") || std::any_of(arguments.kinds.begin(), arguments.kinds.end(),
                                                                            [](const auto& kind) { return kind.starts_with("unlike."); });
  if (unlike && !series && !arguments.few)
    for (ProofCase& one : unlike_proof_cases(first, arguments.seeds, arguments.training_s, arguments.held_out_s))
      cases.push_back(std::move(one));
  const auto chosen = [](const std::vector<std::string>& wanted, const std::string& name) {
    return wanted.empty() || contains(wanted, name);
  };
  std::erase_if(cases,
                [&](const ProofCase& one) { return !chosen(arguments.families, one.family()) || !chosen(arguments.kinds, one.kind.name); });
  for (const std::string& kind : arguments.kinds) check_concealed_kind("--kinds", kind);
  if (cases.empty()) refuse("", "--families, --kinds", "", "no case is left; `--families` has none of these kinds");
  if (arguments.without_baselines)
    for (ProofCase& one : cases) one.with_baselines = false;
  for (ProofCase& one : cases) one.with_oracle = arguments.oracle && !one.kind.effects.empty() && !one.series;
  return cases;
}

// The command that makes these cases again.
std::string command_of(const ProveArguments& arguments) {
  std::string command = "sinew prove";
  if (arguments.few) {
    command += " --few";
  } else {
    command += (arguments.first_seed != 0 ? " --first-seed " + std::to_string(arguments.first_seed) : " --set " + arguments.set) +
               " --seeds " + std::to_string(arguments.seeds);
    if (arguments.clean > clean_per_seed * arguments.seeds) command += " --clean " + std::to_string(arguments.clean);
  }
  command += " --training " + sim::shortest(arguments.training_s) + " --held-out " + sim::shortest(arguments.held_out_s) + " --out " +
             arguments.out;
  const auto add_list = [&](const std::string& option, const std::vector<std::string>& names) {
    if (!names.empty()) command += " " + option;
    for (const std::string& name : names) command += " " + name;
  };
  if (!arguments.plant.empty()) command += " --plant " + arguments.plant;
  add_list("--families", arguments.families);
  add_list("--kinds", arguments.kinds);
  if (arguments.without_baselines) command += " --without-baselines";
  if (arguments.oracle) command += " --oracle";
  return command;
}

const std::vector<std::string> scored_files{"score.json", "README.md", "confusion.svg", "reliability.svg"};

// One run of the command: answers are made and sealed, open cases diagnosed by all ranks, all scored. The first rank alone has the folder;
// each writes its cases there.
class Proof {
 public:
  Proof(const ProveArguments& arguments, Ranks& ranks) : ranks_(ranks), arguments_(with_all_clean(arguments)), out_(arguments.out) {}

  // The exit code.
  int run() {
    if (!ranks_.first_alone([&] { begin(); })) return stopped(ranks_, "nothing was written");
    tell_which_cases();
    const plant::Plant nominal = nominal_of(arguments_);
    if (!make_answers(nominal.system())) return stopped(ranks_, "nothing was written");
    const bool all_go_on = ranks_.first_alone([&] {
      check_that_it_goes_on();
      fs::create_directories(out_ / "cases");
      take_what_is_there();
      seal();
    });
    if (!all_go_on || (arguments_.recordings && !write_recordings(nominal.system()))) return stopped(ranks_, "the same command goes on");
    tell_what_is_open();
    if (!diagnose_open(nominal))
      return stopped(ranks_, std::to_string(results_.size()) + " of " + std::to_string(cases_.size()) + " cases are kept in " +
                                 out_.string() + ", the same command goes on");
    if (ranks_.first()) write_score();
    return 0;
  }

 private:
  void begin() {
    outputs_.emplace(out_, InputPaths{.yaml = {arguments_.plant}}, arguments_.overwrite);
    cases_ = cases_of(arguments_);
    wanted_ = cases_.size();
    if (arguments_.score) std::erase_if(cases_, [&](const ProofCase& one) { return !fs::exists(file_of(one)); });
    const bool goes_on = holds_proof(out_);
    for (const char* name : {"answers.json", "cases", "recordings"}) outputs_->claim_in_parts(name);
    if (fs::exists(out_ / "answers.json") && !goes_on && !arguments_.overwrite)
      refuse((out_ / "answers.json").string(), "--out", out_.string(),
             "holds no answers of a proof; give another folder, or replace it with --overwrite");
    outputs_->claim(scored_files, goes_on);
    if (cases_.empty()) refuse("", "--out", out_.string(), "holds none of the cases that --score would score");
  }

  void tell_which_cases() {
    Json ids = Json::object();
    for (const ProofCase& one : cases_) ids[one.id()] = true;
    ids = Json::parse(ranks_.from_first(ids.dump()));
    if (ranks_.first()) return;
    cases_ = cases_of(arguments_);
    std::erase_if(cases_, [&](const ProofCase& one) { return !ids.contains(one.id()); });
  }

  fs::path file_of(const ProofCase& one) const { return out_ / "cases" / (one.id() + ".json"); }
  // Empty where there is none, or a damaged one.
  Json kept_case(const ProofCase& one) const {
    const fs::path file = file_of(one);
    const Json kept = fs::exists(file) ? Json::parse(sim::read_file(file), nullptr, false) : Json();
    return kept.is_object() ? kept : Json::object();
  }
  std::string seal_of(const ProofCase& one) const { return sim::sha256(answers_[one.id()].dump()); }

  // Every rank: calls work(i) for each i of `which`, somewhere. What it gives goes into `all` of the first rank, by case. False after an
  // interrupt of any rank.
  bool by_case(const std::vector<std::size_t>& which, const char* doing, const std::function<std::optional<Json>(std::size_t)>& work,
               Json& all) const {
    std::mutex keeping;
    Json own = Json::object();
    const auto id = [&](std::size_t n) { return cases_[which[n]].id(); };
    const bool whole = ranks_.share(which.size(), {.threads = arguments_.threads, .doing = doing, .name = id}, [&](std::size_t n) {
      std::optional<Json> made = work(which[n]);
      const std::scoped_lock lock(keeping);
      if (made) own[id(n)] = std::move(*made);
    });
    for (const std::string& of_rank : ranks_.gather(own.dump())) all.update(Json::parse(of_rank));
    return whole;
  }
  std::vector<std::size_t> all_cases() const {
    std::vector<std::size_t> all(cases_.size());
    std::iota(all.begin(), all.end(), std::size_t{0});
    return all;
  }

  // False after an interrupt.
  bool make_answers(const plant::System& system) {
    Json by_id = Json::object();
    const auto answer = [&](std::size_t i) -> std::optional<Json> { return answer_of(cases_[i], make_case(cases_[i], system).truth); };
    const bool whole = by_case(all_cases(), "making recordings", answer, by_id);
    if (ranks_.first() && whole)
      for (const ProofCase& one : cases_) answers_[one.id()] = by_id[one.id()];  // in the order of the cases
    return whole;
  }

  // A case in the folder that has another answer is of another proof, and so is one whose answer was not sealed there.
  void check_that_it_goes_on() const {
    if (arguments_.overwrite || arguments_.score) return;
    const Json sealed = sealed_answers(out_);
    for (const ProofCase& one : cases_) {
      const std::string id = one.id();
      if (sealed.contains(id) ? sealed[id] != answers_[id] : fs::exists(file_of(one)) && kept_case(one).value("answer", "") != seal_of(one))
        refuse(sealed.contains(id) ? (out_ / "answers.json").string() : file_of(one).string(), "--out", out_.string(),
               "case " + id +
                   " is there with another answer: of recordings of another length, or by another version\n"
                   "give another folder, or make the case again with --overwrite");
    }
  }

  // False after an interrupt.
  bool write_recordings(const plant::System& system) const {
    Json nothing;
    const auto write = [&](std::size_t i) -> std::optional<Json> {
      const Made of_case = make_case(cases_[i], system);
      const fs::path folder = out_ / "recordings" / cases_[i].id();
      fs::create_directories(folder);
      sim::write_recording(folder / "training.csv", of_case.training);
      sim::write_recording(folder / "heldout.csv", of_case.held_out);
      return std::nullopt;
    };
    return by_case(all_cases(), "writing recordings", write, nothing);
  }

  // What is there already of the same answers is not done again; README.md says which programs made the cases.
  void take_what_is_there() {
    for (std::size_t i = 0; i < cases_.size(); ++i) {
      const fs::path file = file_of(cases_[i]);
      const Json kept = kept_case(cases_[i]);
      if (kept.value("seconds", Json()) == Json({arguments_.training_s, arguments_.held_out_s}) &&
          kept.value("answer", "") == seal_of(cases_[i])) {
        results_[cases_[i].id()] = kept;
        const bool is_whole = !lacks_baselines(cases_[i], kept) && !lacks_oracle(cases_[i], kept);
        if (is_whole || arguments_.score || kept["verdict"] == "failed") continue;
        diagnosed_before_[i] = kept;
      } else if (arguments_.score) {
        refuse(file.string(), "--score", cases_[i].id(),
               "this case is damaged, or was made of another recording; remove it or make it again");
      }
      open_.push_back(i);
    }
  }

  // The answers are sealed before any diagnosis begins, beside those that are there of other cases; what is only scored
  // has its seal.
  void seal() const {
    const fs::path file = out_ / "answers.json";
    Json sealed = sealed_answers(out_);
    for (const auto& [id, answer] : answers_.items()) {
      if (arguments_.score && sealed.value(id, Json()) != answer) refuse(file.string(), "--score", id, "this answer was not sealed");
      sealed[id] = answer;
    }
    if (!arguments_.score) sim::write_file_whole(file, sealed.dump(1) + "\n");
    std::printf("%zu cases; sha256 of the sealed answers: %s\n", cases_.size(), sim::sha256(sim::read_file(file)).c_str());
    if (!results_.empty()) std::printf("%zu of them are there already\n", results_.size());
    const auto lacking = [&](auto lacks) {
      return std::count_if(diagnosed_before_.begin(), diagnosed_before_.end(),
                           [&](const auto& kept) { return lacks(cases_[kept.first], kept.second); });
    };
    if (const auto n = lacking(lacks_baselines); n > 0) std::printf("of which %td are put to the simpler methods now\n", n);
    if (const auto n = lacking(lacks_oracle); n > 0) std::printf("of which %td are put to the oracle now\n", n);
    std::fflush(stdout);
  }

  void tell_what_is_open() {
    const std::string told =
        ranks_.from_first(ranks_.first() ? Json{{"answers", answers_}, {"open", open_}, {"before", diagnosed_before_}}.dump() : "");
    if (ranks_.first()) return;
    const Json all = Json::parse(told);
    answers_ = all["answers"];
    open_ = all["open"].get<decltype(open_)>();
    diagnosed_before_ = all["before"].get<decltype(diagnosed_before_)>();
  }

  // What an open case comes to; nothing where only the simpler methods or the oracle were wanted, and failed. Throws Stopped.
  std::optional<Json> result_of_open(std::size_t i, const plant::Plant& nominal) const {
    const ProofCase& one = cases_[i];
    const auto should_stop = [this] { return ranks_.any_interrupted(); };
    if (const auto kept = diagnosed_before_.find(i); kept != diagnosed_before_.end()) {
      try {
        return completed(one, nominal, kept->second, should_stop);
      } catch (const diagnose::Stopped&) {
        throw;
      } catch (const std::exception& e) {
        std::fprintf(stderr, "%s: the simpler methods or the oracle failed: %s\n", one.id().c_str(), e.what());
        return std::nullopt;
      }
    }
    Json result;
    try {
      result = diagnose_case(one, nominal, should_stop);
    } catch (const diagnose::Stopped&) {
      throw;
    } catch (const std::exception& e) {
      result = {{"verdict", "failed"},
                {"why", e.what()},
                {"effects", Json::array()},
                {"ambiguous_with", Json::array()},
                {"cannot_be_seen", Json::array()},
                {"located", {{"place", ""}}},
                {"visibility", 1e3},
                {"normalised_before", 0.0},
                {"normalised_after", 0.0}};
    }
    result["seconds"] = {arguments_.training_s, arguments_.held_out_s};
    result["made_by"] = sim::this_build().version + " " + sim::this_build().commit;
    result["answer"] = seal_of(one);
    return result;
  }

  // False where a rank was interrupted.
  bool diagnose_open(const plant::Plant& nominal) {
    const auto diagnosed = [&](std::size_t i) -> std::optional<Json> {
      try {
        std::optional<Json> result = result_of_open(i, nominal);
        if (result) sim::write_file_whole(file_of(cases_[i]), result->dump(1) + "\n");
        return result;
      } catch (const diagnose::Stopped&) {
        return std::nullopt;
      }
    };
    return by_case(open_, "proving", diagnosed, results_);
  }

  void write_score() {
    Score score = score_of(read_cases(answers_, results_));
    score.wanted = static_cast<int>(wanted_);
    const std::string json = score_json(score).dump(1) + "\n";
    outputs_->stage("confusion.svg", confusion_svg(score));
    outputs_->stage("reliability.svg", reliability_svg(score));
    outputs_->stage("README.md", score_markdown(score, command_of(arguments_)));
    outputs_->stage("score.json", json);
    outputs_->commit();
    if (arguments_.json)
      std::printf("%s", json.c_str());
    else
      std::printf("\n%s\nevery miss, strata and the confusion matrix: %s\n", figures_text(score).c_str(), (out_ / "README.md").c_str());
  }

  Ranks& ranks_;
  std::optional<Outputs> outputs_;  // of the first rank
  const ProveArguments arguments_;
  const fs::path out_;
  std::vector<ProofCase> cases_;
  std::size_t wanted_ = 0;
  Json answers_, results_;                        // by case
  std::vector<std::size_t> open_;                 // cases that are still to be done
  std::map<std::size_t, Json> diagnosed_before_;  // of the open ones, those that only lack the simpler methods or the oracle
};

}  // namespace

void add_prove(CLI::App& program, int& exit_code) {
  auto arguments = std::make_shared<ProveArguments>();
  CLI::App* command = program.add_subcommand("prove", "puts the diagnosis to the proof on concealed data");
  command->footer(
      "Recordings are made by a generator that shares no code with the plant; what is in them is sealed before the "
      "first\n"
      "diagnosis begins. Ctrl-C keeps what is done, and the same command goes on from there.\n\n"
      "Examples:\n"
      "  sinew prove --out results/proof\n"
      "  sinew prove --set development --families clean --seeds 2 --out /tmp/clean\n"
      "  sinew prove --kinds hard_stop.exponential --seeds 1 --recordings --out /tmp/one\n"
      "  sinew prove --out results/proof --score\n"
      "  sinew prove --few --out /tmp/few\n"
      "  mpirun -n 8 sinew prove --threads 1 --out /scratch/proof");
  command->add_option("--out", arguments->out, "directory for answers, cases, score")->required();
  command->add_option("--plant", arguments->plant,
                      "nominal plant; without it the paper's limb. plant/limbs/series_limb.yaml: cases of two segments in series");
  command->add_option("--set", arguments->set, "which seeds")->check(CLI::IsMember({"reported", "development"}));
  command->add_option("--first-seed", arguments->first_seed, "seeds from here on, instead of those of a set")
      ->check(CLI::Range(std::uint64_t{1}, std::uint64_t{1000000000}));
  command->add_option("--seeds", arguments->seeds, "seeds of every case")->check(CLI::Range(1, 100));
  command->add_option("--clean", arguments->clean, "recordings in which nothing is missing; at least eight for each seed")
      ->check(CLI::Range(clean_per_seed, 10000));
  command->add_option("--families", arguments->families, "only these")
      ->check(
          CLI::IsMember({"clean", "catalogue", "other_form", "pair", "triple", "outside", "removed", "elsewhere", "series_limb", "unlike"}))
      ->delimiter(',');
  command->add_option("--kinds", arguments->kinds, "only these, by name as in answers.json")->delimiter(',');
  command->add_option("--training", arguments->training_s, "seconds of the training recording")->check(CLI::Range(60.0, 36000.0));
  command->add_option("--held-out", arguments->held_out_s, "seconds of the held-out recording")->check(CLI::Range(60.0, 36000.0));
  command->add_option("--threads", arguments->threads, "cases at a time")->check(CLI::Range(1, 256));
  command->add_flag("--few", arguments->few, "a dozen cases of development, as in ./check");
  command->add_flag("--without-baselines", arguments->without_baselines,
                    "the simpler methods, which take as long as the diagnosis, are left out");
  command->add_flag("--oracle", arguments->oracle,
                    "also fit the generator's own law to every case in which something is concealed, some minutes each: what\n"
                    "share of the reachable held-out gain an answer has; cases that are there already get it, too");
  command->add_flag("--score", arguments->score, "no case is made: those that are there are scored");
  command->add_flag("--recordings", arguments->recordings,
                    "write each case's recordings, too, for `sinew diagnose --train ... --heldout ...`");
  command->add_flag("--json", arguments->json, "the score as JSON on standard output");
  add_overwrite(*command, arguments->overwrite);
  command->callback([arguments, &exit_code] { exit_code = in_all_ranks([&](Ranks& ranks) { return Proof(*arguments, ranks).run(); }); });
}

}  // namespace sinew::apps

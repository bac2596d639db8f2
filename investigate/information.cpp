// SPDX-License-Identifier: Apache-2.0
#include "investigate/information.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <limits>
#include <map>

#include "diagnose/calibrate.h"
#include "diagnose/path.h"
#include "diagnose/state_noise.h"
#include "hil/heat_bound.h"
#include "hil/limits.h"
#include "investigate/usual_strength.h"
#include "sim/simulation.h"

namespace sinew::investigate {
namespace {

using diagnose::Explanation;

constexpr double cool_K = 3.0;  // above where it began, a coil counts as cold
constexpr int most_lowerings = 14;
constexpr double lowering = 0.88;
constexpr std::size_t most_stand_ins = 6;  // for something else

// Effects beyond the plant as given; laws, which its System may not have, too.
std::vector<plant::EffectId> added(const Explanation& explanation, const Explanation& core) {
  std::vector<plant::EffectId> effects;
  for (const plant::EffectId e : explanation.effects())
    if (e.index >= core.system().effects().size() || !core.problem->centres().is_on(e)) effects.push_back(e);
  std::sort(effects.begin(), effects.end());
  return effects;
}

// Every explanation at hand, the likeliest of each set of effects.
std::map<std::vector<plant::EffectId>, const Explanation*> at_hand(const diagnose::Diagnosis& diagnosis) {
  std::map<std::vector<plant::EffectId>, const Explanation*> all;
  const Explanation& core = diagnosis.search.core;
  const auto add = [&](const Explanation& one) {
    if (!one.usable) return;
    const Explanation*& there = all[added(one, core)];
    if (!there || one.log_evidence > there->log_evidence) there = &one;
  };
  add(core);
  add(diagnosis.search.best);
  for (const diagnose::Round& round : diagnosis.search.rounds)
    for (const diagnose::Candidate& candidate : round.candidates) add(candidate.explanation);
  // Fitted by another measure: in the place of what is not there.
  for (const diagnose::Proposal& proposal : diagnosis.proposals.all)
    if (proposal.fit.usable && std::none_of(proposal.effects.begin(), proposal.effects.end(),
                                            [&](plant::EffectId e) { return e.index >= core.system().effects().size(); }))
      all.emplace(added(proposal.fit, core), &proposal.fit);
  // The answer itself, whichever way it was found; a law of it has no name.
  if (diagnosis.values.usable) {
    std::vector<plant::EffectId> answer;
    for (const diagnose::FoundEffect& found : effects_in(diagnosis.answer)) answer.push_back(found.effect);
    std::sort(answer.begin(), answer.end());
    std::vector<plant::EffectId> unlike;
    for (const diagnose::FoundApart& found : apart_in(diagnosis.answer)) unlike.push_back(found.effect);
    std::sort(unlike.begin(), unlike.end());
    answer.insert(answer.end(), unlike.begin(), unlike.end());
    all.emplace(answer, &diagnosis.values);
  }
  return all;
}

Alternative alternative_of(std::shared_ptr<const Explanation> fitted, std::string key, double probability) {
  Alternative one;
  one.key = std::move(key);
  one.probability = probability;
  one.model = fitted->model();
  const auto p = static_cast<Eigen::Index>(fitted->problem->parameters().size());
  one.z = fitted->z.head(p);
  // The prior where the covariance is none: nothing was learned.
  Eigen::MatrixXd covariance = fitted->covariance.rows() >= p ? Eigen::MatrixXd(fitted->covariance.topLeftCorner(p, p))
                                                              : Eigen::MatrixXd(Eigen::MatrixXd::Identity(p, p));
  const Eigen::LLT<Eigen::MatrixXd> factor(0.5 * (covariance + covariance.transpose()) + 1e-10 * Eigen::MatrixXd::Identity(p, p));
  one.spread = factor.info() == Eigen::Success ? Eigen::MatrixXd(factor.matrixL()) : Eigen::MatrixXd(Eigen::MatrixXd::Identity(p, p));
  one.fitted = std::move(fitted);
  return one;
}

// Which the diagnosis keeps.
std::shared_ptr<const Explanation> of_diagnosis(const Explanation& one) { return {std::shared_ptr<const void>(), &one}; }

struct Played {
  double highest = -std::numeric_limits<double>::infinity();
  bool safe = true;
  double cold_from_s = 0.0;  // the time from which all limited states are within cool_K of where they began, to the end
};

Played play(const plant::Plant& plant, sim::Recording& recording, const Question& question, double cool_K_above) {
  Played played;
  const plant::System& system = plant.system();
  const plant::States states = plant.states();
  plant::Integrator integrator(plant, {diagnose::elapsed_where_it_begins(states, recording, question.counted_from_s), {}},
                               question.numerics);
  const std::vector<double> begun = integrator.state();
  const auto failure = sim::replay(integrator, system, recording.samples, [&](std::size_t k) {
    recording.samples[k].channels = sim::in_file_units(system, integrator.readings());
    for (const plant::StateId i : states.ids()) {
      if (!std::isfinite(states[i].safe_until)) continue;
      const double value = integrator.state()[i.index];
      played.highest = std::max(played.highest, value);
      played.safe = played.safe && value <= states[i].safe_until;
      if (value > begun[i.index] + cool_K_above) played.cold_from_s = recording.samples[k].time_s;
    }
  });
  played.safe = played.safe && !failure;
  return played;
}

double lowest_limit(const plant::Plant& plant) {
  double limit = std::numeric_limits<double>::infinity();
  for (const plant::StateInfo& state : plant.states()) limit = std::min(limit, state.safe_until);
  return limit;
}

}  // namespace

double Question::entropy_nat() const {
  double sum = 0.0;
  for (const Alternative& one : alternatives)
    if (one.probability > 0.0) sum -= one.probability * std::log(one.probability / mass);
  return sum + 0.0;
}

Question question_of(const diagnose::Diagnosis& diagnosis, const Belief& belief, const diagnose::DiagnosisSettings& settings,
                     std::size_t most_alternatives) {
  Question question;
  const Explanation& core = diagnosis.search.core;
  const auto explanations = at_hand(diagnosis);
  question.noise = diagnosis.gate.front().noise;
  question.numerics = core.problem->numerics();
  question.counted_from_s = diagnosis.gate.front().begins_s;
  if (const diagnose::GateNotes& last = diagnosis.gate.back(); last.begins_s) question.begins_s = *last.begins_s + last.duration_s;
  double something_else = 0.0;
  for (const Hypothesis& one : belief.all) {
    if (one.kind == Kind::something_else) something_else += one.probability;
    if (one.kind != Kind::nothing && one.kind != Kind::named) continue;
    const auto there = explanations.find(one.effects);
    if (there == explanations.end())
      something_else += one.probability;  // believed, and not at hand: what stands in for something else does for it, too
    else if (one.probability > 1e-4)
      question.alternatives.push_back(alternative_of(of_diagnosis(*there->second), one.key, one.probability));
  }
  // Where nothing is named, the core is what stand-ins are added to.
  if (question.alternatives.empty()) {
    question.alternatives.push_back(alternative_of(of_diagnosis(core), "the plant as given", 0.5 * something_else));
    something_else *= 0.5;
  }
  const Explanation* base = question.alternatives.front().fitted.get();
  const diagnose::Scores& scores = round_from(diagnosis.search, *base).scores;
  question.exaggeration = exaggeration(settings, scores.best.size());
  question.forcing = base->forcing;
  const auto& groups = core.system().entry_groups();
  for (const plant::EntryGroupId g : groups.ids())
    if (groups[g].is_nuisance) question.forcing[g] = std::max(question.forcing[g], groups[g].typical);
  std::vector<Alternative> others;
  for (const Hypothesis& one : belief.all)
    if (Belief::may_yet_show(one)) others.push_back(alternative_of(one.fitted, one.key, one.probability));
  if (something_else > 0.01) {
    std::vector<plant::EffectId> stand_ins;
    for (const std::size_t s : scores.best)
      if (const plant::EffectId e = scores.all[s].effect; !base->problem->centres().is_on(e) && stand_ins.size() < most_stand_ins)
        stand_ins.push_back(e);
    const auto fitted = at_usual_strength(*base, stand_ins, settings.search).with;
    for (std::size_t i = 0; i < stand_ins.size(); ++i)
      if (fitted[i])
        others.push_back(alternative_of(fitted[i], std::string(core.system().effects()[stand_ins[i]].name),
                                        something_else / static_cast<double>(stand_ins.size())));
  }
  std::stable_sort(others.begin(), others.end(), [](const Alternative& a, const Alternative& b) { return a.probability > b.probability; });
  for (Alternative& one : others) question.alternatives.push_back(std::move(one));
  if (question.alternatives.size() > most_alternatives) question.alternatives.resize(most_alternatives);
  for (const Alternative& one : question.alternatives) question.mass += one.probability;
  return question;
}

bool within_device_limits(const Programme& programme, const plant::System& system) {
  constexpr double step_s = 0.05, window_s = LIMIT_ON_TIME_WINDOW_s + 1.0, budget_s = LIMIT_ON_TIME_ms / 1000.0 - 0.4;
  const auto steps = static_cast<std::size_t>(std::ceil(programme.duration_s() / step_s));
  const auto in_window = static_cast<std::size_t>(window_s / step_s);
  for (std::size_t i = 0; i < system.inputs().size(); ++i) {
    std::uint32_t rise_uK = LIMIT_BOUND_START_cK * 10'000u;
    std::vector<double> on_s(steps, 0.0);
    double sum_s = 0.0;
    for (std::size_t k = 0; k < steps; ++k) {
      const double duty = programme.duty(i, static_cast<double>(k) * step_s);
      rise_uK = heat_bound_after(rise_uK, static_cast<std::uint32_t>(std::ceil(duty * 10'000.0 * step_s * 1e3)), 50);
      on_s[k] = duty * step_s;
      sum_s += on_s[k] - (k >= in_window ? on_s[k - in_window] : 0.0);
      if (rise_uK > (LIMIT_BOUND_RISE_cK - 100) * 10'000u || sum_s > budget_s || duty > LIMIT_HIGHEST_DUTY / 10'000.0) return false;
    }
  }
  return true;
}

Expected expected_of(const Question& question, const Shape& asked, double longest_s) {
  Expected expected;
  const Alternative& base = question.alternatives.front();
  const plant::System& system = base.model.system();
  const double limit = lowest_limit(base.model);
  Shape shape = asked;
  double margin_K = 0.0;
  for (int attempt = 0; attempt < most_lowerings;
       ++attempt, shape.level_fraction = std::floor(shape.level_fraction * lowering * 1e3) / 1e3) {
    Programme programme = programme_of(shape, system);
    if (programme.parts.empty()) return expected;
    programme.cool_s = longest_cooling_s;
    if (!within_device_limits(programme, system)) continue;
    sim::Recording measured = rows_of(programme, system);
    measured.time_zero_s = question.begins_s;
    const Played played = play(base.model, measured, question, cool_K);
    if (!played.safe || played.highest > limit - margin_K) continue;
    programme.cool_s = std::clamp(std::ceil(played.cold_from_s - shape.drive_s) + 2.0, 2.0, longest_cooling_s);
    if (programme.duration_s() > longest_s) return expected;
    measured.samples.resize(rows_of(programme, system).samples.size());

    // Every alternative against the base's readings: rows of residuals, and what its parameters may still do to them.
    const std::vector<diagnose::FitData> data{{&measured, measured.samples.size(), question.noise}};
    const std::size_t n = question.alternatives.size();
    std::vector<Eigen::MatrixXd> columns(n);
    Eigen::MatrixXd shifts;
    std::optional<diagnose::Blocks> blocks;
    std::optional<diagnose::StateNoise> state_noise;
    double highest = played.highest;
    bool safe = true;
    for (std::size_t i = 0; i < n && safe; ++i) {
      const Alternative& one = question.alternatives[i];
      sim::Recording own = measured;
      const Played its = i == 0 ? played : play(one.model, own, question, cool_K);
      highest = std::max(highest, its.highest);
      safe = its.safe;
      if (!safe) break;
      // How it begins will be estimated, as of every recording that is not the limb's first.
      const diagnose::FitProblem problem(one.fitted->problem->centres(), one.fitted->problem->parameters(), data,
                                         {diagnose::StartPolicy::estimated, question.counted_from_s, true}, question.numerics);
      if (i == 0) blocks.emplace(problem);
      const auto unknowns = static_cast<Eigen::Index>(problem.unknowns().size()), parameters = one.z.size();
      Eigen::VectorXd z = Eigen::VectorXd::Zero(unknowns);
      z.head(parameters) = one.z;
      diagnose::Path path;
      if (!follow(problem, z.data(), i == 0 ? diagnose::Want::everything : diagnose::Want::derivatives, path)) return expected;
      columns[i] = blocks->means(path.jacobian.data(), problem.unknowns().size());
      columns[i].leftCols(parameters) *= one.spread;
      if (i == 0) {
        shifts = Eigen::MatrixXd::Zero(columns[i].rows(), static_cast<Eigen::Index>(n));
        state_noise.emplace(problem, *blocks, z.data(), path);
        state_noise->set(question.forcing);
        double widest = 0.0;
        for (std::size_t r = 0; r < blocks->rows().size(); ++r) {
          const plant::ChannelId c = blocks->rows()[r].channel;
          if (system.channels()[c].driven_by)
            widest = std::max(widest, columns[i].row(static_cast<Eigen::Index>(r)).head(parameters).norm() * question.noise[c]);
        }
        margin_K = 2.0 * widest;
      }
      shifts.col(static_cast<Eigen::Index>(i)) = blocks->means(path.residuals.data(), 1).col(0);
      state_noise->whiten(columns[i]);
    }
    if (!safe || highest + margin_K > limit) continue;
    state_noise->whiten(shifts);

    Eigen::MatrixXd distance = Eigen::MatrixXd::Zero(static_cast<Eigen::Index>(n), static_cast<Eigen::Index>(n));
    double most = 0.0;
    for (std::size_t i = 0; i < n; ++i)
      for (std::size_t j = 0; j < i; ++j) {
        const auto a = static_cast<Eigen::Index>(i), b = static_cast<Eigen::Index>(j);
        Eigen::MatrixXd both(columns[i].rows(), columns[i].cols() + columns[j].cols());
        both << std::sqrt(0.5) * columns[i], std::sqrt(0.5) * columns[j];
        const Eigen::VectorXd difference = shifts.col(a) - shifts.col(b);
        const Eigen::VectorXd along = both.transpose() * difference;
        Eigen::MatrixXd information = both.transpose() * both;
        information.diagonal().array() += 1.0;
        const double square = std::max(0.0, difference.squaredNorm() - along.dot(information.llt().solve(along)));
        distance(a, b) = distance(b, a) = square;
        const double weight = question.alternatives[i].probability * question.alternatives[j].probability *
                              (1.0 - std::exp(-square / (8.0 * question.exaggeration)));
        if (weight > most) {
          most = weight;
          expected.apart = question.alternatives[j].key;
          expected.from = question.alternatives[i].key;
          expected.separation = std::sqrt(square);
        }
      }
    for (std::size_t i = 0; i < n; ++i) {
      expected.from_first.push_back(std::sqrt(distance(static_cast<Eigen::Index>(i), 0)));
      double overlap = 0.0;
      for (std::size_t j = 0; j < n; ++j)
        overlap += question.alternatives[j].probability / question.mass *
                   std::exp(-distance(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(j)) / (8.0 * question.exaggeration));
      if (overlap > 0.0) expected.information_nat -= question.alternatives[i].probability * std::log(overlap);
    }
    expected.possible = true;
    expected.programme = std::move(programme);
    expected.highest_degC = highest + margin_K;
    return expected;
  }
  return expected;
}

}  // namespace sinew::investigate

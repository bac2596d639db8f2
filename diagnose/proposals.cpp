// SPDX-License-Identifier: Apache-2.0
#include "diagnose/proposals.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>

#include "diagnose/calibrate.h"
#include "diagnose/compare.h"
#include "diagnose/error_size.h"
#include "diagnose/free_laws.h"
#include "diagnose/search.h"
#include "diagnose/thinned.h"
#include "plant/apart.h"
#include "plant/contains.h"
#include "plant/in_part.h"
#include "sim/parallel.h"
#include "sim/random.h"

namespace sinew::diagnose {
namespace {

using Effects = std::vector<plant::EffectId>;

// A fit that waits to be made: which effects, and from where.
struct Begun {
  Effects effects;
  Guess guess;
  Explanation fit;
};

struct ByCatalogue {
  bool operator()(const Effects& a, const Effects& b) const {
    return std::lexicographical_compare(a.begin(), a.end(), b.begin(), b.end(), [](auto x, auto y) { return x.index < y.index; });
  }
};

class Proposer {
 public:
  Proposer(const Fitted& core, const std::vector<FitData>& data, const ProposalSettings& settings, const ExplanationSettings& fit)
      : given_(plant::carried_into(core.of.problem->centres(), plant::with_parts_apart(core.of.problem->centres().shared_system()))),
        whole_(data),
        thinned_(thinned(given_.system(), data)),
        data_(thinned_.data),
        yardstick_(data_),
        settings_(settings),
        numerics_(fit.numerics),
        fit_(fit),
        correlation_(data_.size(), per_channel(given_.system(), 1.0)),
        scale_(scale_of(given_.system(), data_)) {
    fit_.least_squares = true;
    fit_.most_rounds = 1;
    fit_.enough = 1.0;
    fit_.numerics.relative_tolerance = std::max(fit_.numerics.relative_tolerance, coarse_tolerance);
    const Fitted settled = settled_core(core);
    measure_by(settled);
    all_[{}] = fitted_from({}, settled.of.as_guess(), long_fit);
    if (!all_[{}].usable) all_[{}] = core.of;
    for (const plant::EffectId e : given_.system().effects().ids())
      if (const auto& sharing = given_.system().effects()[e].sharing;
          sharing && plant::may_differ(given_, given_.system().sharings()[*sharing]))
        sharings_.push_back(e);
  }

  Proposals run() {
    tell(0.0, "simulating what was found so far");
    take_up(settings_.begun);
    settle();
    const std::size_t most = settings_.most_effects + settings_.most_apart;
    for (std::size_t depth = 1; depth <= most; ++depth) {
      tell(static_cast<double>(depth - 1) / static_cast<double>(most + 1), "trying effects by open-loop simulation");
      const Effects before = best();
      if (!all_.at(before).usable) break;
      std::vector<Begun> begun = depth == 1 ? first_round() : next_round(order(), settings_.width);
      halve(begun);
      for (Begun& one : begun) keep(one);
      settle();
      if (best().size() < depth) break;
    }
    tell(static_cast<double>(most) / static_cast<double>(most + 1), "weighing proposals");
    restart();
    settle();
    // What comes out may be another proposal, whose names have rivals of their own.
    for (int pass = 0; pass < most_exchanges; ++pass) {
      const Effects leading = best();
      if (leading.empty()) break;
      weigh_without(leading);
      exchange(leading);
      settle();
      if (best() == leading) break;
    }
    tell(0.9, "predicting what was left out of the fit");
    const Effects named = standing_ = with_what_pays(what_pays(best()));
    tell(0.92, "trying laws without a name");
    seek_laws(named);
    tell(0.97, "predicting what was left out of the fit");
    return ranked(better_with_laws(named));
  }

 private:
  static constexpr int short_fit = 4, middle_fit = 8, long_fit = 25;
  static constexpr double beyond_doubt = 3.0;  // of log odds: twenty to one
  static constexpr double still_counts = 5.0;  // below the best: what is further down has no share to speak of
  static constexpr int most_exchanges = 4;

  void tell(double share, const std::string& doing) const {
    if (settings_.progress) settings_.progress(share, doing);
  }

  plant::Plant with(const Effects& effects) const {
    plant::Plant plant = given_;
    for (const plant::EffectId e : effects) plant = with_effect(plant, e);
    return plant;
  }
  Explanation fitted_from(const Effects& effects, const Guess& guess, int iterations) const {
    ExplanationSettings fit = fit_;
    fit.iterations_per_round = iterations;
    return explain(with(effects), yardstick_, guess, fit);
  }

  // Every effect alike: one in so many is there. And every cell of a law; but a law that is the form of a name is as likely as not, and so
  // is that parts differ.
  double log_prior(const Effects& effects) const {
    const plant::System& system = given_.system();
    const double named = static_cast<double>(system.without_laws()->effects().size());
    double sum = 0.0;
    for (const plant::EffectId e : effects) {
      const plant::EffectInfo& effect = system.effects()[e];
      sum -= std::log(effect.sharing ? 2.0 : !effect.law ? named : is_form_of(effects, e) ? 2.0 : std::max(named, cells_));
    }
    return sum;
  }
  // Whether a law is the form that one of these has here.
  bool is_form_of(const Effects& names, plant::EffectId law) const {
    return is_own(given_.system(), names, given_.system().laws()[*given_.system().effects()[law].law]);
  }
  // Whether a law that is the form of a name is without one here.
  bool takes_a_name_away(const Effects& all, const Effects& rest) const {
    return std::any_of(rest.begin(), rest.end(),
                       [&](plant::EffectId e) { return given_.system().effects()[e].law && is_form_of(all, e) && !is_form_of(rest, e); });
  }
  double log_odds(const Effects& effects, const Explanation& fit) const {
    return fit.usable ? fit.log_evidence - fit.log_likelihood + error_of(fit).log_likelihood + log_prior(effects) : -1e300;
  }

  // Of as many independent errors as `correlation_` leaves, of unknown size: the size is the proposal's own.
  ErrorSize error_of(const Explanation& fit) const {
    SquaredErrors errors{std::vector<PerChannel>(data_.size(), per_channel(given_.system())), {}};
    errors.count = errors.sum;
    const auto& rows = fit.blocks->rows();
    for (std::size_t i = 0; i < rows.size(); ++i) {
      const auto [r, c] = std::pair(rows[i].recording, rows[i].channel);
      errors.sum[r][c] += rows[i].count * std::pow(fit.residual(static_cast<Eigen::Index>(i)) * fit.problem->data()[r].deviation[c], 2);
      errors.count[r][c] += rows[i].count;
    }
    return error_size(errors, data_, scale_, correlation_);
  }
  std::vector<Effects> order() const {
    std::vector<Effects> sets;
    for (const auto& [effects, fit] : all_) sets.push_back(effects);
    std::stable_sort(sets.begin(), sets.end(),
                     [&](const Effects& a, const Effects& b) { return log_odds(a, all_.at(a)) > log_odds(b, all_.at(b)); });
    return sets;
  }
  Effects best() const { return order().front(); }

  void keep(const Begun& one) {
    if (!one.fit.usable) return;
    const auto [at, is_new] = all_.try_emplace(one.effects, one.fit);
    if (is_new || (at->second.usable && one.fit.log_evidence <= at->second.log_evidence)) return;
    at->second = one.fit;
    folds_.erase(one.effects);
  }

  // The plant as given as near to the recordings as it comes, from several starts, each channel weighted by how far off the best so far is:
  // what it leaves is the first measure of all others.
  Fitted settled_core(const Fitted& core) {
    Fitted best = core;
    double least = spread_of(best, data_, fit_.numerics).log_sum;
    for (int pass = 0; pass < 2; ++pass) {
      const Spread left = spread_of(best, data_, fit_.numerics);
      for (std::size_t r = 0; r < yardstick_.size(); ++r) yardstick_[r].deviation = left.deviation[r];
      std::vector<Begun> begun{{{}, best.of.as_guess(), {}}};
      for (int start = 0; pass == 0 && start < settings_.starts; ++start) begun.push_back({{}, drawn(*core.of.problem, {}, start), {}});
      fit_all(begun, long_fit);
      for (const Begun& one : begun) {
        const Fitted tried = fitted(one.fit);
        const double log_sum = spread_of(tried, data_, fit_.numerics).log_sum;
        if (log_sum >= least) continue;
        best = tried;
        least = log_sum;
      }
    }
    yardstick_ = data_;
    return best;
  }

  // What is believed, the effects as is typical of them; from the second start on drawn from half the prior around that.
  Guess drawn(const FitProblem& problem, const Effects& effects, int start) const {
    Guess guess = from_belief(effects);
    if (start == 0) return guess;
    const sim::RandomStream chance(settings_.seed, "propose.start." + std::to_string(start));
    const std::vector<Unknown>& unknowns = problem.unknowns();
    for (std::size_t u = 0; u < unknowns.size(); ++u) {
      const Unknown& one = unknowns[u];
      double& value = guess.values.try_emplace(one.name, one.centre).first->second;
      value = std::clamp(one.value_at(one.coordinate_of(value) + 0.5 * chance.normal(u)), one.lowest, one.highest);
    }
    return guess;
  }

  // What a path leaves in each channel, for as long as errors are alike; never more than before.
  bool measure_by(const Fitted& path) {
    if (!measured_) correlation_ = samples_alike_of(path, data_, fit_.numerics);
    const Spread left = spread_of(path, data_, fit_.numerics);
    bool changed = !measured_;
    for (std::size_t r = 0; r < data_.size(); ++r)
      for (const plant::ChannelId c : correlation_[r].ids()) {
        const double weighted = left.deviation[r][c] * std::sqrt(correlation_[r][c]);
        const double now = measured_ ? std::min(yardstick_[r].deviation[c], weighted) : weighted;
        changed = changed || now < 0.95 * yardstick_[r].deviation[c];
        yardstick_[r].deviation[c] = now;
      }
    measured_ = true;
    return changed;
  }

  // Where the plant as given has gone far without an effect, the effect is begun with the values that were believed.
  Guess from_belief(const Effects& effects) const {
    Guess guess;
    for (const plant::EffectId e : effects) put_typical(guess, e);
    return guess;
  }
  void put_typical(Guess& guess, plant::EffectId e) const {
    const plant::System& system = given_.system();
    const plant::ParameterId strength = system.effects()[e].strength;
    const auto& declared = system.parameters()[strength].declaration;
    if (declared.kind != plant::Kind::toggle)
      guess.values[system.parameters()[strength].key()] = declared.typical * declared.unit.internal_per_unit;
  }

  // The core without it went far, or what it acts on has just come: the score test, linear about the core, says little of it.
  bool begins_far(plant::EffectId e) const {
    const plant::EffectInfo& effect = given_.system().effects()[e];
    return !effect.hides.empty() || effect.needs.has_value();
  }
  bool begins_far(const Effects& effects) const {
    return std::any_of(effects.begin(), effects.end(), [&](plant::EffectId e) { return begins_far(e); });
  }

  // Parts that differ, where that is no part of it yet: begun as alike as they are.
  void set_apart(const Effects& parent, std::vector<Begun>& begun) const {
    if (count_if(parent, [](const plant::EffectInfo& effect) { return effect.sharing.has_value(); }) >= settings_.most_apart) return;
    for (const plant::EffectId apart : sharings_) {
      const auto& needs = given_.system().effects()[apart].needs;
      if ((!needs || contains(parent, *needs) || given_.is_on(*needs)) && !contains(parent, apart) && !all_.contains(joined(parent, apart)))
        begun.push_back({joined(parent, apart), all_.at(parent).as_guess(), {}});
    }
  }
  template <class Is>
  std::size_t count_if(const Effects& effects, Is&& is) const {
    return static_cast<std::size_t>(
        std::count_if(effects.begin(), effects.end(), [&](plant::EffectId e) { return is(given_.system().effects()[e]); }));
  }

  static Effects joined(Effects effects, plant::EffectId more) {
    effects.insert(std::upper_bound(effects.begin(), effects.end(), more, [](auto a, auto b) { return a.index < b.index; }), more);
    return effects;
  }

  std::vector<Begun> first_round() const {
    const Explanation& core = all_.at(Effects{});
    const Effects candidates = addable(given_, settings_.without);
    std::vector<Begun> begun;
    const Scores scores = score(core, candidates, settings_.threads);
    for (const std::size_t s : scores.best) {
      const Effects alone{scores.all[s].effect};
      begun.push_back({alone, guess_with(core, scores.all[s]), {}});
      // Where the core has gone far without it, or the score is of a finite step.
      if (scores.all[s].is_difference || begins_far(scores.all[s].effect)) begun.push_back({alone, from_belief(alone), {}});
      // One belief is one start, and such a fit has several ends.
      if (begins_far(scores.all[s].effect)) {
        const plant::Plant plant = with(alone);
        const FitProblem problem(plant, fittable_parameters(plant), yardstick_, fit_.start, fit_.numerics);
        for (int start = 1; start < settings_.starts; ++start) begun.push_back({alone, drawn(problem, alone, start), {}});
      }
    }
    // Pairs by their joint score; both as believed, too.
    struct Pair {
      const Score *one, *other;
      JointScore joint;
    };
    std::vector<Pair> pairs;
    for (std::size_t i = 0; i < scores.best.size(); ++i)
      for (std::size_t j = i + 1; j < scores.best.size(); ++j) {
        const Score &one = scores.all[scores.best[i]], &other = scores.all[scores.best[j]];
        const bool seen = one.column.size() > 0 && one.column.size() == other.column.size();
        pairs.push_back({&one, &other, seen ? joint(one, other) : JointScore{}});
      }
    std::stable_sort(pairs.begin(), pairs.end(), [](const Pair& a, const Pair& b) { return a.joint.statistic > b.joint.statistic; });
    if (pairs.size() > settings_.pairs) pairs.resize(settings_.pairs);
    for (const Pair& pair : pairs) {
      const Effects both = joined({pair.one->effect}, pair.other->effect);
      Guess guess = guess_with(core, *pair.one);
      for (const auto& [key, value] : guess_with(core, *pair.other).values) guess.values.try_emplace(key, value);
      begun.push_back({both, guess, {}});
      begun.push_back({both, from_belief(both), {}});
    }
    set_apart({}, begun);
    return begun;
  }

  std::vector<Begun> next_round(std::vector<Effects> parents, std::size_t most) const {
    std::vector<Begun> begun;
    if (parents.size() > most) parents.resize(most);
    for (const Effects& parent : parents) {
      const Explanation& at = all_.at(parent);
      set_apart(parent, begun);
      if (count_if(parent, [](const plant::EffectInfo& effect) { return effect.is_of_catalogue(); }) >= settings_.most_effects) continue;
      const plant::Plant plant = with(parent);
      const Scores scores = score(at, addable(plant, settings_.without), settings_.threads);
      std::size_t scored = 0;
      for (const std::size_t s : scores.best) {
        const Score& one = scores.all[s];
        const bool far = begins_far(one.effect);
        if (!far && scored++ >= settings_.scored) continue;
        const Effects effects = joined(parent, one.effect);
        if (all_.contains(effects)) continue;
        begun.push_back({effects, guess_with(at, one), {}});
        if (!far) continue;
        Guess typical = at.as_guess();
        put_typical(typical, one.effect);
        begun.push_back({effects, typical, {}});
      }
    }
    return begun;
  }

  // What other means found, its path brought near to the recordings first, as the plant as given was: under the measure of that, which is
  // far off, a fit would not stay near.
  void take_up(const std::vector<Explanation>& found) {
    std::vector<Begun> begun(found.size());
    sim::in_parallel(found.size(), settings_.threads, [&](std::size_t i) {
      Begun& one = begun[i];
      one.effects = found[i].effects();
      std::erase_if(one.effects, [&](plant::EffectId e) { return given_.is_on(e); });
      one.fit = fitted_from(one.effects, polished(found[i], data_, fit_).of.as_guess(), 0);
    });
    for (const Begun& one : begun)
      if (!one.effects.empty()) keep(one);
  }

  void fit_all(std::vector<Begun>& begun, int iterations) const {
    sim::in_parallel(begun.size(), settings_.threads,
                     [&](std::size_t i) { begun[i].fit = fitted_from(begun[i].effects, begun[i].guess, iterations); });
    for (Begun& one : begun)
      if (one.fit.usable) one.guess = one.fit.as_guess();
    std::stable_sort(begun.begin(), begun.end(),
                     [&](const Begun& a, const Begun& b) { return log_odds(a.effects, a.fit) > log_odds(b.effects, b.fit); });
    std::erase_if(begun, [](const Begun& one) { return !one.fit.usable; });
  }

  // The better half is fitted further, and what begins far; of that the better half to the end, but no fewer than twice the beam.
  void halve(std::vector<Begun>& begun) const {
    fit_all(begun, short_fit);
    const std::size_t half = std::max(begun.size() / 2, 2 * settings_.width);
    std::vector<Begun> kept;
    for (std::size_t i = 0; i < begun.size(); ++i)
      if (i < half || begins_far(begun[i].effects)) kept.push_back(std::move(begun[i]));
    begun = std::move(kept);
    fit_all(begun, middle_fit);
    begun.resize(std::min(begun.size(), 2 * settings_.width), Begun{});
    fit_all(begun, long_fit);
  }

  // The yardstick as the best leaves it; the best, and what they are compared with, fitted again under it, the plant
  // as given also from the best's own values.
  void settle() {
    for (int pass = 0; pass < 2; ++pass) {
      const Effects leading = best();
      if (!all_.at(leading).usable || (!measure_by(fitted(all_.at(leading))) && pass > 0)) return;
      const std::vector<Effects> sets = order();
      const double odds = log_odds(leading, all_.at(leading));
      std::vector<Begun> again;
      for (std::size_t i = 0; i < sets.size(); ++i)
        if (i < 2 * settings_.width || includes(standing_, sets[i]) || log_odds(sets[i], all_.at(sets[i])) > odds - still_counts)
          again.push_back({sets[i], all_.at(sets[i]).as_guess(), {}});
      for (std::size_t i = 0; i < sets.size(); ++i)
        if (sets[i].size() < leading.size() && includes(leading, sets[i])) again.push_back({sets[i], all_.at(leading).as_guess(), {}});
      fit_all(again, long_fit);
      const auto before = std::move(all_);
      all_.clear();
      folds_.clear();
      for (const Begun& one : again) keep(one);
      for (const Effects& always : {Effects{}, standing_})
        if (const auto as_it_was = before.find(always); as_it_was != before.end()) all_.insert(*as_it_was);
    }
  }

  // The best two from several starts drawn from half the prior.
  void restart() {
    std::vector<Effects> sets = order();
    std::erase_if(sets, [](const Effects& effects) { return effects.empty(); });
    if (sets.size() > 2) sets.resize(2);
    std::vector<Begun> begun;
    for (const Effects& effects : sets)
      for (int start = 1; start < settings_.starts; ++start)
        begun.push_back({effects, drawn(*all_.at(effects).problem, effects, start), {}});
    halve(begun);
    for (const Begun& one : begun) keep(one);
  }

  // Each of the effects, with what needs it, taken out.
  std::vector<Effects> less_one(const Effects& effects) const {
    std::vector<Effects> less;
    for (const plant::EffectId e : effects) {
      less.emplace_back();
      for (const plant::EffectId other : effects)
        if (other != e && given_.system().effects()[other].needs != e) less.back().push_back(other);
    }
    return less;
  }

  // Laws on what has a name, on the plant as given, and a second one on the first: the few cells of the screening that gain most.
  void seek_laws(const Effects& named) {
    std::vector<Effects> parents{named};
    if (!named.empty()) parents.push_back({});
    for (int laws = 1; laws <= settings_.most_laws; ++laws) {
      std::vector<std::pair<Effects, LawCandidate>> sought;  // parent, law
      std::vector<plant::Law> of_round;
      for (const Effects& parent : parents) {
        if (!all_.contains(parent) || !all_.at(parent).usable) continue;
        std::vector<LawCandidate> cells = screen_laws(all_.at(parent), settings_.threads);
        cells_ = std::max(cells_, static_cast<double>(cells.size()));
        std::erase_if(cells, [](const LawCandidate& one) { return one.gain <= 0.0; });
        if (cells.size() > settings_.laws) cells.resize(settings_.laws);
        for (const LawCandidate& cell : cells) {
          sought.emplace_back(parent, cell);
          of_round.push_back(cell.law);
          // Cells of two parents have knots and a size of their own; so has each a name.
          of_round.back().name =
              plant::law_words(given_.system(), cell.law) + " (" + std::to_string(laws) + "." + std::to_string(of_round.size()) + ")";
        }
      }
      if (sought.empty()) return;
      const std::size_t first = given_.system().effects().size();
      given_ = plant::carried_into(given_, plant::with_laws(given_.shared_system(), of_round));
      std::vector<Begun> begun;
      for (std::size_t i = 0; i < sought.size(); ++i) {
        const auto& [parent, cell] = sought[i];
        const plant::EffectId law{first + i};
        const auto& parameters = given_.system().effects()[law].parameters;
        Guess linear = all_.at(parent).as_guess();
        for (Eigen::Index j = 0; j < cell.weights.size(); ++j)
          linear.values[given_.system().parameters()[parameters[static_cast<std::size_t>(j) + 1]].key()] = cell.weights(j);
        begun.push_back({joined(parent, law), linear, {}});
        begun.push_back({joined(parent, law), all_.at(parent).as_guess(), {}});
        // With each effect whose form it would be.
        if (is_form_of(parent, law)) continue;
        for (const plant::EffectId e : addable(with(parent), settings_.without)) {
          if (!is_form_of({e}, law)) continue;
          Guess typical = linear;
          put_typical(typical, e);
          begun.push_back({joined(joined(parent, law), e), typical, {}});
        }
      }
      halve(begun);
      for (const Begun& one : begun) keep(one);
      settle();
      parents = {best()};
      if (laws_in(parents[0]) < laws) return;
    }
  }

  int laws_in(const Effects& effects) const {
    return static_cast<int>(count_if(effects, [](const plant::EffectInfo& effect) { return effect.law.has_value(); }));
  }

  // A proposal without each of its effects, from its own values.
  void weigh_without(const Effects& effects) {
    std::vector<Begun> begun;
    for (const Effects& rest : less_one(effects))
      if (!rest.empty()) begun.push_back({rest, all_.at(effects).as_guess(), {}});
    fit_all(begun, long_fit);
    for (const Begun& one : begun) keep(one);
  }

  // Each of the terms exchanged for the names that do best without it: what could stand in its place has a share, too. From its own values,
  // and from where the proposal is without the term, if that can be followed: else all are tried.
  void exchange(const Effects& effects) {
    const Guess own = all_.at(effects).as_guess();
    std::vector<Begun> begun;
    for (const Effects& rest : less_one(effects)) {
      const Effects others = addable(with(rest), settings_.without);
      const auto at = all_.find(rest);
      if (at == all_.end() || !at->second.usable) {
        for (const plant::EffectId other : others) {
          Guess typical = own;
          put_typical(typical, other);
          if (!contains(effects, other)) begun.push_back({joined(rest, other), typical, {}});
        }
        continue;
      }
      const Scores scores = score(at->second, others, settings_.threads);
      std::size_t taken = 0;
      for (const std::size_t s : scores.best) {
        const plant::EffectId other = scores.all[s].effect;
        if (contains(effects, other)) continue;
        if (!begins_far(other) && taken++ >= settings_.exchanged) continue;
        const Effects instead = joined(rest, other);
        const Guess scored = guess_with(at->second, scores.all[s]);
        Guess from_own = own;
        for (const auto& [key, value] : scored.values) from_own.values.try_emplace(key, value);
        begun.push_back({instead, from_own, {}});
        if (!all_.contains(instead)) begun.push_back({instead, scored, {}});
      }
    }
    halve(begun);
    for (const Begun& one : begun) keep(one);
  }

  // Without what does not pay: the effect that is missed least is taken out until it is missed. A law is missed where what is left out of
  // the fit is predicted worse without it, beyond chance; an effect of the catalogue also where the fit speaks for it and those
  // predictions do not speak against it. The name of a law is no term of its own: the odds decide.
  Effects what_pays(Effects effects) {
    while (!effects.empty()) {
      weigh_without(effects);
      Effects least;
      double most = -1e300;
      const double odds = log_odds(effects, all_.at(effects));
      for (const Effects& rest : less_one(effects)) {
        if (!all_.contains(rest) || !all_.at(rest).usable) continue;
        const double without = log_odds(rest, all_.at(rest));
        if (without <= most || (without <= odds && takes_a_name_away(effects, rest))) continue;
        most = without;
        least = rest;
      }
      if (most == -1e300) break;
      const FoldGain gain = gain_by_folds(least, effects);
      const bool a_law_less = laws_in(least) < laws_in(effects);
      if (gain.beyond_chance() || (!a_law_less && gain.value > 0.0 && odds > most + beyond_doubt)) break;
      effects = least;
    }
    return effects;
  }

  // With laws, where that predicts better than what has names alone, beyond chance.
  Effects better_with_laws(const Effects& named) {
    if (laws_in(best()) == 0) return named;
    const Effects with_laws = what_pays(best());
    if (laws_in(with_laws) == 0) return named;
    return gain_by_folds(named, with_laws).beyond_chance() ? with_laws : named;
  }

  // With the names that pay beside it. Where the plant as given is off for as long as it runs, it leaves few errors that are independent,
  // and evidence asks for more than a term needs that predicts better, beyond chance. Then that is what others are compared with: the
  // errors are counted as it leaves them.
  Effects with_what_pays(Effects effects) {
    while (const std::optional<Effects> more = one_more_that_pays(effects)) {
      const Effects before = effects;
      effects = standing_ = *more;
      count_as_left_by(all_.at(effects));
      settle();
      weigh_without(effects);
      exchange(effects);
      settle();
      if (const std::optional<Effects> instead = one_more_that_pays(before)) effects = standing_ = *instead;
      std::vector<Begun> begun = next_round({effects}, 1);
      halve(begun);
      for (const Begun& one : begun) keep(one);
      settle();
    }
    return effects;
  }
  // The likeliest of the next ones that predicts better, beyond chance.
  std::optional<Effects> one_more_that_pays(const Effects& effects) {
    if (!all_.contains(effects) || !all_.at(effects).usable) return std::nullopt;
    std::size_t asked = 0;
    for (const Effects& more : order()) {
      if (more.size() != effects.size() + 1 || !includes(more, effects) || !all_.at(more).usable) continue;
      const auto is_name = [](const plant::EffectInfo& effect) { return effect.is_of_catalogue(); };
      if (count_if(more, is_name) == count_if(effects, is_name)) continue;  // parts that differ can follow nearly anything
      if (gain_by_folds(effects, more).beyond_chance()) return more;
      if (++asked == settings_.width) break;
    }
    return std::nullopt;
  }
  void count_as_left_by(const Explanation& fit) {
    const std::vector<PerChannel> alike = samples_alike_of(fitted(fit), data_, fit_.numerics);
    for (std::size_t r = 0; r < data_.size(); ++r)
      for (const plant::ChannelId c : alike[r].ids()) correlation_[r][c] = std::min(correlation_[r][c], alike[r][c]);
  }

  FoldGain gain_by_folds(const Effects& before, const Effects& after) {
    for (const Effects& one : {before, after})
      if (!folds_.contains(one)) folds_[one] = cross_validated(fitted(all_.at(one)), data_, settings_.threads, fit_);
    return gain_of(folds_.at(before), folds_.at(after));
  }
  static bool includes(const Effects& all, const Effects& some) {
    return std::includes(all.begin(), all.end(), some.begin(), some.end(), [](auto a, auto b) { return a.index < b.index; });
  }

  Proposals ranked(const Effects& answer) const {
    Proposals result;
    result.kept_alive = thinned_.recordings;
    result.system = given_.shared_system();
    result.cells = static_cast<std::size_t>(cells_);
    for (const Effects& effects : order())
      if (all_.at(effects).usable)
        result.all.push_back({.effects = effects,
                              .fit = all_.at(effects),
                              .error = error_of(all_.at(effects)).share,
                              .log_odds = log_odds(effects, all_.at(effects)),
                              .counts = laws_in(effects) == 0 || laws_in(answer) > 0});
    if (result.all.empty()) return result;
    std::stable_partition(result.all.begin(), result.all.end(), [](const Proposal& one) { return one.counts; });
    double sum = 0.0;
    for (Proposal& one : result.all)
      if (one.counts) sum += one.probability = std::exp(one.log_odds - result.all.front().log_odds);
    for (Proposal& one : result.all) one.probability /= sum;
    for (std::size_t i = 0; i < result.all.size(); ++i)
      if (result.all[i].effects == answer) result.answer = i;
    result.fit = on_every_sample(result.all[result.answer].fit);
    return result;
  }

  // A fit of the recordings as they are, each channel's deviation worth as much.
  Explanation on_every_sample(const Explanation& few) const {
    std::vector<FitData> data = whole_;
    for (std::size_t r = 0; r < data.size(); ++r)
      for (const plant::ChannelId c : data[r].deviation.ids())
        data[r].deviation[c] =
            std::max(data[r].deviation[c], yardstick_[r].deviation[c] * std::sqrt(static_cast<double>(thinned_.every[r][c])));
    ExplanationSettings fit = fit_;
    fit.iterations_per_round = middle_fit;
    fit.numerics = numerics_;
    Explanation all = explain(few.problem->centres(), data, few.as_guess(), fit);
    return all.usable ? all : few;
  }

  plant::Plant given_;  // in a System of the laws that were tried, all off
  const std::vector<FitData>& whole_;
  const Thinned thinned_;
  const std::vector<FitData>& data_;  // thinned
  std::vector<FitData> yardstick_;
  const ProposalSettings& settings_;
  const plant::NumericalSettings numerics_;
  ExplanationSettings fit_;  // with a coarse tolerance
  // Of each recording: samples over which errors are alike, at first as the plant as given leaves them.
  std::vector<PerChannel> correlation_;
  const PerChannel scale_;  // error_size.h
  Effects standing_;        // what others are tried beside, likely or not
  bool measured_ = false;
  double cells_ = 0.0;  // in which a law was sought
  Effects sharings_;    // of parts that may differ
  std::map<Effects, Explanation, ByCatalogue> all_;
  std::map<Effects, FoldErrors, ByCatalogue> folds_;  // cross-validation of what is in `all_`, where it was asked for
};

}  // namespace

Proposals propose(const Fitted& core, const std::vector<FitData>& data, const ProposalSettings& settings, const ExplanationSettings& fit) {
  return Proposer(core, data, settings, fit).run();
}

bool is_left_out(const plant::System& system, plant::EffectId effect, const std::vector<plant::EffectId>& without) {
  const auto& form_of = system.effects()[effect].form_of;
  return contains(without, effect) || (form_of && contains(without, *form_of));
}

std::vector<plant::EffectId> addable(const plant::Plant& plant, const std::vector<plant::EffectId>& without) {
  std::vector<plant::EffectId> result;
  for (const plant::EffectId e : plant.system().effects().ids()) {
    const plant::EffectInfo& effect = plant.system().effects()[e];
    if (is_left_out(plant.system(), e, without)) continue;
    if (!plant.is_on(e) && effect.is_of_catalogue() && (!effect.needs || plant::is_on_everywhere(plant, *effect.needs)))
      result.push_back(e);
  }
  return result;
}

}  // namespace sinew::diagnose

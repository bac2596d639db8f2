// SPDX-License-Identifier: Apache-2.0
#include "diagnose/proposals.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <iterator>
#include <map>
#include <stdexcept>

#include "diagnose/free_laws.h"
#include "diagnose/search.h"
#include "sim/parallel.h"
#include "sim/random.h"

namespace sinew::diagnose {
namespace {

bool holds(const Terms& all, plant::EffectId one) { return std::find(all.begin(), all.end(), one) != all.end(); }

constexpr auto by_index = [](plant::EffectId a, plant::EffectId b) { return a.index < b.index; };
struct ByIndex {
  bool operator()(const Terms& a, const Terms& b) const {
    return std::lexicographical_compare(a.begin(), a.end(), b.begin(), b.end(), by_index);
  }
};
Terms joined(Terms terms, plant::EffectId more) {
  terms.insert(std::upper_bound(terms.begin(), terms.end(), more, by_index), more);
  return terms;
}

// The groups that the noise model has: the surroundings, and what is added to readings.
FreeForcings noise_groups(const plant::System& system) {
  FreeForcings groups = nuisance_free(system);
  for (const plant::Entry& entry : system.entries())
    if (entry.channel) groups[entry.group] = true;
  return groups;
}

// What is off from one block to the next, in units of the sensors' noise: by second differences, as of a channel (channels.h).
PerChannel roughness(const Explanation& at) {
  PerChannel squares = per_channel(at.system()), counts = squares;
  const auto& blocks = at.blocks->blocks();
  for (std::size_t b = 2; b < blocks.size(); ++b)
    for (const plant::ChannelId c : squares.ids()) {
      const std::size_t rows[] = {blocks[b - 2].row[c], blocks[b - 1].row[c], blocks[b].row[c]};
      if (blocks[b - 2].recording != blocks[b].recording || std::find(rows, rows + 3, Blocks::no_row) != rows + 3) continue;
      const auto off = [&](int k) { return at.residual(static_cast<Eigen::Index>(rows[k])); };
      squares[c] += std::pow(off(0) - 2.0 * off(1) + off(2), 2) / 6.0 * at.blocks->rows()[rows[1]].count;
      counts[c] += 1.0;
    }
  for (const plant::ChannelId c : squares.ids()) squares[c] = counts[c] > 0.0 ? std::max(1.0, std::sqrt(squares[c] / counts[c])) : 1.0;
  return squares;
}

// The sizes of the noise that make what an explanation leaves most likely, from `begin` on.
NoiseModel noise_at(const Explanation& at, NoiseModel begin) {
  begin.white = roughness(at);
  const FreeForcings groups = noise_groups(at.system());
  Path path;
  follow(*at.problem, at.z.data(), Want::points, path);
  StateNoise noise(*at.problem, *at.blocks, at.z.data(), path, nullptr, groups);
  return noise.maximise_with_white(at.residual, begin, groups, 1.2);
}

// A fit that waits to be made: which terms, and from where.
struct Begun {
  Terms terms;
  Guess guess;
  Explanation fit;
};

class Proposer {
 public:
  Proposer(const plant::Plant& nominal, const std::vector<FitData>& data, const ProposalSettings& settings, const ExplanationSettings& fit)
      : given_(nominal),
        data_(data),
        settings_(settings),
        fit_(fit),
        noise_{no_forcing(nominal.system()), per_channel(nominal.system(), 1.0)} {
    fit_.most_rounds = 1;
    fit_.enough = 0.2;
    fit_.only_start = false;
  }

  Proposals run() {
    tell(0.02, "fitting the plant as given");
    fit_given();
    // What has a name comes first: on a short recording a flexible law fits much that several effects do together.
    for (std::size_t depth = 1; depth <= settings_.most_terms; ++depth) {
      tell(0.1 + 0.5 * static_cast<double>(depth - 1) / static_cast<double>(settings_.most_terms), "trying effects");
      if (!grow(&Proposer::add_effects, {}) || best().size() < depth) break;
    }
    weigh_less();
    for (int laws = 1; laws <= settings_.most_laws; ++laws) {
      tell(0.6 + 0.15 * laws, "trying laws without a name");
      const Terms before = best();
      if (!grow(&Proposer::add_laws, {Terms{}}) || laws_in(best()) <= laws_in(before)) break;
      weigh_less();
    }
    tell(0.95, "predicting what comes");
    drop_what_does_not_predict();
    return ranked();
  }

 private:
  static constexpr int short_fit = 3, middle_fit = 8, long_fit = 20;

  void tell(double share, const std::string& doing) const {
    if (settings_.progress) settings_.progress(share, doing);
  }

  plant::Plant with(const Terms& terms) const {
    plant::Plant plant = given_;
    for (const plant::EffectId e : terms) plant = with_effect(plant, e);
    return plant;
  }
  Explanation fitted_from(const Terms& terms, const Guess& guess, int iterations) const {
    ExplanationSettings fit = fit_;
    fit.iterations_per_round = iterations;
    fit.noise = noise_;
    return explain(with(terms), data_, guess, fit);
  }

  // Every effect of the catalogue alike: one in so many is there; and every cell of a law.
  double log_prior(const Terms& terms) const {
    const plant::System& system = given_.system();
    const double named = static_cast<double>(system.without_laws()->effects().size());
    double sum = 0.0;
    for (const plant::EffectId e : terms) sum -= std::log(system.effects()[e].law ? std::max(named, cells_) : named);
    return sum;
  }
  double log_odds(const Terms& terms, const Explanation& fit) const { return fit.usable ? fit.log_evidence + log_prior(terms) : -1e300; }
  double log_odds(const Terms& terms) const { return log_odds(terms, all_.at(terms)); }

  std::vector<Terms> order() const {
    std::vector<Terms> sets;
    for (const auto& [terms, fit] : all_) sets.push_back(terms);
    std::stable_sort(sets.begin(), sets.end(), [&](const Terms& a, const Terms& b) { return log_odds(a) > log_odds(b); });
    return sets;
  }
  Terms best() const { return order().front(); }

  void keep(const Begun& one) {
    if (!one.fit.usable) return;
    const auto [at, is_new] = all_.try_emplace(one.terms, one.fit);
    if (!is_new && (!at->second.usable || one.fit.log_posterior > at->second.log_posterior)) at->second = one.fit;
  }

  // From several starts, under noise as large as what the plant with believed values leaves, and then as what the best leaves.
  void fit_given() {
    const plant::System& system = given_.system();
    ExplanationSettings none = fit_;
    none.iterations_per_round = 0;
    noise_.forcing = forcing_to_begin_with(system);
    const FreeForcings groups = noise_groups(system);
    for (const plant::EntryGroupId g : groups.ids())
      if (!groups[g]) noise_.forcing[g] = 0.0;
    Explanation believed = fitted_from({}, {}, 0);
    if (!believed.usable) throw std::runtime_error("the plant cannot be integrated over the recordings; is it near this one?");
    noise_ = noise_at(believed, noise_);
    Explanation leading = fitted_from({}, believed.as_guess(), middle_fit);
    if (!leading.usable) leading = believed;
    bool begun_elsewhere = false;
    for (int pass = 0; pass < 4; ++pass) {
      if (!lower_noise_to(leading) && pass > 0) break;
      std::vector<Begun> begun;
      if (pass > 0 && !begun_elsewhere && something_left()) {
        for (const Guess& other : with_other_starts(leading)) begun.push_back({{}, other, {}});
        for (int start = 1; start < settings_.starts; ++start) begun.push_back({{}, drawn(*leading.problem, {}, start), {}});
        fit_all(begun, middle_fit);
        if (begun.size() > 1) begun.resize(1, Begun{});
        begun_elsewhere = true;
      }
      begun.push_back({{}, leading.as_guess(), {}});
      fit_all(begun, long_fit);
      if (begun.empty()) break;
      leading = begun.front().fit;
    }
    all_[{}] = leading;
  }

  // Whether the readings have a correlated error that matters.
  bool something_left() const {
    for (const plant::Entry& entry : given_.system().entries())
      if (entry.channel && noise_.forcing[entry.group] > 0.0) return true;
    return false;
  }

  // The noise model as this explanation would have it; never larger than before. Whether it changed.
  bool lower_noise_to(const Explanation& at) {
    const NoiseModel now = noise_at(at, noise_);
    bool changed = false;
    const auto lower = [&](double& size, double to) {
      changed = changed || std::abs(to - size) > 0.1 * std::max(size, to);
      size = to;
    };
    for (const plant::EntryGroupId g : now.forcing.ids()) {
      double& size = noise_.forcing[g];
      const bool is_nuisance = given_.system().entry_groups()[g].is_nuisance;
      lower(size, is_nuisance || size == 0.0 ? now.forcing[g] : std::min(now.forcing[g], size));
    }
    for (const plant::ChannelId c : now.white.ids()) lower(noise_.white[c], now.white[c]);
    return changed;
  }

  // What is believed, the terms as is typical of them; drawn from half the prior around that.
  Guess drawn(const FitProblem& problem, const Terms& terms, int start) const {
    Guess guess = from_belief(terms);
    const sim::RandomStream chance(settings_.seed, "propose.start." + std::to_string(start));
    const std::vector<Unknown>& unknowns = problem.unknowns();
    for (std::size_t u = 0; u < unknowns.size(); ++u) {
      const Unknown& one = unknowns[u];
      double& value = guess.values.try_emplace(one.name, one.centre).first->second;
      value = std::clamp(one.value_at(one.coordinate_of(value) + 0.5 * chance.normal(u)), one.lowest, one.highest);
    }
    return guess;
  }
  Guess from_belief(const Terms& terms) const {
    Guess guess;
    for (const plant::EffectId e : terms) put_typical(guess, e);
    return guess;
  }
  void put_typical(Guess& guess, plant::EffectId e) const {
    const plant::System& system = given_.system();
    const plant::ParameterId strength = system.effects()[e].strength;
    const auto& declared = system.parameters()[strength].declaration;
    if (declared.kind != plant::Kind::toggle)
      guess.values[system.parameters()[strength].key()] = declared.typical * declared.unit.internal_per_unit;
  }

  // The plant without it went far, or what it acts on has just come: a linearised fit about that says little of it.
  bool begins_far(plant::EffectId e) const {
    const plant::EffectInfo& effect = given_.system().effects()[e];
    return !effect.hides.empty() || effect.needs.has_value();
  }
  bool begins_far(const Terms& terms) const {
    return std::any_of(terms.begin(), terms.end(), [&](plant::EffectId e) { return begins_far(e); });
  }

  // Adds to the best few proposals, and to `besides`, the terms that promise most. False where nothing promises anything.
  bool grow(void (Proposer::*add)(const Terms&, std::vector<Begun>&), const std::vector<Terms>& besides) {
    std::vector<Terms> parents = order();
    if (parents.size() > settings_.width) parents.resize(settings_.width);
    for (const Terms& one : besides)
      if (std::find(parents.begin(), parents.end(), one) == parents.end()) parents.push_back(one);
    std::vector<Begun> begun;
    for (const Terms& parent : parents)
      if (all_.at(parent).usable) (this->*add)(parent, begun);
    if (begun.empty()) return false;
    halve(begun);
    for (const Begun& one : begun) keep(one);
    settle();
    return true;
  }

  // Without each of its terms, until none of them can be spared.
  void weigh_less() {
    for (Terms leading = best(); !leading.empty();) {
      weigh_without(leading);
      if (best() == leading) break;
      leading = best();
    }
    settle();
  }

  void add_effects(const Terms& parent, std::vector<Begun>& begun) {
    const Explanation& at = all_.at(parent);
    const Scores scores = score(at, addable(with(parent), settings_.without), settings_.threads);
    std::size_t taken = 0;
    for (const std::size_t s : scores.best) {
      const Score& one = scores.all[s];
      const bool far = begins_far(one.effect);
      const bool promises = 0.5 * one.statistic > -log_prior({one.effect}) && taken < settings_.added;
      if (!one.blind && !far && !promises) continue;
      taken += promises;
      const Terms terms = joined(parent, one.effect);
      if (all_.contains(terms)) continue;
      begun.push_back({terms, guess_with(at, one), {}});
      // Where the plant has gone far without it, or the score says nothing of it.
      if (!one.blind && !far) continue;
      Guess typical = parent.empty() ? Guess{} : at.as_guess();
      put_typical(typical, one.effect);
      begun.push_back({terms, typical, {}});
    }
    if (parent.empty()) add_pairs(scores, at, begun);
  }

  void add_pairs(const Scores& scores, const Explanation& at, std::vector<Begun>& begun) const {
    struct Pair {
      const Score *one, *other;
      double gain;
    };
    std::vector<Pair> pairs;
    for (std::size_t i = 0; i < scores.best.size(); ++i)
      for (std::size_t j = i + 1; j < scores.best.size(); ++j) {
        const Score &one = scores.all[scores.best[i]], &other = scores.all[scores.best[j]];
        if (one.column.size() == 0 || one.column.size() != other.column.size()) continue;
        const double more = joint(one, other).statistic - std::max(one.statistic, other.statistic);
        if (0.5 * more > -log_prior({one.effect})) pairs.push_back({&one, &other, joint(one, other).statistic});
      }
    std::stable_sort(pairs.begin(), pairs.end(), [](const Pair& a, const Pair& b) { return a.gain > b.gain; });
    if (pairs.size() > settings_.pairs) pairs.resize(settings_.pairs);
    for (const Pair& pair : pairs) {
      Guess guess = guess_with(at, *pair.one);
      for (const auto& [key, value] : guess_with(at, *pair.other).values) guess.values.try_emplace(key, value);
      begun.push_back({joined({pair.one->effect}, pair.other->effect), guess, {}});
    }
  }

  // The cells that promise most, each at the price of one in so many.
  void add_laws(const Terms& parent, std::vector<Begun>& begun) {
    if (laws_in(parent) >= settings_.most_laws) return;
    std::vector<LawCandidate> cells = screen_laws(all_.at(parent), settings_.threads);
    cells_ = std::max(cells_, static_cast<double>(cells.size()));
    std::erase_if(cells, [&](const LawCandidate& one) { return one.gain < std::log(cells_); });
    if (cells.size() > settings_.laws) cells.resize(settings_.laws);
    if (cells.empty()) return;
    std::vector<plant::Law> laws;
    for (const LawCandidate& cell : cells) {
      laws.push_back(cell.law);
      laws.back().name = plant::law_words(given_.system(), cell.law) + " (" + std::to_string(++law_count_) + ")";
    }
    const std::size_t first = given_.system().effects().size();
    given_ = plant::carried_into(given_, plant::with_laws(given_.shared_system(), laws));
    for (std::size_t i = 0; i < cells.size(); ++i) {
      const plant::EffectId law{first + i};
      const auto& parameters = given_.system().effects()[law].parameters;
      Guess linear = all_.at(parent).as_guess();
      for (Eigen::Index j = 0; j < cells[i].weights.size(); ++j)
        linear.values[given_.system().parameters()[parameters[static_cast<std::size_t>(j) + 1]].key()] = cells[i].weights(j);
      begun.push_back({joined(parent, law), linear, {}});
    }
  }

  std::ptrdiff_t laws_in(const Terms& terms) const {
    return std::count_if(terms.begin(), terms.end(), [&](auto e) { return given_.system().effects()[e].law.has_value(); });
  }

  void fit_all(std::vector<Begun>& begun, int iterations) const {
    sim::in_parallel(begun.size(), settings_.threads,
                     [&](std::size_t i) { begun[i].fit = fitted_from(begun[i].terms, begun[i].guess, iterations); });
    for (Begun& one : begun)
      if (one.fit.usable) one.guess = one.fit.as_guess();
    std::erase_if(begun, [](const Begun& one) { return !one.fit.usable; });
    std::stable_sort(begun.begin(), begun.end(),
                     [&](const Begun& a, const Begun& b) { return log_odds(a.terms, a.fit) > log_odds(b.terms, b.fit); });
  }

  // The better half is fitted further, and what begins far; of that a few to the end, with everything that comes near the best.
  void halve(std::vector<Begun>& begun) const {
    fit_all(begun, short_fit);
    const std::size_t half = std::max(begun.size() / 2, 2 * settings_.width);
    std::vector<Begun> kept;
    for (std::size_t i = 0; i < begun.size(); ++i)
      if (i < half || begins_far(begun[i].terms)) kept.push_back(std::move(begun[i]));
    begun = std::move(kept);
    fit_all(begun, middle_fit);
    if (begun.empty()) return;
    begun.resize(std::min(begun.size(), 2 * settings_.width), Begun{});
    // What has far less than the best, of what the best has more than the plant as given, will not come near it.
    const double leading = log_odds(begun.front().terms, begun.front().fit), margin = std::max(10.0, 0.2 * (leading - log_odds(Terms{})));
    std::erase_if(begun, [&](const Begun& one) { return log_odds(one.terms, one.fit) < leading - margin; });
    fit_all(begun, long_fit);
  }

  // The noise as the best leaves it; under it are fitted again the best few, the plant as given, and what the best is compared with:
  // itself less one term, also from its own values.
  void settle() {
    for (int pass = 0; pass < 3; ++pass) {
      const Terms leading = best();
      if (!all_.at(leading).usable || (!lower_noise_to(all_.at(leading)) && pass > 0)) return;
      std::vector<Terms> sets = order();
      std::vector<Begun> again;
      for (std::size_t i = 0; i < sets.size(); ++i)
        if (i <= settings_.width || sets[i].empty()) again.push_back({sets[i], all_.at(sets[i]).as_guess(), {}});
      for (const Terms& rest : less_one(leading)) again.push_back({rest, all_.at(leading).as_guess(), {}});
      fit_all(again, middle_fit);
      all_.clear();
      for (const Begun& one : again) keep(one);
      if (all_.empty()) return;
      all_.try_emplace(Terms{});
    }
  }

  // Each of the terms, with what needs it, taken out.
  std::vector<Terms> less_one(const Terms& terms) const {
    std::vector<Terms> less;
    for (const plant::EffectId e : terms) {
      less.emplace_back();
      for (const plant::EffectId other : terms)
        if (other != e && given_.system().effects()[other].needs != e) less.back().push_back(other);
    }
    return less;
  }

  // A proposal without each of its terms, from its own values.
  void weigh_without(const Terms& terms) {
    std::vector<Begun> begun;
    for (const Terms& rest : less_one(terms)) begun.push_back({rest, all_.at(terms).as_guess(), {}});
    fit_all(begun, long_fit);
    for (const Begun& one : begun) keep(one);
  }

  // What the best has and does not bear what comes goes, with all that has it: a law that does not predict it better than the same plant
  // without it, an effect of the catalogue that predicts it worse.
  void drop_what_does_not_predict() {
    for (Terms leading = best(); !leading.empty(); leading = best()) {
      const double with_all = log_density_of_what_comes(all_.at(leading), fit_);
      const std::vector<Terms> less = less_one(leading);
      std::vector<double> without(less.size(), 1e300);
      sim::in_parallel(less.size(), settings_.threads, [&](std::size_t i) {
        const auto rest = all_.find(less[i]);
        if (rest != all_.end() && rest->second.usable) without[i] = log_density_of_what_comes(rest->second, fit_);
      });
      std::size_t worst = less.size();
      for (std::size_t i = 0; i < less.size(); ++i) {
        if (without[i] == 1e300) continue;
        const double asked = laws_in(less[i]) < laws_in(leading) ? beyond_doubt : -beyond_doubt;
        if (with_all - without[i] < asked && (worst == less.size() || without[i] > without[worst])) worst = i;
      }
      if (worst == less.size()) return;
      Terms gone;
      std::set_difference(leading.begin(), leading.end(), less[worst].begin(), less[worst].end(), std::back_inserter(gone), by_index);
      std::erase_if(all_,
                    [&](const auto& one) { return std::any_of(gone.begin(), gone.end(), [&](auto e) { return holds(one.first, e); }); });
      weigh_without(best());
    }
  }
  static constexpr double beyond_doubt = 3.0;  // of log density: twenty to one

  Proposals ranked() const {
    Proposals result;
    result.noise = noise_;
    result.system = given_.shared_system();
    result.cells = static_cast<std::size_t>(cells_);
    for (const Terms& terms : order())
      if (all_.at(terms).usable) result.all.push_back({terms, all_.at(terms), log_odds(terms), 0.0});
    double sum = 0.0;
    for (Proposal& one : result.all) sum += one.probability = std::exp(one.log_odds - result.all.front().log_odds);
    for (Proposal& one : result.all) one.probability /= sum;
    return result;
  }

  plant::Plant given_;  // in a System of the laws that were tried, all off
  const std::vector<FitData>& data_;
  const ProposalSettings& settings_;
  ExplanationSettings fit_;
  NoiseModel noise_;
  double cells_ = 0.0;  // in which a law was sought
  int law_count_ = 0;
  std::map<Terms, Explanation, ByIndex> all_;
};

}  // namespace

const Proposal* Proposals::find(const Terms& terms) const {
  for (const Proposal& one : all)
    if (one.terms == terms) return &one;
  return nullptr;
}

double Proposals::probability_of(plant::EffectId effect) const {
  double sum = 0.0;
  for (const Proposal& one : all)
    if (holds(one.terms, effect)) sum += one.probability;
  return sum;
}

Proposals propose(const plant::Plant& nominal, const std::vector<FitData>& data, const ProposalSettings& settings,
                  const ExplanationSettings& fit) {
  return Proposer(nominal, data, settings, fit).run();
}

std::vector<plant::EffectId> addable(const plant::Plant& plant, const std::vector<plant::EffectId>& without) {
  std::vector<plant::EffectId> result;
  for (const plant::EffectId e : plant.system().effects().ids()) {
    const auto& needs = plant.system().effects()[e].needs;
    if (!plant.is_on(e) && !plant.system().effects()[e].law && !holds(without, e) && (!needs || plant.is_on(*needs))) result.push_back(e);
  }
  return result;
}

// With W the filter's whitening along the path of the fit to the first part, and w, J its rows of what comes: these are given what went
// before, and off by J dz for what the first part left open, so that w ~ N(0, 1 + J C J^T) and
//   log N = -1/2 (w^T w - w^T J (C^-1 + J^T J)^-1 J^T w) - 1/2 log |1 + C J^T J| - 1/2 log det of their innovations.
double log_density_of_what_comes(const Explanation& at, const ExplanationSettings& settings) {
  constexpr double first_share = 0.7;
  ExplanationSettings fit = settings;
  fit.noise = NoiseModel{at.forcing, at.white};
  fit.most_rounds = 1;
  fit.iterations_per_round = 15;
  std::vector<FitData> first = at.problem->data();
  for (FitData& one : first) one.sample_count = static_cast<std::size_t>(first_share * static_cast<double>(one.sample_count));
  const Explanation before = explain(at.problem->centres(), first, at.as_guess(), fit);
  if (!before.usable) return -1e300;
  Path path;
  if (!follow(*at.problem, before.z.data(), Want::everything, path)) return -1e300;
  StateNoise noise(*at.problem, *at.blocks, before.z.data(), path, nullptr, with_a_size(at.forcing));
  noise.set({at.forcing, at.white});
  Eigen::MatrixXd rows(static_cast<Eigen::Index>(at.blocks->rows().size()), at.z.size() + 1);
  rows.leftCols(1) = at.blocks->means(path.residuals.data(), 1);
  rows.rightCols(at.z.size()) = at.blocks->means(path.jacobian.data(), static_cast<std::size_t>(at.z.size()));
  if (!rows.allFinite()) return -1e300;
  const double log_determinant = noise.whiten_part(rows, [&](const Blocks::Row& row) {
    return at.blocks->blocks()[row.block].first_sample >= first[row.recording].sample_count;
  });
  const Eigen::VectorXd w = rows.col(0);
  const Eigen::MatrixXd j = rows.rightCols(at.z.size());
  const Eigen::MatrixXd squares = j.transpose() * j;
  const Eigen::LLT<Eigen::MatrixXd> prior(before.covariance);
  const Eigen::MatrixXd information = prior.solve(Eigen::MatrixXd::Identity(at.z.size(), at.z.size())) + squares;
  const Eigen::LLT<Eigen::MatrixXd> both(information);
  const Eigen::VectorXd along = j.transpose() * w;
  double more = 0.0;
  for (Eigen::Index i = 0; i < at.z.size(); ++i) more += 2.0 * std::log(both.matrixL()(i, i)) + 2.0 * std::log(prior.matrixL()(i, i));
  return -0.5 * (w.squaredNorm() - along.dot(both.solve(along))) - 0.5 * more - 0.5 * log_determinant;
}

}  // namespace sinew::diagnose

// SPDX-License-Identifier: Apache-2.0
#include "plant/laws.h"

#include <algorithm>
#include <deque>
#include <stdexcept>

namespace sinew::plant {
namespace {

// The curve of a law, in numbers that carry derivatives.
template <class S>
class Curve {
 public:
  Curve(const Law& law, const S* weights) : knots_(law.knots) {
    for (Eigen::Index k = 0; k < law.curve.rows(); ++k) {
      S value(0.0);
      for (Eigen::Index j = 0; j < law.curve.cols(); ++j) value += law.curve(k, j) * weights[j];
      values_.push_back(value);
    }
  }
  S at(const S& x) const {
    if (!(value_of(x) > knots_.front())) return values_.front();
    if (!(value_of(x) < knots_.back())) return values_.back();
    const auto above = static_cast<std::size_t>(std::upper_bound(knots_.begin(), knots_.end(), value_of(x)) - knots_.begin());
    const S share = (x - knots_[above - 1]) / (knots_[above] - knots_[above - 1]);
    return values_[above - 1] + share * (values_[above] - values_[above - 1]);
  }

 private:
  std::vector<double> knots_;
  std::vector<S> values_;
};

std::vector<const Entry*> entries_of(const System& system, EntryGroupId group) {
  std::vector<const Entry*> result;
  for (const Entry& entry : system.entries())
    if (entry.group == group) result.push_back(&entry);
  return result;
}

// A law where it acts: in one part.
template <class S>
struct Term {
  std::size_t curve;
  VariableId argument;
  std::optional<VariableId> factor;
  double fading_memory_s;
  std::optional<StateId> slow, state;
  std::optional<ChannelId> channel;
  S divided_by;
};

template <class S>
class LawfulEquations final : public Equations<S> {
 public:
  LawfulEquations(std::shared_ptr<const System> alive, std::unique_ptr<Equations<S>> base, std::size_t base_states,
                  std::vector<Curve<S>> curves, std::vector<Term<S>> terms)
      : alive_(std::move(alive)),
        base_(std::move(base)),
        base_states_(base_states),
        curves_(std::move(curves)),
        terms_(std::move(terms)),
        variables_(alive_->variables().size(), S(0.0)),
        of_terms_(terms_.size(), S(0.0)) {}

  void rates(const Situation& given, const S* y, S* rates) override {
    base_->rates(given, y, rates);
    base_->variables(y, variables_.data());
    for (std::size_t t = 0; t < terms_.size(); ++t) {
      const Term<S>& term = terms_[t];
      S argument = variables_[term.argument.index];
      if (term.slow) {
        argument -= y[term.slow->index];
        rates[term.slow->index] = argument / term.fading_memory_s;
      }
      of_terms_[t] = curves_[term.curve].at(argument);
      if (term.factor) of_terms_[t] *= variables_[term.factor->index];
      if (term.state) rates[term.state->index] += of_terms_[t] / term.divided_by;
    }
  }
  void readings(const S* y, S* readings) override {
    base_->readings(y, readings);
    for (std::size_t t = 0; t < terms_.size(); ++t)
      if (terms_[t].channel) readings[terms_[t].channel->index] += of_terms_[t];
  }
  std::vector<S> rest(const Situation& given, const std::vector<std::optional<S>>& known) override {
    std::vector<S> y = base_->rest(given, {known.begin(), known.begin() + static_cast<std::ptrdiff_t>(base_states_)});
    y.resize(known.size(), S(0.0));
    rest_situation_ = given;
    std::vector<S> unused(y.size(), S(0.0));
    base_->rates(rest_situation_, y.data(), unused.data());
    base_->variables(y.data(), variables_.data());
    for (const Term<S>& term : terms_)
      if (term.slow) y[term.slow->index] = known[term.slow->index].value_or(variables_[term.argument.index]);
    return y;
  }
  S input_delay_s() const override { return base_->input_delay_s(); }
  std::vector<S> switch_times_s() const override { return base_->switch_times_s(); }
  void variables(const S* y, S* values) const override { base_->variables(y, values); }

 private:
  std::shared_ptr<const System> alive_;
  std::unique_ptr<Equations<S>> base_;
  std::size_t base_states_;
  std::vector<Curve<S>> curves_;
  std::vector<Term<S>> terms_;
  std::vector<S> variables_, of_terms_;
  Situation rest_situation_;
};

void take_values(const Plant& from, Plant& to, auto parameters) {
  for (const ParameterId p : parameters) {
    to.set(p, from.get(p));
    to.set_own_deviation(p, from.own_deviation(p));
  }
}

class LawfulSystem final : public System {
 public:
  LawfulSystem(std::shared_ptr<const System> base, std::vector<Law> laws) : base_(std::move(base)) {
    take_lists_of(*base_);
    first_law_ = laws_.size(), first_effect_ = effects_.size(), first_parameter_ = parameters_.size();
    for (Law& law : laws) add(std::move(law));
  }

  States states(const EffectsOn& on) const override {
    States list = base_->states(base_on(on));
    each_on(on, [&](const Law& law, EffectId, std::size_t) {
      if (law.fading_memory_s <= 0.0) return;
      const std::vector<const Entry*> entries = entries_of(*this, law.entry);
      for (std::size_t i = 0; i < entries.size(); ++i)
        list.push_back({law.name + ".slow" + (entries.size() > 1 ? "_" + std::to_string(i + 1) : ""), units::none,
                        law.knots.back() - law.knots.front(), AtStart::balanced});
    });
    return list;
  }
  std::unique_ptr<Equations<double>> equations(const std::vector<double>& values, const EffectsOn& on) const override {
    return equations_in<double>(values, on);
  }
  std::unique_ptr<Equations<Jet>> equations(const std::vector<Jet>& values, const EffectsOn& on) const override {
    return equations_in<Jet>(values, on);
  }
  std::vector<StartBelief> start_beliefs(const Plant& plant, std::span<const double> first_measured) const override {
    std::vector<StartBelief> beliefs = base_->start_beliefs(of_base(plant), first_measured);
    beliefs.resize(states(plant.on()).size(), StartBelief{0.0, 1.0});
    return beliefs;
  }
  std::vector<std::vector<std::pair<StateId, double>>> other_starts(const Plant& plant,
                                                                    const std::vector<std::optional<double>>& start) const override {
    if (start.empty()) return base_->other_starts(of_base(plant), start);
    const auto count = static_cast<std::ptrdiff_t>(base_->states(base_on(plant.on())).size());
    return base_->other_starts(of_base(plant), {start.begin(), start.begin() + count});
  }
  std::string structure_yaml() const override { return base_->structure_yaml(); }
  std::shared_ptr<const System> without_laws() const override { return base_->without_laws(); }
  std::shared_ptr<const System> with_own(const std::vector<std::size_t>& sharings) const override {
    return std::make_shared<const LawfulSystem>(base_->with_own(sharings),
                                                std::vector<Law>(laws_.begin() + static_cast<std::ptrdiff_t>(first_law_), laws_.end()));
  }
  Plant as_described(const Plant& plant) const override { return base_->as_described(of_base(plant)); }

 private:
  void add(Law law) {
    if (law.name.empty()) law.name = "law_" + std::to_string(laws_.size() + 1);
    const auto wrong = [&](const char* what) { throw std::invalid_argument(law.name + " " + what); };
    const std::vector<const Entry*> entries = entries_of(*this, law.entry);
    if (entries.empty() || !(entries.front()->state || entries.front()->channel)) wrong("is at no equation and no reading");
    if (law.argument.size() != entries.size()) wrong("needs one argument for each part that has its entry");
    if (!law.factor.empty() && law.factor.size() != entries.size()) wrong("needs one factor for each part that has its entry");
    for (const auto* list : {&law.argument, &law.factor})
      for (const VariableId v : *list)
        if (v.index >= variables_.size()) wrong("is of a variable that is not there");
    if (law.knots.size() < 2 || !std::is_sorted(law.knots.begin(), law.knots.end(), std::less_equal<>())) wrong("needs knots that rise");
    if (law.curve.rows() != static_cast<Eigen::Index>(law.knots.size()) || law.curve.cols() < 1) wrong("needs a value at each knot");

    const EntryGroup& group = entry_groups_[law.entry];
    const auto kept = [&](std::string text) -> std::string_view { return texts_.emplace_back(std::move(text)); };
    const EffectId effect{effects_.size()};
    EffectInfo info;
    info.name = kept(law.name);
    info.place = group.places.empty() ? group.name : group.places.front();
    const VariableInfo& variable = variables_[law.argument.front()];
    const std::string of = variable.name + (law.fading_memory_s > 0.0 ? ", less its slow part," : "");
    const std::string times = law.factor.empty() ? "" : variables_[law.factor.front()].name;
    info.equation = kept("... + g(" + of + ")" + (times.empty() ? "" : " * " + times) + ", g as drawn");
    info.words = kept((times.empty() ? "a term in " + std::string(group.words) : "a share of the " + times) + " that follows the " + of +
                      " along a curve of its own");
    info.law = laws_.size();
    info.strength = ParameterId{parameters_.size()};
    const auto declare = [&](Declaration declared) {
      info.parameters.push_back(ParameterId{parameters_.size()});
      parameters_.push_back({effect, law.name, std::move(declared)});
    };
    declare({.name = "on",
             .symbol = "",
             .unit = units::none,
             .kind = Kind::toggle,
             .range = {0.0, 1.0},
             .typical = 1.0,
             .null_value = 0.0,
             .meaning = "whether the law acts"});
    for (Eigen::Index j = 0; j < law.curve.cols(); ++j)
      declare({.name = "weight_" + std::to_string(j + 1),
               .symbol = "",
               .unit = units::none,
               .range = {-1e6, 1e6},
               .typical = law.is_sought ? 0.0 : 1.0,
               .prior_deviation = law.is_sought ? 1.0 : 0.0,
               .meaning = "of a shape of the curve"});
    effects_.push_back(std::move(info));
    laws_.push_back(std::move(law));
  }

  EffectsOn base_on(const EffectsOn& on) const { return {on.begin(), on.begin() + static_cast<std::ptrdiff_t>(first_effect_)}; }
  Plant of_base(const Plant& plant) const {
    Plant result(base_);
    take_values(plant, result, base_->parameters().ids());
    for (const EffectId e : base_->effects().ids()) result.turn(e, plant.is_on(e));
    return result;
  }

  // visit(law, its effect, index of its first weight), for the laws of this System, not its base's, that are on.
  template <class Visitor>
  void each_on(const EffectsOn& on, Visitor&& visit) const {
    for (std::size_t l = first_law_; l < laws_.size(); ++l) {
      const EffectId effect{first_effect_ + l - first_law_};
      if (on[effect.index]) visit(laws_[l], effect, effects_[effect].strength.index + 1);
    }
  }

  template <class S>
  std::unique_ptr<Equations<S>> equations_in(const std::vector<S>& values, const EffectsOn& on) const {
    std::unique_ptr<Equations<S>> base =
        base_->equations(std::vector<S>(values.begin(), values.begin() + static_cast<std::ptrdiff_t>(first_parameter_)), base_on(on));
    const std::size_t base_states = base_->states(base_on(on)).size();
    std::size_t next_state = base_states;
    std::vector<Curve<S>> curves;
    std::vector<Term<S>> terms;
    each_on(on, [&](const Law& law, EffectId, std::size_t first_weight) {
      const std::vector<const Entry*> entries = entries_of(*this, law.entry);
      for (std::size_t i = 0; i < entries.size(); ++i) {
        Term<S> term{.curve = curves.size(),
                     .argument = law.argument[i],
                     .factor = law.factor.empty() ? std::nullopt : std::optional(law.factor[i]),
                     .fading_memory_s = law.fading_memory_s,
                     .slow = std::nullopt,
                     .state = entries[i]->state,
                     .channel = entries[i]->channel,
                     .divided_by = S(1.0)};
        if (entries[i]->divided_by) term.divided_by = values[entries[i]->divided_by->index];
        if (law.fading_memory_s > 0.0) term.slow = StateId{next_state++};
        terms.push_back(std::move(term));
      }
      curves.emplace_back(law, values.data() + first_weight);
    });
    if (terms.empty()) return base;
    return std::make_unique<LawfulEquations<S>>(shared_from_this(), std::move(base), base_states, std::move(curves), std::move(terms));
  }

  std::shared_ptr<const System> base_;
  std::size_t first_law_, first_effect_, first_parameter_;
  std::deque<std::string> texts_;
};

}  // namespace

bool operator==(const Law& left, const Law& right) {
  return left.entry == right.entry && left.argument == right.argument && left.factor == right.factor &&
         left.fading_memory_s == right.fading_memory_s && left.knots == right.knots && left.curve.cols() == right.curve.cols() &&
         left.curve == right.curve && left.is_sought == right.is_sought && left.name == right.name;
}

std::shared_ptr<const System> with_laws(std::shared_ptr<const System> base, std::vector<Law> laws) {
  return std::make_shared<const LawfulSystem>(std::move(base), std::move(laws));
}

std::string law_words(const System& system, const Law& law) {
  const std::string of = system.variables()[law.argument.front()].name + (law.fading_memory_s > 0.0 ? ", less its slow part" : "");
  if (!law.factor.empty()) return system.variables()[law.factor.front()].name + " times a law of " + of;
  std::string entry(system.entry_groups()[law.entry].name);
  std::replace(entry.begin(), entry.end(), '_', ' ');
  return entry + " of " + of;
}

Plant carried_into(const Plant& plant, const std::shared_ptr<const System>& with_more_laws) {
  Plant result(with_more_laws);
  take_values(plant, result, plant.system().parameters().ids());
  for (const EffectId e : plant.system().effects().ids()) result.turn(e, plant.is_on(e));
  return result;
}

Eigen::VectorXd values_of(const Plant& plant, EffectId law) {
  const EffectInfo& info = plant.system().effects()[law];
  const Law& of = plant.system().laws()[*info.law];
  Eigen::VectorXd weights(of.curve.cols());
  for (Eigen::Index j = 0; j < weights.size(); ++j)
    weights(j) = plant.get(ParameterId{info.strength.index + 1 + static_cast<std::size_t>(j)});
  return of.curve * weights;
}

Plant with_laws_on(const Plant& plant, std::vector<Law> laws) {
  if (laws.empty()) return plant;
  Plant result = carried_into(plant, with_laws(plant.shared_system(), std::move(laws)));
  for (std::size_t e = plant.system().effects().size(); e < result.system().effects().size(); ++e) {
    result.turn(EffectId{e}, true);
    result.set(result.system().effects()[EffectId{e}].strength, 1.0);
  }
  return result;
}

Plant as_in_file(const Plant& plant) {
  const System& system = plant.system();
  std::vector<Law> known;
  for (const EffectId e : system.effects().ids()) {
    if (!system.effects()[e].law || !plant.is_on(e)) continue;
    known.push_back(system.laws()[*system.effects()[e].law]);
    known.back().curve = values_of(plant, e);
    known.back().is_sought = false;
    known.back().name.clear();
  }
  return with_laws_on(system.as_described(plant), std::move(known));
}

}  // namespace sinew::plant

// SPDX-License-Identifier: Apache-2.0
#include "plant/apart.h"

#include <algorithm>
#include <cmath>
#include <deque>
#include <stdexcept>

namespace sinew::plant {
namespace {

constexpr double alike = 0.5;  // of what is believed of a quantity: by how much parts differ

// By how much one deviation of a weight moves a quantity.
struct Step {
  bool is_factor;
  double size;  // of the logarithm, or in internal units
};

Step step_of(const Declaration& declared) {
  if (has_natural_zero(declared)) return {true, alike * std::sqrt(std::log1p(std::pow(declared.prior_deviation / declared.typical, 2)))};
  return {false, alike * declared.prior_deviation * declared.unit.internal_per_unit};
}

template <class S>
S moved(const Step& step, const S& shared, const S& weight) {
  using std::exp;
  return step.is_factor ? S(shared * exp(S(weight * step.size))) : S(shared + weight * step.size);
}

template <class Visitor>
void each_quantity(const Sharing& sharing, ParameterId first_weight, Visitor&& visit) {
  for (std::size_t m = 0; m < sharing.moves.size(); ++m)
    for (const Sharing::Quantity& quantity : sharing.moves[m])
      for (std::size_t part = 0; part < sharing.parts.size(); ++part)
        visit(quantity, part, ParameterId{first_weight.index + m * sharing.parts.size() + part});
}

ParameterId first_weight_of(const EffectInfo& effect) { return ParameterId{effect.strength.index + 1}; }

class ApartSystem final : public System {
 public:
  explicit ApartSystem(std::shared_ptr<const System> base) : base_(std::move(base)) {
    take_lists_of(*base_);
    std::vector<std::size_t> all;
    for (std::size_t s = 0; s < sharings_.size(); ++s) {
      all.push_back(s);
      add(s);
    }
    all_own_ = base_->with_own(all);
    for (const ParameterInfo& info : all_own_->parameters()) {
      const std::optional<ParameterId> same = base_->find_parameter(info.key());
      sources_.push_back(same ? Source{*same, std::nullopt, {}, {}} : own_source(info.key()));
    }
  }

  States states(const EffectsOn& on) const override { return base_->states(base_on(on)); }
  std::unique_ptr<Equations<double>> equations(const std::vector<double>& values, const EffectsOn& on) const override {
    return equations_in<double>(values, on);
  }
  std::unique_ptr<Equations<Jet>> equations(const std::vector<Jet>& values, const EffectsOn& on) const override {
    return equations_in<Jet>(values, on);
  }
  std::vector<StartBelief> start_beliefs(const Plant& plant, std::span<const double> first_measured) const override {
    const Plant own = with_own_values(plant);
    return own.system().start_beliefs(own, first_measured);
  }
  std::vector<std::vector<std::pair<StateId, double>>> other_starts(const Plant& plant,
                                                                    const std::vector<std::optional<double>>& start) const override {
    const Plant own = with_own_values(plant);
    return own.system().other_starts(own, start);
  }
  std::string structure_yaml() const override { return base_->structure_yaml(); }
  std::shared_ptr<const System> without_laws() const override { return base_->without_laws(); }

  Plant as_described(const Plant& plant) const override {
    const Plant own = with_own_values(plant);
    return own.system().as_described(own);
  }

 private:
  // Its base, with values of their own where parts are apart.
  Plant with_own_values(const Plant& plant) const {
    std::vector<std::size_t> apart;
    for (std::size_t s = 0; s < sharings_.size(); ++s)
      if (plant.is_on(effect_of(s))) apart.push_back(s);
    Plant result(apart.empty() ? base_ : base_->with_own(apart));
    for (const ParameterId p : base_->parameters().ids()) {
      const ParameterId same = result.system().parameter(base_->parameters()[p].key());
      result.set(same, plant.get(p));
      result.set_own_deviation(same, plant.own_deviation(p));
    }
    // What is known of a value that all share is known of each that one has now, and nothing has the shared one any more.
    for (const std::size_t s : apart)
      for (const ApartValue& one : values_apart(plant, effect_of(s))) {
        const ParameterId own = result.system().parameter(own_key(s, one.shared, one.part));
        const Declaration& declared = parameters_[one.shared].declaration;
        const double unit = declared.unit.internal_per_unit;
        result.set(own, std::clamp(one.value, declared.range.lowest * unit, declared.range.highest * unit));
        result.set_own_deviation(own, plant.own_deviation(one.shared));
        result.set_own_deviation(result.system().parameter(parameters_[one.shared].key()), std::nullopt);
      }
    for (const EffectId e : base_->effects().ids()) result.turn(e, plant.is_on(e));
    return result;
  }

  // Where a value of the System in which all parts have their own comes from.
  struct Source {
    ParameterId shared;
    std::optional<ParameterId> weight;
    EffectId apart;
    Step step;
  };

  EffectId effect_of(std::size_t sharing) const { return EffectId{base_->effects().size() + sharing}; }

  const std::string& own_key(std::size_t sharing, ParameterId shared, std::size_t part) const {
    for (const auto& move : sharings_[sharing].moves)
      for (const Sharing::Quantity& quantity : move)
        if (quantity.parameter == shared) return quantity.own_keys[part];
    throw std::out_of_range("no such quantity");
  }

  Source own_source(const std::string& key) const {
    std::optional<Source> found;
    for (std::size_t s = 0; s < sharings_.size(); ++s)
      each_quantity(sharings_[s], first_weight_of(effects_[effect_of(s)]),
                    [&](const Sharing::Quantity& quantity, std::size_t part, ParameterId weight) {
                      if (quantity.own_keys[part] == key)
                        found = Source{quantity.parameter, weight, effect_of(s), step_of(parameters_[quantity.parameter].declaration)};
                    });
    if (found) return *found;
    // What of an effect is not fitted has no weight: "junction.A.x" is "junction.x".
    const std::size_t first = key.find('.'), last = key.rfind('.');
    return {parameter(key.substr(0, first) + key.substr(last)), std::nullopt, {}, {}};
  }

  void add(std::size_t s) {
    const Sharing& sharing = sharings_[s];
    const auto kept = [&](std::string text) -> std::string_view { return texts_.emplace_back(std::move(text)); };
    EffectInfo info;
    const std::string each = "each " + std::string(sharing.part_word), whose = sharing.words + " of " + each;
    info.name = kept(whose);
    info.place = sharing.place;
    info.equation = "";
    info.words = kept(each + " has values of its own: " + sharing.words);
    info.needs = sharing.effect;
    info.sharing = s;
    info.strength = ParameterId{parameters_.size()};
    const EffectId effect{effects_.size()};
    const auto declare = [&](Declaration declared) {
      info.parameters.push_back(ParameterId{parameters_.size()});
      parameters_.push_back({effect, whose, std::move(declared)});
    };
    declare({.name = "on",
             .symbol = "",
             .unit = units::none,
             .kind = Kind::toggle,
             .range = {0.0, 1.0},
             .typical = 1.0,
             .null_value = 0.0,
             .meaning = "whether parts have values of their own"});
    for (std::size_t m = 0; m < sharing.moves.size(); ++m)
      for (const std::string& part : sharing.parts)
        declare({.name = parameters_[sharing.moves[m].front().parameter].declaration.name + "." + part,
                 .symbol = "",
                 .unit = units::none,
                 .range = {-8.0, 8.0},
                 .typical = 0.0,
                 .prior_deviation = 1.0,
                 .meaning = "by how many deviations this part differs"});
    effects_.push_back(std::move(info));
  }

  EffectsOn base_on(const EffectsOn& on) const { return {on.begin(), on.begin() + static_cast<std::ptrdiff_t>(base_->effects().size())}; }

  template <class S>
  std::unique_ptr<Equations<S>> equations_in(const std::vector<S>& values, const EffectsOn& on) const {
    const auto count = static_cast<std::ptrdiff_t>(base_->parameters().size());
    if (std::none_of(on.begin() + static_cast<std::ptrdiff_t>(base_->effects().size()), on.end(), [](bool one) { return one; }))
      return base_->equations(std::vector<S>(values.begin(), values.begin() + count), base_on(on));
    std::vector<S> own;
    for (const Source& source : sources_) {
      const S& shared = values[source.shared.index];
      own.push_back(source.weight && on[source.apart.index] ? moved(source.step, shared, values[source.weight->index]) : shared);
    }
    return all_own_->equations(own, base_on(on));
  }

  std::shared_ptr<const System> base_, all_own_;
  std::vector<Source> sources_;  // by parameter of all_own_
  std::deque<std::string> texts_;
};

}  // namespace

std::shared_ptr<const System> with_parts_apart(std::shared_ptr<const System> base) {
  const auto& effects = base->effects();
  const bool are_there = std::any_of(effects.begin(), effects.end(), [](const EffectInfo& effect) { return effect.sharing.has_value(); });
  if (base->sharings().empty() || are_there) return base;
  return std::make_shared<const ApartSystem>(std::move(base));
}

bool may_differ(const Plant& plant, const Sharing& sharing) {
  for (const auto& move : sharing.moves)
    for (const Sharing::Quantity& quantity : move)
      if (plant.own_deviation(quantity.parameter) == 0.0) return false;
  return true;
}

std::vector<ApartValue> values_apart(const Plant& plant, EffectId apart) {
  const System& system = plant.system();
  const EffectInfo& effect = system.effects()[apart];
  std::vector<ApartValue> result;
  each_quantity(system.sharings()[*effect.sharing], first_weight_of(effect),
                [&](const Sharing::Quantity& quantity, std::size_t part, ParameterId weight) {
                  const Step step = step_of(system.parameters()[quantity.parameter].declaration);
                  const double shared = plant.get(quantity.parameter), value = moved(step, shared, plant.get(weight));
                  result.push_back({quantity.parameter, part, weight, value,
                                    moved(Step{step.is_factor, step.is_factor ? step.size : 0.0}, 1.0, plant.get(weight)),
                                    step.is_factor ? value * step.size : step.size});
                });
  return result;
}

}  // namespace sinew::plant

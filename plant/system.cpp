// SPDX-License-Identifier: Apache-2.0
#include "plant/system.h"

#include <algorithm>
#include <stdexcept>

#include "plant/effect_set.h"
#include "plant/laws.h"

namespace sinew::plant {
namespace {

template <class List, class Matches>
auto find(const List& list, Matches&& matches) -> std::optional<typename std::remove_cvref_t<decltype(*list.ids().begin())>> {
  for (const auto id : list.ids())
    if (matches(list[id])) return id;
  return std::nullopt;
}

template <class Found>
auto required(const Found& found, const char* what, std::string_view name) {
  if (!found) throw std::out_of_range(std::string("no such ") + what + ": " + std::string(name));
  return *found;
}

}  // namespace

std::string name_in_part(std::string_view pattern, std::string_view part) {
  std::string name(pattern);
  const std::size_t at = name.find("{}");
  if (at == std::string::npos) return name;
  if (!part.empty()) return name.replace(at, 2, part);
  return name.replace(at > 0 && name[at - 1] == '_' ? at - 1 : at, at > 0 && name[at - 1] == '_' ? 3 : 2, "");
}

System::System() = default;
System::~System() = default;
const std::vector<Law>& System::laws() const { return laws_; }

std::string ParameterInfo::key() const { return owner.empty() ? declaration.name : owner + "." + declaration.name; }

std::optional<ParameterId> System::find_parameter(std::string_view key) const {
  return find(parameters_, [&](const ParameterInfo& info) { return info.key() == key; });
}
ParameterId System::parameter(std::string_view key) const { return required(find_parameter(key), "parameter", key); }
EffectId System::effect(std::string_view name) const {
  return required(find(effects_, [&](const EffectInfo& info) { return info.name == name; }), "effect", name);
}
ChannelId System::channel(std::string_view column) const {
  return required(find(channels_, [&](const ChannelInfo& info) { return info.column == column; }), "channel", column);
}

void System::take_lists_of(const System& base) {
  name_ = base.name_, words_ = base.words_;
  inputs_ = base.inputs_, channels_ = base.channels_, parameters_ = base.parameters_, effects_ = base.effects_;
  entry_groups_ = base.entry_groups_, entries_ = base.entries_, variables_ = base.variables_;
  constants_ = base.constants_, drives_ = base.drives_, loggers_ = base.loggers_;
  parts_word_ = base.parts_word_, upstream_kind_ = base.upstream_kind_, upstream_places_ = base.upstream_places_;
  averaging_s_ = base.averaging_s_;
  laws_ = base.laws_, sharings_ = base.sharings_, own_keys_ = base.own_keys_;
}

std::shared_ptr<const System> System::with_own(const std::vector<std::size_t>&) const {
  throw std::logic_error("parts of this system have no values of their own");
}

Plant System::as_described(const Plant& plant) const { return plant; }

std::optional<ParameterId> System::surroundings() const {
  for (const Entry& entry : entries_)
    if (entry.parameter) return entry.parameter;
  return std::nullopt;
}

std::vector<StartBelief> System::start_beliefs(const Plant& plant, std::span<const double>) const {
  const States list = states(plant.on());
  Situation given;
  given.inputs.assign(inputs_.size(), 0.0);
  const std::vector<double> rest = plant.equations()->rest(given, std::vector<std::optional<double>>(list.size()));
  std::vector<StartBelief> beliefs;
  for (const StateId i : list.ids()) beliefs.push_back({rest[i.index], list[i].start_deviation});
  return beliefs;
}

std::vector<std::vector<std::pair<StateId, double>>> System::other_starts(const Plant&, const std::vector<std::optional<double>>&) const {
  return {};
}

Plant::Plant(std::shared_ptr<const System> system) : system_(std::move(system)) {
  for (const ParameterInfo& info : system_->parameters()) {
    const Declaration& declared = info.declaration;
    values_.push_back(declared.null_value.value_or(declared.typical) * declared.unit.internal_per_unit);
  }
  own_deviations_.resize(values_.size());
  on_.assign(system_->effects().size(), false);
}

double Plant::deviation(ParameterId p) const {
  const Declaration& declared = system_->parameters()[p].declaration;
  return own_deviation(p).value_or(declared.prior_deviation * declared.unit.internal_per_unit);
}

double Plant::get_in_file_units(ParameterId p) const { return get(p) / system_->parameters()[p].declaration.unit.internal_per_unit; }
void Plant::set_in_file_units(ParameterId p, double value) { set(p, value * system_->parameters()[p].declaration.unit.internal_per_unit); }

void Plant::turn_on_by_strength() {
  for (const EffectId e : system_->effects().ids()) {
    const EffectInfo& info = system_->effects()[e];
    const auto is_not_null = [&](ParameterId p) { return get_in_file_units(p) != *system_->parameters()[p].declaration.null_value; };
    on_[e.index] = is_not_null(info.strength);
    for (const ParameterId own : info.own_strengths) on_[e.index] = on_[e.index] || is_not_null(own);
  }
}

std::unique_ptr<Equations<Jet>> Plant::equations_with_derivatives(const std::vector<std::pair<ParameterId, int>>& seeds) const {
  std::vector<Jet> lifted(values_.begin(), values_.end());
  for (const auto& [parameter, lane] : seeds) {
    if (parameter.index >= lifted.size()) throw std::invalid_argument("sensitivity to a parameter that is not there");
    lifted[parameter.index].v[lane] = 1.0;
  }
  return system_->equations(lifted, on_);
}

bool operator==(const Plant& left, const Plant& right) {
  if (left.on_ != right.on_ || left.values_ != right.values_ || left.own_deviations_ != right.own_deviations_ ||
      left.system_->laws() != right.system_->laws())
    return false;
  if (left.system_ == right.system_) return true;
  // Values of a part's own: the same numbers may be another part's.
  const auto same = [](const ParameterInfo& a, const ParameterInfo& b) { return a.key() == b.key(); };
  if (!std::ranges::equal(left.system_->parameters(), right.system_->parameters(), same)) return false;
  return left.system_->name() == right.system_->name() && left.system_->structure_yaml() == right.system_->structure_yaml();
}

}  // namespace sinew::plant

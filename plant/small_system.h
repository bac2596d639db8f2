// SPDX-License-Identifier: Apache-2.0
// A System whose structure is fixed, from its equations and its lists: all that a new plant needs beside one file of its own
// (docs/adding_a_system.md). The file has, as templates on the scalar S:
//
//   Core<S>     parameters and first values: `parameters(self, visit)`, as for an effect
//   Now<S>      derives from AtAnInstant<Core<S>>: what the equations compute on the way from state to rate, in this order
//     input(y)        from the state y and from input(i): what acts from outside
//     balance()       what moves the plant: forces, flows
//     rates(rate)     dy/dt of the core's states
//     reading()       fills shown[channel]: what the sensors show without noise
//     rest(known, y)  may be left out: the core's states at rest that are not 0; known[i] is the value where it is given
//   Effects<S>  a tuple of effects; each derives from WholePlant and takes part in the stages `input`, `balance` and `reading`
//               by a member function of that name, `void balance(Now<S>&) const`, called after the core's own. One with states of
//               its own has `states`, takes `const S* own` as second argument of a stage, and has `rest(now, own)` and
//               `rates(now, own, rate)`.
#pragma once

#include <algorithm>
#include <cctype>
#include <cmath>
#include <string>

#include "plant/effect_set.h"

namespace sinew::plant {

template <class CoreOfS>
struct AtAnInstant;
template <template <class> class Core, class S>
struct AtAnInstant<Core<S>> {
  const Core<S>* core = nullptr;
  const Situation* given = nullptr;
  std::vector<S> shown;  // [channels]
  S input(std::size_t i) const { return S(given->input(i)); }
};

// What an effect of a plant without parts acts on.
struct WholePlant {
  static constexpr int part = 0;
};

// The parameter that carries an effect's strength, where 0 is its null.
inline Declaration strength(const char* name, const char* symbol, Unit unit, double typical, double deviation, Range range,
                            std::string_view meaning) {
  return {.name = name,
          .symbol = symbol,
          .unit = unit,
          .range = range,
          .typical = typical,
          .null_value = 0.0,
          .prior_deviation = deviation,
          .meaning = meaning};
}

template <class S>
using Known = std::vector<std::optional<S>>;  // one a state

// sqrt(x) above `least`; below, the line from there through 0 and on: a slope for every x, and a flow that turns round where a
// level would fall below empty.
template <class S>
S signed_root(const S& x, double least) {
  using std::sqrt;
  return value_of(x) > least ? S(sqrt(x)) : S(x / std::sqrt(least));
}

// A sensor that follows late, tau dm/dt = x - m: rate of the state m, and the reading. A lag below `shortest_s` is applied to first
// order, x - tau dx/dt, which is exact in the limit.
template <class S>
S lagged_rate(const S& x, const S& x_rate, const S& m, const S& time_constant_s, double shortest_s) {
  return value_of(time_constant_s) < shortest_s ? x_rate : S((x - m) / time_constant_s);
}
template <class S>
S lagged_reading(const S& x, const S& x_rate, const S& m, const S& time_constant_s, double shortest_s) {
  return value_of(time_constant_s) < shortest_s ? S(x - time_constant_s * x_rate) : m;
}

struct SmallState {
  std::string_view key;  // ends in its unit
  Unit unit;
  double scale;               // see StateInfo
  Range range = {-1e6, 1e6};  // of first values
};

struct SmallChannel {
  ChannelInfo info;
  std::string_view shows = "";  // key of the state that it reads, if it is one
};

// Where physics may enter: the rate of `state`, or the reading of `channel`. One group each.
struct SmallEntry {
  EntryGroup group;
  std::string_view state = "";       // a key
  std::string_view divided_by = "";  // a parameter of the core, if any
  std::string_view channel = "";     // a column
};

struct SmallLists {
  std::string name;   // of the folder
  std::string words;  // "the axis"
  std::vector<SmallState> states;
  std::vector<InputInfo> inputs;
  std::vector<SmallChannel> channels;
  std::vector<SmallEntry> entries;
  std::vector<Drive> drives = {};
};

template <class S, template <class> class Core, template <class> class Now, template <class> class Effects>
class SmallEquations final : public Equations<S> {
 public:
  SmallEquations(std::shared_ptr<const System> alive, const OwnParts& own, const std::vector<S>& values, const EffectsOn& on,
                 std::size_t core_states, std::size_t states)
      : alive_(std::move(alive)), values_({}, own), on_(on), states_(states) {
    values_.assign(values);
    now_.core = &values_.core;
    now_.shown.resize(alive_->channels().size());
    for (const StateInfo& state : alive_->states(EffectsOn(on_.size(), false))) core_units_.push_back(state.unit.internal_per_unit);
    std::size_t next = core_states;
    values_.each_effect([&](auto index, const auto& instances) {
      first_[index] = next;
      if (on_[index]) next += states_per_part<typename std::remove_cvref_t<decltype(instances.sets)>::value_type>();
    });
  }
  SmallEquations(const SmallEquations&) = delete;

// Calls the member function of that name on every effect that is on and has it, with its own states where it wants them.
#define SINEW_STAGE(stage)                                              \
  each_on([&](const auto& effect, [[maybe_unused]] std::size_t first) { \
    if constexpr (requires { effect.stage(now_); })                     \
      effect.stage(now_);                                               \
    else if constexpr (requires { effect.stage(now_, y); })             \
      effect.stage(now_, y + first);                                    \
  })

  void rates(const Situation& given, const S* y, S* rates) override {
    now_.given = &given;
    now_.input(y);
    SINEW_STAGE(input);
    now_.balance();
    SINEW_STAGE(balance);
    now_.rates(rates);
    each_on([&](const auto& effect, [[maybe_unused]] std::size_t first) {
      if constexpr (HasStates<std::remove_cvref_t<decltype(effect)>>) effect.rates(now_, y + first, rates + first);
    });
  }

  void readings(const S* y, S* readings) override {
    now_.reading();
    SINEW_STAGE(reading);
    std::copy(now_.shown.begin(), now_.shown.end(), readings);
  }
#undef SINEW_STAGE

  std::vector<S> rest(const Situation& given, const Known<S>& known) override {
    std::vector<S> y(states_, S(0.0)), rate(states_, S(0.0));
    const auto put_known = [&] {
      for (std::size_t i = 0; i < states_; ++i)
        if (known[i]) y[i] = *known[i];
    };
    rest_situation_ = given;
    now_.given = &rest_situation_;
    if constexpr (requires { now_.rest(known, y.data()); }) now_.rest(known, y.data());
    put_known();
    rates(rest_situation_, y.data(), rate.data());
    each_on([&](const auto& effect, [[maybe_unused]] std::size_t first) {
      if constexpr (HasStates<std::remove_cvref_t<decltype(effect)>>) effect.rest(now_, y.data() + first);
    });
    put_known();
    return y;
  }

  S input_delay_s() const override {
    S delay(0.0);
    each_on([&](const auto& effect, std::size_t) {
      if constexpr (requires { effect.input_delay_s(); }) delay += effect.input_delay_s();
    });
    return delay;
  }

  std::vector<S> switch_times_s() const override {
    std::vector<S> times;
    each_on([&](const auto& effect, std::size_t) {
      if constexpr (requires { effect.switch_time_s(); }) times.push_back(effect.switch_time_s());
    });
    return times;
  }

  // The core's states, the inputs, the time; in the order of the System's list.
  void variables(const S* y, S* values) const override {
    std::size_t next = 0;
    for (; next < core_units_.size(); ++next) values[next] = y[next] / core_units_[next];
    for (const InputId i : alive_->inputs().ids()) values[next++] = S(now_.given->input(i.index));
    values[next] = S(now_.given->time_s);
  }

 private:
  // visit(effect, index of its first own state), for every effect that is on.
  template <class Visitor>
  void each_on(Visitor&& visit) const {
    values_.each_effect([&](auto index, const auto& instances) {
      if (on_[index]) visit(instances.of(0), first_[index]);
    });
  }

  std::shared_ptr<const System> alive_;
  ValueSet<Core<S>, Effects<S>> values_;
  EffectsOn on_;
  std::size_t states_;
  std::vector<double> core_units_;
  std::array<std::size_t, std::tuple_size_v<Effects<S>>> first_{};
  Situation rest_situation_;
  Now<S> now_;
};

// "viscous friction" of "viscous_friction_Ns_m" in N*s/m.
inline std::string words_of_key(std::string_view key, const Unit& unit) {
  std::string suffix = "_", words(key);
  for (const char c : unit.text) suffix += c == '/' ? "_" : std::isalnum(static_cast<unsigned char>(c)) ? std::string(1, c) : "";
  if (suffix.size() > 1 && words.ends_with(suffix)) words.resize(words.size() - suffix.size());
  std::replace(words.begin(), words.end(), '_', ' ');
  return words;
}

template <template <class> class Core, template <class> class Now, template <class> class Effects>
class SmallSystem final : public System {
 public:
  SmallSystem(SmallLists lists, const Description& structure, const std::vector<OwnValues>& own) : lists_(std::move(lists)) {
    if (!structure.scalar.empty() || !structure.map.empty() || !structure.list.empty())
      throw DescriptionError(structure.path, "has no structure to choose; write " + lists_.name + ": {}");
    name_ = lists_.name;
    words_ = lists_.words;
    drives_ = lists_.drives;
    const auto no_parts = [](int) { return std::vector<std::string>(); };
    using Values = ValueSet<Core<double>, Effects<double>>;
    own_ = own_parts_of(own, Values({}, {}), no_parts);
    list_parameters_and_effects(Values({}, own_), no_parts, parameters_, effects_);
    inputs_ = ListOf<InputId, InputInfo>(lists_.inputs);
    for (const SmallChannel& channel : lists_.channels) channels_.push_back(channel.info);
    list_variables_and_entries();
    // Whatever is fitted of the core might not be constant; nor might a sensor's gain.
    for (const ParameterId p : parameters_.ids())
      if (const Declaration& declared = parameters_[p].declaration; !parameters_[p].effect && declared.prior_deviation > 0.0)
        constants_.push_back({.words = "the " + words_of_key(declared.name, declared.unit),
                              .place = lists_.entries.front().group.places.front(),
                              .parameters = {p}});
    for (const ChannelId c : channels_.ids())
      for (const Entry& entry : entries_)
        if (entry.channel == c)
          constants_.push_back({.words = "the gain of the " + channels_[c].words + "'s sensor",
                                .place = entry_groups_[entry.group].places.front(),
                                .channels = {c}});
  }

  States states(const EffectsOn& on) const override {
    States list;
    for (const SmallState& state : lists_.states) list.push_back({std::string(state.key), state.unit, state.scale});
    ValueSet<Core<double>, Effects<double>>({}, {}).each_effect([&](auto index, const auto& instances) {
      using Effect = typename std::remove_cvref_t<decltype(instances.sets)>::value_type;
      if constexpr (HasStates<Effect>)
        if (on[index])
          for (const StateDeclaration& declared : Effect::states)
            list.push_back({std::string(Effect::name) + "." + std::string(declared.name), declared.unit, declared.scale, declared.at_start,
                            declared.start_deviation});
    });
    return list;
  }

  std::unique_ptr<Equations<double>> equations(const std::vector<double>& values, const EffectsOn& on) const override {
    return equations_in<double>(values, on);
  }
  std::unique_ptr<Equations<Jet>> equations(const std::vector<Jet>& values, const EffectsOn& on) const override {
    return equations_in<Jet>(values, on);
  }

  // Within their scale of rest, given what the channels show first.
  std::vector<StartBelief> start_beliefs(const Plant& plant, std::span<const double> first_measured) const override {
    const States list = states(plant.on());
    const auto equations = plant.equations();
    Known<double> known(list.size());
    Situation given;
    given.inputs.assign(inputs_.size(), 0.0);
    std::vector<double> shown(channels_.size(), 0.0), rest, rates(list.size());
    // First as if each channel showed its state itself; then by as much more as it shows less, for an offset.
    for (const int pass : {0, 1, 2}) {
      rest = equations->rest(given, known);
      if (pass == 2) break;
      if (pass == 1) {
        equations->rates(given, rest.data(), rates.data());
        equations->readings(rest.data(), shown.data());
      }
      for (const ChannelId c : channels_.ids()) {
        const std::string_view shows = lists_.channels[c.index].shows;
        if (shows.empty() || std::isnan(first_measured[c.index])) continue;
        std::optional<double>& first = known[state_of(shows).index];
        first = first.value_or(0.0) + first_measured[c.index] - shown[c.index];
      }
    }
    std::vector<StartBelief> beliefs;
    for (const StateId i : list.ids()) {
      beliefs.push_back({rest[i.index], list[i].start_deviation});
      if (i.index >= lists_.states.size()) continue;
      beliefs.back().lowest = lists_.states[i.index].range.lowest;
      beliefs.back().highest = lists_.states[i.index].range.highest;
    }
    return beliefs;
  }

  std::string structure_yaml() const override { return name_ + ": {}\n"; }

 private:
  template <class S>
  std::unique_ptr<Equations<S>> equations_in(const std::vector<S>& values, const EffectsOn& on) const {
    return std::make_unique<SmallEquations<S, Core, Now, Effects>>(shared_from_this(), own_, values, on, lists_.states.size(),
                                                                   states(on).size());
  }

  StateId state_of(std::string_view key) const {
    for (std::size_t i = 0; i < lists_.states.size(); ++i)
      if (lists_.states[i].key == key) return {i};
    throw std::out_of_range("no such state: " + std::string(key));
  }

  void list_variables_and_entries() {
    for (const SmallState& state : lists_.states) variables_.push_back({words_of_key(state.key, state.unit), std::string(state.unit.text)});
    for (const InputInfo& input : lists_.inputs) variables_.push_back({input.words, std::string(input.unit.text), true});
    variables_.push_back({"time", "s"});
    for (const SmallEntry& declared : lists_.entries) {
      Entry entry{.group = {entry_groups_.size()}};
      if (!declared.state.empty()) entry.state = state_of(declared.state);
      if (!declared.divided_by.empty()) entry.divided_by = parameter(declared.divided_by);
      if (!declared.channel.empty()) entry.channel = channel(declared.channel);
      // The equation's own state first.
      if (entry.state) entry.may_depend_on.push_back(VariableId{entry.state->index});
      for (const VariableId v : variables_.ids())
        if (!entry.state || v.index != entry.state->index) entry.may_depend_on.push_back(v);
      entry_groups_.push_back(declared.group);
      EntryGroup& group = entry_groups_[entry.group];
      if (group.begin == 0.0) group.begin = 0.5 * group.typical;
      // What enters anywhere is seen in the one channel that there is.
      if (group.alike.empty() && lists_.channels.size() == 1) group.alike = lists_.channels.front().info.kind;
      entries_.push_back(std::move(entry));
    }
  }

  SmallLists lists_;
  OwnParts own_;
};

}  // namespace sinew::plant

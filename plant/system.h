// SPDX-License-Identifier: Apache-2.0
// What a plant is to the rest of the program: lists, and functions that walk them.
//
// A System says what may be in a plant of its kind: states, inputs, channels, parameters, effects, the entries at which physics
// may enter. A Plant is a System with values: one number a parameter, and which effects are on. Equations are those of a
// Plant, for plain numbers or for numbers that carry derivatives. Whoever stands above this folder (sim, diagnose, model, report)
// knows these lists and nothing of what is behind them.
//
// A new System is one folder below this one (docs/adding_a_system.md).
#pragma once

#include <limits>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "plant/ids.h"
#include "plant/parameter.h"
#include "plant/scalar.h"

namespace sinew::plant {

// What is given from outside, in plain numbers.
struct Situation {
  double time_s = 0.0;  // since the start of the scenario or recording
  // When a held input or a switch in time last changed: within such a segment the right-hand side is smooth in time.
  double segment_start_s = 0.0;
  std::vector<double> inputs = {};      // at inputs_from_s
  std::vector<double> slopes_1_s = {};  // of each input since then; empty: all are held
  double inputs_from_s = 0.0;
  double input(std::size_t i) const { return slopes_1_s.empty() ? inputs[i] : inputs[i] + slopes_1_s[i] * (time_s - inputs_from_s); }
};

// What is known of a state where a recording begins.
enum class AtStart {
  open,      // nothing, if it begins in mid-motion
  balanced,  // that it is at rest with the others
  counted,   // in the first recording as `balanced`: what has grown since then is open where others begin
  elapsed,   // `counted`, and it is the time since then: known where recordings say when they were made
};
constexpr bool grows_between_recordings(AtStart at_start) { return at_start == AtStart::counted || at_start == AtStart::elapsed; }

struct StateInfo {
  std::string key;  // "temperature_A_degC", "viscoelastic_creep.angle_rad"; ends in its unit
  Unit unit;
  double scale;  // a change of this size is large: sets the absolute tolerance
  AtStart at_start = AtStart::open;
  double start_deviation = 0.5 * scale;                         // of the prior of an unknown start
  double safe_until = std::numeric_limits<double>::infinity();  // an experiment that is designed stays below it
};
using States = ListOf<StateId, StateInfo>;

enum class Between { held, linear };  // what an input does from one sample to the next

struct InputInfo {
  std::string column;  // "duty_A"
  std::string name;    // of the part that it drives: "A"
  std::string part;    // the same in words: "coil A"
  std::string words;   // "duty A"
  Unit unit;
  Range range;  // a recording with a value outside is refused
  Between between = Between::held;
};

struct ChannelInfo {
  std::string column;      // "temperature_A_degC"
  std::string words;       // "temperature A"
  std::string unit_words;  // "°C", as people read it
  Unit unit;
  Range range;
  double noise;  // standard deviation and quantisation of the usual sensor, in `unit`
  double step;
  std::string short_name;  // of its random stream, and in options: "temperature_A"
  // Misreadings are told by the kind: only channels of one kind can be exchanged for each other.
  std::string kind;  // "temperature", "angle"
  // What surroundings that are never quite still move it by, in `unit`: a mismatch as small as that is no sign of missing physics.
  double ordinary_disturbance = 0.0;
  // For words about a stretch of time: the input that drives the part whose sensor this is.
  std::optional<InputId> driven_by = std::nullopt;
  std::string part = "";          // "coil A"
  std::string driven_words = "";  // "is heated"
  std::string idle_words = "";    // "cools"
};

// Which way an input moves a channel: what a controller of that channel needs to know.
struct Drive {
  ChannelId channel;
  InputId input;
  double sense;  // of the channel's change, as a share of the whole: 1, -1, or between where directions are oblique
};

// A file that a logger of such a plant writes, and which of its columns are which of a recording's.
struct LoggerFormat {
  std::string_view clock_column;                                  // milliseconds since midnight; the header line begins with it
  std::vector<std::pair<std::string_view, std::string>> columns;  // of the file, of the recording
  std::vector<std::string_view> unused;                           // expected, and passed over in silence
};

// One parameter among all there are: first the core's, then each effect's, in the order of their lists.
struct ParameterInfo {
  std::optional<EffectId> effect;  // none: the core's
  std::string owner;               // name of the effect; with a part's name where that has a value of its own: "latent_heat.A"
  Declaration declaration;
  std::string key() const;  // "heat_loss_A_W_K", "thermocouple_lag.time_constant_s"
};

struct EffectInfo {
  std::string_view name;
  std::string_view place;  // "thermal", "sensor.angle"
  std::string_view equation;
  std::string_view words;
  std::vector<ParameterId> parameters;  // shared by all parts
  ParameterId strength;                 // the one among them that has a null
  std::vector<std::string> parts = {};  // names of those it acts on
  // Strengths that parts have of their own, where the file gives one.
  std::vector<ParameterId> own_strengths;
  // Of what quantity of its part it is a function, as System::variables() names it without the part: "angle", "temperature"; "other ..." of
  // the part beside it, "memory of ..." where it follows what that has been. Empty: of none of them, or of several.
  std::string_view argument = "";
  // An effect of time grows with it; what is said of one is what it has grown to after this time, in these words.
  std::string_view grown_words = "";
  std::string_view grown_unit = "";
  // What this acts on is brought by another effect: without that it cannot be on.
  std::optional<EffectId> needs = std::nullopt;
  // The same physics by another equation: a finding has the other's name, in a form of its own.
  std::optional<EffectId> form_of = std::nullopt;
  // Of these parameters a recording shows less where this is on: what is believed of them then is wider by the factor.
  std::vector<std::pair<ParameterId, double>> hides = {};
  // It begins at an instant, which is one of its parameters.
  bool begins_at_an_instant = false;
  // Where this is no effect of the catalogue but a law: which of System::laws().
  std::optional<std::size_t> law = std::nullopt;
  // Where it is none but that parts have values of their own (apart.h): which of System::sharings().
  std::optional<std::size_t> sharing = std::nullopt;
  bool is_of_catalogue() const { return !law && !sharing; }
};

// What parts of a kind share, and each may have of its own.
struct Sharing {
  struct Quantity {
    ParameterId parameter;
    std::vector<std::string> own_keys;  // [parts]: of a part's own value
  };
  std::string words;                       // "the transformation temperatures"
  std::optional<EffectId> effect;          // whose; none: the core's
  std::string_view place;                  // as an effect's
  std::string_view part_word, parts_word;  // "coil", "coils"
  std::vector<std::string> parts;          // their names
  // Each list changes together.
  std::vector<std::vector<Quantity>> moves;
};

// The same equation, or the same reading, in every part that has it. A random forcing of it has one size.
struct EntryGroup {
  std::string_view name;   // for programs: "heat"
  std::string_view words;  // "the wires' heat balances"
  std::string_view unit;   // of the forcing
  double typical;          // a size that matters, in internal units
  double correlation_time_s;
  std::vector<std::string_view> places = {};  // of the effects that enter here; where there are two, the second is the inputs' side
  std::string_view input_words = "";          // of the second: "the heating of the wires by their current"
  double begin = 0.0;                         // the size that a fit begins with
  // Up to this size a forcing is no sign of missing physics, as the air that moves around every plant; 0: any size is.
  double ordinary = 0.0;
  bool is_nuisance = false;  // the surroundings, which never move by more
  double least = 0.0;        // from where the size of the surroundings is sought
  // Groups of one such name move the same channels, and cannot be told apart without a law.
  std::string_view alike = "";
};

// Where physics may enter: one equation (a push on the rate of `state`, divided by the value of `divided_by`), or the reading of
// `channel`. Or it enters wherever
// `parameter` does, as the air around a limb.
struct Entry {
  EntryGroupId group;
  std::string part = "";  // whose it is, where a group has several: "A"
  std::optional<StateId> state = std::nullopt;
  std::optional<ParameterId> divided_by = std::nullopt;
  std::optional<ChannelId> channel = std::nullopt;
  std::optional<ParameterId> parameter = std::nullopt;
  std::vector<VariableId> may_depend_on = {};  // best guess first
  std::vector<VariableId> factors = {};        // parts of the equation, of which a law may be a share
};

// What the equations compute on the way, and a mismatch may be a function of.
struct VariableInfo {
  std::string name;        // "temperature A"
  std::string unit;        // "°C"
  bool of_inputs = false;  // what follows it comes from the inputs' side (EntryGroup::places)
};

// What is held for constant, and might not be.
struct Constant {
  std::string words;  // "the beam's stiffness"
  std::string_view place;
  std::vector<ParameterId> parameters = {};         // that change together, ...
  std::vector<ChannelId> channels = {};             // ... or readings, by a gain about ...
  std::optional<ParameterId> about = std::nullopt;  // ... this value; none: 0
  double scale = 10.0;                              // a change that matters, in `unit`
  std::string unit = "%";
};

// What is believed of a first value before a fit. Internal units.
struct StartBelief {
  double centre, deviation;
  double lowest = -1e6, highest = 1e6;
};

class Plant;
struct Law;

// The right-hand side and the readings of one plant, in one scalar. Keeps scratch: one object serves one thread.
template <class S>
class Equations {
 public:
  virtual ~Equations() = default;
  // y, rates: [states], internal units (SI, radians, degC).
  virtual void rates(const Situation& given, const S* y, S* rates) = 0;
  // After `rates` of the same instant: what the sensors would show without noise and steps. readings: [channels].
  virtual void readings(const S* y, S* readings) = 0;
  // The state at rest, but for what is given: one entry a state, each possibly empty.
  virtual std::vector<S> rest(const Situation& given, const std::vector<std::optional<S>>& known) = 0;
  // By how much inputs act late; the integrator moves their edges.
  virtual S input_delay_s() const { return S(0.0); }
  // Instants at which the right-hand side jumps.
  virtual std::vector<S> switch_times_s() const { return {}; }
  // After `rates` of the same instant: [variables], in the units of their list.
  virtual void variables(const S*, S*) const {}
};

using EffectsOn = std::vector<bool>;  // by EffectId

// The effect whose name a finding of this one has.
inline EffectId family_of(const ListOf<EffectId, EffectInfo>& effects, EffectId e) { return effects[e].form_of.value_or(e); }

class System : public std::enable_shared_from_this<System> {
 public:
  virtual ~System();
  System(const System&) = delete;
  System& operator=(const System&) = delete;

  std::string_view name() const { return name_; }
  std::string_view words() const { return words_; }  // "the limb", as sentences begin with it
  const ListOf<InputId, InputInfo>& inputs() const { return inputs_; }
  const ListOf<ChannelId, ChannelInfo>& channels() const { return channels_; }
  const ListOf<ParameterId, ParameterInfo>& parameters() const { return parameters_; }
  const ListOf<EffectId, EffectInfo>& effects() const { return effects_; }
  const ListOf<EntryGroupId, EntryGroup>& entry_groups() const { return entry_groups_; }
  const std::vector<Entry>& entries() const { return entries_; }
  const ListOf<VariableId, VariableInfo>& variables() const { return variables_; }
  const std::vector<Constant>& constants() const { return constants_; }
  const std::vector<Drive>& drives() const { return drives_; }
  // The usual logger; then, where there is one, the same with the sides exchanged.
  const std::vector<LoggerFormat>& loggers() const { return loggers_; }
  // What inputs drive, in one word: "coils".
  std::string_view parts_word() const { return parts_word_; }
  // Channels of this kind show what lies before all others, and so do the effects of these places: where they are off, only what
  // enters there can be the cause.
  std::string_view upstream_kind() const { return upstream_kind_; }
  const std::vector<std::string_view>& upstream_places() const { return upstream_places_; }
  // The parameter of the surroundings, where there is one (entries()).
  std::optional<ParameterId> surroundings() const;
  // Physics without a name, as curves (laws.h); each is an effect, too, after those of the catalogue.
  const std::vector<Law>& laws() const;
  virtual std::shared_ptr<const System> without_laws() const { return shared_from_this(); }
  const std::vector<Sharing>& sharings() const { return sharings_; }
  // Keys of what parts share of the core, of which a file can give a part a value of its own.
  const std::vector<std::string>& own_keys() const { return own_keys_; }
  // The same with values of their own for all parts of these sharings.
  virtual std::shared_ptr<const System> with_own(const std::vector<std::size_t>& sharings) const;
  // The plant without laws, and where parts are apart, with values of their own: as a file describes it.
  virtual Plant as_described(const Plant& plant) const;
  // Averages of the readings over this time lose nothing that the plant can do; 0: samples are taken as they are.
  double averaging_s() const { return averaging_s_; }

  // Throws std::out_of_range where there is none.
  ParameterId parameter(std::string_view key) const;
  EffectId effect(std::string_view name) const;
  ChannelId channel(std::string_view column) const;
  std::optional<ParameterId> find_parameter(std::string_view key) const;

  virtual States states(const EffectsOn& on) const = 0;
  virtual std::unique_ptr<Equations<double>> equations(const std::vector<double>& values, const EffectsOn& on) const = 0;
  virtual std::unique_ptr<Equations<Jet>> equations(const std::vector<Jet>& values, const EffectsOn& on) const = 0;

  // What is believed of the first values where a recording begins in mid-motion. `first_measured`: [channels], internal
  // units, NaN where a channel was never measured. One a state.
  virtual std::vector<StartBelief> start_beliefs(const Plant& plant, std::span<const double> first_measured) const;
  // Other first values that a fit which began at `start` does not feel: each a list of states and values.
  virtual std::vector<std::vector<std::pair<StateId, double>>> other_starts(const Plant& plant,
                                                                            const std::vector<std::optional<double>>& start) const;
  // The structure, as it stands in a plant file above `parameters:`; empty where the name says all. Whole lines.
  virtual std::string structure_yaml() const { return ""; }

 protected:
  System();
  void take_lists_of(const System& base);
  std::string name_, words_;
  ListOf<InputId, InputInfo> inputs_;
  ListOf<ChannelId, ChannelInfo> channels_;
  ListOf<ParameterId, ParameterInfo> parameters_;
  ListOf<EffectId, EffectInfo> effects_;
  ListOf<EntryGroupId, EntryGroup> entry_groups_;
  std::vector<Entry> entries_;
  ListOf<VariableId, VariableInfo> variables_;
  std::vector<Constant> constants_;
  std::vector<Drive> drives_;
  std::vector<LoggerFormat> loggers_;
  std::string_view parts_word_ = "inputs", upstream_kind_ = "";
  std::vector<std::string_view> upstream_places_;
  double averaging_s_ = 0.0;
  std::vector<Law> laws_;
  std::vector<Sharing> sharings_;
  std::vector<std::string> own_keys_;
};

// A system with values. Copies are cheap enough to pass around, and equal where all values are.
//
// An effect is on when a plant file names it with a value other than its null, or when someone turns it on to ask what
// it would do. An effect that is off takes no part at all: it has no states and costs nothing.
class Plant {
 public:
  Plant() = default;  // of no system; only to be assigned to
  // Nominal values, all effects off.
  explicit Plant(std::shared_ptr<const System> system);

  const System& system() const { return *system_; }
  const std::shared_ptr<const System>& shared_system() const { return system_; }
  double get(ParameterId p) const { return values_[p.index]; }                           // internal units
  void set(ParameterId p, double internal_value) { values_[p.index] = internal_value; }  // does not check the range
  double get_in_file_units(ParameterId p) const;
  void set_in_file_units(ParameterId p, double value);
  const std::vector<double>& values() const { return values_; }  // by ParameterId, internal units
  // One standard deviation of what is believed of a parameter, internal units; 0: known, and not fitted.
  double deviation(ParameterId p) const;
  // As this limb's own plant file gives it, in place of the one that is declared for every limb.
  std::optional<double> own_deviation(ParameterId p) const { return own_deviations_[p.index]; }
  void set_own_deviation(ParameterId p, std::optional<double> internal) { own_deviations_[p.index] = internal; }
  bool is_on(EffectId e) const { return on_[e.index]; }
  void turn(EffectId e, bool on) { on_[e.index] = on; }
  const EffectsOn& on() const { return on_; }
  // Turns on every effect whose strength is not at its null, and all others off.
  void turn_on_by_strength();

  States states() const { return system_->states(on_); }
  std::unique_ptr<Equations<double>> equations() const { return system_->equations(values_, on_); }
  // Every value lifted, and the derivative of lane k of parameter p set to 1 for every (p, k).
  std::unique_ptr<Equations<Jet>> equations_with_derivatives(const std::vector<std::pair<ParameterId, int>>& seeds) const;

  friend bool operator==(const Plant& left, const Plant& right);

 private:
  std::shared_ptr<const System> system_;
  std::vector<double> values_;
  std::vector<std::optional<double>> own_deviations_;
  EffectsOn on_;
};

}  // namespace sinew::plant

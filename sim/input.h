// SPDX-License-Identifier: Apache-2.0
// What drives a plant: the paper's babbling controller, open-loop signals, or the inputs of a recording.
#pragma once

#include <array>
#include <cmath>
#include <numbers>
#include <string>
#include <variant>
#include <vector>

#include "plant/parameter.h"
#include "sim/random.h"
#include "sim/recording.h"
#include "sim/signals.h"

namespace sinew::sim {

// Declares a field of a scenario: its key in YAML, what it may be, and what it is.
struct Key {
  std::string name;
  plant::Range range{0.0, 1.0};  // for numbers
  std::string meaning;
  bool required = false;
};

inline constexpr plant::Range any_time_s{0.0, 1.0e6};
inline constexpr plant::Range fraction{0.0, 1.0};

// Open-loop signals. Each adds its value to an input from `from_s` until `until_s` and nothing outside. The sum is cut to the
// input's range. Keys end in the unit of the input; `_fraction` here stands for any.
struct ConstantSignal {
  static constexpr std::string_view name = "constant";
  double value_fraction = 0.0;
  template <class Self, class Visitor>
  static void fields(Self& self, Visitor&& visit) {
    visit(self.value_fraction, Key{"value_fraction", fraction, "value, at all times", true});
  }
  double at(double, const RandomStream&) const { return value_fraction; }
};

struct StepSignal {
  static constexpr std::string_view name = "step";
  double height_fraction = 0.0, from_s = 0.0, until_s = 0.0;
  template <class Self, class Visitor>
  static void fields(Self& self, Visitor&& visit) {
    visit(self.height_fraction, Key{"height_fraction", fraction, "value while the step lasts", true});
    visit(self.from_s, Key{"from_s", any_time_s, "begin", true});
    visit(self.until_s, Key{"until_s", any_time_s, "end", true});
  }
  double at(double t, const RandomStream&) const { return t >= from_s && t < until_s ? height_fraction : 0.0; }
};

struct RampSignal {
  static constexpr std::string_view name = "ramp";
  double first_fraction = 0.0, last_fraction = 0.0, from_s = 0.0, until_s = 0.0;
  template <class Self, class Visitor>
  static void fields(Self& self, Visitor&& visit) {
    visit(self.first_fraction, Key{"first_fraction", fraction, "value at the begin", true});
    visit(self.last_fraction, Key{"last_fraction", fraction, "value at the end", true});
    visit(self.from_s, Key{"from_s", any_time_s, "begin", true});
    visit(self.until_s, Key{"until_s", any_time_s, "end", true});
  }
  double at(double t, const RandomStream&) const {
    if (t < from_s || t >= until_s) return 0.0;
    return first_fraction + (last_fraction - first_fraction) * (t - from_s) / (until_s - from_s);
  }
};

struct SineSignal {
  static constexpr std::string_view name = "sine";
  double mean_fraction = 0.0, amplitude_fraction = 0.0, period_s = 1.0, from_s = 0.0, until_s = 0.0;
  template <class Self, class Visitor>
  static void fields(Self& self, Visitor&& visit) {
    visit(self.mean_fraction, Key{"mean_fraction", {-1.0, 1.0}, "mean", true});
    visit(self.amplitude_fraction, Key{"amplitude_fraction", fraction, "amplitude", true});
    visit(self.period_s, Key{"period_s", {1.0e-3, 1.0e6}, "period", true});
    visit(self.from_s, Key{"from_s", any_time_s, "begin; the sine begins at its mean, rising", true});
    visit(self.until_s, Key{"until_s", any_time_s, "end", true});
  }
  double at(double t, const RandomStream&) const {
    if (t < from_s || t >= until_s) return 0.0;
    return mean_fraction + amplitude_fraction * std::sin(2.0 * std::numbers::pi * (t - from_s) / period_s);
  }
};

// A sine whose frequency grows steadily.
struct ChirpSignal {
  static constexpr std::string_view name = "chirp";
  double mean_fraction = 0.0, amplitude_fraction = 0.0, first_frequency_Hz = 0.01, last_frequency_Hz = 0.1, from_s = 0.0, until_s = 0.0;
  template <class Self, class Visitor>
  static void fields(Self& self, Visitor&& visit) {
    constexpr plant::Range frequencies{0.0, 1.0e3};
    visit(self.mean_fraction, Key{"mean_fraction", {-1.0, 1.0}, "mean", true});
    visit(self.amplitude_fraction, Key{"amplitude_fraction", fraction, "amplitude", true});
    visit(self.first_frequency_Hz, Key{"first_frequency_Hz", frequencies, "frequency at the begin", true});
    visit(self.last_frequency_Hz, Key{"last_frequency_Hz", frequencies, "frequency at the end", true});
    visit(self.from_s, Key{"from_s", any_time_s, "begin", true});
    visit(self.until_s, Key{"until_s", any_time_s, "end", true});
  }
  double at(double t, const RandomStream&) const {
    if (t < from_s || t >= until_s) return 0.0;
    const double since = t - from_s, slope = (last_frequency_Hz - first_frequency_Hz) / (until_s - from_s);
    return mean_fraction + amplitude_fraction * std::sin(2.0 * std::numbers::pi * (first_frequency_Hz + 0.5 * slope * since) * since);
  }
};

// Pseudo-random binary sequence: one of two values, drawn anew every `hold_s`.
struct PrbsSignal {
  static constexpr std::string_view name = "prbs";
  double low_fraction = 0.0, high_fraction = 0.0, hold_s = 1.0, from_s = 0.0, until_s = 0.0;
  template <class Self, class Visitor>
  static void fields(Self& self, Visitor&& visit) {
    visit(self.low_fraction, Key{"low_fraction", fraction, "one of the two values", true});
    visit(self.high_fraction, Key{"high_fraction", fraction, "the other", true});
    visit(self.hold_s, Key{"hold_s", {1.0e-3, 1.0e6}, "time between draws", true});
    visit(self.from_s, Key{"from_s", any_time_s, "begin", true});
    visit(self.until_s, Key{"until_s", any_time_s, "end", true});
  }
  double at(double t, const RandomStream& chance) const {
    if (t < from_s || t >= until_s) return 0.0;
    // A hair is added so that a tick on a draw's edge takes the new draw whatever the rounding.
    const auto draw = static_cast<std::uint64_t>(std::floor((t - from_s) / hold_s + 1e-9));
    return chance.uniform(draw) < 0.5 ? low_fraction : high_fraction;
  }
};

using Signal = std::variant<ConstantSignal, StepSignal, RampSignal, SineSignal, ChirpSignal, PrbsSignal>;

struct OpenLoopInput {
  std::vector<std::vector<Signal>> signals;  // of each input; shorter, or empty: nothing
};

// The paper's babbling (Sabelhaus et al. 2022): random setpoints, each held for a random time, followed by a PI law,
//   u = K_P e + K_I sum e dt, cut to [-1, 1];
// positive u drives what moves the channel up, negative u what moves it down (or nothing), each up to the limit. Every channel
// that inputs drive (System::drives) has setpoints of its own; an input gets the sum over its channels.
struct BabbleInput {
  static constexpr std::string_view name = "babble";
  double lowest_deg = -45.0, highest_deg = 45.0, shortest_hold_s = 1.0, longest_hold_s = 30.0;
  double proportional_gain_1_deg = 0.06, integral_gain_1_deg_s = 1.0e-5, duty_limit_fraction = 0.6;
  std::string positive_drives;  // name of an input's part; it and what works with it move their channel up. Empty: as the System says
  bool both_sides = true;       // false: nothing is driven by negative u
  template <class Self, class Visitor>
  static void fields(Self& self, Visitor&& visit) {
    constexpr plant::Range setpoints{-180.0, 180.0}, gains{0.0, 100.0};
    visit(self.lowest_deg, Key{"lowest_deg", setpoints, "setpoints are uniform from here", true});
    visit(self.highest_deg, Key{"highest_deg", setpoints, "to here", true});
    visit(self.shortest_hold_s, Key{"shortest_hold_s", {0.01, 1.0e6}, "a setpoint is held for a time uniform from here"});
    visit(self.longest_hold_s, Key{"longest_hold_s", {0.01, 1.0e6}, "to here"});
    visit(self.proportional_gain_1_deg, Key{"proportional_gain_1_deg", gains, "K_P"});
    visit(self.integral_gain_1_deg_s, Key{"integral_gain_1_deg_s", gains, "K_I"});
    visit(self.duty_limit_fraction, Key{"duty_limit_fraction", fraction, "the duty never passes this"});
    visit(self.positive_drives, Key{"positive_drives", {}, "what bends towards positive values"});
    visit(self.both_sides, Key{"both_coils", {}, "whether negative u drives the other side"});
  }
};

struct ReplayInput {
  static constexpr std::string_view name = "replay";
  std::string recording_path;  // as it stands in the scenario, relative to it
  Recording recording;
};

using Input = std::variant<OpenLoopInput, BabbleInput, ReplayInput>;

// What a driver remembers from tick to tick.
struct DriverState {
  struct Following {  // one channel
    std::int64_t setpoints_drawn = 0;
    double setpoint = 0.0;
    double next_setpoint_s = 0.0;
    double error_integral = 0.0;
    double last_measured = 0.0;
  };
  std::vector<Following> following;
  std::size_t replay_index = 0;
};

// Turns measurements into commands.
class Driver {
 public:
  // `system` and `input` must outlive this.
  Driver(const plant::System& system, const Input& input, std::uint64_t seed, double period_s);
  Command command(const Measurement& measured, double time_s);
  const DriverState& state() const { return state_; }
  void set_state(const DriverState& state) { state_ = state; }

 private:
  struct Followed {
    plant::ChannelId channel;
    std::vector<std::pair<plant::InputId, double>> driven_by;  // input, and which way it moves the channel
    RandomStream setpoint_chance, hold_chance;
  };
  std::vector<double> babble(const BabbleInput& input, const Measurement& measured, double time_s);
  const plant::System& system_;
  const Input& input_;
  double period_s_;
  std::vector<RandomStream> signal_chance_;
  std::vector<Followed> followed_;
  DriverState state_;
};

}  // namespace sinew::sim

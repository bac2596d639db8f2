// SPDX-License-Identifier: Apache-2.0
// Two tanks, one above the other: a pump fills the upper one, which runs out into the lower one, which runs out.
//
//   dh_1/dt = g u - a_1 sqrt(h_1)        dh_2/dt = a_1 sqrt(h_1) - a_2 sqrt(h_2)        u: pump voltage
//
// Levels are in volts of the lower tank's sensor, above the outlet; that of the upper tank is what its water would make in the
// lower one. The sensor's zero need not be at the outlet: y = h_2 + y_0.
// Source: M. Schoukens, P. Mattsson, T. Wigren, J.-P. Noel, "Cascaded tanks benchmark combining soft and hard nonlinearities",
// Workshop on Nonlinear System Identification Benchmarks, 2016. Outflow: Bernoulli, Torricelli.
#include "plant/small_system.h"
#include "plant/systems.h"

// clang-format off
namespace sinew::plant {
namespace tanks {

using Text = std::string_view;
constexpr double nearly_empty_V = 1e-3;  // below this level an outflow is linear in it
constexpr double shortest_lag_s = 1e-2;

template <class S>
struct Core {
  S pump_gain_1_s{0.05}, upper_outflow_sqrtV_s{0.07}, lower_outflow_sqrtV_s{0.07}, sensor_zero_V{0.0};

  template <class Self, class Visitor>
  static void parameters(Self& self, Visitor&& visit) {
    constexpr Text source = "a tank of this kind empties within minutes";
    const auto declared = [&](const char* name, const char* symbol, Unit unit, double typical, Text meaning) {
      return Declaration{.name = name, .symbol = symbol, .unit = unit, .range = {0.001, 5.0}, .typical = typical,
                         .prior_deviation = 0.05, .meaning = meaning, .source = source};
    };
    visit(self.pump_gain_1_s, declared("pump_gain_1_s", "g", units::per_s, 0.05, "rise of the upper level for each volt"));
    visit(self.upper_outflow_sqrtV_s, declared("upper_outflow_sqrtV_s", "a_1", units::sqrtV_s, 0.07, "outflow of the upper tank"));
    visit(self.lower_outflow_sqrtV_s, declared("lower_outflow_sqrtV_s", "a_2", units::sqrtV_s, 0.07, "outflow of the lower tank"));
    visit(self.sensor_zero_V, Declaration{.name = "sensor_zero_V", .symbol = "y_0", .unit = units::V, .range = {-5.0, 5.0}, .typical = 0.0,
                                          .prior_deviation = 1.0, .meaning = "reading when the lower tank has run out"});
  }
};

template <class S>
struct Now : AtAnInstant<Core<S>> {
  S upper_V, lower_V, pump_V, upper_rate_V_s, lower_rate_V_s;

  void input(const S* y) {
    upper_V = y[0];
    lower_V = y[1];
    pump_V = AtAnInstant<Core<S>>::input(0);
  }
  void balance() {
    const S between = this->core->upper_outflow_sqrtV_s * signed_root(upper_V, nearly_empty_V);
    upper_rate_V_s = this->core->pump_gain_1_s * pump_V - between;
    lower_rate_V_s = between - this->core->lower_outflow_sqrtV_s * signed_root(lower_V, nearly_empty_V);
  }
  void rates(S* rate) const {
    rate[0] = upper_rate_V_s;
    rate[1] = lower_rate_V_s;
  }
  void reading() { this->shown[0] = lower_V + this->core->sensor_zero_V; }
  // Of two levels that are not known, the one that keeps the other where it is; with neither, those that the pump keeps.
  void rest(const Known<S>& known, S* y) const {
    const Core<S>& c = *this->core;
    const S ratio = c.lower_outflow_sqrtV_s / c.upper_outflow_sqrtV_s;
    const S root = c.pump_gain_1_s * this->given->input(0) / c.upper_outflow_sqrtV_s;
    y[0] = known[1] ? S(ratio * ratio * *known[1]) : S(root * root);
    y[1] = (known[0] ? *known[0] : y[0]) / (ratio * ratio);
  }
};

inline Declaration spill_rate() {
  return strength("rate_1_s", "r", units::per_s, 1.0, 1.0, {0.0, 5.0}, "spilt in a second, of what stands over");
}
inline Declaration spill_height() {
  return {.name = "height_V", .symbol = "h_o", .unit = units::V, .range = {1.0, 50.0}, .typical = 10.0, .prior_deviation = 4.0,
          .meaning = "level at which it overflows"};
}

template <class S>
struct UpperOverflow : WholePlant {
  static constexpr Text name = "upper_overflow", place = "flow",
                        equation = "dh_1/dt -> dh_1/dt - q,  dh_2/dt -> dh_2/dt + s q,  q = r (h_1 - h_o)_+",
                        words = "the upper tank overflows, partly into the lower one", argument = "upper level";
  S rate_1_s{0.0}, height_V{10.0}, share_fraction{0.5};
  template <class Self, class Visitor>
  static void parameters(Self& self, Visitor&& visit) {
    visit(self.rate_1_s, spill_rate());
    visit(self.height_V, spill_height());
    visit(self.share_fraction, Declaration{.name = "share_fraction", .symbol = "s", .unit = units::none, .range = {0.0, 1.0},
                                           .typical = 0.5, .prior_deviation = 0.3, .meaning = "share that falls into the lower tank"});
  }
  void balance(Now<S>& now) const {
    const S spilt_V_s = rate_1_s * positive_part(S(now.upper_V - height_V));
    now.upper_rate_V_s -= spilt_V_s;
    now.lower_rate_V_s += share_fraction * spilt_V_s;
  }
};

template <class S>
struct LowerOverflow : WholePlant {
  static constexpr Text name = "lower_overflow", place = "flow", equation = "dh_2/dt -> dh_2/dt - r (h_2 - h_o)_+",
                        words = "the lower tank overflows", argument = "lower level";
  S rate_1_s{0.0}, height_V{10.0};
  template <class Self, class Visitor>
  static void parameters(Self& self, Visitor&& visit) {
    visit(self.rate_1_s, spill_rate());
    visit(self.height_V, spill_height());
  }
  void balance(Now<S>& now) const { now.lower_rate_V_s -= rate_1_s * positive_part(S(now.lower_V - height_V)); }
};

template <class S>
struct SensorSaturation : WholePlant {
  static constexpr Text name = "sensor_saturation", place = "sensor", equation = "y -> y - s (y - y_max)_+",
                        words = "the level sensor saturates", argument = "lower level";
  S share_fraction{0.0}, highest_V{10.0};
  template <class Self, class Visitor>
  static void parameters(Self& self, Visitor&& visit) {
    visit(self.share_fraction, strength("share_fraction", "s", units::none, 1.0, 1.0, {0.0, 1.0}, "share of what is above, not shown"));
    visit(self.highest_V, Declaration{.name = "highest_V", .symbol = "y_max", .unit = units::V, .range = {1.0, 20.0},
                                      .typical = 10.0, .prior_deviation = 0.2, .meaning = "reading at which it saturates"});
  }
  void reading(Now<S>& now) const { now.shown[0] -= share_fraction * positive_part(S(now.shown[0] - highest_V)); }
};

template <class S>
struct UpperLeak : WholePlant {
  static constexpr Text name = "upper_leak", place = "flow", equation = "dh_1/dt -> dh_1/dt - l h_1",
                        words = "the upper tank leaks", argument = "upper level";
  S leak_1_s{0.0};
  template <class Self, class Visitor>
  static void parameters(Self& self, Visitor&& visit) {
    visit(self.leak_1_s, strength("leak_1_s", "l", units::per_s, 0.002, 0.005, {0.0, 0.5}, "share of the level lost in a second"));
  }
  void balance(Now<S>& now) const { now.upper_rate_V_s -= leak_1_s * now.upper_V; }
};

template <class S>
struct PumpDeadBand : WholePlant {
  static constexpr Text name = "pump_dead_band", place = "actuation", equation = "u -> (u - u_0)_+",
                        words = "the pump does not turn at low voltage", argument = "pump voltage";
  S voltage_V{0.0};
  template <class Self, class Visitor>
  static void parameters(Self& self, Visitor&& visit) {
    visit(self.voltage_V, strength("voltage_V", "u_0", units::V, 0.3, 0.5, {0.0, 5.0}, "voltage at which it begins to turn"));
  }
  void input(Now<S>& now) const { now.pump_V = positive_part(S(now.pump_V - voltage_V)); }
};

template <class S>
struct SensorLag : WholePlant {
  static constexpr Text name = "sensor_lag", place = "sensor", equation = "tau dy/dt = h_2 - y",
                        words = "the level sensor follows late";
  static constexpr std::array states{StateDeclaration{"level_V", units::V, 5.0}};
  S time_constant_s{0.0};
  template <class Self, class Visitor>
  static void parameters(Self& self, Visitor&& visit) {
    visit(self.time_constant_s, strength("time_constant_s", "tau", units::s, 3.0, 10.0, {0.0, 120.0}, "its damping"));
  }
  void rest(const Now<S>& now, S* own) const { own[0] = now.lower_V; }
  void rates(const Now<S>& now, const S* own, S* rate) const {
    rate[0] = lagged_rate(now.lower_V, now.lower_rate_V_s, own[0], time_constant_s, shortest_lag_s);
  }
  void reading(Now<S>& now, const S* own) const {
    now.shown[0] += lagged_reading(now.lower_V, now.lower_rate_V_s, own[0], time_constant_s, shortest_lag_s) - now.lower_V;
  }
};

// Saturation after lag: the electronics saturate, the float follows late.
template <class S>
using Effects = std::tuple<UpperOverflow<S>, LowerOverflow<S>, UpperLeak<S>, PumpDeadBand<S>, SensorLag<S>, SensorSaturation<S>>;

}  // namespace tanks

std::shared_ptr<const System> make_tanks(const Description& structure, const std::vector<OwnValues>& own) {
  const SmallLists lists{
      .name = "tanks",
      .words = "the pair of tanks",
      .states = {{"upper_level_V", units::V, 5.0, {0.0, 30.0}}, {"lower_level_V", units::V, 5.0, {0.0, 30.0}}},
      .inputs = {{.column = "pump_voltage_V", .name = "pump", .part = "pump", .words = "pump voltage", .unit = units::V, .range = {0.0, 100.0}}},
      .channels = {{{.column = "level_V", .words = "level", .unit_words = "V", .unit = units::V, .range = {-1.0, 20.0},
                     .noise = 0.02, .step = 0.0, .short_name = "level", .kind = "level"}, "lower_level_V"}},
      .entries = {{.group = {.name = "upper_flow", .words = "the upper tank's balance of flows", .unit = "V/s", .typical = 0.01,
                             .correlation_time_s = 40.0, .places = {"flow", "actuation"}, .input_words = "the pump's delivery"},
                   .state = "upper_level_V"},
                  {.group = {.name = "lower_flow", .words = "the lower tank's balance of flows", .unit = "V/s", .typical = 0.01,
                             .correlation_time_s = 40.0, .places = {"flow"}},
                   .state = "lower_level_V"},
                  {.group = {.name = "level_reading", .words = "the level sensor's reading", .unit = "V", .typical = 0.1,
                             .correlation_time_s = 40.0, .places = {"sensor"}},
                   .channel = "level_V"}},
      .drives = {{ChannelId{0}, InputId{0}, 1.0}}};
  return std::make_shared<SmallSystem<tanks::Core, tanks::Now, tanks::Effects>>(lists, structure, own);
}

}  // namespace sinew::plant

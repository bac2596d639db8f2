// SPDX-License-Identifier: Apache-2.0
// An electronic circuit that moves like a mass on a spring: the Silverbox.
//
//   m d2y/dt2 + d dy/dt + k y = u + u_0        u: drive, u_0: its offset, y: displacement, all in volts
//
// Source: T. Wigren, J. Schoukens, "Three free data sets for development and benchmarking in nonlinear system identification",
// European Control Conference, 2013; nonlinearbenchmark.org. The drive changes steadily between samples.
#include "plant/small_system.h"
#include "plant/systems.h"

// clang-format off
namespace sinew::plant {
namespace silverbox {

using Text = std::string_view;
constexpr double slow_V_s = 0.5;          // dry friction is full above this speed
constexpr double shortest_lag_s = 1e-5;

template <class S>
struct Core {
  S mass_s2{5e-6}, damping_s{2e-4}, stiffness_V_V{1.0}, drive_offset_V{0.0};

  template <class Self, class Visitor>
  static void parameters(Self& self, Visitor&& visit) {
    visit(self.mass_s2, Declaration{.name = "mass_s2", .symbol = "m", .unit = units::s2, .range = {1e-7, 1e-3}, .typical = 5e-6,
                                    .prior_deviation = 3e-6, .meaning = "drive for each V/s^2", .source = "resonance near 70 Hz"});
    visit(self.damping_s, Declaration{.name = "damping_s", .symbol = "d", .unit = units::s, .range = {1e-6, 0.1}, .typical = 2e-4,
                                      .prior_deviation = 2e-4, .meaning = "drive for each V/s", .source = "a few per cent of critical"});
    visit(self.stiffness_V_V, Declaration{.name = "stiffness_V_V", .symbol = "k", .unit = units::V_V, .range = {0.01, 100.0},
                                          .typical = 1.0, .prior_deviation = 0.5, .meaning = "drive for each volt of displacement"});
    visit(self.drive_offset_V, Declaration{.name = "drive_offset_V", .symbol = "u_0", .unit = units::V, .range = {-0.5, 0.5},
                                           .typical = 0.0, .prior_deviation = 0.01, .meaning = "what is added to the drive",
                                           .source = "offset of an amplifier"});
  }
};

template <class S>
struct Now : AtAnInstant<Core<S>> {
  S displacement_V, velocity_V_s, drive_V, force_V;

  void input(const S* y) {
    displacement_V = y[0];
    velocity_V_s = y[1];
    drive_V = AtAnInstant<Core<S>>::input(0) + this->core->drive_offset_V;
  }
  void balance() { force_V = drive_V - this->core->damping_s * velocity_V_s - this->core->stiffness_V_V * displacement_V; }
  void rates(S* rate) const {
    rate[0] = velocity_V_s;
    rate[1] = force_V / this->core->mass_s2;
  }
  void reading() { this->shown[0] = displacement_V; }
  void rest(const Known<S>&, S* y) const { y[0] = (this->given->input(0) + this->core->drive_offset_V) / this->core->stiffness_V_V; }
};

template <class S>
struct CubicStiffness : WholePlant {
  static constexpr Text name = "cubic_stiffness", place = "mechanics", equation = "force -> force - k_3 y^3",
                        words = "the spring stiffens with displacement, to both sides alike", argument = "displacement";
  S stiffness_1_V2{0.0};
  template <class Self, class Visitor>
  static void parameters(Self& self, Visitor&& visit) {
    visit(self.stiffness_1_V2, strength("stiffness_1_V2", "k_3", units::per_V2, 1.0, 5.0, {-100.0, 100.0}, "drive for each V^3"));
  }
  void balance(Now<S>& now) const {
    now.force_V -= stiffness_1_V2 * now.displacement_V * now.displacement_V * now.displacement_V;
  }
};

template <class S>
struct QuadraticStiffness : WholePlant {
  static constexpr Text name = "quadratic_stiffness", place = "mechanics", equation = "force -> force - k_2 y^2",
                        words = "the spring stiffens to one side and softens to the other", argument = "displacement";
  S stiffness_1_V{0.0};
  template <class Self, class Visitor>
  static void parameters(Self& self, Visitor&& visit) {
    visit(self.stiffness_1_V, strength("stiffness_1_V", "k_2", units::per_V, 0.1, 1.0, {-20.0, 20.0}, "drive for each V^2"));
  }
  void balance(Now<S>& now) const { now.force_V -= stiffness_1_V * now.displacement_V * now.displacement_V; }
};

template <class S>
struct DryFriction : WholePlant {
  static constexpr Text name = "dry_friction", place = "mechanics", equation = "force -> force - F_c tanh(v / v_s)",
                        words = "dry friction", argument = "velocity";
  S force_V{0.0};
  template <class Self, class Visitor>
  static void parameters(Self& self, Visitor&& visit) {
    visit(self.force_V, strength("force_V", "F_c", units::V, 0.001, 0.005, {0.0, 0.5}, "drive that it takes up"));
  }
  void balance(Now<S>& now) const { now.force_V -= force_V * tanh(now.velocity_V_s / slow_V_s); }
};

template <class S>
struct QuadraticDamping : WholePlant {
  static constexpr Text name = "quadratic_damping", place = "mechanics", equation = "force -> force - d_2 |v| v",
                        words = "damping rises with the square of the velocity", argument = "velocity";
  S damping_s2_V{0.0};
  template <class Self, class Visitor>
  static void parameters(Self& self, Visitor&& visit) {
    visit(self.damping_s2_V, strength("damping_s2_V", "d_2", units::s2_V, 2e-6, 5e-6, {-1e-3, 1e-3}, "drive for each (V/s)^2"));
  }
  void balance(Now<S>& now) const {
    now.force_V -= damping_s2_V * (value_of(now.velocity_V_s) < 0.0 ? -1.0 : 1.0) * now.velocity_V_s * now.velocity_V_s;
  }
};

template <class S>
struct HardStop : WholePlant {
  static constexpr Text name = "hard_stop", place = "mechanics", equation = "force -> force - k_c (|y| - y_c)_+ sgn y",
                        words = "it runs against stops on both sides", argument = "displacement";
  S stiffness_V_V{0.0}, distance_V{0.1};
  template <class Self, class Visitor>
  static void parameters(Self& self, Visitor&& visit) {
    visit(self.stiffness_V_V, strength("stiffness_V_V", "k_c", units::V_V, 0.5, 2.0, {0.0, 100.0}, "stiffness of the contact"));
    visit(self.distance_V, Declaration{.name = "distance_V", .symbol = "y_c", .unit = units::V, .range = {0.005, 5.0}, .typical = 0.1,
                                       .prior_deviation = 0.1, .meaning = "displacement at which it touches"});
  }
  void balance(Now<S>& now) const {
    const double side = value_of(now.displacement_V) < 0.0 ? -1.0 : 1.0;
    now.force_V -= stiffness_V_V * side * positive_part(S(side * now.displacement_V - distance_V));
  }
};

template <class S>
struct SensorLag : WholePlant {
  static constexpr Text name = "sensor_lag", place = "sensor", equation = "tau dy_m/dt = y - y_m",
                        words = "the displacement is shown late";
  static constexpr std::array states{StateDeclaration{"displacement_V", units::V, 0.1}};
  S time_constant_s{0.0};
  template <class Self, class Visitor>
  static void parameters(Self& self, Visitor&& visit) {
    visit(self.time_constant_s, strength("time_constant_s", "tau", units::s, 1e-4, 3e-4, {0.0, 0.1}, "time constant of the filter"));
  }
  void rest(const Now<S>& now, S* own) const { own[0] = now.displacement_V; }
  void rates(const Now<S>& now, const S* own, S* rate) const {
    rate[0] = lagged_rate(now.displacement_V, now.velocity_V_s, own[0], time_constant_s, shortest_lag_s);
  }
  void reading(Now<S>& now, const S* own) const {
    now.shown[0] = lagged_reading(now.displacement_V, now.velocity_V_s, own[0], time_constant_s, shortest_lag_s);
  }
};

template <class S>
using Effects = std::tuple<CubicStiffness<S>, QuadraticStiffness<S>, DryFriction<S>, QuadraticDamping<S>, HardStop<S>, SensorLag<S>>;

}  // namespace silverbox

std::shared_ptr<const System> make_silverbox(const Description& structure, const std::vector<OwnValues>& own) {
  const SmallLists lists{
      .name = "silverbox",
      .words = "the oscillator",
      .states = {{"displacement_V", units::V, 0.1}, {"velocity_V_s", units::V_s, 50.0}},
      .inputs = {{.column = "drive_V", .name = "drive", .part = "drive", .words = "drive", .unit = units::V,
                  .range = {-10.0, 10.0}, .between = Between::linear}},
      .channels = {{{.column = "displacement_V", .words = "displacement", .unit_words = "V", .unit = units::V,
                     .range = {-10.0, 10.0}, .noise = 2e-4, .step = 0.0, .short_name = "displacement", .kind = "displacement"},
                    "displacement_V"}},
      .entries = {{.group = {.name = "force", .words = "the balance of forces", .unit = "V", .typical = 1e-3, .correlation_time_s = 0.01,
                             .places = {"mechanics", "actuation"}, .input_words = "the drive"},
                   .state = "velocity_V_s", .divided_by = "mass_s2"},
                  {.group = {.name = "displacement_reading", .words = "the displacement's reading", .unit = "V", .typical = 1e-3,
                             .correlation_time_s = 0.01, .places = {"sensor"}},
                   .channel = "displacement_V"}},
      .drives = {{ChannelId{0}, InputId{0}, 1.0}}};
  return std::make_shared<SmallSystem<silverbox::Core, silverbox::Now, silverbox::Effects>>(lists, structure, own);
}

}  // namespace sinew::plant

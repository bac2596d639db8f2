// SPDX-License-Identifier: Apache-2.0
// An axis that a motor moves along a rail: the electro-mechanical positioning system.
//
//   M dv/dt = g u - c v        dx/dt = v        u: motor voltage, g: known gain of drive, motor and gear
//
// Source: A. Janot, M. Gautier, M. Brunot, "Data set and reference models of EMPS", Workshop on Nonlinear System Identification
// Benchmarks, 2019; nonlinearbenchmark.org. Friction: Olsson et al. 1998.
#include "plant/small_system.h"
#include "plant/systems.h"

// clang-format off
namespace sinew::plant {
namespace emps {

using Text = std::string_view;
constexpr double stuck_m_s = 5e-4;        // dry friction is full above this speed; below, the axis creeps
constexpr double shortest_lag_s = 1e-4;

template <class S>
struct Core {
  S mass_kg{100.0}, viscous_friction_Ns_m{200.0}, drive_gain_N_V{35.0};

  template <class Self, class Visitor>
  static void parameters(Self& self, Visitor&& visit) {
    visit(self.mass_kg, Declaration{.name = "mass_kg", .symbol = "M", .unit = units::kg, .range = {1.0, 2000.0}, .typical = 100.0,
                                    .prior_deviation = 50.0, .meaning = "mass of the carriage, with what turns along with it"});
    visit(self.viscous_friction_Ns_m,
          Declaration{.name = "viscous_friction_Ns_m", .symbol = "c", .unit = units::Ns_m, .range = {0.1, 10000.0},
                      .typical = 200.0, .prior_deviation = 150.0, .meaning = "force of friction for each metre per second"});
    visit(self.drive_gain_N_V, Declaration{.name = "drive_gain_N_V", .symbol = "g", .unit = units::N_V, .range = {0.1, 1000.0},
                                           .typical = 35.0, .meaning = "force of the drive for each volt",
                                           .source = "measured apart from the motion; in the data set"});
  }
};

template <class S>
struct Now : AtAnInstant<Core<S>> {
  S position_m, velocity_m_s, voltage_V, force_N;

  void input(const S* y) {
    position_m = y[0];
    velocity_m_s = y[1];
    voltage_V = AtAnInstant<Core<S>>::input(0);
  }
  void balance() { force_N = this->core->drive_gain_N_V * voltage_V - this->core->viscous_friction_Ns_m * velocity_m_s; }
  void rates(S* rate) const {
    rate[0] = velocity_m_s;
    rate[1] = force_N / this->core->mass_kg;
  }
  void reading() { this->shown[0] = position_m; }
};

template <class S>
struct DryFriction : WholePlant {
  static constexpr Text name = "dry_friction", place = "mechanics", equation = "force -> force - F_c tanh(v / v_s)",
                        words = "the axis rubs on its rail (dry friction)", argument = "velocity";
  S force_N{0.0};
  template <class Self, class Visitor>
  static void parameters(Self& self, Visitor&& visit) {
    visit(self.force_N, strength("force_N", "F_c", units::N, 10.0, 20.0, {0.0, 500.0}, "force of dry friction"));
  }
  void balance(Now<S>& now) const { now.force_N -= force_N * tanh(now.velocity_m_s / stuck_m_s); }
};

template <class S>
struct ForceOffset : WholePlant {
  static constexpr Text name = "force_offset", place = "actuation", equation = "force -> force - F_0",
                        words = "a constant force acts (an offset of the amplifier, or a slope)";
  S force_N{0.0};
  template <class Self, class Visitor>
  static void parameters(Self& self, Visitor&& visit) {
    visit(self.force_N, strength("force_N", "F_0", units::N, 2.0, 10.0, {-200.0, 200.0}, "constant force towards negative x"));
  }
  void balance(Now<S>& now) const { now.force_N -= force_N; }
};

template <class S>
struct StribeckFriction : WholePlant {
  static constexpr Text name = "stribeck_friction", place = "mechanics",
                        equation = "force -> force - F_s tanh(v / v_s) exp(-(v / v_t)^2)",
                        words = "friction is higher at low speed (Stribeck)", argument = "velocity";
  S force_N{0.0}, speed_m_s{0.01};
  template <class Self, class Visitor>
  static void parameters(Self& self, Visitor&& visit) {
    visit(self.force_N, strength("force_N", "F_s", units::N, 5.0, 10.0, {0.0, 500.0}, "friction that vanishes with speed"));
    visit(self.speed_m_s, Declaration{.name = "speed_m_s", .symbol = "v_t", .unit = units::m_s, .range = {0.002, 0.5},
                                      .typical = 0.01, .prior_deviation = 0.02, .meaning = "speed at which it is nearly gone"});
  }
  void balance(Now<S>& now) const {
    const S ratio = now.velocity_m_s / speed_m_s;
    now.force_N -= force_N * tanh(now.velocity_m_s / stuck_m_s) * exp(-1.0 * ratio * ratio);
  }
};

template <class S>
struct QuadraticFriction : WholePlant {
  static constexpr Text name = "quadratic_friction", place = "mechanics", equation = "force -> force - c_2 |v| v",
                        words = "friction rises with the square of the speed", argument = "velocity";
  S friction_Ns2_m2{0.0};
  template <class Self, class Visitor>
  static void parameters(Self& self, Visitor&& visit) {
    visit(self.friction_Ns2_m2,
          strength("friction_Ns2_m2", "c_2", units::Ns2_m2, 100.0, 300.0, {-5000.0, 5000.0}, "force for each (m/s)^2"));
  }
  void balance(Now<S>& now) const {
    now.force_N -= friction_Ns2_m2 * (value_of(now.velocity_m_s) < 0.0 ? -1.0 : 1.0) * now.velocity_m_s * now.velocity_m_s;
  }
};

template <class S>
struct CentringSpring : WholePlant {
  static constexpr Text name = "centring_spring", place = "mechanics", equation = "force -> force - k (x - x_0)",
                        words = "a spring pulls the axis to one place (a cable)", argument = "position";
  S stiffness_N_m{0.0}, centre_m{0.1};
  template <class Self, class Visitor>
  static void parameters(Self& self, Visitor&& visit) {
    visit(self.stiffness_N_m, strength("stiffness_N_m", "k", units::N_m, 20.0, 50.0, {0.0, 5000.0}, "its stiffness"));
    visit(self.centre_m, Declaration{.name = "centre_m", .symbol = "x_0", .unit = units::m, .range = {-1.0, 1.0}, .typical = 0.1,
                                     .prior_deviation = 0.1, .meaning = "where it is slack"});
  }
  void balance(Now<S>& now) const { now.force_N -= stiffness_N_m * (now.position_m - centre_m); }
};

template <class S>
struct InputDelay : WholePlant {
  static constexpr Text name = "input_delay", place = "actuation", equation = "u(t) -> u(t - d)", words = "the drive acts late";
  S delay_s{0.0};
  template <class Self, class Visitor>
  static void parameters(Self& self, Visitor&& visit) {
    visit(self.delay_s, strength("delay_s", "d", units::s, 0.005, 0.01, {0.0, 0.5}, "from voltage to force"));
  }
  S input_delay_s() const { return delay_s; }
};

template <class S>
struct SensorLag : WholePlant {
  static constexpr Text name = "sensor_lag", place = "sensor", equation = "tau dx_m/dt = x - x_m",
                        words = "the position sensor follows late";
  static constexpr std::array states{StateDeclaration{"position_m", units::m, 0.1}};
  S time_constant_s{0.0};
  template <class Self, class Visitor>
  static void parameters(Self& self, Visitor&& visit) {
    visit(self.time_constant_s, strength("time_constant_s", "tau", units::s, 0.005, 0.02, {0.0, 1.0}, "its filter"));
  }
  void rest(const Now<S>& now, S* own) const { own[0] = now.position_m; }
  void rates(const Now<S>& now, const S* own, S* rate) const {
    rate[0] = lagged_rate(now.position_m, now.velocity_m_s, own[0], time_constant_s, shortest_lag_s);
  }
  void reading(Now<S>& now, const S* own) const {
    now.shown[0] = lagged_reading(now.position_m, now.velocity_m_s, own[0], time_constant_s, shortest_lag_s);
  }
};

template <class S>
using Effects = std::tuple<DryFriction<S>, ForceOffset<S>, StribeckFriction<S>, QuadraticFriction<S>, CentringSpring<S>,
                           InputDelay<S>, SensorLag<S>>;

}  // namespace emps

std::shared_ptr<const System> make_emps(const Description& structure, const std::vector<OwnValues>& own) {
  const SmallLists lists{
      .name = "emps",
      .words = "the axis",
      .states = {{"position_m", units::m, 0.1}, {"velocity_m_s", units::m_s, 0.1}},
      .inputs = {{.column = "motor_voltage_V", .name = "motor", .part = "motor", .words = "motor voltage", .unit = units::V, .range = {-100.0, 100.0}}},
      .channels = {{{.column = "position_m", .words = "position", .unit_words = "m", .unit = units::m, .range = {-100.0, 100.0},
                     .noise = 1e-5, .step = 0.0, .short_name = "position", .kind = "position"}, "position_m"}},
      .entries = {{.group = {.name = "force", .words = "the axis's balance of forces", .unit = "N", .typical = 2.0, .correlation_time_s = 0.5,
                             .places = {"mechanics", "actuation"}, .input_words = "the force of the motor"},
                   .state = "velocity_m_s", .divided_by = "mass_kg"},
                  {.group = {.name = "position_reading", .words = "the position sensor's reading", .unit = "m", .typical = 1e-3,
                             .correlation_time_s = 0.5, .places = {"sensor"}},
                   .channel = "position_m"}},
      .drives = {{ChannelId{0}, InputId{0}, 1.0}}};
  return std::make_shared<SmallSystem<emps::Core, emps::Now, emps::Effects>>(lists, structure, own);
}

}  // namespace sinew::plant

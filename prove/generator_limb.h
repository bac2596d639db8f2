// SPDX-License-Identifier: Apache-2.0
// The concealed limb: its numbers, and the run that integrates it. Numbers are in the units of files (degrees, °C).
#pragma once

#include <array>
#include <cstddef>
#include <vector>

namespace sinew::prove {

// Every number that the physics has. The first block is the core with its defaults (design/plant.md, section 1); all
// others stand at the value at which they vanish, and what belongs to them but is no strength at something harmless.
struct Physics {
  double supply_voltage_V = 7.0;
  double resistance_A_Ohm = 2.5, resistance_B_Ohm = 2.5;
  double heat_capacity_A_J_K = 0.85, heat_capacity_B_J_K = 0.85;
  double heat_loss_A_W_K = 0.040, heat_loss_B_W_K = 0.040;
  double ambient_temperature_degC = 25.0;
  double heating_midpoint_degC = 75.0, heating_width_K = 7.0;
  double cooling_midpoint_degC = 60.0, cooling_width_K = 7.0;
  double transformation_time_s = 0.10;
  double austenite_stiffness_N_m = 313.0, martensite_stiffness_N_m = 113.0;
  double coil_stretch_m = 0.030, transformation_stretch_m = 0.028;
  double moment_arm_A_m = 0.006, moment_arm_B_m = 0.006;
  double beam_stiffness_Nm_rad = 0.050, beam_damping_Nms_rad = 0.004, beam_inertia_kgm2 = 2.0e-5;
  double angle_offset_deg = 0.0;
  double bend_sign = 1.0;

  // Coils that are not alike: A has half of it less, B half of it more.
  double temperatures_apart_K = 0.0;                 // of both transformation temperatures
  double widths_apart = 0.0, stretches_apart = 0.0;  // of the logarithm of both widths; as a share of the transformation's stretch

  // sensor.temperature
  double lag_s = 0.0;            // tau dT_m/dt = T - T_m
  double diffusive_lag_s = 0.0;  // three equal nodes in a row behind the wire, read at the last; the sum of their delays
  // A bead in a sleeve: tau_1 dT_1/dt = T - T_1, tau_2 dT_m/dt = T_1 - T_m; each of them may be 0.
  double outer_pole_s = 0.0, inner_pole_s = 0.0;
  double sink_gain = 1.0;  // T_m = T_inf + g (T - T_inf)
  double sink_growth_1_K =
      0.0;  // T_m = T_inf + x / (1 + a |x|), x = T - T_inf: what leaves the leads goes as x (1 + ..), by free convection
  double outer_loss = 0.0, outer_power_share = 1.0;  // turns outside lose (1 + b) h and are heated (1 + q b) P
  double bow_K = 0.0;                                // T_m + 4 bow x (1 - x), x from 25 degC over 80 K

  // thermal
  double body_conductance_W_K = 0.0, body_capacity_J_K = 1.0, body_loss_W_K = 0.0;
  // The same heat in three nodes, each a third of the capacity; wires touch the first, the last loses to the air.
  double ladder_conductance_W_K = 0.0, ladder_capacity_J_K = 1.0, ladder_loss_W_K = 0.0, ladder_inner_W_K = 0.0;
  double sheath_conductance_W_K = 0.0, sheath_capacity_J_K = 1.0, sheath_loss_W_K = 0.0;
  // The body that the thermocouple sits on; none without a heat capacity. It takes a share q C_x / (C + C_x) of the coil's current heat,
  // the same in both coils (C: the mean of their wires), and the wire has the rest; it loses r C_x (T_x - T_inf);
  // G (1 + a ((T + T_x) / 2 - T_inf)) joins them. With an inner conductance it is two bodies in a row, each of half the heat
  // capacity: the first takes the heat and touches the wire, the second loses to the air and carries the thermocouple.
  double junction_capacity_J_K = 0.0, junction_cooling_rate_1_s = 0.0, junction_relative_power = 0.0;
  double junction_conductance_W_K = 0.0, junction_slope_1_K = 0.0, junction_inner_W_K = 0.0;
  // What lies around that body. With an inner conductance four nodes in a row, each of a quarter of the heat capacity; the body touches
  // the first, the last loses to the air.
  double layer_conductance_W_K = 0.0, layer_capacity_J_K = 1.0, layer_loss_W_K = 0.0, layer_inner_W_K = 0.0;
  double cross_conductance_W_K = 0.0;
  // Silicone between the wires that stores heat: 2 G (T_j - T_n) goes into it from either side, C_n dT_n/dt is their sum. At rest G lies
  // between the wires.
  double between_conductance_W_K = 0.0, between_capacity_J_K = 1.0;
  double latent_heat_J = 0.0;
  double latent_heating_J = 0.0, latent_cooling_J = 0.0;  // absorbed while xi falls, freed while it rises
  // L deta/dt, where eta follows envelopes of its own: midpoints of xi, widths of xi times a factor. Heat is kept, as eta is a state.
  double broad_latent_J = 0.0, broad_width_factor = 1.0;
  double convection_slope_1_K = 0.0;
  double convection_exponent = 0.0;    // h (|T - T_inf| / 30 K)^n
  double convection_root_1_rtK = 0.0;  // h (1 + a sqrt(|T - T_inf|))
  double radiation_W_K4 = 0.0;         // loses s (T^4 - T_inf^4) more, absolute temperatures
  double airflow_change = 0.0, airflow_onset_s = 0.0;
  // h (1 + gust g(t)): from `first` on, every `interval`, g rises smoothly over `ramp`, stays 1, and falls as smoothly.
  double gust_change = 0.0, gust_first_s = 0.0, gust_interval_s = 1.0, gust_length_s = 0.0, gust_ramp_s = 0.1;
  double ambient_rate_K_s = 0.0;
  double ambient_swing_K = 0.0, ambient_swing_period_s = 1.0;  // T_inf + swing sin(2 pi t / period)
  double motion_cooling_s_rad = 0.0;                           // h (1 + a |omega|)
  double bend_cooling_1_rad = 0.0;                             // h_A (1 + a sign theta), h_B (1 - a sign theta)
  double tension_cooling_1_N = 0.0;                            // h (1 + a max(0, F))

  // actuation
  double resistance_increase = 0.0;
  double resistance_peak = 0.0;  // R (1 + 4 rho xi (1 - xi))
  double source_resistance_Ohm = 0.0;
  // V_s - R_0 I - V_p, tau dV_p/dt = R_1 I - V_p
  double limit_resistance_Ohm = 0.0, limit_current_A = 1.0;  // V_s - R max(0, I - I_0)
  double battery_prompt_Ohm = 0.0, battery_slow_Ohm = 0.0, battery_time_s = 1.0;
  double deadband = 0.0;
  double soft_deadband = 0.0;  // u^2 / (u + u_0)
  // w ln((1 + exp((u - u_0) / w)) / (1 + exp(-u_0 / w))), w = knee u_0: u - u_0 far above u_0, nothing at 0, and a bend in between
  double knee_deadband = 0.0, knee_share = 0.3;
  double delay_s = 0.0;
  double ramp_s = 0.0;                             // the driver follows the duty with this time constant
  double resistance_slope_1_K = 0.0;               // R (1 + a (T - T_inf))
  double pulse_fade = 0.0, pulse_fade_s = 1.0;     // u (1 - a m), tau dm/dt = u / 0.6 - m
  double waking_angle = 0.0, waking_time_s = 1.0;  // max(0, u - d (1 - m)), tau dm/dt = min(1, u / 0.2) - m

  // transformation
  double stress_shift_K_N = 0.0;
  double saturating_shift_K_N = 0.0, saturating_tension_N = 1.0;  // s F_s tanh(F / F_s)
  double quadratic_shift_K_N2 = 0.0;                              // s |F| F
  double heating_shift_K_N = 0.0, cooling_shift_K_N = 0.0;        // of T_heat alone, and of T_cool alone
  double threshold_shift_K_N = 0.0, threshold_tension_N = 0.0;    // s max(0, |F| - F_0) sign F
  double torsion_shift_K_N = 0.0, torsion_core_share = 0.0;       // s F sqrt(1 - (1 - c) xi)
  double fatigue_per_cycle = 0.0;
  double log_fatigue_loss = 0.0, log_fatigue_cycles = 1.0;  // delta_t (1 - a ln(1 + n / n_0))
  double shakedown_loss = 0.0, shakedown_cycles = 1.0;      // delta_t (1 - a (1 - exp(-n / n_0)))
  double minor_loop_share = 0.0;
  // The slope share times how far xi has still to go: (1 - xi) / (1 - xi_cool) while cooling, xi / xi_heat while heating.
  double proportional_loop_share = 0.0;
  double r_phase_share = 0.0, r_phase_midpoint_degC = 45.0, r_phase_width_K = 4.0;
  double rate_shift_s = 0.0;                                 // T_heat, T_cool + s dT/dt (before latent heat)
  double stabilisation_K = 0.0, stabilisation_time_s = 1.0;  // T_heat + S z, tau dz/dt = xi - z

  // mechanics
  double creep_stiffness_Nm_rad = 0.0, creep_time_s = 1.0;
  // Three Maxwell branches that share the stiffness equally; their times are a factor 8 apart around the middle one.
  double series_stiffness_Nm_rad = 0.0, series_middle_time_s = 1.0;
  // Two Maxwell branches, each with half of the stiffness.
  double twofold_stiffness_Nm_rad = 0.0, twofold_fast_s = 1.0, twofold_slow_s = 1.0;
  // A Maxwell branch that flows the faster the more it is loaded: tau dtheta_v/dt = theta_c sinh((theta - theta_v) / theta_c)
  double eyring_stiffness_Nm_rad = 0.0, eyring_time_s = 1.0, eyring_angle_deg = 5.0;
  double friction_Nm = 0.0, friction_smoothing_rad_s = 1.0;
  // M_c tanh(omega / omega_s) (1 + b exp(-(omega / omega_p)^2))
  double stribeck_Nm = 0.0, stribeck_smoothing_rad_s = 1.0, stribeck_peak = 0.0, stribeck_speed_rad_s = 1.0;
  // Bristles: moment - M_c z / z_0, dz/dt = omega - |omega| z / z_0
  double bristle_Nm = 0.0, bristle_deg = 1.0;
  double cubic_Nm_rad3 = 0.0;
  double fourth_order_Nm_rad4 = 0.0;                  // moment - k |theta|^3 theta
  double chain_Nm_rad = 0.0, chain_limit_deg = 90.0;  // moment - k theta q / (1 - q), q = (theta / theta_max)^2; theta_max over 60 deg
  double gravity_Nm = 0.0, gravity_tilt_deg = 0.0;
  // Weight spread along an arc of constant curvature, whose tip's tangent has turned by theta: the potential is
  // -m g l (cos(phi) (1 - cos(theta)) / theta^2 - sin(phi) (theta - sin(theta)) / theta^2)
  double spread_gravity_Nm = 0.0, spread_gravity_tilt_deg = 0.0;
  double slack = 0.0;  // 1: a coil cannot push
  double stop_stiffness_Nm_rad = 0.0, stop_angle_deg = 30.0;
  // 2 M_0 exp(-theta_c / w) sinh(theta / w)
  double soft_stop_Nm = 0.0, soft_stop_angle_deg = 30.0, soft_stop_width_deg = 5.0;
  double softening_1_K = 0.0;         // k_a (1 - a (T - 75 degC))
  double speed_loss_Nms2_rad2 = 0.0;  // moment - c_2 |omega| omega
  // k_b (1 - a (T_s - T_inf)), tau dT_s/dt = (T_A + T_B) / 2 - T_s
  double warm_softening_1_K = 0.0, warm_softening_time_s = 1.0;
  double backlash_deg = 0.0;  // the coils feel an angle that follows the beam's with this much play in all

  // sensor.angle
  double angle_lag_s = 0.0;
  double resonance_s = 0.0, resonance_damping = 0.7;  // theta_m'' tau^2 + 2 zeta tau theta_m' + theta_m = theta
  double film_pole_s = 0.0, filter_pole_s = 0.0;      // tau_1 dtheta_1/dt = theta - theta_1, tau_2 dtheta_m/dt = theta_1 - theta_m
  double angle_drift_deg_s = 0.0;
  double root_drift_deg_rts = 0.0;  // theta_m + d sqrt(t), 0 before t = 0
  // theta_m - h z / z_0, dz/dt = omega - |omega| z / z_0: up to h behind on either way
  double hysteresis_deg = 0.0, hysteresis_reversal_deg = 1.0;
  double settling_deg = 0.0, settling_time_s = 1.0;  // theta_m + d (1 - exp(-t / tau)), 0 before t = 0
  double saturation_1_deg = 0.0;                     // theta_m = tanh(s theta) / s
  double saturation_1_rad2 = 0.0;                    // theta_m = theta / sqrt(1 + c theta^2), theta in radians
  double cross_sensitivity_deg_K = 0.0;              // theta_m + a ((T_A + T_B) / 2 - T_inf)

  double wire_J_K() const { return 0.5 * (heat_capacity_A_J_K + heat_capacity_B_J_K); }
};

// How far the ambient is from its value, by time; straight between the values, constant beyond them.
struct Air {
  double first_s = 0.0;
  double period_s = 0.1;
  std::vector<double> offset_K;  // empty: still
  double at(double time_s) const;
};

struct Shown {
  std::array<double, 2> temperature_degC;
  double angle_deg;
};

// Coefficients of the method of Runge, Kutta and Chebyshev, of order 2 (Sommeijer, Shampine, Verwer 1997).
struct Chebyshev {
  struct Stage {
    double first, last, before, rate, first_rate;  // weights of Y_0, Y_j-1, Y_j-2, h F_j-1, h F_0
    double time;                                   // of Y_j, in steps
  };
  std::vector<Stage> stages;  // as many as it takes for steps of that length at that rate of decay
  static Chebyshev reaching(double step_times_rate);
};

// A limb in time, with fixed steps of at most 1 ms that end where the right-hand side jumps (a duty that arrives,
// airflow that changes): Runge and Kutta's method of order 4, or Chebyshev's where friction makes the beam too stiff.
class Run {
 public:
  // At `start_s`, cold and at rest: at the air's temperature, on the cooling envelope, in static balance. `air` is that of
  // each wire.
  Run(const Physics& physics, std::array<Air, 2> air, double start_s);
  // A limb between two recordings, with no duty under way.
  struct Left {
    double time_s = 0.0;
    std::vector<double> state;
  };
  // Goes on from there. Throws std::invalid_argument where the state has another length.
  Run(const Physics& physics, std::array<Air, 2> air, const Left& left);
  Left left() const { return {time_s_, {y_.begin(), y_.end()}}; }

  double time_s() const { return time_s_; }
  void hold(const std::array<double, 2>& duty);  // commands from now on
  void advance_to(double time_s);
  Shown shown() const;
  std::array<double, 2> wire_temperature_degC() const;

  // Where the limb of `physics` would rest with both wires at these temperatures, without its offset.
  static double balance_deg(const Physics& physics, const std::array<double, 2>& temperature_degC);

 private:
  static constexpr std::size_t states = 54;
  using State = std::array<double, states>;
  struct Command {
    double arrives_s;
    std::array<double, 2> duty;
  };

  void rest(const std::array<double, 2>& temperature_degC);
  std::array<double, 2> ambient_degC(double time_s) const;
  double tension_N(std::size_t coil, double temperature_degC, double fraction, double angle_rad, double cycles) const;
  double stress_shift_K(double tension_N, double fraction) const;  // what both transformation temperatures share
  double static_moment_Nm(double angle_rad, double tension_A_N, double tension_B_N) const;
  std::size_t seat(std::size_t coil) const;  // place in the state of the temperature that the thermocouple sits on
  double into_junction_W(std::size_t coil, const State& y, double joule_W, double ambient_degC, State& dy) const;
  State rates(double time_s, const State& y) const;
  void step(double time_s, double step_s);
  void stiff_step(double time_s, double step_s);

  Physics p_;
  std::array<Air, 2> air_;
  std::array<double, 2> resistance_, capacity_, loss_, arm_, side_;  // side: +1 where a bend shortens the coil
  double junction_power_share_;                                      // of the coil's current heat
  double longest_step_s_ = 1.0e-3;
  Chebyshev stiff_;  // no stages: not needed
  double time_s_;
  State y_{};
  std::array<double, 2> duty_{};  // that has arrived
  std::vector<Command> under_way_;
  bool airflow_changed_ = false;  // within this segment
};

}  // namespace sinew::prove

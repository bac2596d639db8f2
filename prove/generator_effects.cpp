// SPDX-License-Identifier: Apache-2.0
#include "prove/generator_effects.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "prove/generator_random.h"

namespace sinew::prove {
namespace {

constexpr std::string_view at_thermocouple = "sensor.temperature", in_heat = "thermal", in_power = "actuation", in_phase = "transformation",
                           in_beam = "mechanics", at_angle = "sensor.angle";
using P = Physics;

std::vector<Effect> catalogue() {
  using enum Role;
  return {
      {"thermocouple_lag",
       "",
       at_thermocouple,
       true,
       "the thermocouple's bead follows the wire late",
       {{"time_constant_s", 1.5, strength, &P::lag_s}}},
      {"thermocouple_heat_sink",
       "",
       at_thermocouple,
       true,
       "the thermocouple's leads drain heat",
       {{"gain", 0.85, from_one, &P::sink_gain}}},
      // No longer of the catalogue, but in the place that it had there: which case has which disturbance hangs on the order.
      {"junction",
       "outer_turns",
       at_thermocouple,
       false,
       "the thermocouple sits on turns outside the body that carry current and touch nothing",
       {{"relative_heat_loss", 0.4, strength, &P::outer_loss}, {"power_share", 0.5, shape, &P::outer_power_share}}},
      {"body_heat_storage",
       "",
       in_heat,
       true,
       "the silicone stores heat and gives it back",
       {{"conductance_W_K", 0.012, strength, &P::body_conductance_W_K},
        {"heat_capacity_J_K", 6.0, shape, &P::body_capacity_J_K},
        {"heat_loss_W_K", 0.05, shape, &P::body_loss_W_K}}},
      {"sheath_heat_storage",
       "",
       in_heat,
       true,
       "what is glued around each wire stores heat",
       {{"conductance_W_K", 0.03, strength, &P::sheath_conductance_W_K},
        {"heat_capacity_J_K", 1.5, shape, &P::sheath_capacity_J_K},
        {"heat_loss_W_K", 0.03, shape, &P::sheath_loss_W_K}}},
      {"cross_heating", "", in_heat, true, "one wire heats the other", {{"conductance_W_K", 0.006, strength, &P::cross_conductance_W_K}}},
      {"latent_heat",
       "",
       in_heat,
       true,
       "the transformation absorbs and frees heat",
       {{"latent_heat_J", 10.0, strength, &P::latent_heat_J}}},
      {"convection_nonlinearity",
       "",
       in_heat,
       true,
       "heat loss grows with temperature",
       {{"slope_1_K", 0.006, strength, &P::convection_slope_1_K}}},
      {"airflow_change",
       "",
       in_heat,
       true,
       "the air moves more from one moment on",
       {{"relative_change", 0.3, strength, &P::airflow_change}, {"onset_s", 0.0, onset, &P::airflow_onset_s}}},
      {"ambient_drift", "", in_heat, true, "the room warms or cools", {{"rate_K_s", 0.01, signed_strength, &P::ambient_rate_K_s}}},
      {"resistance_change", "", in_power, true, "martensite resists more", {{"relative_increase", 0.2, strength, &P::resistance_increase}}},
      {"supply_sag",
       "",
       in_power,
       true,
       "the supply sags under load",
       {{"source_resistance_Ohm", 0.35, strength, &P::source_resistance_Ohm}}},
      {"duty_deadband",
       "",
       in_power,
       true,
       "the first part of the duty has no effect",
       {{"threshold_fraction", 0.05, strength, &P::deadband}}},
      {"input_delay", "", in_power, true, "commands act late", {{"delay_s", 0.3, strength, &P::delay_s}}},
      {"stress_shift",
       "",
       in_phase,
       true,
       "tension raises the transformation temperatures",
       {{"shift_K_N", 2.0, strength, &P::stress_shift_K_N}}},
      {"fatigue", "", in_phase, true, "every cycle costs stroke", {{"loss_per_cycle", 0.03, strength, &P::fatigue_per_cycle}}},
      {"minor_loops",
       "",
       in_phase,
       true,
       "inside the loop the phase goes on changing",
       {{"slope_share", 0.3, strength, &P::minor_loop_share}}},
      {"r_phase",
       "",
       in_phase,
       true,
       "part of the stroke comes from the R-phase",
       {{"share", 0.25, strength, &P::r_phase_share},
        {"midpoint_degC", 45.0, shape, &P::r_phase_midpoint_degC},
        {"width_K", 4.0, shape, &P::r_phase_width_K}}},
      {"viscoelastic_creep",
       "",
       in_beam,
       true,
       "the silicone creeps",
       {{"stiffness_Nm_rad", 0.02, strength, &P::creep_stiffness_Nm_rad}, {"time_constant_s", 8.0, shape, &P::creep_time_s}}},
      {"dry_friction",
       "",
       in_beam,
       true,
       "the coils rub in their channels",
       {{"moment_Nm", 0.006, strength, &P::friction_Nm}, {"smoothing_rad_s", 0.05, shape, &P::friction_smoothing_rad_s}}},
      {"cubic_stiffening",
       "",
       in_beam,
       true,
       "the body stiffens at large bends",
       {{"stiffness_Nm_rad3", 0.04, strength, &P::cubic_Nm_rad3}}},
      {"gravity_load",
       "",
       in_beam,
       true,
       "the limb's weight bends it",
       {{"moment_Nm", 0.01, strength, &P::gravity_Nm}, {"tilt_deg", 20.0, signed_shape, &P::gravity_tilt_deg}}},
      {"coil_slack", "", in_beam, true, "a coil goes slack instead of pushing", {{"enabled", 1.0, fixed, &P::slack}}},
      {"hard_stop",
       "",
       in_beam,
       true,
       "the limb runs against a stop",
       {{"stiffness_Nm_rad", 0.3, strength, &P::stop_stiffness_Nm_rad}, {"angle_deg", 0.6, within_reach, &P::stop_angle_deg}}},
      {"angle_sensor_lag", "", at_angle, true, "the bend sensor follows late", {{"time_constant_s", 0.6, strength, &P::angle_lag_s}}},
      {"angle_sensor_drift",
       "",
       at_angle,
       true,
       "the bend sensor's zero drifts",
       {{"rate_deg_s", 0.01, signed_strength, &P::angle_drift_deg_s}}},
  };
}

std::vector<Effect> other_forms() {
  using enum Role;
  return {
      {"thermocouple_lag",
       "diffusive",
       at_thermocouple,
       false,
       "heat diffuses through the bead: three nodes in a row",
       {{"total_lag_s", 1.8, strength, &P::diffusive_lag_s}}},
      {"body_heat_storage",
       "ladder",
       in_heat,
       false,
       "heat wanders through the silicone: three nodes in a row",
       {{"conductance_W_K", 0.015, strength, &P::ladder_conductance_W_K},
        {"heat_capacity_J_K", 8.0, shape, &P::ladder_capacity_J_K},
        {"heat_loss_W_K", 0.05, shape, &P::ladder_loss_W_K},
        {"inner_conductance_W_K", 0.06, shape, &P::ladder_inner_W_K}}},
      {"convection_nonlinearity",
       "power",
       in_heat,
       false,
       "heat loss coefficient goes as a power of the temperature rise",
       {{"exponent", 0.28, strength, &P::convection_exponent}}},
      {"airflow_change",
       "gusts",
       in_heat,
       false,
       "gusts come and go",
       {{"relative_change", 0.4, strength, &P::gust_change},
        {"first_s", 50.0, shape, &P::gust_first_s},
        {"interval_s", 90.0, shape, &P::gust_interval_s},
        {"length_s", 25.0, shape, &P::gust_length_s},
        {"ramp_s", 6.0, shape, &P::gust_ramp_s}}},
      {"ambient_drift",
       "swing",
       in_heat,
       false,
       "the room's heating switches slowly: the ambient swings",
       {{"amplitude_K", 2.0, signed_strength, &P::ambient_swing_K}, {"period_s", 300.0, shape, &P::ambient_swing_period_s}}},
      {"latent_heat",
       "directional",
       in_heat,
       false,
       "the transformation absorbs more heat than it gives back",
       {{"heating_J", 12.0, strength, &P::latent_heating_J}, {"cooling_J", 7.0, strength, &P::latent_cooling_J}}},
      {"supply_sag",
       "battery",
       in_power,
       false,
       "a battery sags at once and further with time, and recovers slowly",
       {{"prompt_resistance_Ohm", 0.2, strength, &P::battery_prompt_Ohm},
        {"slow_resistance_Ohm", 0.2, strength, &P::battery_slow_Ohm},
        {"recovery_s", 10.0, shape, &P::battery_time_s}}},
      {"duty_deadband",
       "soft",
       in_power,
       false,
       "small duty has little effect: u^2 / (u + u_0)",
       {{"half_fraction", 0.06, strength, &P::soft_deadband}}},
      {"input_delay",
       "driver_lag",
       in_power,
       false,
       "the driver follows the duty with a first-order lag",
       {{"time_constant_s", 0.35, strength, &P::ramp_s}}},
      {"stress_shift",
       "saturating",
       in_phase,
       false,
       "tension raises the transformation temperatures, less and less",
       {{"shift_K_N", 2.5, strength, &P::saturating_shift_K_N}, {"tension_N", 4.0, shape, &P::saturating_tension_N}}},
      {"fatigue",
       "shakedown",
       in_phase,
       false,
       "the stroke is lost in the first cycles and then settles",
       {{"loss", 0.25, strength, &P::shakedown_loss}, {"cycles", 4.0, shape, &P::shakedown_cycles}}},
      {"viscoelastic_creep",
       "series",
       in_beam,
       false,
       "the silicone creeps over decades of time: three branches",
       {{"stiffness_Nm_rad", 0.03, strength, &P::series_stiffness_Nm_rad}, {"middle_time_s", 8.0, shape, &P::series_middle_time_s}}},
      {"dry_friction",
       "stribeck",
       in_beam,
       false,
       "friction that is higher at rest than in motion",
       {{"moment_Nm", 0.0045, strength, &P::stribeck_Nm},
        {"smoothing_rad_s", 0.04, shape, &P::stribeck_smoothing_rad_s},
        {"peak", 0.6, shape, &P::stribeck_peak},
        {"peak_speed_rad_s", 0.12, shape, &P::stribeck_speed_rad_s}}},
      {"hard_stop",
       "exponential",
       in_beam,
       false,
       "the limb is pressed into something that gives",
       {{"moment_Nm", 0.006, strength, &P::soft_stop_Nm},
        {"angle_deg", 0.55, within_reach, &P::soft_stop_angle_deg},
        {"width_deg", 4.0, shape, &P::soft_stop_width_deg}}},
      {"angle_sensor_lag",
       "second_order",
       at_angle,
       false,
       "the bend sensor follows late and overshoots a little",
       {{"period_s", 0.35, strength, &P::resonance_s}, {"damping_ratio", 0.7, shape, &P::resonance_damping}}},
      {"angle_sensor_drift",
       "settling",
       at_angle,
       false,
       "the bend sensor's zero creeps to a new place",
       {{"shift_deg", 4.0, signed_strength, &P::settling_deg}, {"time_constant_s", 80.0, shape, &P::settling_time_s}}},
  };
}

std::vector<Effect> outside() {
  using enum Role;
  return {
      {"thermocouple_bow",
       "",
       at_thermocouple,
       false,
       "the thermocouple is wrong in the middle of its range",
       {{"bow_K", 4.0, signed_strength, &P::bow_K}}},
      {"motion_cooling",
       "",
       in_heat,
       false,
       "a limb that moves fans itself: h (1 + a |omega|)",
       {{"slope_s_rad", 4.0, strength, &P::motion_cooling_s_rad}}},
      {"bend_cooling",
       "",
       in_heat,
       false,
       "a bend bares the outer wire and covers the inner one: h (1 + a theta)",
       {{"slope_1_rad", 0.5, signed_strength, &P::bend_cooling_1_rad}}},
      {"hot_resistance",
       "",
       in_power,
       false,
       "resistance rises with temperature: R (1 + a (T - T_inf))",
       {{"slope_1_K", 0.005, strength, &P::resistance_slope_1_K}}},
      {"pulse_fade",
       "",
       in_power,
       false,
       "the switch warms in long pulses and passes less",
       {{"loss_fraction", 0.35, strength, &P::pulse_fade}, {"time_constant_s", 6.0, shape, &P::pulse_fade_s}}},
      {"waking_switch",
       "",
       in_power,
       false,
       "the switch misses the first part of the duty until it has been driven a while",
       {{"angle_fraction", 0.08, strength, &P::waking_angle}, {"time_constant_s", 3.0, shape, &P::waking_time_s}}},
      {"rate_shift",
       "",
       in_phase,
       false,
       "the transformation comes later the faster the wire warms or cools",
       {{"shift_s", 0.8, strength, &P::rate_shift_s}}},
      {"martensite_stabilisation",
       "",
       in_phase,
       false,
       "martensite that has been cold for long needs more heat to leave",
       {{"shift_K", 7.0, strength, &P::stabilisation_K}, {"time_constant_s", 30.0, shape, &P::stabilisation_time_s}}},
      {"austenite_softening",
       "",
       in_beam,
       false,
       "a hot coil softens further: k_a (1 - a (T - 75 degC))",
       {{"slope_1_K", 0.006, strength, &P::softening_1_K}}},
      {"speed_loss",
       "",
       in_beam,
       false,
       "loss grows with the square of speed",
       {{"moment_Nms2_rad2", 0.1, strength, &P::speed_loss_Nms2_rad2}}},
      // Of the catalogue since, and here in the place that it had when it was not.
      {"angle_sensor_saturation",
       "tanh",
       at_angle,
       false,
       "the bend sensor saturates: tanh(s theta) / s",
       {{"slope_1_deg", 1.0 / 60.0, root_of_strength, &P::saturation_1_deg}}},
      {"angle_temperature",
       "",
       at_angle,
       false,
       "the bend sensor reads the limb's warmth, too",
       {{"slope_deg_K", 0.08, signed_strength, &P::cross_sensitivity_deg_K}}},
  };
}

// The thermocouple's own body and what lies around it: of the catalogue, and in other forms.
std::vector<Effect> junctions() {
  using enum Role;
  return {
      {"junction",
       "",
       at_thermocouple,
       true,
       "the thermocouple sits on turns outside and glue, a body of its own that takes a share of the current heat",
       {{"heat_capacity_J_K", 0.4, strength, &P::junction_capacity_J_K, 0.5},
        {"relative_power", 0.225, power_share, &P::junction_relative_power, 0.55},
        {"cooling_rate_1_s", 0.025, shape, &P::junction_cooling_rate_1_s, 0.6},
        {"conductance_W_K", 0.075, shape, &P::junction_conductance_W_K, 0.6}}},
      {"junction_layer",
       "",
       at_thermocouple,
       true,
       "a layer around the thermocouple's body stores heat",
       {{"conductance_W_K", 0.035, strength, &P::layer_conductance_W_K, 0.42},
        {"heat_capacity_J_K", 0.55, shape, &P::layer_capacity_J_K, 0.45},
        {"heat_loss_W_K", 0.004, shape, &P::layer_loss_W_K, 0.5}}},
      {"junction",
       "series",
       at_thermocouple,
       false,
       "two bodies in a row lie between the wire and the thermocouple",
       {{"heat_capacity_J_K", 0.4, strength, &P::junction_capacity_J_K, 0.5},
        {"relative_power", 0.225, power_share, &P::junction_relative_power, 0.55},
        {"cooling_rate_1_s", 0.025, shape, &P::junction_cooling_rate_1_s, 0.6},
        {"conductance_W_K", 0.075, shape, &P::junction_conductance_W_K, 0.6},
        {"inner_conductance_W_K", 0.15, shape, &P::junction_inner_W_K}}},
      {"junction",
       "progressive",
       at_thermocouple,
       false,
       "the joint between the wire and the thermocouple's body conducts better the warmer it is",
       {{"heat_capacity_J_K", 0.4, strength, &P::junction_capacity_J_K, 0.5},
        {"relative_power", 0.225, power_share, &P::junction_relative_power, 0.55},
        {"cooling_rate_1_s", 0.025, shape, &P::junction_cooling_rate_1_s, 0.6},
        {"conductance_W_K", 0.055, shape, &P::junction_conductance_W_K, 0.45},
        {"slope_1_K", 0.012, shape, &P::junction_slope_1_K}}},
      {"junction_layer",
       "diffusive",
       at_thermocouple,
       false,
       "heat diffuses through the layer around the thermocouple's body: four nodes in a row",
       {{"conductance_W_K", 0.035, strength, &P::layer_conductance_W_K, 0.42},
        {"heat_capacity_J_K", 0.55, shape, &P::layer_capacity_J_K, 0.45},
        {"heat_loss_W_K", 0.004, shape, &P::layer_loss_W_K, 0.5},
        {"inner_conductance_W_K", 0.08, shape, &P::layer_inner_W_K}}},
  };
}

// Forms that came after those above, with where each comes from. No case of before has one.
std::vector<Effect> further_forms() {
  using enum Role;
  return {
      // A bead of epoxy in a sleeve: two lumps in a row, the second of which draws hardly any heat from the first.
      {"thermocouple_lag",
       "two_poles",
       at_thermocouple,
       false,
       "the thermocouple's bead follows the sleeve that follows the wire",
       {{"outer_time_s", 1.1, strength, &P::outer_pole_s}, {"inner_time_s", 0.6, strength, &P::inner_pole_s}}},
      // Leads that lose heat by free convection and radiation, whose coefficient grows with the rise (Incropera 2007, chapter 9).
      {"thermocouple_heat_sink",
       "convective",
       at_thermocouple,
       false,
       "the thermocouple's leads drain the more heat the hotter they are",
       {{"slope_1_K", 0.003, strength, &P::sink_growth_1_K}}},
      // Between free convection about a wire (a rise to the power of 1/4) and the catalogue's straight line.
      {"convection_nonlinearity",
       "root",
       in_heat,
       false,
       "heat loss coefficient grows with the square root of the temperature rise",
       {{"slope_1_rtK", 0.05, strength, &P::convection_root_1_rtK}}},
      // Stefan and Boltzmann: 5.67e-8 W/m^2/K^4 over the 20 cm^2 of a coil's silicone would be 1.1e-10 W/K^4.
      {"convection_nonlinearity",
       "radiation",
       in_heat,
       false,
       "the wire radiates: loss by the fourth power of absolute temperature",
       {{"coefficient_W_K4", 1.2e-10, strength, &P::radiation_W_K4}}},
      // Fourier conduction with the heat that the silicone in between stores: the catalogue's body, were it not for the air around it.
      {"body_heat_storage",
       "between",
       in_heat,
       false,
       "one wire heats the other through silicone that has to warm up first",
       {{"conductance_W_K", 0.008, strength, &P::between_conductance_W_K}, {"heat_capacity_J_K", 0.8, shape, &P::between_capacity_J_K}}},
      // Calorimetry sees all of the wire, the stroke only the part under the largest stress, which transforms in a narrower range.
      {"latent_heat",
       "broad",
       in_heat,
       false,
       "latent heat is spread over a wider range than the stroke's transformation",
       {{"latent_heat_J", 12.0, strength, &P::broad_latent_J}, {"width_factor", 1.8, shape, &P::broad_width_factor}}},
      // The crossover of a laboratory supply from constant voltage to limited current.
      {"supply_sag",
       "limit",
       in_power,
       false,
       "the supply holds its voltage up to a current, and droops beyond",
       {{"droop_resistance_Ohm", 0.9, strength, &P::limit_resistance_Ohm}, {"current_A", 0.6, shape, &P::limit_current_A}}},
      // The battery without its prompt part: a large capacitor, or a regulator that follows slowly.
      {"supply_sag",
       "slow",
       in_power,
       false,
       "the supply sags with a delay, and recovers as slowly",
       {{"source_resistance_Ohm", 0.4, strength, &P::battery_slow_Ohm}, {"time_constant_s", 5.0, shape, &P::battery_time_s}}},
      // A transistor whose turn-on time varies from pulse to pulse: the mean over thresholds that scatter (softplus).
      {"duty_deadband",
       "knee",
       in_power,
       false,
       "the first part of the duty has little effect, and the edge is soft",
       {{"threshold_fraction", 0.06, strength, &P::knee_deadband}, {"knee_share", 0.3, shape, &P::knee_share}}},
      // The resistance peak of the R-phase on the way between austenite and martensite (Otsuka, Wayman 1998, Shape Memory Materials).
      {"resistance_change",
       "peak",
       in_power,
       false,
       "resistance is highest in the middle of the transformation",
       {{"relative_peak", 0.25, strength, &P::resistance_peak}}},
      // A Clausius-Clapeyron slope that rises with stress, as where a coil's turns open and its wire is sheared more per newton.
      {"stress_shift",
       "quadratic",
       in_phase,
       false,
       "tension raises the transformation temperatures, more and more",
       {{"shift_K_N2", 0.25, strength, &P::quadratic_shift_K_N2}}},
      // Liang and Rogers 1990, Brinson 1993: C_A differs from C_M.
      {"stress_shift",
       "two_slopes",
       in_phase,
       false,
       "tension raises the austenite's temperature and the martensite's by different slopes",
       {{"heating_shift_K_N", 1.4, strength, &P::heating_shift_K_N}, {"cooling_shift_K_N", 2.6, strength, &P::cooling_shift_K_N}}},
      // Residual strain of cycled wire grows with the logarithm of their number.
      {"fatigue",
       "logarithmic",
       in_phase,
       false,
       "every decade of cycles costs as much stroke as the one before",
       {{"loss", 0.09, strength, &P::log_fatigue_loss}, {"cycles", 1.0, shape, &P::log_fatigue_cycles}}},
      // Partial loops scaled by the fraction that can still transform, as in Liang and Rogers 1990.
      {"minor_loops",
       "proportional",
       in_phase,
       false,
       "inside the loop the phase goes on changing by its share of what is left",
       {{"slope_share", 0.4, strength, &P::proportional_loop_share}}},
      // A Prony series of two terms, as silicone's relaxation is usually tabulated.
      {"viscoelastic_creep",
       "two_times",
       in_beam,
       false,
       "the silicone creeps fast at first and then slowly: two branches",
       {{"stiffness_Nm_rad", 0.025, strength, &P::twofold_stiffness_Nm_rad},
        {"fast_s", 2.5, shape, &P::twofold_fast_s},
        {"slow_s", 40.0, shape, &P::twofold_slow_s}}},
      // Eyring 1936: activated flow, the rate goes as the hyperbolic sine of the stress.
      {"viscoelastic_creep",
       "eyring",
       in_beam,
       false,
       "the silicone creeps the faster the more it is loaded",
       {{"stiffness_Nm_rad", 0.022, strength, &P::eyring_stiffness_Nm_rad},
        {"time_constant_s", 20.0, shape, &P::eyring_time_s},
        {"angle_deg", 4.0, shape, &P::eyring_angle_deg}}},
      // Dahl 1968: friction as a spring that yields, with displacement before sliding.
      {"dry_friction",
       "bristle",
       in_beam,
       false,
       "the coils stick to their channels, give a little, and then rub",
       {{"moment_Nm", 0.006, strength, &P::bristle_Nm}, {"give_deg", 1.0, shape, &P::bristle_deg}}},
      // The next term beside the cubic one, with the sign of the bend: silicone that is pressed together on the inner side.
      {"cubic_stiffening",
       "fourth_order",
       in_beam,
       false,
       "the body stiffens at large bends, later and faster: by the fourth power",
       {{"stiffness_Nm_rad4", 0.06, strength, &P::fourth_order_Nm_rad4}}},
      // Gent 1996: rubber whose chains have a finite length.
      {"cubic_stiffening",
       "limited_chain",
       in_beam,
       false,
       "the body stiffens without bound as its chains come to their full length",
       {{"stiffness_Nm_rad", 0.03, strength, &P::chain_Nm_rad}, {"limit_deg", 80.0, shape, &P::chain_limit_deg, 0.1}}},
      // Weight times length, of a uniform arc instead of a weight at its end.
      {"gravity_load",
       "spread",
       in_beam,
       false,
       "the limb's weight, spread along its arc, bends it",
       {{"moment_Nm", 0.06, strength, &P::spread_gravity_Nm}, {"tilt_deg", 40.0, signed_shape, &P::spread_gravity_tilt_deg}}},
      // A film glued on by something soft, and the low pass of its amplifier.
      {"angle_sensor_lag",
       "two_poles",
       at_angle,
       false,
       "the bend sensor's film and its filter follow one after the other",
       {{"film_s", 0.4, strength, &P::film_pole_s}, {"filter_s", 0.25, strength, &P::filter_pole_s}}},
      // Water that diffuses into the film: Fick's law, before it comes to the other side.
      {"angle_sensor_drift",
       "root",
       at_angle,
       false,
       "the bend sensor's zero drifts with the square root of time",
       {{"rate_deg_rts", 0.2, signed_strength, &P::root_drift_deg_rts}}},
  };
}

std::vector<Effect> further_outside() {
  using enum Role;
  return {
      {"tension_cooling",
       "",
       in_heat,
       false,
       "a taut coil lies against its channel and loses more heat: h (1 + a F)",
       {{"slope_1_N", 0.06, strength, &P::tension_cooling_1_N}}},
      {"silicone_softening",
       "",
       in_beam,
       false,
       "warm silicone is softer: k_b falls with a temperature that follows the wires' mean",
       {{"slope_1_K", 0.006, strength, &P::warm_softening_1_K}, {"time_constant_s", 30.0, shape, &P::warm_softening_time_s}}},
      {"backlash",
       "",
       in_beam,
       false,
       "the coils' ends have play in the body: they feel a bend only once it is used up",
       {{"play_deg", 8.0, strength, &P::backlash_deg}}},
      {"angle_hysteresis",
       "",
       at_angle,
       false,
       "the bend sensor shows less than there is on the way up and more on the way down",
       {{"half_width_deg", 1.5, strength, &P::hysteresis_deg}, {"reversal_deg", 3.0, shape, &P::hysteresis_reversal_deg}}},
  };
}

// Forms of stress_shift, after all others: what cases draw hangs on the order.
std::vector<Effect> forms_of_tension() {
  using enum Role;
  return {
      // Brinson 1993, J. Intell. Mater. Syst. Struct. 4: only the stress beyond a critical one, at which twins begin to turn into one
      // variant, raises the temperature at which martensite forms. Here for both ways.
      {"stress_shift",
       "threshold",
       in_phase,
       false,
       "tension raises the transformation temperatures only beyond a threshold",
       {{"shift_K_N", 2.8, strength, &P::threshold_shift_K_N}, {"threshold_N", 1.2, shape, &P::threshold_tension_N}}},
      // A spring's wire is twisted: its shear stress goes as the radius (Mirzaeifar, DesRoches, Yavari 2011, Int. J. Solids Struct. 48, on
      // helical springs of shape memory alloy). Each ring has a shift of its own; what is under the least stress is the first to become
      // austenite and the last to become martensite, so with a share c of the cross-section, in the middle, that does not transform, the
      // front stands at r/R = sqrt(1 - (1 - c) xi). The shift is that of the surface. A tube of a thin wall (c = 1) has the plain effect.
      {"stress_shift",
       "torsion",
       in_phase,
       false,
       "tension twists the wire: its surface has the whole shift, and what lies deeper has less",
       {{"shift_K_N", 2.4, strength, &P::torsion_shift_K_N}, {"core_share", 0.15, shape, &P::torsion_core_share}}},
  };
}

// Coils that are not alike, each by the first of the quantities that differ.
std::vector<Effect> named_since() {
  using enum Role;
  return {
      {"angle_sensor_saturation",
       "",
       at_angle,
       true,
       "the bend sensor shows less and less of a large bend",
       {{"saturation_1_rad2", 0.6, strength, &P::saturation_1_rad2}}},
  };
}

std::vector<Effect> unlike() {
  using enum Role;
  return {
      {"unlike",
       "heating_midpoint_degC",
       in_phase,
       false,
       "the coils transform at temperatures of their own",
       {{"apart_K", 8.0, signed_strength, &P::temperatures_apart_K}}},
      {"unlike",
       "heating_width_K",
       in_phase,
       false,
       "the coils transform over widths of their own",
       {{"log_ratio", 0.6, signed_strength, &P::widths_apart}}},
      {"unlike",
       "transformation_stretch_m",
       in_phase,
       false,
       "the transformation stretches each coil by a length of its own",
       {{"apart_share", 0.3, signed_strength, &P::stretches_apart}}},
  };
}

constexpr std::array<std::array<std::string_view, 2>, 12> pairs{{
    {"latent_heat", "viscoelastic_creep"},
    {"thermocouple_lag", "dry_friction"},
    {"supply_sag", "cubic_stiffening"},
    {"body_heat_storage", "stress_shift"},
    {"convection_nonlinearity", "angle_sensor_lag"},
    {"cross_heating", "minor_loops"},
    {"resistance_change", "hard_stop"},
    {"airflow_change", "gravity_load"},
    {"input_delay", "fatigue"},
    {"duty_deadband", "r_phase"},
    {"ambient_drift", "angle_sensor_drift"},
    {"thermocouple_heat_sink", "viscoelastic_creep"},
}};

// One for each place, drawn at random: two effects that share an equation; and one of both kinds of sensor.
constexpr std::array<std::array<std::string_view, 2>, 7> pairs_of_one_place{{
    {"thermocouple_lag", "thermocouple_heat_sink"},
    {"cross_heating", "airflow_change"},
    {"resistance_change", "supply_sag"},
    {"fatigue", "r_phase"},
    {"cubic_stiffening", "coil_slack"},
    {"angle_sensor_lag", "angle_sensor_drift"},
    {"thermocouple_lag", "angle_sensor_lag"},
}};

// Of three different places each.
constexpr std::array<std::array<std::string_view, 3>, 8> triples{{
    {"thermocouple_lag", "latent_heat", "viscoelastic_creep"},
    {"body_heat_storage", "supply_sag", "dry_friction"},
    {"convection_nonlinearity", "stress_shift", "gravity_load"},
    {"thermocouple_heat_sink", "duty_deadband", "cubic_stiffening"},
    {"cross_heating", "resistance_change", "angle_sensor_lag"},
    {"latent_heat", "input_delay", "hard_stop"},
    {"airflow_change", "fatigue", "angle_sensor_drift"},
    {"sheath_heat_storage", "r_phase", "viscoelastic_creep"},
}};

// Names that came after the numbers had been drawn: their draws are still those of the old ones.
constexpr std::array<std::array<std::string_view, 2>, 5> renamed{{
    {"body_heat_storage.between", "cross_heating.delayed"},
    {"junction.outer_turns", "outer_turns"},
    {"angle_sensor_saturation.tanh", "angle_saturation"},
    {"relative_power", "power_share"},
    {"cooling_rate_1_s", "heat_loss_W_K"},
}};

}  // namespace

std::string drawn_as(std::string_view name) {
  for (const auto& [now, before] : renamed)
    if (name == now) return std::string(before);
  return std::string(name);
}

const std::vector<CoreNumber>& core_numbers() {
  using enum Spread;
  static const std::vector<CoreNumber> all{
      {"supply_voltage_V", known, &P::supply_voltage_V},
      {"resistance_A_Ohm", relative, &P::resistance_A_Ohm},
      {"resistance_B_Ohm", relative, &P::resistance_B_Ohm},
      {"heat_capacity_A_J_K", relative, &P::heat_capacity_A_J_K},
      {"heat_capacity_B_J_K", relative, &P::heat_capacity_B_J_K},
      {"heat_loss_A_W_K", relative, &P::heat_loss_A_W_K},
      {"heat_loss_B_W_K", relative, &P::heat_loss_B_W_K},
      {"ambient_temperature_degC", kelvins, &P::ambient_temperature_degC},
      {"heating_midpoint_degC", kelvins, &P::heating_midpoint_degC},
      {"heating_width_K", relative, &P::heating_width_K},
      {"cooling_midpoint_degC", kelvins, &P::cooling_midpoint_degC},
      {"cooling_width_K", relative, &P::cooling_width_K},
      {"transformation_time_s", relative, &P::transformation_time_s},
      {"austenite_stiffness_N_m", relative, &P::austenite_stiffness_N_m},
      {"martensite_stiffness_N_m", relative, &P::martensite_stiffness_N_m},
      {"coil_stretch_m", relative, &P::coil_stretch_m},
      {"transformation_stretch_m", relative, &P::transformation_stretch_m},
      {"moment_arm_A_m", relative, &P::moment_arm_A_m},
      {"moment_arm_B_m", relative, &P::moment_arm_B_m},
      {"beam_stiffness_Nm_rad", relative, &P::beam_stiffness_Nm_rad},
      {"beam_damping_Nms_rad", relative, &P::beam_damping_Nms_rad},
      {"beam_inertia_kgm2", known, &P::beam_inertia_kgm2},
      {"angle_offset_deg", offset, &P::angle_offset_deg},
      {"bend_sign", known, &P::bend_sign},
  };
  return all;
}

const std::vector<Effect>& effects() {
  static const std::vector<Effect> all = [] {
    std::vector<Effect> list = catalogue();
    for (const auto& more :
         {other_forms(), outside(), junctions(), further_forms(), further_outside(), forms_of_tension(), named_since(), unlike()})
      list.insert(list.end(), more.begin(), more.end());
    return list;
  }();
  return all;
}

std::string key_of(const Effect& effect) {
  return effect.form.empty() ? std::string(effect.name) : std::string(effect.name) + "." + std::string(effect.form);
}

const Effect& effect_of_key(std::string_view key) {
  for (const Effect& effect : effects())
    if (key_of(effect) == key) return effect;
  throw std::invalid_argument("no such effect to conceal: " + std::string(key));
}

Physics physics_of(const std::map<std::string, double>& core_parameters, const std::vector<TruthEffect>& truth) {
  Physics physics;
  const auto put = [&physics](const auto& numbers, const std::string& name, double value, const std::string& owner) {
    const auto found = std::ranges::find_if(numbers, [&](const auto& number) { return number.name == name; });
    if (found == numbers.end()) throw std::invalid_argument(owner + " has no parameter " + name);
    physics.*(found->field) = value;
  };
  for (const auto& [name, value] : core_parameters) put(core_numbers(), name, value, "the core");
  for (const TruthEffect& one : truth) {
    const std::string key = one.form.empty() ? one.name : one.name + "." + one.form;
    for (const auto& [name, value] : one.parameters) put(effect_of_key(key).numbers, name, value, key);
  }
  return physics;
}

TruthEffect drawn(const Effect& effect, const Draw& draw) {
  TruthEffect truth{std::string(effect.name), std::string(effect.form), std::string(effect.place), {},
                    effect.in_catalogue,      std::string(effect.words)};
  double before = 1.0;
  for (const Number& number : effect.numbers) {
    const Stream chance(draw.seed, draw.kind + "/" + drawn_as(key_of(effect)) + "." + drawn_as(number.name));
    const double varied = number.plain * chance.uniform(0, 1.0 - number.variation, 1.0 + number.variation);
    const double sign = chance.uniform(1) < 0.5 ? -1.0 : 1.0;
    double value = varied;
    switch (number.role) {
      case Role::strength:
        value = draw.strength * varied;
        break;
      case Role::signed_strength:
        value = sign * draw.strength * varied;
        break;
      case Role::from_one:
        value = 1.0 - draw.strength * (1.0 - number.plain) * chance.uniform(0, 1.0 - number.variation, 1.0 + number.variation);
        break;
      case Role::root_of_strength:
        value = std::sqrt(draw.strength) * varied;
        break;
      case Role::shape:
        break;
      case Role::power_share:
        value = before > 0.0 ? draw.strength * varied * (draw.wire_J_K + before) / before : 0.0;
        break;
      case Role::signed_shape:
        value = sign * varied;
        break;
      case Role::fixed:
        value = number.plain;
        break;
      case Role::onset: {
        const double earliest = draw.training_s / 3.0;
        const double latest = std::min(2.0 * earliest, 0.8 * draw.heldout_s);
        value = chance.uniform(0, earliest, latest > earliest ? latest : 2.0 * earliest);
        break;
      }
      // A quarter more would be out of reach where plain is 0.8; a tenth is variety enough.
      case Role::within_reach:
        value = draw.reach_deg * number.plain * chance.uniform(0, 0.9, 1.1);
        break;
    }
    truth.parameters.emplace(number.name, value);
    before = value;
  }
  return truth;
}

std::string_view name_of(Family family) {
  switch (family) {
    case Family::clean:
      return "clean";
    case Family::catalogue:
      return "catalogue";
    case Family::other_form:
      return "other_form";
    case Family::pair:
      return "pair";
    case Family::outside:
      return "outside";
    case Family::triple:
      return "triple";
    case Family::unlike:
      return "unlike";
  }
  return "";
}

namespace {

Kind pair_of(std::string_view one, std::string_view other) {
  return {Family::pair, std::string(one) + "+" + std::string(other), {std::string(one), std::string(other)}};
}

}  // namespace

std::vector<Kind> kinds() {
  std::vector<Kind> all{{Family::clean, "core", {}}};
  const auto add = [&all](Family family, const std::vector<Effect>& list) {
    for (const Effect& effect : list) {
      const bool is_form_by_now = !effect.in_catalogue && !effect.form.empty();  // it left the catalogue, or came to have a name there
      all.push_back({is_form_by_now ? Family::other_form : family, key_of(effect), {key_of(effect)}});
    }
  };
  add(Family::catalogue, catalogue());
  add(Family::other_form, other_forms());
  for (const auto& [one, other] : pairs) all.push_back(pair_of(one, other));
  add(Family::outside, outside());
  // A layer is around a junction: it is never alone.
  all.push_back({Family::catalogue, "junction", {"junction"}});
  all.push_back({Family::pair, "junction+junction_layer", {"junction", "junction_layer"}});
  all.push_back({Family::other_form, "junction.series", {"junction.series"}});
  all.push_back({Family::other_form, "junction.progressive", {"junction.progressive"}});
  all.push_back({Family::other_form, "junction_layer.diffusive", {"junction", "junction_layer.diffusive"}});
  for (const Kind& kind : further_kinds()) all.push_back(kind);
  return all;
}

std::vector<Kind> further_kinds() {
  std::vector<Kind> all;
  for (const auto& names : triples) {
    Kind kind{Family::triple, "", {names.begin(), names.end()}};
    for (const std::string& name : kind.effects) kind.name += (kind.name.empty() ? "" : "+") + name;
    all.push_back(kind);
  }
  for (const Effect& effect : further_forms()) all.push_back({Family::other_form, key_of(effect), {key_of(effect)}});
  for (const Effect& effect : further_outside()) all.push_back({Family::outside, key_of(effect), {key_of(effect)}});
  for (const auto& [one, other] : pairs_of_one_place) all.push_back(pair_of(one, other));
  for (const Effect& effect : forms_of_tension()) all.push_back({Family::other_form, key_of(effect), {key_of(effect)}});
  for (const Effect& effect : named_since()) all.push_back({Family::catalogue, key_of(effect), {key_of(effect)}});
  return all;
}

std::vector<Kind> unlike_kinds() {
  std::vector<Kind> all;
  for (const Effect& effect : unlike()) all.push_back({Family::unlike, key_of(effect), {key_of(effect)}});
  // One in each of three places.
  constexpr std::array<std::string_view, 3> beside{"thermocouple_lag", "latent_heat", "viscoelastic_creep"};
  for (std::size_t i = 0; i < beside.size(); ++i)
    all.push_back({Family::unlike, all[i].name + "+" + std::string(beside[i]), {all[i].name, std::string(beside[i])}});
  return all;
}

}  // namespace sinew::prove

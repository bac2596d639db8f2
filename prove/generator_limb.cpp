// SPDX-License-Identifier: Apache-2.0
#include "prove/generator_limb.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <stdexcept>
#include <string>
#include <utility>

#include "prove/generator_math.h"

namespace sinew::prove {
namespace {

// Places in the state. What an effect that is off would need stays as it began.
constexpr std::size_t temperature = 0, martensite = 2, angle = 4, velocity = 5;
constexpr std::size_t body = 6;           // 3 nodes, of which body_heat_storage has one
constexpr std::size_t bead = 9;           // 2 wires times 3 nodes, of which thermocouple_lag has one each
constexpr std::size_t cycles = 15;        // 2
constexpr std::size_t creep = 17;         // 3 branches of the series, and the catalogue's own
constexpr std::size_t angle_sensor = 21;  // angle shown, and its rate for the resonance
constexpr std::size_t battery = 23;
constexpr std::size_t driver = 24;      // 2, duty that follows
constexpr std::size_t memory = 26;      // 2, of the switch
constexpr std::size_t stabilised = 28;  // 2
constexpr std::size_t sheath = 30;      // 2
constexpr std::size_t outer = 32;       // 2, how much warmer the turns outside are
constexpr std::size_t junction = 34;    // 2 wires times 2 bodies, of which junction has one each
constexpr std::size_t layer = 38;       // 2 wires times 4 nodes, of which junction_layer has one each
constexpr std::size_t layer_nodes = 4;
constexpr std::size_t broad = 46;       // 2, fraction by which the latent heat goes
constexpr std::size_t between = 48;     // silicone between the wires
constexpr std::size_t bristle = 49;     // rad
constexpr std::size_t silicone = 50;    // temperature by which the beam softens
constexpr std::size_t coil_angle = 51;  // angle that the coils feel
constexpr std::size_t hysteresis = 52;  // rad
constexpr std::size_t eyring = 53;
constexpr std::array series_factor{0.125, 1.0, 8.0};

constexpr double stiff_step_s = 0.5e-3;
// How fast the coils' ends follow once the play is used up. A play has a corner and no time; this is below what any sensor shows.
constexpr double contact_s = 0.01;

// How deep inside the loop, in martensite fraction, minor loops are fully there. The equation has a jump at its edge.
constexpr double loop_edge = 2.0e-4;

double mean(const std::array<double, 2>& both) { return 0.5 * (both[0] + both[1]); }
double smooth_step(double x) {
  x = std::clamp(x, 0.0, 1.0);
  return x * x * (3.0 - 2.0 * x);
}

struct Loop {
  double upper, lower;
  double upper_slope_1_K, lower_slope_1_K;  // of each envelope alone
};

double half_way(std::size_t coil) { return coil == 0 ? -0.5 : 0.5; }

Loop loop(const Physics& p, std::size_t coil, double temperature_degC, double heating_shift_K, double cooling_shift_K,
          double width_factor = 1.0) {
  Loop at;
  const double own_K = half_way(coil) * p.temperatures_apart_K, wider = std::exp(half_way(coil) * p.widths_apart);
  const double heating_width_K = p.heating_width_K * wider, cooling_width_K = p.cooling_width_K * wider;
  at.upper = falling((temperature_degC - p.heating_midpoint_degC - heating_shift_K - own_K) / (heating_width_K * width_factor));
  at.lower = falling((temperature_degC - p.cooling_midpoint_degC - cooling_shift_K - own_K) / (cooling_width_K * width_factor));
  at.upper_slope_1_K = -at.upper * (1.0 - at.upper) / heating_width_K;
  at.lower_slope_1_K = -at.lower * (1.0 - at.lower) / cooling_width_K;
  if (at.lower > at.upper) at.upper = at.lower = 0.5 * (at.upper + at.lower);
  return at;
}

double gust(const Physics& p, double time_s) {
  if (time_s < p.gust_first_s) return 0.0;
  const double since = std::fmod(time_s - p.gust_first_s, p.gust_interval_s);
  return smooth_step(since / p.gust_ramp_s) - smooth_step((since - p.gust_ramp_s - p.gust_length_s) / p.gust_ramp_s);
}

double dead_band_with_knee(double u, double threshold, double width) {
  const auto softplus = [](double x) { return positive(x) + std::log1p(std::exp(-std::abs(x))); };
  return width * (softplus((u - threshold) / width) - softplus(-threshold / width));
}

// What a weight of 1 Nm that is spread along an arc bends it by: the derivatives of the arc's mean place, along its base's direction and
// across it, by the angle.
double spread_weight_Nm(double theta, double tilt_rad) {
  double along = -theta / 12.0, across = 1.0 / 6.0 - theta * theta / 40.0;  // series; the next terms are below 1e-11
  if (std::abs(theta) > 1.0e-3) {
    const double s = std::sin(theta), c = std::cos(theta);
    along = (s - 2.0 * (1.0 - c) / theta) / (theta * theta);
    across = ((1.0 - c) - 2.0 * (theta - s) / theta) / (theta * theta);
  }
  return std::cos(tilt_rad) * along - std::sin(tilt_rad) * across;
}

// The zero of a function that falls (or rises, `rising`) from `low` to `high`.
template <class Function>
double zero_between(double low, double high, bool rising, Function&& function) {
  for (int i = 0; i < 60; ++i) {
    const double middle = 0.5 * (low + high);
    ((function(middle) > 0.0) == rising ? high : low) = middle;
  }
  return 0.5 * (low + high);
}

}  // namespace

double Air::at(double time_s) const {
  if (offset_K.empty()) return 0.0;
  const double last = static_cast<double>(offset_K.size() - 1);
  const double place = std::clamp((time_s - first_s) / period_s, 0.0, last);
  const auto before = std::min(static_cast<std::size_t>(place), offset_K.size() - 1);
  const auto after = std::min(before + 1, offset_K.size() - 1);
  return offset_K[before] + (place - static_cast<double>(before)) * (offset_K[after] - offset_K[before]);
}

Chebyshev Chebyshev::reaching(double step_times_rate) {
  // Stable up to 2/3 (s^2 - 1) (1 - 2/15 eps) with s stages.
  constexpr double eps = 2.0 / 13.0;
  std::size_t s = 3;
  while (2.0 / 3.0 * (static_cast<double>(s * s) - 1.0) * (1.0 - 2.0 / 15.0 * eps) < step_times_rate) ++s;
  const double w_0 = 1.0 + eps / static_cast<double>(s * s);
  // Chebyshev polynomials at w_0 and their first two derivatives, by their recurrence.
  std::vector<double> t{1.0, w_0}, dt{0.0, 1.0}, ddt{0.0, 0.0};
  for (std::size_t j = 2; j <= s; ++j) {
    t.push_back(2.0 * w_0 * t[j - 1] - t[j - 2]);
    dt.push_back(2.0 * t[j - 1] + 2.0 * w_0 * dt[j - 1] - dt[j - 2]);
    ddt.push_back(4.0 * dt[j - 1] + 2.0 * w_0 * ddt[j - 1] - ddt[j - 2]);
  }
  const double w_1 = dt[s] / ddt[s];
  std::vector<double> b(s + 1);
  for (std::size_t j = 2; j <= s; ++j) b[j] = ddt[j] / (dt[j] * dt[j]);
  b[0] = b[1] = b[2];
  Chebyshev method;
  method.stages.push_back({1.0, 0.0, 0.0, 0.0, b[1] * w_1, b[1] * w_1});
  for (std::size_t j = 2; j <= s; ++j) {
    const double last = 2.0 * b[j] * w_0 / b[j - 1], before = -b[j] / b[j - 2], rate = 2.0 * b[j] * w_1 / b[j - 1];
    const double first_rate = -(1.0 - b[j - 1] * t[j - 1]) * rate;
    method.stages.push_back({1.0 - last - before, last, before, rate, first_rate, w_1 * ddt[j] / dt[j]});
  }
  return method;
}

Run::Run(const Physics& physics, std::array<Air, 2> air, double start_s)
    : p_(physics),
      air_(std::move(air)),
      resistance_{p_.resistance_A_Ohm, p_.resistance_B_Ohm},
      capacity_{p_.heat_capacity_A_J_K, p_.heat_capacity_B_J_K},
      loss_{p_.heat_loss_A_W_K, p_.heat_loss_B_W_K},
      arm_{p_.moment_arm_A_m, p_.moment_arm_B_m},
      side_{p_.bend_sign, -p_.bend_sign},
      junction_power_share_(p_.junction_relative_power * p_.junction_capacity_J_K / (p_.wire_J_K() + p_.junction_capacity_J_K)),
      time_s_(start_s) {
  // Damping at its stiffest: friction at rest, and the loss that grows with speed at half a radian per second.
  const double damping_Nms_rad = p_.beam_damping_Nms_rad + p_.friction_Nm / p_.friction_smoothing_rad_s +
                                 p_.stribeck_Nm * (1.0 + p_.stribeck_peak) / p_.stribeck_smoothing_rad_s + p_.speed_loss_Nms2_rad2;
  const double rate_1_s = damping_Nms_rad / p_.beam_inertia_kgm2;
  // Order 4 is stable up to 2.78.
  if (rate_1_s * longest_step_s_ > 1.5) {
    longest_step_s_ = stiff_step_s;
    stiff_ = Chebyshev::reaching(1.2 * rate_1_s * longest_step_s_);
  }
  rest(ambient_degC(start_s));
}

Run::Run(const Physics& physics, std::array<Air, 2> air, const Left& left) : Run(physics, std::move(air), left.time_s) {
  if (left.state.size() != y_.size()) throw std::invalid_argument("a limb has " + std::to_string(y_.size()) + " states");
  std::ranges::copy(left.state, y_.begin());
}

void Run::hold(const std::array<double, 2>& duty) { under_way_.push_back({time_s_ + p_.delay_s, duty}); }

void Run::advance_to(double time_s) {
  constexpr double same_s = 1.0e-9;
  while (time_s_ < time_s) {
    while (!under_way_.empty() && under_way_.front().arrives_s <= time_s_ + same_s) {
      duty_ = under_way_.front().duty;
      under_way_.erase(under_way_.begin());
    }
    double until_s = time_s;
    if (!under_way_.empty()) until_s = std::min(until_s, under_way_.front().arrives_s);
    airflow_changed_ = time_s_ + same_s >= p_.airflow_onset_s;
    if (p_.airflow_change != 0.0 && !airflow_changed_) until_s = std::min(until_s, p_.airflow_onset_s);
    if (time_s - until_s < same_s) until_s = time_s;
    const double length_s = until_s - time_s_;
    const double count = std::max(1.0, std::ceil(length_s / longest_step_s_ - 1.0e-6));
    for (double i = 0.0; i < count; ++i) {
      const double from_s = time_s_ + length_s * i / count;
      stiff_.stages.empty() ? step(from_s, length_s / count) : stiff_step(from_s, length_s / count);
    }
    time_s_ = until_s;
  }
}

std::array<double, 2> Run::wire_temperature_degC() const { return {y_[temperature], y_[temperature + 1]}; }

Shown Run::shown() const {
  const std::array<double, 2> ambient = ambient_degC(time_s_);
  Shown shown{};
  for (std::size_t j = 0; j < 2; ++j) {
    double t = y_[seat(j)];
    if (p_.lag_s > 0.0) t = y_[bead + 3 * j];
    if (p_.diffusive_lag_s > 0.0) t = y_[bead + 3 * j + 2];
    if (p_.outer_pole_s > 0.0) t = y_[bead + 3 * j];
    if (p_.inner_pole_s > 0.0) t = y_[bead + 3 * j + 1];
    t += y_[outer + j];
    t = ambient[j] + p_.sink_gain * (t - ambient[j]);
    if (p_.sink_growth_1_K > 0.0) t = ambient[j] + (t - ambient[j]) / (1.0 + p_.sink_growth_1_K * std::abs(t - ambient[j]));
    const double x = (t - 25.0) / 80.0;
    shown.temperature_degC[j] = t + 4.0 * p_.bow_K * x * (1.0 - x);
  }
  const bool late = p_.angle_lag_s > 0.0 || p_.resonance_s > 0.0;
  double theta = (late ? y_[angle_sensor] : y_[angle]) / degree;
  if (p_.film_pole_s > 0.0) theta = y_[angle_sensor] / degree;
  if (p_.filter_pole_s > 0.0) theta = y_[angle_sensor + 1] / degree;
  if (p_.hysteresis_deg != 0.0) theta -= p_.hysteresis_deg * y_[hysteresis] / (p_.hysteresis_reversal_deg * degree);
  if (p_.root_drift_deg_rts != 0.0) theta += p_.root_drift_deg_rts * std::sqrt(positive(time_s_));
  theta /= std::sqrt(1.0 + p_.saturation_1_rad2 * (theta * degree) * (theta * degree));
  theta += p_.angle_drift_deg_s * time_s_;
  theta += p_.settling_deg * (1.0 - std::exp(-positive(time_s_) / p_.settling_time_s));
  if (p_.saturation_1_deg > 0.0) theta = std::tanh(p_.saturation_1_deg * theta) / p_.saturation_1_deg;
  theta += p_.cross_sensitivity_deg_K * (0.5 * (y_[temperature] + y_[temperature + 1]) - mean(ambient));
  shown.angle_deg = theta + p_.angle_offset_deg;
  return shown;
}

double Run::balance_deg(const Physics& physics, const std::array<double, 2>& temperature_degC) {
  Run run(physics, {}, 0.0);
  run.rest(temperature_degC);
  return run.y_[angle] / degree;
}

std::array<double, 2> Run::ambient_degC(double time_s) const {
  const double room = p_.ambient_temperature_degC + p_.ambient_rate_K_s * time_s;
  std::array<double, 2> ambient{room + air_[0].at(time_s), room + air_[1].at(time_s)};
  if (p_.ambient_swing_K != 0.0)
    for (double& one : ambient) one += p_.ambient_swing_K * std::sin(2.0 * std::numbers::pi * time_s / p_.ambient_swing_period_s);
  return ambient;
}

double Run::tension_N(std::size_t coil, double temperature_degC, double fraction, double angle_rad, double n) const {
  const double stretch = p_.coil_stretch_m - side_[coil] * arm_[coil] * angle_rad;
  const double k_a = p_.austenite_stiffness_N_m * (1.0 - p_.softening_1_K * (temperature_degC - 75.0));
  const double k = k_a + fraction * (p_.martensite_stiffness_N_m - k_a);
  double longer = p_.transformation_stretch_m * (1.0 + half_way(coil) * p_.stretches_apart) * (1.0 - p_.fatigue_per_cycle * n);
  if (p_.log_fatigue_loss != 0.0) longer *= 1.0 - p_.log_fatigue_loss * std::log1p(n / p_.log_fatigue_cycles);
  if (p_.shakedown_loss != 0.0) longer *= 1.0 - p_.shakedown_loss * (1.0 - std::exp(-n / p_.shakedown_cycles));
  double share = fraction;
  if (p_.r_phase_share != 0.0)
    share = (1.0 - p_.r_phase_share) * fraction +
            p_.r_phase_share * falling((temperature_degC - p_.r_phase_midpoint_degC) / p_.r_phase_width_K);
  const double force = k * (stretch - share * longer);
  return p_.slack != 0.0 ? positive(force) : force;
}

double Run::stress_shift_K(double tension, double fraction) const {
  double shift = p_.stress_shift_K_N * tension;
  if (p_.saturating_shift_K_N != 0.0)
    shift += p_.saturating_shift_K_N * p_.saturating_tension_N * std::tanh(tension / p_.saturating_tension_N);
  if (p_.quadratic_shift_K_N2 != 0.0) shift += p_.quadratic_shift_K_N2 * std::abs(tension) * tension;
  if (p_.threshold_shift_K_N != 0.0)
    shift += p_.threshold_shift_K_N * std::copysign(positive(std::abs(tension) - p_.threshold_tension_N), tension);
  // Where the front between the phases stands, in radii of the wire: austenite spreads from the middle outwards.
  if (p_.torsion_shift_K_N != 0.0)
    shift += p_.torsion_shift_K_N * tension * std::sqrt(positive(1.0 - (1.0 - p_.torsion_core_share) * fraction));
  return shift;
}

// All moments on a beam that does not move and has crept as far as it will.
double Run::static_moment_Nm(double theta, double tension_A_N, double tension_B_N) const {
  double moment = side_[0] * arm_[0] * tension_A_N + side_[1] * arm_[1] * tension_B_N - p_.beam_stiffness_Nm_rad * theta;
  moment -= p_.cubic_Nm_rad3 * theta * theta * theta;
  if (p_.fourth_order_Nm_rad4 != 0.0) moment -= p_.fourth_order_Nm_rad4 * std::abs(theta * theta * theta) * theta;
  if (p_.chain_Nm_rad != 0.0) {
    const double used = theta / (p_.chain_limit_deg * degree);
    moment -= p_.chain_Nm_rad * theta * used * used / (1.0 - used * used);
  }
  if (p_.gravity_Nm != 0.0) moment -= p_.gravity_Nm * std::sin(theta + p_.gravity_tilt_deg * degree);
  if (p_.spread_gravity_Nm != 0.0) moment += p_.spread_gravity_Nm * spread_weight_Nm(theta, p_.spread_gravity_tilt_deg * degree);
  const double beyond = std::abs(theta) - p_.stop_angle_deg * degree;
  if (beyond > 0.0) moment -= p_.stop_stiffness_Nm_rad * std::copysign(beyond, theta);
  if (p_.soft_stop_Nm != 0.0)
    moment -= 2.0 * p_.soft_stop_Nm * std::exp(-p_.soft_stop_angle_deg / p_.soft_stop_width_deg) *
              std::sinh(theta / (p_.soft_stop_width_deg * degree));
  return moment;
}

void Run::rest(const std::array<double, 2>& warm_degC) {
  // Each coil on its cooling envelope, which its own tension moves; the tension falls as the fraction rises.
  const auto fraction_at = [&](std::size_t j, double theta) {
    return zero_between(0.0, 1.0, true, [&](double xi) {
      const double force = tension_N(j, warm_degC[j], xi, theta, 0.0), shift = stress_shift_K(force, xi);
      return xi -
             loop(p_, j, warm_degC[j], shift + p_.heating_shift_K_N * force + p_.stabilisation_K * xi, shift + p_.cooling_shift_K_N * force)
                 .lower;
    });
  };
  const double theta = zero_between(-2.0, 2.0, false, [&](double trial) {
    return static_moment_Nm(trial, tension_N(0, warm_degC[0], fraction_at(0, trial), trial, 0.0),
                            tension_N(1, warm_degC[1], fraction_at(1, trial), trial, 0.0));
  });
  y_ = {};
  const std::array<double, 2> ambient = ambient_degC(time_s_);
  for (std::size_t i = 0; i < 3; ++i) y_[body + i] = mean(ambient);
  for (std::size_t j = 0; j < 2; ++j) {
    y_[temperature + j] = warm_degC[j];
    y_[sheath + j] = ambient[j];
    y_[martensite + j] = y_[stabilised + j] = fraction_at(j, theta);
    const double force = tension_N(j, warm_degC[j], y_[martensite + j], theta, 0.0), shift = stress_shift_K(force, y_[martensite + j]);
    y_[broad + j] =
        loop(p_, j, warm_degC[j], shift + p_.heating_shift_K_N * force, shift + p_.cooling_shift_K_N * force, p_.broad_width_factor).lower;
    for (std::size_t i = 0; i < 3; ++i) y_[bead + 3 * j + i] = warm_degC[j];
    for (std::size_t i = 0; i < 2; ++i) y_[junction + 2 * j + i] = warm_degC[j];
    for (std::size_t i = 0; i < layer_nodes; ++i) y_[layer + layer_nodes * j + i] = ambient[j];
  }
  for (std::size_t i = 0; i < 4; ++i) y_[creep + i] = theta;
  y_[between] = y_[silicone] = mean(warm_degC);
  y_[angle] = y_[angle_sensor] = y_[coil_angle] = y_[eyring] = theta;
  if (p_.film_pole_s > 0.0 || p_.filter_pole_s > 0.0) y_[angle_sensor + 1] = theta;
}

std::size_t Run::seat(std::size_t coil) const {
  if (p_.junction_capacity_J_K <= 0.0) return temperature + coil;
  return junction + 2 * coil + (p_.junction_inner_W_K > 0.0 ? 1 : 0);
}

// Heat that a wire gives away to the body under its thermocouple: what flows there, and the current heat that arises there instead of in
// the wire. Sets the rates of that body and of the layer around it.
double Run::into_junction_W(std::size_t coil, const State& y, double joule_W, double ambient_degC, State& dy) const {
  const std::size_t touched = junction + 2 * coil, measured = seat(coil);
  const double t = y[temperature + coil];
  const double rise = 0.5 * (t + y[touched]) - ambient_degC;
  const double gained =
      junction_power_share_ * joule_W + p_.junction_conductance_W_K * (1.0 + p_.junction_slope_1_K * rise) * (t - y[touched]);

  const std::size_t first = layer + layer_nodes * coil;
  const std::size_t nodes = p_.layer_inner_W_K > 0.0 ? layer_nodes : 1;
  const double into_layer = p_.layer_conductance_W_K * (y[measured] - y[first]);
  double inwards = into_layer;
  for (std::size_t i = first; i < first + nodes; ++i) {
    const bool last = i + 1 == first + nodes;
    const double onwards = last ? p_.layer_loss_W_K * (y[i] - ambient_degC) : p_.layer_inner_W_K * (y[i] - y[i + 1]);
    dy[i] = (inwards - onwards) * static_cast<double>(nodes) / p_.layer_capacity_J_K;
    inwards = onwards;
  }

  const double lost = p_.junction_cooling_rate_1_s * p_.junction_capacity_J_K * (y[measured] - ambient_degC) + into_layer;
  if (measured == touched) {
    dy[measured] = (gained - lost) / p_.junction_capacity_J_K;
  } else {
    const double onwards = p_.junction_inner_W_K * (y[touched] - y[measured]);
    dy[touched] = (gained - onwards) / (0.5 * p_.junction_capacity_J_K);
    dy[measured] = (onwards - lost) / (0.5 * p_.junction_capacity_J_K);
  }
  return gained;
}

Run::State Run::rates(double time_s, const State& y) const {
  State dy{};
  const double theta = y[angle], omega = y[velocity];
  const std::array<double, 2> ambient = ambient_degC(time_s);
  double felt = theta;  // by the coils
  if (p_.backlash_deg > 0.0) {
    felt = y[coil_angle];
    const double half = 0.5 * p_.backlash_deg * degree;
    dy[coil_angle] = (positive(theta - felt - half) - positive(felt - theta - half)) / contact_s;
  }

  // Actuation.
  std::array<double, 2> u{}, ohm{};
  double conductance = 0.0;
  for (std::size_t j = 0; j < 2; ++j) {
    u[j] = p_.ramp_s > 0.0 ? y[driver + j] : duty_[j];
    if (p_.ramp_s > 0.0) dy[driver + j] = (duty_[j] - y[driver + j]) / p_.ramp_s;
    if (p_.waking_angle != 0.0) {
      dy[memory + j] = (std::min(1.0, u[j] / 0.2) - y[memory + j]) / p_.waking_time_s;
      u[j] = positive(u[j] - p_.waking_angle * (1.0 - y[memory + j]));
    }
    if (p_.pulse_fade != 0.0) {
      dy[memory + j] = (u[j] / 0.6 - y[memory + j]) / p_.pulse_fade_s;
      u[j] *= 1.0 - p_.pulse_fade * y[memory + j];
    }
    u[j] = positive(u[j] - p_.deadband);
    if (p_.soft_deadband > 0.0) u[j] = u[j] * u[j] / (u[j] + p_.soft_deadband);
    if (p_.knee_deadband > 0.0) u[j] = dead_band_with_knee(u[j], p_.knee_deadband, p_.knee_share * p_.knee_deadband);
    ohm[j] = resistance_[j] * (1.0 + p_.resistance_increase * y[martensite + j]) *
             (1.0 + p_.resistance_slope_1_K * (y[temperature + j] - ambient[j]));
    if (p_.resistance_peak != 0.0) ohm[j] *= 1.0 + 4.0 * p_.resistance_peak * y[martensite + j] * (1.0 - y[martensite + j]);
    conductance += u[j] / ohm[j];
  }
  double volt = (p_.supply_voltage_V - y[battery]) / (1.0 + (p_.source_resistance_Ohm + p_.battery_prompt_Ohm) * conductance);
  if (p_.limit_resistance_Ohm != 0.0 && conductance * volt > p_.limit_current_A)
    volt = (volt + p_.limit_resistance_Ohm * p_.limit_current_A) / (1.0 + p_.limit_resistance_Ohm * conductance);
  if (p_.battery_slow_Ohm != 0.0) dy[battery] = (p_.battery_slow_Ohm * conductance * volt - y[battery]) / p_.battery_time_s;

  // Heat and transformation of each wire.
  double air_factor = airflow_changed_ ? 1.0 + p_.airflow_change : 1.0;
  if (p_.gust_change != 0.0) air_factor *= 1.0 + p_.gust_change * gust(p_, time_s);
  air_factor *= 1.0 + p_.motion_cooling_s_rad * std::abs(omega);
  std::array<double, 2> force{};
  for (std::size_t j = 0; j < 2; ++j) {
    const double t = y[temperature + j], xi = y[martensite + j];
    const double rise = t - ambient[j];
    double h = loss_[j] * air_factor * (1.0 + p_.convection_slope_1_K * rise) * (1.0 + p_.bend_cooling_1_rad * side_[j] * theta);
    if (p_.convection_exponent != 0.0) h *= std::pow(std::abs(rise) / 30.0, p_.convection_exponent);
    if (p_.convection_root_1_rtK != 0.0) h *= 1.0 + p_.convection_root_1_rtK * std::sqrt(std::abs(rise));
    force[j] = tension_N(j, t, xi, felt, y[cycles + j]);
    if (p_.tension_cooling_1_N != 0.0) h *= 1.0 + p_.tension_cooling_1_N * positive(force[j]);
    const double joule = u[j] * volt * volt / ohm[j];
    dy[outer + j] = (p_.outer_loss * (p_.outer_power_share * joule - h * rise) - (1.0 + p_.outer_loss) * h * y[outer + j]) / capacity_[j];
    double heat = joule - h * rise;
    if (p_.junction_capacity_J_K > 0.0) heat -= into_junction_W(j, y, joule, ambient[j], dy);
    const double into_sheath = p_.sheath_conductance_W_K * (t - y[sheath + j]);
    heat -= into_sheath;
    dy[sheath + j] = (into_sheath - p_.sheath_loss_W_K * (y[sheath + j] - ambient[j])) / p_.sheath_capacity_J_K;
    heat -= p_.cross_conductance_W_K * (t - y[temperature + 1 - j]);
    if (p_.radiation_W_K4 != 0.0) heat -= p_.radiation_W_K4 * (std::pow(t + 273.15, 4) - std::pow(ambient[j] + 273.15, 4));
    if (p_.between_conductance_W_K != 0.0) {
      const double into_between = 2.0 * p_.between_conductance_W_K * (t - y[between]);
      heat -= into_between;
      dy[between] += into_between / p_.between_capacity_J_K;
    }
    const double into_body = (p_.body_conductance_W_K + p_.ladder_conductance_W_K) * (t - y[body]);
    heat -= into_body;
    dy[body] += into_body;

    const double shift = stress_shift_K(force[j], xi) + p_.rate_shift_s * heat / capacity_[j];
    const double heating_shift = shift + p_.heating_shift_K_N * force[j] + p_.stabilisation_K * y[stabilised + j];
    const double cooling_shift = shift + p_.cooling_shift_K_N * force[j];
    const Loop at = loop(p_, j, t, heating_shift, cooling_shift);
    if (p_.broad_latent_J != 0.0) {
      const Loop of_heat = loop(p_, j, t, heating_shift, cooling_shift, p_.broad_width_factor);
      dy[broad + j] = (positive(of_heat.lower - y[broad + j]) - positive(y[broad + j] - of_heat.upper)) / p_.transformation_time_s;
      heat += p_.broad_latent_J * dy[broad + j];
    }
    const double pull = (positive(at.lower - xi) - positive(xi - at.upper)) / p_.transformation_time_s;
    // dxi/dt = pull + slope dT/dt and C dT/dt = heat + L dxi/dt, solved together. As the slope is negative, the sign of
    // dT/dt inside the loop is that of the heat, and the sign of dxi/dt does not depend on L.
    double slope = 0.0;
    if (p_.minor_loop_share != 0.0 && xi > at.lower && xi < at.upper)
      slope = p_.minor_loop_share * (heat > 0.0 ? at.upper_slope_1_K : at.lower_slope_1_K) *
              std::min(1.0, std::min(xi - at.lower, at.upper - xi) / loop_edge);
    if (p_.proportional_loop_share != 0.0 && xi > at.lower && xi < at.upper)
      slope = p_.proportional_loop_share *
              (heat > 0.0 ? at.upper_slope_1_K * xi / at.upper : at.lower_slope_1_K * (1.0 - xi) / (1.0 - at.lower)) *
              std::min(1.0, std::min(xi - at.lower, at.upper - xi) / loop_edge);
    const bool to_austenite = pull * capacity_[j] + slope * heat < 0.0;
    const double latent = p_.latent_heat_J + (to_austenite ? p_.latent_heating_J : p_.latent_cooling_J);
    dy[temperature + j] = (heat + latent * pull) / (capacity_[j] - latent * slope);
    dy[martensite + j] = pull + slope * dy[temperature + j];
    // Cycles of the recording; those before it count as the limb's past, which is in its parameters.
    if (time_s >= 0.0) dy[cycles + j] = 0.5 * std::abs(dy[martensite + j]);
    dy[stabilised + j] = (xi - y[stabilised + j]) / p_.stabilisation_time_s;

    const std::size_t first = bead + 3 * j;
    const double followed = y[seat(j)];
    if (p_.lag_s > 0.0) dy[first] = (followed - y[first]) / p_.lag_s;
    if (p_.outer_pole_s > 0.0) dy[first] = (followed - y[first]) / p_.outer_pole_s;
    if (p_.inner_pole_s > 0.0) dy[first + 1] = ((p_.outer_pole_s > 0.0 ? y[first] : followed) - y[first + 1]) / p_.inner_pole_s;
    if (p_.diffusive_lag_s > 0.0) {
      const double node_s = p_.diffusive_lag_s / 6.0;  // three nodes delay by 3 + 2 + 1 times that of one
      dy[first] = (followed - 2.0 * y[first] + y[first + 1]) / node_s;
      dy[first + 1] = (y[first] - 2.0 * y[first + 1] + y[first + 2]) / node_s;
      dy[first + 2] = (y[first + 1] - y[first + 2]) / node_s;
    }
  }
  if (p_.ladder_conductance_W_K != 0.0) {
    const double node_J_K = p_.ladder_capacity_J_K / 3.0;
    const double inwards = p_.ladder_inner_W_K * (y[body] - y[body + 1]);
    const double onwards = p_.ladder_inner_W_K * (y[body + 1] - y[body + 2]);
    dy[body] = (dy[body] - inwards) / node_J_K;
    dy[body + 1] = (inwards - onwards) / node_J_K;
    dy[body + 2] = (onwards - p_.ladder_loss_W_K * (y[body + 2] - mean(ambient))) / node_J_K;
  } else {
    dy[body] = (dy[body] - p_.body_loss_W_K * (y[body] - mean(ambient))) / p_.body_capacity_J_K;
  }

  // Mechanics.
  double moment =
      static_moment_Nm(theta, force[0], force[1]) - p_.beam_damping_Nms_rad * omega - p_.speed_loss_Nms2_rad2 * std::abs(omega) * omega;
  if (p_.friction_Nm != 0.0) moment -= p_.friction_Nm * std::tanh(omega / p_.friction_smoothing_rad_s);
  if (p_.stribeck_Nm != 0.0) {
    const double relative = omega / p_.stribeck_speed_rad_s;
    moment -= p_.stribeck_Nm * std::tanh(omega / p_.stribeck_smoothing_rad_s) * (1.0 + p_.stribeck_peak * std::exp(-relative * relative));
  }
  if (p_.series_stiffness_Nm_rad != 0.0)
    for (std::size_t i = 0; i < 3; ++i) {
      moment -= p_.series_stiffness_Nm_rad / 3.0 * (theta - y[creep + i]);
      dy[creep + i] = (theta - y[creep + i]) / (series_factor[i] * p_.series_middle_time_s);
    }
  if (p_.twofold_stiffness_Nm_rad != 0.0) {
    const std::array follows_s{p_.twofold_fast_s, p_.twofold_slow_s};
    for (std::size_t i = 0; i < 2; ++i) {
      moment -= 0.5 * p_.twofold_stiffness_Nm_rad * (theta - y[creep + i]);
      dy[creep + i] = (theta - y[creep + i]) / follows_s[i];
    }
  }
  if (p_.eyring_stiffness_Nm_rad != 0.0) {
    const double scale = p_.eyring_angle_deg * degree;
    moment -= p_.eyring_stiffness_Nm_rad * (theta - y[eyring]);
    dy[eyring] = scale * std::sinh((theta - y[eyring]) / scale) / p_.eyring_time_s;
  }
  if (p_.bristle_Nm != 0.0) {
    const double limit = p_.bristle_deg * degree;
    moment -= p_.bristle_Nm * y[bristle] / limit;
    dy[bristle] = omega - std::abs(omega) * y[bristle] / limit;
  }
  if (p_.warm_softening_1_K != 0.0) {
    moment += p_.beam_stiffness_Nm_rad * p_.warm_softening_1_K * (y[silicone] - mean(ambient)) * theta;
    dy[silicone] = (0.5 * (y[temperature] + y[temperature + 1]) - y[silicone]) / p_.warm_softening_time_s;
  }
  moment -= p_.creep_stiffness_Nm_rad * (theta - y[creep + 3]);
  dy[creep + 3] = (theta - y[creep + 3]) / p_.creep_time_s;
  dy[angle] = omega;
  dy[velocity] = moment / p_.beam_inertia_kgm2;

  if (p_.hysteresis_deg != 0.0) dy[hysteresis] = omega - std::abs(omega) * y[hysteresis] / (p_.hysteresis_reversal_deg * degree);
  if (p_.film_pole_s > 0.0) dy[angle_sensor] = (theta - y[angle_sensor]) / p_.film_pole_s;
  if (p_.filter_pole_s > 0.0)
    dy[angle_sensor + 1] = ((p_.film_pole_s > 0.0 ? y[angle_sensor] : theta) - y[angle_sensor + 1]) / p_.filter_pole_s;
  if (p_.angle_lag_s > 0.0) dy[angle_sensor] = (theta - y[angle_sensor]) / p_.angle_lag_s;
  if (p_.resonance_s > 0.0) {
    dy[angle_sensor] = y[angle_sensor + 1];
    dy[angle_sensor + 1] =
        (theta - y[angle_sensor]) / (p_.resonance_s * p_.resonance_s) - 2.0 * p_.resonance_damping * y[angle_sensor + 1] / p_.resonance_s;
  }
  return dy;
}

void Run::step(double t, double h) {
  const auto moved = [this](const State& rate, double by) {
    State y;
    for (std::size_t i = 0; i < states; ++i) y[i] = y_[i] + by * rate[i];
    return y;
  };
  const State a = rates(t, y_);
  const State b = rates(t + 0.5 * h, moved(a, 0.5 * h));
  const State c = rates(t + 0.5 * h, moved(b, 0.5 * h));
  const State d = rates(t + h, moved(c, h));
  for (std::size_t i = 0; i < states; ++i) y_[i] += h / 6.0 * (a[i] + 2.0 * b[i] + 2.0 * c[i] + d[i]);
}

void Run::stiff_step(double t, double h) {
  const State first = rates(t, y_);
  State before = y_, last = y_, rate = first;
  for (std::size_t j = 0; j < stiff_.stages.size(); ++j) {
    const Chebyshev::Stage& c = stiff_.stages[j];
    if (j > 0) rate = rates(t + h * stiff_.stages[j - 1].time, last);
    State next;
    for (std::size_t i = 0; i < states; ++i)
      next[i] = c.first * y_[i] + c.last * last[i] + c.before * before[i] + h * (c.rate * rate[i] + c.first_rate * first[i]);
    before = last;
    last = next;
  }
  y_ = last;
}

}  // namespace sinew::prove

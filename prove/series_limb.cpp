// SPDX-License-Identifier: Apache-2.0
#include "prove/series_limb.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <stdexcept>
#include <utility>

#include "prove/generator_effects.h"
#include "prove/generator_limb.h"
#include "prove/generator_math.h"
#include "prove/generator_random.h"
#include "prove/generator_recording.h"

namespace sinew::prove {
namespace {

constexpr std::size_t coil_count = series_coils.size(), segment_count = series_segments.size();
constexpr double longest_step_s = 1.0e-3;

constexpr std::size_t segment_of(std::size_t coil) { return coil / 2; }
constexpr std::size_t beside(std::size_t coil) { return coil ^ 1; }                // the other coil of its segment
constexpr double side_of(std::size_t coil) { return coil % 2 == 0 ? 1.0 : -1.0; }  // +1 where a bend shortens it

// Numbers of every part, and `whole`, of which only what all parts share is read: supply, room, transformation, springs, effects.
struct SeriesPhysics {
  Physics whole;
  std::array<double, coil_count> resistance_Ohm, capacity_J_K, loss_W_K, arm_m;
  std::array<double, segment_count> stiffness_Nm_rad, damping_Nms_rad, inertia_kgm2, offset_deg, bend_sign;
  SeriesPhysics() {
    resistance_Ohm.fill(whole.resistance_A_Ohm);
    capacity_J_K.fill(whole.heat_capacity_A_J_K);
    loss_W_K.fill(whole.heat_loss_A_W_K);
    arm_m.fill(whole.moment_arm_A_m);
    stiffness_Nm_rad.fill(whole.beam_stiffness_Nm_rad);
    damping_Nms_rad.fill(whole.beam_damping_Nms_rad);
    inertia_kgm2.fill(whole.beam_inertia_kgm2);
    offset_deg.fill(whole.angle_offset_deg);
    bend_sign.fill(whole.bend_sign);
  }
};

// Calls with name, spread and a reference to each of the core's numbers, in a fixed order.
template <class Visitor>
void each_core_number(SeriesPhysics& physics, Visitor&& visit) {
  for (const CoreNumber& number : core_numbers()) {
    const std::string name(number.name);
    const bool of_a_part = name.find("_A_") != std::string::npos || name.find("_B_") != std::string::npos || name.starts_with("beam_") ||
                           name == "angle_offset_deg" || name == "bend_sign";
    if (!of_a_part) visit(name, number.spread, physics.whole.*number.field);
  }
  for (std::size_t j = 0; j < coil_count; ++j) {
    const std::string coil(series_coils[j]);
    visit("resistance_" + coil + "_Ohm", Spread::relative, physics.resistance_Ohm[j]);
    visit("heat_capacity_" + coil + "_J_K", Spread::relative, physics.capacity_J_K[j]);
    visit("heat_loss_" + coil + "_W_K", Spread::relative, physics.loss_W_K[j]);
    visit("moment_arm_" + coil + "_m", Spread::relative, physics.arm_m[j]);
  }
  for (std::size_t s = 0; s < segment_count; ++s) {
    const std::string segment(series_segments[s]);
    visit("beam_stiffness_" + segment + "_Nm_rad", Spread::relative, physics.stiffness_Nm_rad[s]);
    visit("beam_damping_" + segment + "_Nms_rad", Spread::relative, physics.damping_Nms_rad[s]);
    visit("beam_inertia_" + segment + "_kgm2", Spread::known, physics.inertia_kgm2[s]);
    visit("angle_offset_" + segment + "_deg", Spread::offset, physics.offset_deg[s]);
    visit("bend_sign_" + segment, Spread::known, physics.bend_sign[s]);
  }
}

SeriesPhysics series_physics_of(const std::map<std::string, double>& core_parameters, const std::vector<TruthEffect>& effects) {
  for (const TruthEffect& effect : effects) {
    const auto kinds = series_kinds();
    if (!effect.form.empty() || std::ranges::find(kinds, effect.name, &Kind::name) == kinds.end())
      throw std::invalid_argument("the limb of two segments has no effect " + effect.name);
  }
  SeriesPhysics physics;
  physics.whole = physics_of({}, effects);
  std::size_t known = 0;
  each_core_number(physics, [&](const std::string& name, Spread, double& value) {
    if (const auto found = core_parameters.find(name); found != core_parameters.end()) value = found->second, ++known;
  });
  if (known == core_parameters.size()) return physics;
  for (const auto& [name, value] : core_parameters) {
    bool found = false;
    each_core_number(physics, [&](const std::string& other, Spread, double&) { found = found || other == name; });
    if (!found) throw std::invalid_argument("the core of the limb of two segments has no parameter " + name);
  }
  return physics;
}

struct Envelopes {
  double heating, cooling;
};
Envelopes envelopes_at(const Physics& p, double temperature_degC, double shift_K) {
  Envelopes at{falling((temperature_degC - p.heating_midpoint_degC - shift_K) / p.heating_width_K),
               falling((temperature_degC - p.cooling_midpoint_degC - shift_K) / p.cooling_width_K)};
  if (at.cooling > at.heating) at.heating = at.cooling = 0.5 * (at.heating + at.cooling);
  return at;
}

// The zero of a function that rises from `low` to `high`.
template <class Function>
double zero_between(double low, double high, Function&& function) {
  for (int i = 0; i < 60; ++i) {
    const double middle = 0.5 * (low + high);
    (function(middle) > 0.0 ? high : low) = middle;
  }
  return 0.5 * (low + high);
}

struct SeriesState {
  std::array<double, coil_count> temperature_degC{}, fraction{}, bead_degC{};
  std::array<double, segment_count> angle_rad{}, velocity_rad_s{}, crept_rad{};
};
SeriesState moved(SeriesState y, const SeriesState& rate, double by) {
  for (std::size_t j = 0; j < coil_count; ++j) {
    y.temperature_degC[j] += by * rate.temperature_degC[j];
    y.fraction[j] += by * rate.fraction[j];
    y.bead_degC[j] += by * rate.bead_degC[j];
  }
  for (std::size_t s = 0; s < segment_count; ++s) {
    y.angle_rad[s] += by * rate.angle_rad[s];
    y.velocity_rad_s[s] += by * rate.velocity_rad_s[s];
    y.crept_rad[s] += by * rate.crept_rad[s];
  }
  return y;
}

// The limb in time, as Run: steps of at most 1 ms by Runge and Kutta's method of order 4, from cold and rest.
class SeriesRun {
 public:
  SeriesRun(const SeriesPhysics& physics, std::array<Air, coil_count> air) : p_(physics), air_(std::move(air)) {
    for (std::size_t j = 0; j < coil_count; ++j) y_.temperature_degC[j] = y_.bead_degC[j] = ambient_degC(j, 0.0);
    for (std::size_t s = 0; s < segment_count; ++s) {  // from base to tip: a moment hangs on the angles before it
      y_.angle_rad[s] = zero_between(-2.0, 2.0, [&](double theta) {
        SeriesState trial = y_;
        trial.angle_rad[s] = trial.crept_rad[s] = theta;
        settle(s, trial);
        return -moment_Nm(s, trial);
      });
      y_.crept_rad[s] = y_.angle_rad[s];
      settle(s, y_);
    }
  }

  void hold(const std::array<double, coil_count>& duty) { duty_ = duty; }

  void advance_to(double time_s) {
    const double length_s = time_s - time_s_;
    if (!(length_s > 0.0)) return;
    const double count = std::max(1.0, std::ceil(length_s / longest_step_s - 1.0e-6)), h = length_s / count;
    for (double i = 0.0; i < count; ++i) {
      const double t = time_s_ + length_s * i / count;
      const SeriesState a = rates(t, y_), b = rates(t + 0.5 * h, moved(y_, a, 0.5 * h)), c = rates(t + 0.5 * h, moved(y_, b, 0.5 * h)),
                        d = rates(t + h, moved(y_, c, h));
      y_ = moved(moved(moved(moved(y_, a, h / 6.0), b, h / 3.0), c, h / 3.0), d, h / 6.0);
    }
    time_s_ = time_s;
  }

  SeriesSample shown(double time_s) const {
    SeriesSample row{time_s, duty_, p_.whole.lag_s > 0.0 ? y_.bead_degC : y_.temperature_degC, {}};
    for (std::size_t s = 0; s < segment_count; ++s) row.angle_deg[s] = y_.angle_rad[s] / degree + p_.offset_deg[s];
    return row;
  }

 private:
  double ambient_degC(std::size_t coil, double time_s) const { return p_.whole.ambient_temperature_degC + air_[coil].at(time_s); }

  double tension_N(std::size_t coil, const SeriesState& y) const {
    const Physics& p = p_.whole;
    const std::size_t s = segment_of(coil);
    const double stretch = p.coil_stretch_m - p_.bend_sign[s] * side_of(coil) * p_.arm_m[coil] * y.angle_rad[s];
    const double k = p.austenite_stiffness_N_m + y.fraction[coil] * (p.martensite_stiffness_N_m - p.austenite_stiffness_N_m);
    return k * (stretch - y.fraction[coil] * p.transformation_stretch_m);
  }

  // All moments about segment s, but for its damping.
  double moment_Nm(std::size_t s, const SeriesState& y) const {
    double moment = -p_.stiffness_Nm_rad[s] * y.angle_rad[s] - p_.whole.creep_stiffness_Nm_rad * (y.angle_rad[s] - y.crept_rad[s]);
    for (std::size_t j = 0; j < coil_count; ++j)
      if (segment_of(j) == s) moment += p_.bend_sign[s] * side_of(j) * p_.arm_m[j] * tension_N(j, y);
    double absolute_rad = 0.0;
    for (std::size_t before = 0; before <= s; ++before) absolute_rad += y.angle_rad[before];
    return moment - p_.whole.gravity_Nm * std::sin(absolute_rad + p_.whole.gravity_tilt_deg * degree);
  }

  // The coils of segment s on their cooling envelopes, which their own tension moves.
  void settle(std::size_t s, SeriesState& y) const {
    for (std::size_t j = 0; j < coil_count; ++j)
      if (segment_of(j) == s)
        y.fraction[j] = zero_between(0.0, 1.0, [&](double xi) {
          SeriesState trial = y;
          trial.fraction[j] = xi;
          return xi - envelopes_at(p_.whole, y.temperature_degC[j], p_.whole.stress_shift_K_N * tension_N(j, trial)).cooling;
        });
  }

  SeriesState rates(double time_s, const SeriesState& y) const {
    const Physics& p = p_.whole;
    SeriesState dy;
    for (std::size_t j = 0; j < coil_count; ++j) {
      const double t = y.temperature_degC[j], xi = y.fraction[j];
      const double heat = duty_[j] * p.supply_voltage_V * p.supply_voltage_V / p_.resistance_Ohm[j] -
                          p_.loss_W_K[j] * (t - ambient_degC(j, time_s)) - p.cross_conductance_W_K * (t - y.temperature_degC[beside(j)]);
      dy.temperature_degC[j] = heat / p_.capacity_J_K[j];
      const Envelopes at = envelopes_at(p, t, p.stress_shift_K_N * tension_N(j, y));
      dy.fraction[j] = (positive(at.cooling - xi) - positive(xi - at.heating)) / p.transformation_time_s;
      if (p.lag_s > 0.0) dy.bead_degC[j] = (t - y.bead_degC[j]) / p.lag_s;
    }
    for (std::size_t s = 0; s < segment_count; ++s) {
      dy.angle_rad[s] = y.velocity_rad_s[s];
      dy.velocity_rad_s[s] = (moment_Nm(s, y) - p_.damping_Nms_rad[s] * y.velocity_rad_s[s]) / p_.inertia_kgm2[s];
      dy.crept_rad[s] = (y.angle_rad[s] - y.crept_rad[s]) / p.creep_time_s;
    }
    return dy;
  }

  SeriesPhysics p_;
  std::array<Air, coil_count> air_;
  double time_s_ = 0.0;
  SeriesState y_;
  std::array<double, coil_count> duty_{};
};

struct SeriesRecorded {
  std::vector<SeriesSample> rows, without_noise;
};

SeriesRecorded record_series(const SeriesPhysics& physics, std::uint64_t seed, const std::string& name, double duration_s,
                             double drawn_memory_s, const Settings& settings) {
  const double period_s = 1.0 / settings.sample_rate_Hz;
  const auto rows = static_cast<std::size_t>(std::round(duration_s / period_s)) + 1;
  std::array<Air, coil_count> air;
  if (settings.disturbances.moving_air) {
    const double memory_s = settings.air == AirMotion::slow ? slow_air_s : settings.air == AirMotion::fast ? fast_air_s : drawn_memory_s;
    for (std::size_t j = 0; j < coil_count; ++j) {
      const std::string own = settings.air == AirMotion::separate ? "air " + std::string(series_coils[j]) : "air";
      air[j] = moving_air(seed, name + own, 0.0, static_cast<double>(rows - 1) * period_s, memory_s);
    }
  }
  std::vector<Sensor> thermocouples, bends;
  for (const auto coil : series_coils) thermocouples.push_back({Stream(seed, name + "thermocouple " + std::string(coil)), 0.1, 0.25});
  std::vector<Babbler> babblers;
  for (const auto segment : series_segments) {
    bends.push_back({Stream(seed, name + "bend sensor " + std::string(segment)), 0.05, 1.0 / 32.0});
    babblers.emplace_back(seed, name + std::string(segment) + "/", period_s, false);
  }

  SeriesRun limb(physics, std::move(air));
  SeriesRecorded recorded;
  for (std::size_t k = 0; k < rows; ++k) {
    const double time_s = static_cast<double>(k) * period_s;
    limb.advance_to(time_s);
    SeriesSample shown = limb.shown(time_s), row = shown;
    for (std::size_t j = 0; j < coil_count; ++j) row.temperature_degC[j] = thermocouples[j].report(shown.temperature_degC[j], k);
    for (std::size_t s = 0; s < segment_count; ++s) {
      row.angle_deg[s] = bends[s].report(shown.angle_deg[s], k);
      const std::array<double, 2> both = babblers[s].duty(time_s, row.angle_deg[s]);
      for (std::size_t j = 0; j < coil_count; ++j)
        if (segment_of(j) == s) row.duty[j] = row.temperature_degC[j] > too_hot_degC ? 0.0 : both[j % 2];
    }
    shown.duty = row.duty;
    limb.hold(row.duty);
    recorded.rows.push_back(row);
    recorded.without_noise.push_back(shown);
  }
  return recorded;
}

}  // namespace

std::vector<std::string> series_columns() {
  std::vector<std::string> columns{"time_s"};
  for (const auto coil : series_coils) columns.push_back("duty_" + std::string(coil));
  for (const auto coil : series_coils) columns.push_back("temperature_" + std::string(coil) + "_degC");
  for (const auto segment : series_segments) columns.push_back("angle_" + std::string(segment) + "_deg");
  return columns;
}

std::vector<double> series_row(const SeriesSample& row) {
  std::vector<double> values{row.time_s};
  values.insert(values.end(), row.duty.begin(), row.duty.end());
  values.insert(values.end(), row.temperature_degC.begin(), row.temperature_degC.end());
  values.insert(values.end(), row.angle_deg.begin(), row.angle_deg.end());
  return values;
}

std::vector<Kind> series_kinds() {
  std::vector<Kind> kinds{{Family::clean, "core", {}}};
  for (const char* name : {"thermocouple_lag", "cross_heating", "stress_shift", "viscoelastic_creep", "gravity_load"})
    kinds.push_back({Family::catalogue, name, {name}});
  return kinds;
}

SeriesConcealed make_series(const Kind& kind, std::uint64_t seed, const Settings& settings) {
  check_range("sample_rate_Hz", settings.sample_rate_Hz, 1.0, 100.0);
  check_range("core_spread", settings.core_spread, 0.0, 0.3);
  const Disturbances& d = settings.disturbances;
  if (settings.protocol != Protocol::babbling || d.coarse_steps || d.gaps || d.outliers || d.clock_drift || d.mid_motion)
    throw std::invalid_argument("the limb of two segments has babbling alone, and of the disturbances moving air alone");
  const std::string stream = "series/" + kind.name;
  SeriesConcealed made;
  SeriesPhysics defaults;
  each_core_number(defaults, [&](const std::string& name, Spread spread, double& value) {
    const double off = Stream(seed, stream + "/core." + name).uniform(0, -1.0, 1.0);
    made.core_parameters[name] = off_by(value, spread, settings.core_spread, off);
  });
  for (const std::string& key : kind.effects)
    made.effects.push_back(drawn(effect_of_key(key), {seed, stream, settings.strength, settings.training_s, settings.heldout_s,
                                                      largest_setpoint_deg, defaults.whole.wire_J_K()}));
  const SeriesPhysics physics = series_physics_of(made.core_parameters, made.effects);
  const double memory_s = Stream(seed, stream + "/air memory").uniform(0, 20.0, 40.0);
  SeriesRecorded training = record_series(physics, seed, stream + "/training/", settings.training_s, memory_s, settings);
  SeriesRecorded heldout = record_series(physics, seed, stream + "/heldout/", settings.heldout_s, memory_s, settings);
  made.training = std::move(training.rows);
  made.training_without_noise = std::move(training.without_noise);
  made.heldout = std::move(heldout.rows);
  made.heldout_without_noise = std::move(heldout.without_noise);
  return made;
}

std::vector<SeriesSample> simulate_series(const std::map<std::string, double>& core_parameters, const std::vector<TruthEffect>& effects,
                                          const std::vector<SeriesSample>& samples) {
  SeriesRun limb(series_physics_of(core_parameters, effects), {});
  std::vector<SeriesSample> rows;
  for (const SeriesSample& row : samples) {
    limb.advance_to(row.time_s - samples.front().time_s);
    limb.hold(row.duty);
    rows.push_back(limb.shown(row.time_s));
  }
  return rows;
}

}  // namespace sinew::prove

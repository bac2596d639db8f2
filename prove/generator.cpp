// SPDX-License-Identifier: Apache-2.0
#include "prove/generator.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "prove/generator_effects.h"
#include "prove/generator_limb.h"
#include "prove/generator_random.h"

namespace sinew::prove {
namespace {

constexpr double period_s = 0.1;
constexpr double lead_in_s = 30.0;      // of mid_motion
constexpr double too_hot_degC = 110.0;  // the thermostat
constexpr double largest_setpoint_deg = 45.0;
constexpr double missing = std::numeric_limits<double>::quiet_NaN();

double time_of(std::int64_t tick) { return static_cast<double>(tick) * period_s; }

// A channel's noise and steps: thermocouple (MAX31855) and bend sensor.
struct Sensor {
  Stream chance;
  double noise, step;
  double report(double shown, std::uint64_t n) const {
    return std::round((shown + noise * chance.normal(n)) / step) * step + 0.0;  // + 0.0: never -0
  }
};

// Ornstein-Uhlenbeck process, drawn exactly from one sample to the next.
Air moving_air(std::uint64_t seed, const std::string& name, double first_s, std::size_t count, double memory_s) {
  constexpr double deviation_K = 0.3;
  const Stream chance(seed, name + "air");
  const double kept = std::exp(-period_s / memory_s);
  const double fresh = std::sqrt(1.0 - kept * kept);
  Air air{first_s, period_s, {deviation_K * chance.normal(0)}};
  for (std::size_t n = 1; n < count; ++n) air.offset_K.push_back(kept * air.offset_K.back() + fresh * deviation_K * chance.normal(n));
  return air;
}

// The paper's controller: setpoints held for a while, followed by a PI law; and a thermostat.
class Babbler {
 public:
  Babbler(std::uint64_t seed, const std::string& name) : setpoints_(seed, name + "setpoint"), holds_(seed, name + "hold") {}

  std::array<double, 2> duty(double elapsed_s, const std::array<double, 2>& temperature_degC, double angle_deg) {
    constexpr double proportional_1_deg = 0.06, integral_1_deg_s = 1.0e-5, largest_duty = 0.6;
    while (elapsed_s >= next_s_) {
      setpoint_deg_ = setpoints_.uniform(drawn_, -largest_setpoint_deg, largest_setpoint_deg);
      next_s_ += holds_.uniform(drawn_, 1.0, 30.0);
      ++drawn_;
    }
    const double error_deg = setpoint_deg_ - angle_deg;
    sum_deg_s_ += error_deg * period_s;
    const double u = std::clamp(proportional_1_deg * error_deg + integral_1_deg_s * sum_deg_s_, -1.0, 1.0);
    std::array<double, 2> duty{std::clamp(u, 0.0, largest_duty), std::clamp(-u, 0.0, largest_duty)};
    for (std::size_t j = 0; j < 2; ++j)
      if (temperature_degC[j] > too_hot_degC) duty[j] = 0.0;
    return duty;
  }

 private:
  Stream setpoints_, holds_;
  std::uint64_t drawn_ = 0;
  double setpoint_deg_ = 0.0, next_s_ = 0.0, sum_deg_s_ = 0.0;
};

double& channel(Sample& row, std::size_t which) { return which < 2 ? row.temperature_degC[which] : row.angle_deg; }

// What happens between the sensors and the file. The controller does not see it.
void spoil(std::vector<Sample>& rows, std::uint64_t seed, const std::string& name, const Disturbances& disturbances) {
  const double last = static_cast<double>(rows.size());
  for (std::size_t c = 0; c < 3; ++c) {
    const std::string own = name + "channel " + std::to_string(c) + "/";
    if (disturbances.outliers) {
      const Stream whether(seed, own + "outlier"), by(seed, own + "outlier size");
      for (std::size_t k = 0; k < rows.size(); ++k) {
        if (whether.uniform(k) >= 0.005) continue;
        const double share = by.uniform(k, -1.0, 1.0);
        channel(rows[k], c) += (c < 2 ? 20.0 : 15.0) * 0.5 * (share + std::copysign(1.0, share));
      }
    }
    if (disturbances.gaps) {
      const Stream where(seed, own + "gap"), length(seed, own + "gap length");
      for (std::uint64_t g = 0; g < 3; ++g) {
        const auto first = static_cast<std::size_t>(where.uniform(g) * last);
        const auto count = static_cast<std::size_t>(std::round(length.uniform(g, 0.5, 8.0) / period_s));
        for (std::size_t k = first; k < std::min(first + count, rows.size()); ++k) channel(rows[k], c) = missing;
      }
    }
  }
  if (disturbances.clock_drift)
    for (Sample& row : rows) row.time_s *= 1.01;
}

struct Recorded {
  std::vector<Sample> rows, without_noise;
};

Recorded record(const Physics& physics, std::uint64_t seed, const std::string& name, double duration_s, double air_memory_s,
                const Disturbances& disturbances) {
  const auto rows = static_cast<std::int64_t>(std::round(duration_s / period_s)) + 1;
  const std::int64_t before = disturbances.mid_motion ? std::int64_t{std::lround(lead_in_s / period_s)} : 0;
  const double temperature_step_K = disturbances.coarse_steps ? 0.5 : 0.25;
  const double angle_step_deg = disturbances.coarse_steps ? 0.25 : 1.0 / 32.0;
  const std::array<Sensor, 2> thermocouple{Sensor{Stream(seed, name + "thermocouple A"), 0.1, temperature_step_K},
                                           Sensor{Stream(seed, name + "thermocouple B"), 0.1, temperature_step_K}};
  const Sensor bend{Stream(seed, name + "bend sensor"), 0.05, angle_step_deg};
  Air air;
  if (disturbances.moving_air) air = moving_air(seed, name, time_of(-before), static_cast<std::size_t>(rows + before), air_memory_s);

  Run limb(physics, air, time_of(-before));
  Babbler babbler(seed, name);
  Recorded recorded;
  for (std::int64_t tick = -before; tick < rows; ++tick) {
    limb.advance_to(time_of(tick));
    const Shown shown = limb.shown();
    const auto n = static_cast<std::uint64_t>(tick + before);
    Sample row{time_of(tick), {}, {}, bend.report(shown.angle_deg, n)};
    for (std::size_t j = 0; j < 2; ++j) row.temperature_degC[j] = thermocouple[j].report(shown.temperature_degC[j], n);
    row.duty = babbler.duty(time_of(tick + before), row.temperature_degC, row.angle_deg);
    limb.hold(row.duty);
    if (tick < 0) continue;
    recorded.rows.push_back(row);
    recorded.without_noise.push_back({row.time_s, row.duty, shown.temperature_degC, shown.angle_deg});
  }
  spoil(recorded.rows, seed, name, disturbances);
  for (std::size_t k = 0; k < recorded.rows.size(); ++k) recorded.without_noise[k].time_s = recorded.rows[k].time_s;
  return recorded;
}

std::map<std::string, double> drawn_core(std::uint64_t seed, const std::string& kind) {
  std::map<std::string, double> core;
  const Physics defaults;
  for (const CoreNumber& number : core_numbers()) {
    const double off = Stream(seed, kind + "/core." + std::string(number.name)).uniform(0, -1.0, 1.0);
    double value = defaults.*number.field;
    switch (number.spread) {
      case Spread::known:
        break;
      case Spread::relative:
        value *= 1.0 + 0.08 * off;
        break;
      case Spread::kelvins:
        value += 3.0 * off;
        break;
      case Spread::offset:
        value += off;
        break;
    }
    core.emplace(number.name, value);
  }
  return core;
}

// Whether the thermocouple sits on a body that stores heat apart from the wire.
bool has_body(const Effect& effect) {
  return std::ranges::find(effect.numbers, &Physics::junction_capacity_J_K, &Number::field) != effect.numbers.end();
}

}  // namespace

Concealed make(const Kind& kind, std::uint64_t seed, const Settings& settings) {
  Concealed made;
  const std::string stream = drawn_as(kind.name);
  made.core_parameters = drawn_core(seed, stream);
  const auto near = [&](const std::string& name, double value) {
    made.core_parameters[name] = value * Stream(seed, stream + "/core." + name).uniform(0, 0.97, 1.03);
  };
  if (std::ranges::find(kind.effects, "coil_slack") != kind.effects.end()) {
    // A cold coil has to be longer than the room there is for it, by more than a bend takes up.
    near("coil_stretch_m", 0.030 - 0.0045 * settings.strength);
    near("transformation_stretch_m", 0.028 + 0.0055 * settings.strength);
  }
  if (std::ranges::any_of(kind.effects, [](const std::string& key) { return has_body(effect_of_key(key)); })) {
    // What is outside is not inside: the wire that works is lighter than believed, in both coils alike.
    const double left = 1.0 - settings.strength * Stream(seed, stream + "/lighter").uniform(0, 0.23, 0.48);
    near("heat_capacity_A_J_K", Physics{}.heat_capacity_A_J_K * left);
    near("heat_capacity_B_J_K", Physics{}.heat_capacity_B_J_K * left);
  }

  const Physics core = physics_of(made.core_parameters, {});
  const double cold = core.ambient_temperature_degC;
  const double reach_deg = std::min({largest_setpoint_deg, std::abs(Run::balance_deg(core, {too_hot_degC, cold})),
                                     std::abs(Run::balance_deg(core, {cold, too_hot_degC}))});
  for (const std::string& key : kind.effects)
    made.effects.push_back(
        drawn(effect_of_key(key), {seed, stream, settings.strength, settings.training_s, settings.heldout_s, reach_deg, core.wire_J_K()}));

  const Physics physics = physics_of(made.core_parameters, made.effects);
  const double air_memory_s = Stream(seed, stream + "/air memory").uniform(0, 20.0, 40.0);
  Recorded training = record(physics, seed, stream + "/training/", settings.training_s, air_memory_s, settings.disturbances);
  Recorded heldout = record(physics, seed, stream + "/heldout/", settings.heldout_s, air_memory_s, settings.disturbances);
  made.training = std::move(training.rows);
  made.training_without_noise = std::move(training.without_noise);
  made.heldout = std::move(heldout.rows);
  made.heldout_without_noise = std::move(heldout.without_noise);
  return made;
}

std::vector<Sample> simulate(const std::map<std::string, double>& core_parameters, const std::vector<TruthEffect>& effects,
                             const std::vector<Sample>& samples) {
  Run limb(physics_of(core_parameters, effects), {}, 0.0);
  std::vector<Sample> shown;
  for (const Sample& row : samples) {
    limb.advance_to(row.time_s - samples.front().time_s);
    const Shown now = limb.shown();
    shown.push_back({row.time_s, row.duty, now.temperature_degC, now.angle_deg});
    limb.hold(row.duty);
  }
  return shown;
}

}  // namespace sinew::prove

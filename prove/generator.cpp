// SPDX-License-Identifier: Apache-2.0
#include "prove/generator.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <stdexcept>
#include <utility>

#include "prove/generator_effects.h"
#include "prove/generator_limb.h"
#include "prove/generator_random.h"
#include "prove/generator_recording.h"

namespace sinew::prove {
namespace {

constexpr double lead_in_s = 30.0;  // of mid_motion
constexpr double missing = std::numeric_limits<double>::quiet_NaN();

class Steps : public Driver {
 public:
  Steps(std::uint64_t seed, const std::string& name)
      : levels_{Stream(seed, name + "level A"), Stream(seed, name + "level B")}, holds_(seed, name + "hold") {}

  std::array<double, 2> duty(double elapsed_s, double) override {
    while (elapsed_s >= next_s_) {
      const std::uint64_t turn = drawn_ % 4;  // A, B, both, none
      for (std::size_t j = 0; j < 2; ++j) duty_[j] = turn == j || turn == 2 ? levels_[j].uniform(drawn_, 0.05, 0.35) : 0.0;
      next_s_ += holds_.uniform(drawn_, 8.0, 30.0);
      ++drawn_;
    }
    return duty_;
  }

 private:
  std::array<Stream, 2> levels_;
  Stream holds_;
  std::uint64_t drawn_ = 0;
  double next_s_ = 0.0;
  std::array<double, 2> duty_{};
};

class SlowRamps : public Driver {
 public:
  SlowRamps(std::uint64_t seed, const std::string& name) : peaks_(seed, name + "peak"), lengths_(seed, name + "ramp length") {}

  std::array<double, 2> duty(double elapsed_s, double) override {
    while (elapsed_s >= next_s_) {
      began_s_ = next_s_;
      next_s_ += lengths_.uniform(drawn_, 60.0, 120.0);
      peak_ = peaks_.uniform(drawn_, 0.12, 0.22);
      ++drawn_;
    }
    const double done = (elapsed_s - began_s_) / (next_s_ - began_s_);
    std::array<double, 2> duty{};
    duty[(drawn_ - 1) % 2] = peak_ * (1.0 - std::abs(2.0 * done - 1.0));
    return duty;
  }

 private:
  Stream peaks_, lengths_;
  std::uint64_t drawn_ = 0;
  double began_s_ = 0.0, next_s_ = 0.0, peak_ = 0.0;
};

class RandomBinary : public Driver {
 public:
  RandomBinary(std::uint64_t seed, const std::string& name)
      : whether_{Stream(seed, name + "on A"), Stream(seed, name + "on B")}, level_(seed, name + "level") {}

  std::array<double, 2> duty(double elapsed_s, double) override {
    constexpr double interval_s = 4.0, probability = 1.0 / 3.0;
    const auto interval = static_cast<std::uint64_t>(std::floor(elapsed_s / interval_s + 1.0e-9));
    std::array<double, 2> duty{};
    for (std::size_t j = 0; j < 2; ++j)
      if (whether_[j].uniform(interval) < probability) duty[j] = level_.uniform(j, 0.25, 0.45);
    return duty;
  }

 private:
  std::array<Stream, 2> whether_;
  Stream level_;
};

std::unique_ptr<Driver> driver_of(Protocol protocol, std::uint64_t seed, const std::string& name, double period_s) {
  switch (protocol) {
    case Protocol::babbling:
    case Protocol::one_sided:
      break;
    case Protocol::steps:
      return std::make_unique<Steps>(seed, name);
    case Protocol::slow_ramps:
      return std::make_unique<SlowRamps>(seed, name);
    case Protocol::random_binary:
      return std::make_unique<RandomBinary>(seed, name);
  }
  return std::make_unique<Babbler>(seed, name, period_s, protocol == Protocol::one_sided);
}

// The air of each wire, from `first_s` to `last_s`; `drawn_memory_s` is that of air that is neither slow nor fast.
std::array<Air, 2> air_of(const Settings& settings, std::uint64_t seed, const std::string& name, double first_s, double last_s,
                          double drawn_memory_s) {
  if (!settings.disturbances.moving_air) return {};
  const double memory_s = settings.air == AirMotion::slow ? slow_air_s : settings.air == AirMotion::fast ? fast_air_s : drawn_memory_s;
  const Air air = moving_air(seed, name + "air", first_s, last_s, memory_s);
  return {air, settings.air == AirMotion::separate ? moving_air(seed, name + "air B", first_s, last_s, memory_s) : air};
}

double& channel(Sample& row, std::size_t which) { return which < 2 ? row.temperature_degC[which] : row.angle_deg; }

// What happens between the sensors and the file. The controller does not see it.
void spoil(std::vector<Sample>& rows, std::uint64_t seed, const std::string& name, double period_s, const Disturbances& disturbances) {
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
                const Settings& settings) {
  const Disturbances& disturbances = settings.disturbances;
  const double period_s = 1.0 / settings.sample_rate_Hz;
  const auto time_of = [period_s](std::int64_t tick) { return static_cast<double>(tick) * period_s; };
  const auto rows = static_cast<std::int64_t>(std::round(duration_s / period_s)) + 1;
  const std::int64_t before = disturbances.mid_motion ? std::int64_t{std::lround(lead_in_s / period_s)} : 0;
  const double temperature_step_K = disturbances.coarse_steps ? 0.5 : 0.25;
  const double angle_step_deg = disturbances.coarse_steps ? 0.25 : 1.0 / 32.0;
  const std::array<Sensor, 2> thermocouple{Sensor{Stream(seed, name + "thermocouple A"), 0.1, temperature_step_K},
                                           Sensor{Stream(seed, name + "thermocouple B"), 0.1, temperature_step_K}};
  const Sensor bend{Stream(seed, name + "bend sensor"), 0.05, angle_step_deg};

  Run limb(physics, air_of(settings, seed, name, time_of(-before), time_of(rows - 1), air_memory_s), time_of(-before));
  const std::unique_ptr<Driver> driver = driver_of(settings.protocol, seed, name, period_s);
  Recorded recorded;
  for (std::int64_t tick = -before; tick < rows; ++tick) {
    limb.advance_to(time_of(tick));
    const Shown shown = limb.shown();
    const auto n = static_cast<std::uint64_t>(tick + before);
    Sample row{time_of(tick), {}, {}, bend.report(shown.angle_deg, n)};
    for (std::size_t j = 0; j < 2; ++j) row.temperature_degC[j] = thermocouple[j].report(shown.temperature_degC[j], n);
    row.duty = driver->duty(time_of(tick + before), row.angle_deg);
    for (std::size_t j = 0; j < 2; ++j)
      if (row.temperature_degC[j] > too_hot_degC) row.duty[j] = 0.0;
    limb.hold(row.duty);
    if (tick < 0) continue;
    recorded.rows.push_back(row);
    recorded.without_noise.push_back({row.time_s, row.duty, shown.temperature_degC, shown.angle_deg});
  }
  spoil(recorded.rows, seed, name, period_s, disturbances);
  for (std::size_t k = 0; k < recorded.rows.size(); ++k) recorded.without_noise[k].time_s = recorded.rows[k].time_s;
  return recorded;
}

std::map<std::string, double> drawn_core(std::uint64_t seed, const std::string& kind, double spread) {
  std::map<std::string, double> core;
  const Physics defaults;
  for (const CoreNumber& number : core_numbers()) {
    const double off = Stream(seed, kind + "/core." + std::string(number.name)).uniform(0, -1.0, 1.0);
    const double value = off_by(defaults.*number.field, number.spread, spread, off);
    core.emplace(number.name, value);
  }
  return core;
}

// Whether the thermocouple sits on a body that stores heat apart from the wire.
bool has_body(const Effect& effect) {
  return std::ranges::find(effect.numbers, &Physics::junction_capacity_J_K, &Number::field) != effect.numbers.end();
}

}  // namespace

ConcealedLimb conceal(const Kind& kind, std::uint64_t seed, const Settings& settings) {
  check_range("core_spread", settings.core_spread, 0.0, 0.3);
  ConcealedLimb made;
  const std::string stream = drawn_as(kind.name);
  made.core_parameters = drawn_core(seed, stream, settings.core_spread);
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

  made.air_memory_s = Stream(seed, stream + "/air memory").uniform(0, 20.0, 40.0);
  return made;
}

Run concealed_run(const Kind& kind, std::uint64_t seed, const Settings& settings, const std::string& recording, double duration_s,
                  const std::optional<Run::Left>& left) {
  const ConcealedLimb limb = conceal(kind, seed, settings);
  const Physics physics = physics_of(limb.core_parameters, limb.effects);
  const double begin_s = left ? left->time_s : 0.0;
  std::array<Air, 2> air =
      air_of(settings, seed, drawn_as(kind.name) + "/" + recording + "/", begin_s, begin_s + duration_s, limb.air_memory_s);
  return left ? Run(physics, std::move(air), *left) : Run(physics, std::move(air), begin_s);
}

Kind kind_of_name(std::string_view name) {
  std::string near;
  std::vector<Kind> all = kinds();
  for (const Kind& kind : unlike_kinds()) all.push_back(kind);
  for (const Kind& kind : all) {
    if (kind.name == name) return kind;
    const std::string_view stem = name.substr(0, std::min<std::size_t>(name.size(), 4));
    if (!stem.empty() && kind.name.find(stem) != std::string::npos) near += (near.empty() ? "" : ", ") + kind.name;
  }
  throw std::invalid_argument("no kind of concealed limb is called " + std::string(name) + (near.empty() ? "" : "; near are: " + near));
}

Concealed make(const Kind& kind, std::uint64_t seed, const Settings& settings) {
  check_range("sample_rate_Hz", settings.sample_rate_Hz, 1.0, 100.0);
  const std::string stream = drawn_as(kind.name);
  Concealed made;
  ConcealedLimb limb = conceal(kind, seed, settings);
  made.core_parameters = std::move(limb.core_parameters);
  made.effects = std::move(limb.effects);
  const double air_memory_s = limb.air_memory_s;
  const Physics physics = physics_of(made.core_parameters, made.effects);
  Recorded training = record(physics, seed, stream + "/training/", settings.training_s, air_memory_s, settings);
  Recorded heldout = record(physics, seed, stream + "/heldout/", settings.heldout_s, air_memory_s, settings);
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

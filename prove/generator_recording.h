// SPDX-License-Identifier: Apache-2.0
// What all limbs of the generator share: air, sensors, the paper's controller, and how far a core's parameter is off.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <stdexcept>
#include <string>

#include "prove/generator_effects.h"
#include "prove/generator_limb.h"
#include "prove/generator_random.h"

namespace sinew::prove {

inline constexpr double air_period_s = 0.1;    // air is drawn on a grid of its own, whatever the sample rate
inline constexpr double too_hot_degC = 110.0;  // the thermostat
inline constexpr double largest_setpoint_deg = 45.0, largest_duty = 0.6;
inline constexpr double slow_air_s = 150.0, fast_air_s = 5.0;

// A channel's noise and steps: thermocouple (MAX31855) and bend sensor.
struct Sensor {
  Stream chance;
  double noise, step;
  double report(double shown, std::uint64_t n) const {
    return std::round((shown + noise * chance.normal(n)) / step) * step + 0.0;  // + 0.0: never -0
  }
};

// Ornstein-Uhlenbeck process, drawn exactly from one point of its grid to the next.
inline Air moving_air(std::uint64_t seed, const std::string& stream, double first_s, double last_s, double memory_s) {
  constexpr double deviation_K = 0.3;
  const Stream chance(seed, stream);
  const double kept = std::exp(-air_period_s / memory_s);
  const double fresh = std::sqrt(1.0 - kept * kept);
  const auto count = static_cast<std::size_t>(std::ceil((last_s - first_s) / air_period_s - 1.0e-6)) + 1;
  Air air{first_s, air_period_s, {deviation_K * chance.normal(0)}};
  for (std::size_t n = 1; n < count; ++n) air.offset_K.push_back(kept * air.offset_K.back() + fresh * deviation_K * chance.normal(n));
  return air;
}

// Decides on the duty of both coils, sample by sample; the thermostat comes after it.
class Driver {
 public:
  virtual ~Driver() = default;
  virtual std::array<double, 2> duty(double elapsed_s, double angle_deg) = 0;
};

// The paper's controller: setpoints held for a while, followed by a PI law.
class Babbler : public Driver {
 public:
  Babbler(std::uint64_t seed, const std::string& name, double period_s, bool coil_a_alone)
      : setpoints_(seed, name + "setpoint"),
        holds_(seed, name + "hold"),
        period_s_(period_s),
        lowest_setpoint_deg_(coil_a_alone ? 0.0 : -largest_setpoint_deg),
        largest_duty_b_(coil_a_alone ? 0.0 : largest_duty) {}

  std::array<double, 2> duty(double elapsed_s, double angle_deg) override {
    constexpr double proportional_1_deg = 0.06, integral_1_deg_s = 1.0e-5;
    while (elapsed_s >= next_s_) {
      setpoint_deg_ = setpoints_.uniform(drawn_, lowest_setpoint_deg_, largest_setpoint_deg);
      next_s_ += holds_.uniform(drawn_, 1.0, 30.0);
      ++drawn_;
    }
    const double error_deg = setpoint_deg_ - angle_deg;
    sum_deg_s_ += error_deg * period_s_;
    const double u = std::clamp(proportional_1_deg * error_deg + integral_1_deg_s * sum_deg_s_, -1.0, 1.0);
    return {std::clamp(u, 0.0, largest_duty), std::clamp(-u, 0.0, largest_duty_b_)};
  }

 private:
  Stream setpoints_, holds_;
  double period_s_, lowest_setpoint_deg_, largest_duty_b_;
  std::uint64_t drawn_ = 0;
  double setpoint_deg_ = 0.0, next_s_ = 0.0, sum_deg_s_ = 0.0;
};

// A core's value that is off by a share `off` (-1 to 1) of what it may be off by.
inline double off_by(double value, Spread kind, double spread, double off) {
  constexpr double usual_spread = 0.08;
  switch (kind) {
    case Spread::known:
      break;
    case Spread::relative:
      return value * (1.0 + spread * off);
    case Spread::kelvins:
      return value + 3.0 * (spread / usual_spread) * off;
    case Spread::offset:
      return value + spread / usual_spread * off;
  }
  return value;
}

inline void check_range(const std::string& name, double value, double lowest, double highest) {
  if (!(value >= lowest && value <= highest))
    throw std::invalid_argument(name + " is " + std::to_string(value) + ", and must lie in [" + std::to_string(lowest) + ", " +
                                std::to_string(highest) + "]");
}

}  // namespace sinew::prove

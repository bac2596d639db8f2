// SPDX-License-Identifier: Apache-2.0
#include "hil/supervisor.h"

#include <algorithm>
#include <cmath>

#include "hil/heat_bound.h"
#include "hil/limits.h"
#include "hil/message.h"
#include "sim/simulation.h"
#include "sim/text.h"

namespace sinew::hil {
namespace {

constexpr double limit_degC = LIMIT_HOST_cdegC / 100.0, highest_duty = LIMIT_HIGHEST_DUTY / 10000.0;
constexpr double horizon_s = 2.0, horizon_steps = 8;
// Below the device's own budget, which has buckets of a whole second.
constexpr double on_budget_s = LIMIT_ON_TIME_ms / 1000.0 - 0.4, on_window_s = LIMIT_ON_TIME_WINDOW_s + 1.0;
constexpr double forget_s = 5.0;              // correction downwards
constexpr double least_correction_K = -10.0;  // a sensor that drifts cold must not talk the prediction down without end
constexpr double most_off_K = 30.0, most_off_s = 1.0;
constexpr double most_angle_off_deg = 45.0;  // half of what the limb does: a plant that is not calibrated may be off by much
constexpr double longest_missing_s = 0.5;
// The bound that a command must keep if it is the last for as long as the device lets it live, in the period after which the next is due.
constexpr std::uint32_t bound_most_uK = (LIMIT_BOUND_RISE_cK - 50) * 10'000u;
constexpr plant::NumericalSettings numerics{plant::Method::automatic, 1e-5};

}  // namespace

HostSupervisor::HostSupervisor(const plant::Plant& limb, const plant::Start& start, double period_s)
    : limb_(limb),
      parts_(parts_of(limb)),
      period_s_(period_s),
      observer_(limb, start, numerics),
      watch_(parts_.coils.size()),
      angle_off_for_s_(parts_.angles.size(), 0.0),
      predicted_degC_(parts_.coils.size(), 0.0) {
  for (Watch& coil : watch_) coil.bound_uK = LIMIT_BOUND_START_cK * 10'000u;
}

void HostSupervisor::bound_said(std::span<const std::uint16_t> rise_cK) {
  for (std::size_t j = 0; j < watch_.size(); ++j) watch_[j].bound_uK = std::max(watch_[j].bound_uK, rise_cK[j] * 10'000u);
}

double HostSupervisor::duty_within_bound(const Watch& coil) const {
  const double held_ms = std::ceil(period_s_ * 1e3) + LIMIT_DEAD_MAN_ms;
  const std::uint32_t without_uK = heat_bound_after(coil.bound_uK, 0, static_cast<std::uint16_t>(held_ms));
  if (without_uK >= bound_most_uK) return 0.0;
  return (bound_most_uK - without_uK) / (held_ms * LIMIT_BOUND_HEATING_mK_s);
}

std::vector<double> HostSupervisor::hottest_degC(const std::vector<double>& duty) const {
  const std::vector<double>& now = observer_.state();
  plant::Start from;
  from.given.assign(now.begin(), now.end());
  from.inputs = duty;
  std::vector<double> hottest;
  for (std::size_t j = 0; j < parts_.coils.size(); ++j) {
    const std::size_t wire = parts_.coils[j].temperature.index;
    from.given[wire] = now[wire] + watch_[j].correction_K;
    hottest.push_back(*from.given[wire]);
  }
  plant::Integrator ahead(limb_, from, numerics);
  ahead.hold(duty);
  for (int k = 1; k <= static_cast<int>(horizon_steps); ++k) {
    if (ahead.advance_to(horizon_s * k / horizon_steps)) return std::vector<double>(hottest.size(), HUGE_VAL);
    for (std::size_t j = 0; j < parts_.coils.size(); ++j)
      hottest[j] = std::max(hottest[j], ahead.state()[parts_.coils[j].temperature.index]);
  }
  return hottest;
}

std::vector<double> HostSupervisor::lower(const std::vector<double>& wanted, const sim::Measurement& measured) {
  const std::vector<double> observed = observer_.readings();
  for (std::size_t j = 0; j < parts_.coils.size(); ++j) {
    const std::size_t shown = parts_.coils[j].shown.index;
    double& correction_K = watch_[j].correction_K;
    if (std::isnan(measured.channels[shown])) continue;
    const double difference_K = measured.channels[shown] - observed[shown];
    correction_K =
        difference_K > correction_K ? difference_K : correction_K + (difference_K - correction_K) * std::min(1.0, period_s_ / forget_s);
    correction_K = std::max(correction_K, least_correction_K);
  }
  std::vector<double> duty(parts_.coils.size(), 0.0);
  bool changed = false;
  for (std::size_t j = 0; j < parts_.coils.size(); ++j) {
    if (std::isnan(wanted[j])) objection_ = "the command for coil " + parts_.coils[j].name + " is not a number";
    const double asked = std::isnan(wanted[j]) ? 0.0 : std::clamp(wanted[j], 0.0, highest_duty);
    const double left_s = std::max(0.0, on_budget_s - watch_[j].on_sum_s);
    duty[j] = std::min({asked, left_s / period_s_, duty_within_bound(watch_[j])});
    changed = changed || duty[j] != wanted[j];
  }
  if (objection_) duty.assign(duty.size(), 0.0);
  if (std::any_of(duty.begin(), duty.end(), [](double one) { return one > 0.0; })) {
    predicted_degC_ = hottest_degC(duty);
    for (std::size_t j = 0; j < parts_.coils.size(); ++j) {
      if (duty[j] == 0.0 || predicted_degC_[j] <= limit_degC) continue;
      changed = true;
      double low = 0.0, high = duty[j];
      for (int k = 0; k < 7; ++k) {
        duty[j] = 0.5 * (low + high);
        (hottest_degC(duty)[j] <= limit_degC ? low : high) = duty[j];
      }
      duty[j] = low;
    }
  }
  // As the wire has it: ten-thousandths, cut and never rounded up.
  for (double& one : duty) one = std::floor(one * DUTY_ONE + 1e-9) / DUTY_ONE;
  lowered_ += changed;
  return duty;
}

void HostSupervisor::applied(const std::vector<double>& duty_fraction) {
  observer_.hold(duty_fraction);
  ++ticks_;
  if (const auto failure = observer_.advance_to(static_cast<double>(ticks_) * period_s_))
    objection_ = "the plant that watches the limb failed: " + failure->reason;
  for (std::size_t j = 0; j < parts_.coils.size(); ++j) {
    Watch& coil = watch_[j];
    const double step_ms = period_s_ * 1e3;
    coil.bound_uK = heat_bound_after(coil.bound_uK, static_cast<std::uint32_t>(std::ceil(duty_fraction[j] * DUTY_ONE * step_ms)),
                                     static_cast<std::uint16_t>(step_ms));
    coil.on_s.push_back(duty_fraction[j] * period_s_);
    coil.on_sum_s += coil.on_s.back();
    if (static_cast<double>(coil.on_s.size()) * period_s_ > on_window_s) {
      coil.on_sum_s -= coil.on_s.front();
      coil.on_s.pop_front();
    }
  }
}

void HostSupervisor::look(const sim::Measurement& measured, std::span<const std::uint32_t> all_raw) {
  const std::vector<double> observed = observer_.readings();
  for (std::size_t j = 0; j < parts_.coils.size(); ++j) {
    const Coil& coil = parts_.coils[j];
    Watch& watch = watch_[j];
    const auto object = [&](const std::string& why) {
      if (!objection_) objection_ = "thermocouple " + coil.name + ": " + why;
    };
    const double shown_degC = measured.channels[coil.shown.index];
    const std::uint32_t raw = all_raw[coil.thermocouple];
    watch.missing_s = std::isnan(shown_degC) ? watch.missing_s + period_s_ : 0.0;
    if (watch.missing_s > longest_missing_s) object("nothing heard for " + sim::shortest(longest_missing_s) + " s");
    if (std::isnan(shown_degC)) continue;
    if (raw == 0 || raw == 0xffffffffu) object("all bits are the same");
    if (raw & 0x00010007u) object("the amplifier reports a fault");
    // The words and the number were made apart; they must agree.
    const double decoded_degC = (static_cast<std::int32_t>(raw) >> 18) * 0.25;
    if (std::abs(decoded_degC - shown_degC) > 0.01) object("number and bits differ");
    if (shown_degC > LIMIT_COIL_cdegC / 100.0) object(sim::shortest(shown_degC) + " degC, beyond the limit");
    if (watch.last_degC && std::abs(shown_degC - *watch.last_degC) > LIMIT_JUMP_cK / 100.0 + 60.0 * period_s_)
      object("jumped to " + sim::shortest(shown_degC) + " degC");
    watch.last_degC = shown_degC;
    watch.off_for_s = std::abs(shown_degC - observed[coil.shown.index]) > most_off_K ? watch.off_for_s + period_s_ : 0.0;
    if (watch.off_for_s > most_off_s)
      object(sim::shortest(shown_degC) + " degC, where the plant has " + sim::shortest(std::round(observed[coil.shown.index])));
  }
}

void HostSupervisor::look_at_angles(const sim::Measurement& measured, std::span<const std::uint16_t> raw) {
  const std::vector<double> observed = sim::in_file_units(limb_.system(), observer_.readings());
  for (std::size_t k = 0; k < parts_.angles.size(); ++k) {
    const std::size_t channel = parts_.angles[k].index;
    const std::string& name = limb_.system().channels()[parts_.angles[k]].words;
    const double shown_deg = measured.channels[channel];
    if (std::isnan(shown_deg)) continue;
    if (!objection_ && (raw[k] < LIMIT_ANGLE_LEAST_raw || raw[k] > LIMIT_ANGLE_MOST_raw))
      objection_ = name + ": at the end of its range, a wire is off";
    double& off_for_s = angle_off_for_s_[k];
    off_for_s = std::abs(shown_deg - observed[channel]) > most_angle_off_deg ? off_for_s + period_s_ : 0.0;
    if (!objection_ && off_for_s > most_off_s)
      objection_ = name + ": " + sim::shortest(shown_deg) + " deg, where the plant has " + sim::shortest(std::round(observed[channel]));
  }
}

}  // namespace sinew::hil

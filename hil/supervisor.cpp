// SPDX-License-Identifier: Apache-2.0
#include "hil/supervisor.h"

#include <algorithm>
#include <cmath>

#include "hil/limits.h"
#include "sim/text.h"

namespace sinew::hil {
namespace {

constexpr double limit_degC = LIMIT_HOST_cdegC / 100.0, highest_duty = LIMIT_HIGHEST_DUTY / 10000.0;
constexpr double horizon_s = 2.0, horizon_steps = 8;
// Below the device's own budget, which has buckets of a whole second.
constexpr double on_budget_s = LIMIT_ON_TIME_ms / 1000.0 - 0.4, on_window_s = LIMIT_ON_TIME_WINDOW_s + 1.0;
constexpr double forget_s = 5.0;          // correction downwards
constexpr double least_correction_K = -10.0;  // a sensor that drifts cold must not talk the prediction down without end
constexpr double most_off_K = 30.0, most_off_s = 1.0;
constexpr double longest_missing_s = 0.5;
constexpr plant::NumericalSettings numerics{plant::Method::automatic, 1e-5};

constexpr const char* names[] = {"A", "B"};

}  // namespace

HostSupervisor::HostSupervisor(const plant::Limb<double>& limb, const plant::Start& start, double period_s)
    : limb_(limb), period_s_(period_s), observer_(limb, start, numerics) {}

plant::PerCoil<double> HostSupervisor::hottest_degC(const plant::PerCoil<double>& duty) const {
  const std::vector<double>& now = observer_.state();
  plant::Start from;
  from.given.assign(now.begin(), now.end());
  from.duty_fraction = duty;
  for (const std::size_t j : plant::coils)
    from.given[plant::core_state::temperature + j] = now[plant::core_state::temperature + j] + correction_K_[j];
  plant::Integrator ahead(limb_, from, numerics);
  ahead.hold(duty);
  plant::PerCoil<double> hottest{*from.given[plant::core_state::temperature], *from.given[plant::core_state::temperature + 1]};
  for (int k = 1; k <= static_cast<int>(horizon_steps); ++k) {
    if (ahead.advance_to(horizon_s * k / horizon_steps)) return {HUGE_VAL, HUGE_VAL};
    for (const std::size_t j : plant::coils) hottest[j] = std::max(hottest[j], ahead.state()[plant::core_state::temperature + j]);
  }
  return hottest;
}

plant::PerCoil<double> HostSupervisor::lower(const plant::PerCoil<double>& wanted, const sim::Measurement& measured) {
  const plant::Reading<double> observed = observer_.reading();
  for (const std::size_t j : plant::coils) {
    if (std::isnan(measured.temperature_degC[j])) continue;
    const double difference_K = measured.temperature_degC[j] - observed.temperature_degC[j];
    correction_K_[j] = difference_K > correction_K_[j]
                           ? difference_K
                           : correction_K_[j] + (difference_K - correction_K_[j]) * std::min(1.0, period_s_ / forget_s);
    correction_K_[j] = std::max(correction_K_[j], least_correction_K);
  }
  plant::PerCoil<double> duty{};
  bool changed = false;
  for (const std::size_t j : plant::coils) {
    if (std::isnan(wanted[j])) objection_ = std::string("the command for coil ") + names[j] + " is not a number";
    const double asked = std::isnan(wanted[j]) ? 0.0 : std::clamp(wanted[j], 0.0, highest_duty);
    const double left_s = std::max(0.0, on_budget_s - on_sum_s_[j]);
    duty[j] = std::min(asked, left_s / period_s_);
    changed = changed || duty[j] != wanted[j];
  }
  if (objection_) duty = {};
  if (duty[0] > 0.0 || duty[1] > 0.0) {
    predicted_degC_ = hottest_degC(duty);
    for (const std::size_t j : plant::coils) {
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

void HostSupervisor::applied(const plant::PerCoil<double>& duty_fraction) {
  observer_.hold(duty_fraction);
  ++ticks_;
  if (const auto failure = observer_.advance_to(static_cast<double>(ticks_) * period_s_))
    objection_ = "the plant that watches the limb failed: " + failure->reason;
  for (const std::size_t j : plant::coils) {
    on_s_[j].push_back(duty_fraction[j] * period_s_);
    on_sum_s_[j] += on_s_[j].back();
    if (static_cast<double>(on_s_[j].size()) * period_s_ > on_window_s) {
      on_sum_s_[j] -= on_s_[j].front();
      on_s_[j].pop_front();
    }
  }
}

void HostSupervisor::look(const sim::Measurement& measured, const std::array<std::uint32_t, 2>& raw) {
  const plant::Reading<double> observed = observer_.reading();
  for (const std::size_t j : plant::coils) {
    const auto object = [&](const std::string& why) {
      if (!objection_) objection_ = std::string("thermocouple ") + names[j] + ": " + why;
    };
    const double shown_degC = measured.temperature_degC[j];
    missing_s_[j] = std::isnan(shown_degC) ? missing_s_[j] + period_s_ : 0.0;
    if (missing_s_[j] > longest_missing_s) object("nothing heard for " + sim::shortest(longest_missing_s) + " s");
    if (std::isnan(shown_degC)) continue;
    if (raw[j] == 0 || raw[j] == 0xffffffffu) object("all bits are the same");
    if (raw[j] & 0x00010007u) object("the amplifier reports a fault");
    // The words and the number were made apart; they must agree.
    const double decoded_degC = (static_cast<std::int32_t>(raw[j]) >> 18) * 0.25;
    if (std::abs(decoded_degC - shown_degC) > 0.01) object("number and bits differ");
    if (shown_degC > LIMIT_COIL_cdegC / 100.0) object(sim::shortest(shown_degC) + " degC, beyond the limit");
    if (last_degC_[j] && std::abs(shown_degC - *last_degC_[j]) > 10.0 + 60.0 * period_s_) object("jumped to " + sim::shortest(shown_degC) + " degC");
    last_degC_[j] = shown_degC;
    off_for_s_[j] = std::abs(shown_degC - observed.temperature_degC[j]) > most_off_K ? off_for_s_[j] + period_s_ : 0.0;
    if (off_for_s_[j] > most_off_s) object(sim::shortest(shown_degC) + " degC, where the plant has " + sim::shortest(std::round(observed.temperature_degC[j])));
  }
}

}  // namespace sinew::hil

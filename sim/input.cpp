// SPDX-License-Identifier: Apache-2.0
#include "sim/input.h"

#include <algorithm>

namespace sinew::sim {

Driver::Driver(const Input& input, std::uint64_t seed, double period_s)
    : input_(input), period_s_(period_s),
      signal_chance_{RandomStream(seed, "duty_A"), RandomStream(seed, "duty_B")},
      setpoint_chance_(seed, "babble.setpoint"), hold_chance_(seed, "babble.hold") {}

plant::PerCoil<double> Driver::babble(const BabbleInput& input, const Measurement& measured, double time_s) {
  if (!std::isnan(measured.angle_deg)) state_.last_angle_deg = measured.angle_deg;
  if (time_s >= state_.next_setpoint_s) {
    const auto n = static_cast<std::uint64_t>(state_.setpoints_drawn++);
    state_.setpoint_deg = input.lowest_deg + (input.highest_deg - input.lowest_deg) * setpoint_chance_.uniform(n);
    state_.next_setpoint_s +=
        input.shortest_hold_s + (input.longest_hold_s - input.shortest_hold_s) * hold_chance_.uniform(n);
  }
  const double error_deg = state_.setpoint_deg - state_.last_angle_deg;
  state_.error_integral_deg_s += error_deg * period_s_;
  const double u = std::clamp(
      input.proportional_gain_1_deg * error_deg + input.integral_gain_1_deg_s * state_.error_integral_deg_s, -1.0, 1.0);
  const double limit = input.duty_limit_fraction;
  plant::PerCoil<double> duty{};
  const std::size_t other = input.positive_drives == plant::A ? plant::B : plant::A;
  if (u > 0.0) duty[input.positive_drives] = std::min(u, limit);
  if (u < 0.0 && input.both_coils) duty[other] = std::min(-u, limit);
  return duty;
}

Command Driver::command(const Measurement& measured, double time_s) {
  Command command{measured.tick, {}};
  if (const auto* open_loop = std::get_if<OpenLoopInput>(&input_)) {
    for (const std::size_t j : plant::coils) {
      double sum = 0.0;
      for (const Signal& signal : open_loop->duty[j])
        sum += std::visit([&](const auto& one) { return one.at(time_s, signal_chance_[j]); }, signal);
      command.duty_fraction[j] = std::clamp(sum, 0.0, 1.0);
    }
  } else if (const auto* input = std::get_if<BabbleInput>(&input_)) {
    command.duty_fraction = babble(*input, measured, time_s);
  } else {
    const auto& samples = std::get<ReplayInput>(input_).recording.samples;
    const double first_s = samples.front().time_s;
    std::size_t& i = state_.replay_index;
    while (i + 1 < samples.size() && samples[i + 1].time_s - first_s <= time_s + 1e-9) ++i;
    command.duty_fraction = samples[i].duty_fraction;
  }
  return command;
}

}  // namespace sinew::sim

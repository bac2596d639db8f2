// SPDX-License-Identifier: Apache-2.0
#include "sim/input.h"

#include <algorithm>

namespace sinew::sim {

Driver::Driver(const plant::System& system, const Input& input, std::uint64_t seed, double period_s)
    : system_(system), input_(input), period_s_(period_s) {
  for (const auto& one : system.inputs()) signal_chance_.emplace_back(seed, one.column);
  const auto* babbling = std::get_if<BabbleInput>(&input);
  if (!babbling) return;
  for (const plant::Drive& drive : system.drives()) {
    if (followed_.empty() || followed_.back().channel != drive.channel) {
      // The first channel's streams have no name of their own, so that a further one leaves them as they are.
      const std::string own = followed_.empty() ? "" : "." + system.channels()[drive.channel].short_name;
      followed_.push_back({drive.channel, {}, RandomStream(seed, "babble.setpoint" + own), RandomStream(seed, "babble.hold" + own)});
    }
    followed_.back().driven_by.emplace_back(drive.input, drive.sense);
  }
  for (Followed& one : followed_) {
    const bool turned = std::any_of(one.driven_by.begin(), one.driven_by.end(), [&](const auto& by) {
      return system.inputs()[by.first].name == babbling->positive_drives && by.second < 0.0;
    });
    for (auto& by : one.driven_by)
      if (turned) by.second = -by.second;
  }
  state_.following.resize(followed_.size());
}

std::vector<double> Driver::babble(const BabbleInput& input, const Measurement& measured, double time_s) {
  std::vector<double> sum(system_.inputs().size(), 0.0);
  for (std::size_t k = 0; k < followed_.size(); ++k) {
    const Followed& one = followed_[k];
    DriverState::Following& state = state_.following[k];
    if (const double value = measured.channels[one.channel.index]; !std::isnan(value)) state.last_measured = value;
    if (time_s >= state.next_setpoint_s) {
      const auto n = static_cast<std::uint64_t>(state.setpoints_drawn++);
      state.setpoint = input.lowest_deg + (input.highest_deg - input.lowest_deg) * one.setpoint_chance.uniform(n);
      state.next_setpoint_s += input.shortest_hold_s + (input.longest_hold_s - input.shortest_hold_s) * one.hold_chance.uniform(n);
    }
    const double error = state.setpoint - state.last_measured;
    state.error_integral += error * period_s_;
    const double u = std::clamp(input.proportional_gain_1_deg * error + input.integral_gain_1_deg_s * state.error_integral, -1.0, 1.0);
    if (u < 0.0 && !input.both_sides) continue;
    for (const auto& [driven, sense] : one.driven_by) sum[driven.index] += u * sense;
  }
  for (double& value : sum) value = std::clamp(value, 0.0, input.duty_limit_fraction);
  return sum;
}

Command Driver::command(const Measurement& measured, double time_s) {
  Command command{measured.tick, std::vector<double>(system_.inputs().size(), 0.0)};
  if (const auto* open_loop = std::get_if<OpenLoopInput>(&input_)) {
    for (std::size_t i = 0; i < open_loop->signals.size(); ++i) {
      double sum = 0.0;
      for (const Signal& signal : open_loop->signals[i])
        sum += std::visit([&](const auto& one) { return one.at(time_s, signal_chance_[i]); }, signal);
      const plant::Range& range = system_.inputs()[plant::InputId{i}].range;
      command.inputs[i] = std::clamp(sum, range.lowest, range.highest);
    }
  } else if (const auto* input = std::get_if<BabbleInput>(&input_)) {
    command.inputs = babble(*input, measured, time_s);
  } else {
    const auto& samples = std::get<ReplayInput>(input_).recording.samples;
    const double first_s = samples.front().time_s;
    std::size_t& i = state_.replay_index;
    while (i + 1 < samples.size() && samples[i + 1].time_s - first_s <= time_s + 1e-9) ++i;
    command.inputs = samples[i].inputs;
  }
  return command;
}

}  // namespace sinew::sim

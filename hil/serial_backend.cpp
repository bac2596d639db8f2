// SPDX-License-Identifier: Apache-2.0
#include "hil/serial_backend.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "hil/limits.h"

namespace sinew::hil {
namespace {

// A command is sent again this often: then one or two that are lost or damaged are no silence to the device.
constexpr std::int64_t longest_silence_us = 50'000;
constexpr double nan = std::numeric_limits<double>::quiet_NaN();

std::uint16_t on_wire(double duty_fraction) {
  const double all = duty_fraction * DUTY_ONE;
  return all > 0.0 ? static_cast<std::uint16_t>(std::lround(std::min(all, static_cast<double>(LIMIT_HIGHEST_DUTY)))) : std::uint16_t{0};
}

}  // namespace

std::uint8_t telemetry_period_ms(std::int64_t period_us) {
  return static_cast<std::uint8_t>(std::clamp<std::int64_t>(period_us / 4000, 3, longest_silence_us / 2000));
}

std::int64_t SerialBackend::parts_of_period() const { return (period_us_ + longest_silence_us - 1) / longest_silence_us; }

sim::Measurement SerialBackend::begin() {
  begin_us_ = device_.now_us();
  measure(0, part_arrival_us_, heard_in_part_);
  return measure(0, tick_arrival_us_, heard_);
}

sim::Measurement SerialBackend::exchange(const sim::Command& asked) {
  sim::Command command = asked;
  const std::int64_t parts = parts_of_period();
  const auto begin_of_part_us = [&](std::int64_t part) { return deadline_us(command.tick) + period_us_ * part / parts; };
  for (std::int64_t part = 1; part <= parts; ++part) {
    std::vector<std::uint16_t> duty;
    for (const Coil& coil : parts_.coils) duty.push_back(on_wire(command.inputs[coil.input.index]));
    device_.listen_until(begin_of_part_us(part - 1) + send_offset_us());
    device_.command(duty, LIMIT_DEAD_MAN_ms);
    if (part == 1) written_us_ = device_.now_us();
    device_.listen_until(begin_of_part_us(part));
    const sim::Measurement measured = measure(command.tick, part_arrival_us_, heard_in_part_);
    if (part < parts && before_repetition && !before_repetition(measured, command)) break;
  }
  return measure(command.tick + 1, tick_arrival_us_, heard_);
}

sim::Measurement SerialBackend::measure(std::int64_t tick, std::int64_t& last_arrival_us, bool& heard) {
  const auto& telemetry = device_.telemetry();
  sim::Measurement measured{tick, std::vector<double>(parts_.thermocouples.size() + parts_.angles.size(), nan)};
  heard = telemetry && telemetry->arrived_us != last_arrival_us;
  if (!heard) return measured;
  last_arrival_us = telemetry->arrived_us;
  const message_telemetry& said = telemetry->said;
  for (std::size_t k = 0; k < parts_.thermocouples.size(); ++k)
    if (said.sensor[k] == TRIP_NONE) measured.channels[parts_.thermocouples[k].index] = said.temperature_cdegC[k] / 100.0;
  for (std::size_t k = 0; k < parts_.angles.size(); ++k)
    if (said.angle_fault[k] == TRIP_NONE) measured.channels[parts_.angles[k].index] = said.angle_cdeg[k] / 100.0;
  return measured;
}

}  // namespace sinew::hil

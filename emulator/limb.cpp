// SPDX-License-Identifier: GPL-3.0-or-later
#include "emulator/limb.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "sim/input_error.h"
#include "sim/text.h"

namespace sinew::emulator {
namespace {

constexpr std::int64_t conversion_us = 100'000, grid_us = 10'000;
constexpr double angle_span_deg = 180.0, reference_mV = 5000.0;
constexpr double conversions_summed = 16.0;  // by the firmware: its mean has the scenario's noise

std::uint32_t word(double temperature_degC, double junction_degC) {
  const auto hot = static_cast<std::int32_t>(std::lround(std::clamp(temperature_degC, -270.0, 1800.0) * 4.0));
  const auto cold = static_cast<std::int32_t>(std::lround(std::clamp(junction_degC, -55.0, 125.0) * 16.0));
  return (static_cast<std::uint32_t>(hot & 0x3fff) << 18) | (static_cast<std::uint32_t>(cold & 0xfff) << 4);
}

}  // namespace

Limb::Limb(const sim::Scenario& scenario, std::vector<Fault> faults, bool trace, std::unique_ptr<Body> body)
    : scenario_(scenario), faults_(std::move(faults)), trace_(trace), body_(std::move(body)) {
  const plant::System& system = scenario.plant.system();
  const auto fail = [](const std::string& key, std::size_t found, const std::string& advice) {
    throw sim::InputError({.key = key, .value = std::to_string(found), .advice = advice});
  };
  if (system.inputs().size() != board_coils)
    fail("plant: number of coils", system.inputs().size(), "the emulated board has " + std::to_string(board_coils));
  std::size_t angles = 0;
  PerCoil<std::size_t> thermocouples{};
  for (const plant::ChannelId c : system.channels().ids()) {
    const plant::ChannelInfo& channel = system.channels()[c];
    noise_.emplace_back(static_cast<std::uint64_t>(scenario.seed), channel.short_name + ".noise");
    if (channel.kind == "angle") angle_ = c, ++angles;
    if (channel.kind == "temperature" && channel.driven_by)
      thermocouples_[channel.driven_by->index] = c, ++thermocouples[channel.driven_by->index];
  }
  if (angles != 1) fail("plant: number of bend sensors", angles, "the emulated board has 1");
  for (const plant::InputId i : system.inputs().ids())
    if (thermocouples[i.index] != 1)
      fail("plant: number of thermocouples on coil " + system.inputs()[i].name, thermocouples[i.index], "the emulated board has 1 on each");
  supply_ = system.parameter("supply_voltage_V");
  ambient_ = system.parameter("ambient_temperature_degC");
  std::string coils_header, readings_header;
  trace_csv_ = "time_s";
  for (const plant::InputId i : system.inputs().ids()) {
    const std::string& name = system.inputs()[i].name;
    trace_csv_ += ",gate_" + name;
    coils_header += ",coil_" + name + "_degC";
    readings_header += ",reading_" + name + "_degC";
  }
  trace_csv_ += coils_header + readings_header + "\n";
  row(0);
}

const Fault* Limb::active(FaultKind kind, std::size_t coil, std::int64_t now_us) const {
  for (const Fault& fault : faults_)
    if (fault.kind == kind && now_us >= fault.from_us && now_us < fault.until_us && (fault.coil == coil || !description(kind).of_a_coil))
      return &fault;
  return nullptr;
}

void Limb::move_plant(std::int64_t now_us) {
  if (now_us <= moved_us_) return;
  body_->advance_to(static_cast<double>(now_us) / 1e6);
  moved_us_ = now_us;
}

double Limb::supply_V(std::int64_t now_us) const {
  double supply_V = scenario_.plant.get(supply_);
  if (const Fault* other = active(FaultKind::supply_V, 0, now_us)) supply_V = other->value;
  if (const Fault* ramp = active(FaultKind::supply_ramp_V_s, 0, now_us))
    supply_V += ramp->value * static_cast<double>(now_us - ramp->from_us) / 1e6;
  return supply_V;
}

// The supply behind the coil, or ground: through the switch, or through the divider where nothing comes from above.
int Limb::drain_mV(std::int64_t now_us, std::size_t coil, const PerCoil<bool>& pins_on) {
  bool gate_on = pins_on[active(FaultKind::gates_swapped, 0, now_us) ? board_coils - 1 - coil : coil];
  if (const Fault* stuck = active(FaultKind::gate_stuck, coil, now_us)) gate_on = static_cast<double>(now_us % 10'000) < stuck->value * 1e4;
  const bool conducts = gate_on || active(FaultKind::coil_welded, coil, now_us);
  if (conducts || !relay_closed_ || active(FaultKind::coil_open, coil, now_us)) return 0;
  return static_cast<int>(std::lround(supply_V(now_us) * 1000.0));
}

// What flows: a welded switch conducts, an open coil does not, and heat goes with the square of the supply.
void Limb::hold(std::int64_t now_us) {
  std::vector<double> duty(gates_.begin(), gates_.end());
  if (active(FaultKind::gates_swapped, 0, now_us)) std::reverse(duty.begin(), duty.end());
  for (std::size_t j = 0; j < board_coils; ++j) {
    if (const Fault* stuck = active(FaultKind::gate_stuck, j, now_us)) duty[j] = stuck->value;
    if (active(FaultKind::coil_welded, j, now_us)) duty[j] = 1.0;
    if (active(FaultKind::coil_open, j, now_us) || !relay_closed_) duty[j] = 0.0;
    const double nominal_V = scenario_.plant.get(supply_), now_V = supply_V(now_us);
    if (now_V != nominal_V) duty[j] *= std::pow(now_V / nominal_V, 2);
  }
  body_->hold(duty);
}

void Limb::row(std::int64_t now_us) {
  if (!trace_) return;
  sim::append_shortest(trace_csv_, static_cast<double>(now_us) / 1e6);
  const auto put = [&](double value) {
    trace_csv_ += ',';
    sim::append_shortest(trace_csv_, value);
  };
  for (const double gate : gates_) put(gate);
  for (const double wire_degC : body_->wires_degC()) put(wire_degC);
  for (const Amplifier& one : amplifiers_) put((static_cast<std::int32_t>(one.shown) >> 18) * 0.25);
  trace_csv_ += '\n';
}

void Limb::gates(std::int64_t now_us, const PerCoil<double>& duty_fraction) {
  move_plant(now_us);
  gates_ = duty_fraction;
  hold(now_us);
  row(now_us);
}

void Limb::relay(std::int64_t now_us, bool closed) {
  if (closed == relay_closed_) return;
  move_plant(now_us);
  relay_closed_ = closed;
  hold(now_us);
}

Left Limb::left_after(std::int64_t now_us, double pause_s) {
  move_plant(now_us);
  body_->hold(std::vector<double>(board_coils, 0.0));
  body_->advance_to(static_cast<double>(now_us) / 1e6 + pause_s);
  return body_->left();
}

std::int64_t Limb::next_us() const {
  std::int64_t next = (moved_us_ / grid_us + 1) * grid_us;
  for (const Amplifier& one : amplifiers_)
    if (one.begun_us >= 0) next = std::min(next, one.begun_us + conversion_us);
  for (const Fault& fault : faults_) {
    if (fault.from_us > moved_us_) next = std::min(next, fault.from_us);
    if (fault.until_us > moved_us_) next = std::min(next, fault.until_us);
  }
  return next;
}

void Limb::advance(std::int64_t now_us) {
  move_plant(now_us);
  hold(now_us);
  for (std::size_t j = 0; j < board_coils; ++j)
    if (amplifiers_[j].begun_us >= 0 && now_us >= amplifiers_[j].begun_us + conversion_us) {
      amplifiers_[j].shown = convert(j, now_us);
      amplifiers_[j].begun_us = -1;
    }
  row(now_us);
}

std::uint32_t Limb::convert(std::size_t coil, std::int64_t now_us) {
  const std::uint64_t n = amplifiers_[coil].conversions++;
  const std::size_t from = active(FaultKind::sensors_swapped, coil, now_us) ? board_coils - 1 - coil : coil;
  const std::size_t channel = thermocouples_[coil].index;
  const sim::SensorSettings& settings = scenario_.sensors[channel];
  double shown = body_->readings()[thermocouples_[from].index] + settings.bias + settings.noise * noise_[channel].normal(n);
  if (const Fault* noise = active(FaultKind::sensor_noise, coil, now_us)) {
    const sim::RandomStream more(static_cast<std::uint64_t>(scenario_.seed), coil == 0 ? "fault.noise" : "fault.noise.other");
    shown += noise->value * more.normal(n);
  }
  double junction = scenario_.plant.get(ambient_);
  if (const Fault* scale = active(FaultKind::sensor_scale, coil, now_us)) shown = junction + scale->value * (shown - junction);
  if (const Fault* drift = active(FaultKind::sensor_drift, coil, now_us))
    shown -= drift->value * static_cast<double>(now_us - drift->from_us) / 1e6;
  // The chip adds its cold junction to what the thermocouple says: an error there is one here.
  if (const Fault* jump = active(FaultKind::junction_jump, coil, now_us)) {
    junction += jump->value;
    shown += jump->value;
  }
  if (active(FaultKind::sensor_stuck, coil, now_us)) return amplifiers_[coil].shown;
  const std::uint32_t good = word(shown, junction);
  if (active(FaultKind::sensor_open, coil, now_us)) return good | 0x00010001u;
  if (active(FaultKind::sensor_ground, coil, now_us)) return good | 0x00010002u;
  if (active(FaultKind::sensor_supply, coil, now_us)) return good | 0x00010004u;
  if (active(FaultKind::sensor_garbled, coil, now_us)) return good | 0x00020000u;
  return good;
}

void Limb::select(std::int64_t now_us, std::size_t coil, bool selected) {
  Amplifier& one = amplifiers_[coil];
  if (!selected) {
    one.begun_us = now_us;
    return;
  }
  one.begun_us = -1;
  one.shifting = one.shown;
  // A dead chip or line is so at once, not from the next conversion on.
  if (active(FaultKind::sensor_zeros, coil, now_us)) one.shifting = 0;
  if (active(FaultKind::sensor_ones, coil, now_us)) one.shifting = 0xffffffffu;
  if (const Fault* flips = active(FaultKind::sensor_flips, coil, now_us)) {
    const sim::RandomStream chance(static_cast<std::uint64_t>(scenario_.seed), "fault.flips");
    if (chance.uniform(one.conversions) < flips->value) one.shifting ^= 1u << (chance.bits(one.conversions + (1u << 20)) % 32);
  }
}

std::uint8_t Limb::clock_out(std::size_t coil) {
  const auto byte = static_cast<std::uint8_t>(amplifiers_[coil].shifting >> 24);
  amplifiers_[coil].shifting <<= 8;
  return byte;
}

int Limb::bend_sensor_mV(std::int64_t now_us) {
  if (active(FaultKind::bend_low, 0, now_us)) return 0;
  if (active(FaultKind::bend_high, 0, now_us)) return static_cast<int>(reference_mV);
  if (active(FaultKind::bend_stuck, 0, now_us)) return bend_mV_;
  const sim::SensorSettings& settings = scenario_.sensors[angle_.index];
  const double noise_deg = settings.noise * std::sqrt(conversions_summed) * noise_[angle_.index].normal(angle_conversions_++);
  const double shown_deg = body_->readings()[angle_.index] + settings.bias + noise_deg;
  return bend_mV_ = static_cast<int>(std::lround(std::clamp(shown_deg / angle_span_deg + 0.5, 0.0, 1.0) * reference_mV));
}

}  // namespace sinew::emulator

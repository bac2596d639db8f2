// SPDX-License-Identifier: GPL-3.0-or-later
#include "emulator/fault.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

#include "sim/input_error.h"
#include "sim/text.h"

namespace sinew::emulator {
namespace {

constexpr std::array<FaultDescription, static_cast<std::size_t>(FaultKind::count)> descriptions{{
    {"sensor_open", true, false, true, "thermocouple wire broken"},
    {"sensor_ground", true, false, true, "thermocouple shorted to ground"},
    {"sensor_supply", true, false, true, "thermocouple shorted to supply"},
    {"sensor_zeros", true, false, true, "amplifier dead: all bits 0"},
    {"sensor_ones", true, false, true, "data line hangs high: all bits 1"},
    {"sensor_garbled", true, false, true, "a bit set that is always 0"},
    {"sensor_stuck", true, false, true, "the same reading for ever"},
    {"sensor_drift", true, true, true, "reads too cold, by VALUE K more each second"},
    {"sensor_scale", true, true, true, "shows VALUE of the rise over the cold junction"},
    {"sensor_noise", true, true, true, "VALUE kelvin more white noise"},
    {"sensor_flips", true, true, true, "in VALUE of the words one bit arrives flipped"},
    {"sensors_swapped", false, false, true, "thermocouples exchanged"},
    {"bend_low", false, false, true, "the bend sensor shows 0 V: unplugged, or shorted to ground"},
    {"bend_high", false, false, true, "the bend sensor shows 5 V: shorted to supply"},
    {"bend_stuck", false, false, true, "the bend sensor shows the same for ever"},
    {"junction_jump", true, true, true, "cold junction off by VALUE K"},
    {"hang", false, false, false, "the main loop never comes round, interrupts are served"},
    {"hang_masked", false, false, false, "the same with interrupts off"},
    {"brown_out", false, false, false, "the processor's supply sags: a reset"},
    {"reset", false, false, false, "somebody pushes the button"},
    {"power_cycle", false, false, false, "power off and on"},
    {"power_cut_in_storing", false, true, false, "power off and on VALUE us after the EEPROM begins to write, from then on"},
    {"coil_welded", true, false, true, "the switch conducts whatever its gate says"},
    {"coil_open", true, false, true, "no current"},
    {"gate_stuck", true, true, true, "its gate is on for VALUE of the time, whatever the pin says"},
    {"gates_swapped", false, false, true, "gates exchanged"},
    {"supply_V", false, true, true, "the coils' supply is VALUE V"},
    {"supply_ramp_V_s", false, true, true, "the coils' supply rises by VALUE V each second"},
    {"fuse_high", false, true, false, "the chip's high fuse is VALUE, 0 to 255; from 0 s on"},
    {"fuse_extended", false, true, false, "its extended fuse is VALUE, 0 to 255; from 0 s on"},
    {"time_ms", false, true, false, "the device's count of milliseconds becomes VALUE"},
}};

}  // namespace

const FaultDescription& description(FaultKind kind) { return descriptions[static_cast<std::size_t>(kind)]; }

std::string fault_help() {
  std::string text = "KIND[:COIL]@FROM_s[+FOR_s][=VALUE], COIL a coil's name, as A or B. Kinds:\n";
  for (const FaultDescription& one : descriptions)
    text += std::string("  ") + one.name + (one.of_a_coil ? ":COIL" : "") + (one.has_value ? " (=VALUE)" : "") + ": " + one.meaning + "\n";
  return text;
}

Fault parse_fault(const std::string& text, const std::vector<std::string>& coils) {
  const auto fail = [&](const std::string& advice) -> void {
    throw sim::InputError({.key = "--fault", .value = text, .advice = advice + "\n" + fault_help()});
  };
  Fault fault{};
  const std::size_t at = text.find('@');
  if (at == std::string::npos) fail("says no time");
  std::string kind = text.substr(0, at), rest = text.substr(at + 1);
  bool has_coil = false;
  if (const std::size_t colon = kind.find(':'); colon != std::string::npos) {
    const std::string coil = kind.substr(colon + 1);
    const auto named = std::find(coils.begin(), coils.end(), coil);
    if (named == coils.end()) {
      std::string names;
      for (const std::string& name : coils) names += (names.empty() ? "" : " or ") + name;
      fail("the coil must be " + names);
    }
    fault.coil = static_cast<std::size_t>(named - coils.begin());
    has_coil = true;
    kind.resize(colon);
  }
  std::size_t k = 0;
  while (k < descriptions.size() && kind != descriptions[k].name) ++k;
  if (k == descriptions.size()) fail("there is no such fault");
  fault.kind = static_cast<FaultKind>(k);
  if (has_coil && !descriptions[k].of_a_coil) fail("is of the board, not of a coil");
  const auto cut = [&](char mark) -> std::optional<double> {
    const std::size_t found = rest.find(mark);
    if (found == std::string::npos) return std::nullopt;
    const auto number = sim::parse_number(rest.substr(found + 1));
    if (!number || std::isnan(*number)) fail(std::string("no number behind ") + mark);
    rest.resize(found);
    return number;
  };
  const auto value = cut('=');
  const auto lasts_s = cut('+');
  const auto from_s = sim::parse_number(rest);
  if (!from_s || !(*from_s >= 0.0 && *from_s < 1e6)) fail("the time must be seconds from 0 on");
  if (value.has_value() != descriptions[k].has_value) fail(value ? "takes no value" : "wants a value");
  fault.value = value.value_or(0.0);
  if (fault.kind == FaultKind::fuse_high || fault.kind == FaultKind::fuse_extended)
    if (!(fault.value >= 0.0 && fault.value <= 255.0) || fault.value != std::floor(fault.value)) fail("a fuse is a whole number, 0 to 255");
  fault.from_us = std::llround(*from_s * 1e6);
  if (lasts_s) {
    if (!descriptions[k].lasts) fail("happens at a moment and does not last");
    if (!(*lasts_s > 0.0 && *lasts_s < 1e6)) fail("must last longer than 0 s");
    fault.until_us = fault.from_us + std::llround(*lasts_s * 1e6);
  }
  return fault;
}

}  // namespace sinew::emulator

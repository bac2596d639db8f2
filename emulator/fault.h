// SPDX-License-Identifier: GPL-3.0-or-later
// What is made to go wrong, and when: KIND[:COIL]@FROM_s[+FOR_s][=VALUE].
#pragma once

#include <cstdint>
#include <limits>
#include <string>
#include <vector>

namespace sinew::emulator {

enum class FaultKind {
  sensor_open,     // thermocouple wire broken
  sensor_ground,   // shorted to ground
  sensor_supply,   // shorted to supply
  sensor_zeros,    // amplifier dead: all bits 0
  sensor_ones,     // data line hangs high
  sensor_garbled,  // a reserved bit set
  sensor_stuck,    // the same reading for ever
  sensor_drift,    // VALUE kelvin a second, the reading too cold by it
  sensor_scale,    // it shows VALUE of its rise over the cold junction
  sensor_noise,    // VALUE kelvin of white noise, one standard deviation, more than the scenario's
  sensor_flips,    // in VALUE of the words one bit arrives flipped
  sensors_swapped,
  bend_low,       // 0 V on the bend sensor's wire: unplugged, by its resistor to ground
  bend_high,      // 5 V
  bend_stuck,     // what it showed when that began
  junction_jump,  // cold junction VALUE kelvin off
  hang,           // the main loop never comes round, interrupts are served
  hang_masked,    // the same with interrupts off
  brown_out,
  reset,  // somebody pushes the button
  power_cycle,
  power_cut_in_storing,  // VALUE us after the EEPROM begins to write, the first time from then on
  coil_welded,           // the switch conducts whatever its gate says
  coil_open,             // no current
  gate_stuck,            // its gate is on for VALUE of the time, whatever the pin says
  gates_swapped,         // the gates of the two coils are exchanged
  supply_V,              // VALUE volts
  supply_ramp_V_s,       // the supply rises by VALUE volts each second, from the nominal one
  fuse_high,             // the chip's high fuse is VALUE: from the start alone, for a program reads it then
  fuse_extended,         // the same of its extended fuse
  time_ms,               // the device's millisecond count becomes VALUE
  count
};

// Name, whether it is of one coil, whether it wants a value.
struct FaultDescription {
  const char* name;
  bool of_a_coil, has_value, lasts;
  const char* meaning;
};
const FaultDescription& description(FaultKind kind);

struct Fault {
  FaultKind kind;
  std::size_t coil = 0;
  std::int64_t from_us = 0;
  std::int64_t until_us = std::numeric_limits<std::int64_t>::max();
  double value = 0.0;
};

// `coils`: their names; the first is meant where the text names none. Throws sim::InputError.
Fault parse_fault(const std::string& text, const std::vector<std::string>& coils);
std::string fault_help();

}  // namespace sinew::emulator

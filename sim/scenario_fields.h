// SPDX-License-Identifier: Apache-2.0
// The fields of a scenario that are declared neither by a signal nor by a System: what reads, writes and describes scenarios walks these.
#pragma once

#include <string>

#include "sim/fields.h"
#include "sim/scenario.h"

namespace sinew::sim {

inline constexpr plant::Range durations_s{0.1, 1e6}, sample_periods_s{0.001, 60.0};

template <class Self, class Visitor>
void sensor_fields(Self& self, const std::string& unit, Visitor&& visit) {
  visit(self.noise, Key{"noise_" + unit, {0.0, 100.0}, "standard deviation of white noise"});
  visit(self.step, Key{"step_" + unit, {0.0, 100.0}, "quantisation; 0: none"});
  visit(self.bias, Key{"bias_" + unit, {-1000.0, 1000.0}, "added to every sample"});
  visit(self.dropout_fraction, Key{"dropout_fraction", fraction, "share of samples that are missing"});
}
template <class Self, class Visitor>
void stuck_fields(Self& self, Visitor&& visit) {
  visit(self.from_s, Key{"from_s", any_time_s, "begin", true});
  visit(self.until_s, Key{"until_s", any_time_s, "end", true});
}
template <class Self, class Visitor>
void numerics_fields(Self& self, Visitor&& visit) {
  visit(self.numerics.method, Key{"method", {}, "cvode, arkode or automatic"});
  visit(self.numerics.relative_tolerance, Key{"relative_tolerance", {1e-13, 1e-2}, "of the integrator"});
  visit(self.restart_period_s, Key{"restart_period_s", {0.001, 1e6}, "checkpoints can be taken this often"});
}

// Keys of a signal end in the unit of its input.
Key key_for(const plant::InputInfo& input, const Key& key);

// Keys of `start:` are those of the states, with angles in degrees as everywhere in files.
std::string start_key(const plant::StateInfo& state);
plant::Range start_range(const plant::StateInfo& state);

}  // namespace sinew::sim

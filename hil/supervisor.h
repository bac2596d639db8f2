// SPDX-License-Identifier: Apache-2.0
// The host's supervisor: lowers the duty until the plant's prediction stays under the limit, and believes no sensor blindly.
//
// An invariance filter after Sabelhaus, Patterson, Wertz, Majidi, "Safe supervisory control of soft robot actuators" (Soft
// Robotics 2024): a duty may pass if, held over a horizon, it keeps every coil under the limit; zero duty always does, for
// coils cool without it, so whatever passes leaves a next step that is safe too. Here the prediction is that of the whole
// plant, begun where an observer is that runs beside the limb, and moved to what the thermocouples say.
//
// It knows nothing of the device's supervisor, and the device's nothing of this one.
#pragma once

#include <cstdint>
#include <deque>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "hil/limb_parts.h"
#include "plant/integrator.h"
#include "sim/signals.h"

namespace sinew::hil {

class HostSupervisor {
 public:
  // `period_s`: from one look at the limb to the next.
  HostSupervisor(const plant::Plant& limb, const plant::Start& start, double period_s);

  // The duty that may pass, at most the one that is wanted. One an input, here and below.
  std::vector<double> lower(const std::vector<double>& wanted, const sim::Measurement& measured);
  // The angles' own sums of ADC conversions, in the order of the wire: an end of the range, or far from the plant for long.
  void look_at_angles(const sim::Measurement& measured, std::span<const std::uint16_t> raw);
  // The device's bound of each coil's heat (heat_bound.h), as its telemetry says.
  void bound_said(std::span<const std::uint16_t> rise_cK);
  // What the device applied since, one period on.
  void applied(const std::vector<double>& duty_fraction);
  // The amplifiers' own words, in the order of the wire. Says why the session must end, once it must.
  void look(const sim::Measurement& measured, std::span<const std::uint32_t> raw);

  const std::optional<std::string>& objection() const { return objection_; }
  std::int64_t lowered() const { return lowered_; }                              // calls of lower that did
  const std::vector<double>& predicted_degC() const { return predicted_degC_; }  // of each coil, hottest over the horizon

 private:
  struct Watch {                // of one coil
    double correction_K = 0.0;  // measured less observed; up at once, down slowly
    std::deque<double> on_s;
    double on_sum_s = 0.0, off_for_s = 0.0, missing_s = 0.0;
    std::optional<double> last_degC;
    std::uint32_t bound_uK;  // what the device's bound is at the most
  };
  // What may be held until the next command can take its place, lest the device's bound trips it.
  double duty_within_bound(const Watch& coil) const;
  std::vector<double> hottest_degC(const std::vector<double>& duty) const;
  plant::Plant limb_;
  LimbParts parts_;
  double period_s_;
  plant::Integrator observer_;
  std::int64_t ticks_ = 0;
  std::vector<Watch> watch_;
  std::vector<double> angle_off_for_s_;
  std::vector<double> predicted_degC_;
  std::optional<std::string> objection_;
  std::int64_t lowered_ = 0;
};

}  // namespace sinew::hil

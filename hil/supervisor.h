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
#include <string>

#include "hil/message.h"
#include "plant/integrator.h"
#include "sim/signals.h"

namespace sinew::hil {

class HostSupervisor {
 public:
  HostSupervisor(const plant::Limb<double>& limb, const plant::Start& start, double period_s);

  // The duty that may pass, at most the one that is wanted.
  plant::PerCoil<double> lower(const plant::PerCoil<double>& wanted, const sim::Measurement& measured);
  // What the device applied since, one period on.
  void applied(const plant::PerCoil<double>& duty_fraction);
  // The amplifier's own words, and how old they are. Says why the session must end, once it must.
  void look(const sim::Measurement& measured, const std::array<std::uint32_t, 2>& raw);

  const std::optional<std::string>& objection() const { return objection_; }
  std::int64_t lowered() const { return lowered_; }  // commands
  plant::PerCoil<double> predicted_degC() const { return predicted_degC_; }  // hottest over the horizon

 private:
  plant::PerCoil<double> hottest_degC(const plant::PerCoil<double>& duty) const;
  plant::Limb<double> limb_;
  double period_s_;
  plant::Integrator observer_;
  std::int64_t ticks_ = 0;
  plant::PerCoil<double> correction_K_{};  // measured less observed; up at once, down slowly
  plant::PerCoil<std::deque<double>> on_s_;
  plant::PerCoil<double> on_sum_s_{}, predicted_degC_{}, off_for_s_{};
  plant::PerCoil<std::optional<double>> last_degC_;
  plant::PerCoil<double> missing_s_{};
  std::optional<std::string> objection_;
  std::int64_t lowered_ = 0;
};

}  // namespace sinew::hil

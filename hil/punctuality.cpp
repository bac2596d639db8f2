// SPDX-License-Identifier: Apache-2.0
#include "hil/punctuality.h"

#include <algorithm>
#include <vector>

#include "hil/serial_backend.h"
#include "hil/session.h"
#include "hil/supervisor.h"

namespace sinew::hil {

Punctuality measure_punctuality(Link& link, std::uint16_t session, std::int64_t period_us, double duration_s,
                                const std::function<bool()>& should_stop) {
  const plant::Plant limb = plant::default_plant();
  const LimbParts parts = parts_of(limb);
  Device device(link, session);
  const auto hello = device.hello(telemetry_period_ms(period_us));
  if (!hello) throw Refused("no answer to the hello");
  if (hello->parts.coils != parts.coils.size() || hello->parts.thermocouples != parts.thermocouples.size() ||
      hello->parts.angles != parts.angles.size())
    throw Refused("the board has other parts than the paper's limb, with which this is measured");
  SerialBackend backend(device, parts, period_us);
  const double period_s = static_cast<double>(period_us) / 1e6;
  HostSupervisor supervisor(limb, {}, period_s / static_cast<double>(backend.parts_of_period()));
  // As in a session, and for nothing: what it would allow is not sent.
  const std::vector<double> wanted(parts.coils.size(), 0.3), none(parts.coils.size(), 0.0);
  const auto work = [&](const sim::Measurement& measured) {
    if (const auto& t = device.telemetry()) supervisor.bound_said(t->said.bound_rise_cK);
    supervisor.applied(none);
    supervisor.lower(wanted, measured);
  };
  backend.before_repetition = [&](const sim::Measurement& now, sim::Command&) {
    work(now);
    return !should_stop();
  };
  const auto ticks = static_cast<std::int64_t>(duration_s / period_s);
  std::vector<std::int64_t> late_us;
  late_us.reserve(static_cast<std::size_t>(ticks));
  Punctuality result;
  sim::Measurement measured = backend.begin();
  for (std::int64_t tick = 0; tick < ticks && !should_stop(); ++tick) {
    result.without_telemetry += !backend.heard();
    work(measured);
    measured = backend.exchange({tick, none});
    late_us.push_back(backend.written_us() - backend.deadline_us(tick));
  }
  std::sort(late_us.begin(), late_us.end());
  if (late_us.empty()) return result;
  const auto share = [&](double part) {
    return late_us[std::min(late_us.size() - 1, static_cast<std::size_t>(part * static_cast<double>(late_us.size())))];
  };
  result.deadlines = static_cast<std::int64_t>(late_us.size());
  result.within_5_ms = std::upper_bound(late_us.begin(), late_us.end(), 5000) - late_us.begin();
  result.median_us = share(0.5);
  result.share_99_9_us = share(0.999);
  result.most_us = late_us.back();
  return result;
}

}  // namespace sinew::hil

// SPDX-License-Identifier: Apache-2.0
// A plant of one's own with the installed libraries: simulates it, records it, and finds its heat loss from the recording.
#include <cstdio>

#include "diagnose/calibrate.h"
#include "plant/integrator.h"
#include "plant/systems.h"
#include "sim/simulation.h"

namespace sinew::plant {
std::shared_ptr<const System> make_kettle(const Description& structure, const std::vector<OwnValues>& own);  // kettle.cpp
}

int main() {
  using namespace sinew;
  plant::Plant kettle(plant::make_kettle({}, {}));
  const plant::ParameterId loss = kettle.system().parameter("heat_loss_W_K");
  kettle.set_in_file_units(loss, 1.5);

  sim::Recording recording{.name = "kettle", .columns = sim::columns_of(kettle.system())};
  for (int k = 0; k <= 200; ++k) recording.samples.push_back({.time_s = 30.0 * k, .inputs = {k < 100 ? 200.0 : 0.0}, .channels = {0.0}});
  plant::Integrator integrator(kettle, plant::Start{}, {});
  const auto failure = sim::replay(integrator, kettle.system(), recording.samples, [&](std::size_t k) {
    recording.samples[k].channels = {diagnose::shown(kettle.system(), integrator.readings(), plant::ChannelId{0})};
  });
  if (failure) {
    std::fprintf(stderr, "%s\n", failure->reason.c_str());
    return 1;
  }
  std::printf("after %.0f s of 200 W: %.2f degC\n", recording.samples[100].time_s, recording.samples[100].channels[0]);

  const plant::Plant nominal(kettle.shared_system());
  diagnose::CalibrationSettings settings;
  settings.parameters = {loss};
  settings.start = diagnose::StartPolicy::at_rest;
  settings.starts = 1;
  const diagnose::PerChannel noise = diagnose::per_channel(kettle.system(), 0.1);
  const diagnose::Calibration fit = diagnose::calibrate(nominal, {{&recording, recording.samples.size(), noise}}, settings);
  std::printf("heat_loss_W_K: %.3f fitted, 1.500 simulated, %.3f believed before\n", fit.fitted.get_in_file_units(loss),
              nominal.get_in_file_units(loss));
  return 0;
}

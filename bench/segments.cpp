// SPDX-License-Identifier: Apache-2.0
// Time of a simulation against the number of segments in series, two coils each, with sensitivities of all that the core has and
// without. The equations grow as the segments, so a run should, too; with sensitivities, columns and rows both grow.
#include <sstream>

#include "bench/babbling.h"
#include "sim/plant_file.h"
#include "sim/random.h"

using namespace sinew;

namespace {

plant::Plant limb_of(int segments) {
  std::ostringstream yaml;
  yaml << "format: 2\nlimb:\n  segments:\n";
  for (int s = 0; s < segments; ++s) yaml << "    - {name: s" << s << ", axes: 1}\n";
  yaml << "  coils:\n";
  for (int s = 0; s < segments; ++s)
    yaml << "    - {name: A" << s << ", segment: s" << s << ", direction_deg: 0}\n    - {name: B" << s << ", segment: s" << s
         << ", direction_deg: 180}\n";
  yaml << "  channels:\n";
  for (int s = 0; s < segments; ++s)
    yaml << "    - {column: temperature_A" << s << "_degC, thermocouple: A" << s << "}\n    - {column: temperature_B" << s
         << "_degC, thermocouple: B" << s << "}\n    - {column: angle_s" << s << "_deg, bend: s" << s << "}\n";
  return sim::read_plant(sim::parse_yaml(yaml.str(), "limb.yaml"), ".");
}

// Each coil at a duty of its own, held for ten seconds; all change at once, so that a limb of more segments restarts no more often.
sim::Recording driven(const plant::Plant& limb, double duration_s) {
  sim::Recording recording{.name = "driven", .columns = sim::columns_of(limb.system())};
  const sim::RandomStream chance(7, "bench.segments");
  const std::size_t inputs = limb.system().inputs().size(), channels = limb.system().channels().size();
  for (std::size_t k = 0; 0.1 * static_cast<double>(k) <= duration_s; ++k) {
    sim::Sample sample{.time_s = 0.1 * static_cast<double>(k),
                       .inputs = std::vector<double>(inputs),
                       .channels = std::vector<double>(channels)};
    for (std::size_t i = 0; i < inputs; ++i) sample.inputs[i] = 0.3 * chance.uniform((k / 100) * inputs + i);
    recording.samples.push_back(sample);
  }
  return recording;
}

plant::SensitivityRequest all_of_core(const plant::Plant& limb) {
  plant::SensitivityRequest request;
  for (const plant::ParameterId p : limb.system().parameters().ids())
    if (!limb.system().parameters()[p].effect) request.parameters.push_back(p);
  return request;
}

}  // namespace

int main() {
  std::printf(
      "Ten minutes of held duty, two coils a segment, ARKODE at 1e-6; with sensitivities of 60 s to all parameters of the core.\n\n");
  std::printf("| segments | states | run [ms] | ms a segment | columns | 60 s with sensitivities [ms] | us a column and state |\n");
  std::printf("|---|---|---|---|---|---|---|\n");
  for (const int segments : {1, 2, 4, 8, 16}) {
    const plant::Plant limb = limb_of(segments);
    const sim::Recording long_one = driven(limb, 600.0), short_one = bench::first_part(long_one, 60.0);
    const plant::SensitivityRequest request = all_of_core(limb);
    const std::vector<double> least_s =
        bench::fastest_in_turn_s(3, {[&] {
                                       bench::replay(long_one, {plant::Method::arkode, 1e-6}, {}, limb);
                                     },
                                     [&] {
                                       bench::replay(short_one, {plant::Method::arkode, 1e-6}, request, limb);
                                     }});
    const double cells = static_cast<double>(request.columns() * limb.states().size());
    std::printf("| %d | %zu | %.1f | %.1f | %zu | %.1f | %.1f |\n", segments, limb.states().size(), 1e3 * least_s[0],
                1e3 * least_s[0] / segments, request.columns(), 1e3 * least_s[1], 1e6 * least_s[1] / cells);
  }
  std::printf("\nLeast of 3 repeats in turn; %s.\n", bench::conditions().c_str());
}

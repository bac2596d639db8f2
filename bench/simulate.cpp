// SPDX-License-Identifier: Apache-2.0
// Ten minutes of babbling on the core plant, replayed at a relative tolerance of 1e-6 on one core: how long, and how exact.
//
//   bench_simulate [--export FOLDER]     FOLDER: duty.csv, reference.csv and simulate.json for against_scipy.py
#include <cstring>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "bench/babbling.h"
#include "sim/text.h"

using namespace sinew;

namespace {

constexpr double duration_s = 600.0;
constexpr double goal_ms = 60.0;

std::string csv_of(const bench::Replay& run, const sim::Recording& recording) {
  std::string csv = "time_s,temperature_A_degC,temperature_B_degC,angle_deg\n";
  for (std::size_t k = 0; k < run.shown.size(); ++k) {
    sim::append_shortest(csv, recording.samples[k].time_s);
    for (const std::size_t j : bench::coils) sim::append_shortest(csv += ',', run.shown[k][j]);
    sim::append_shortest(csv += ',', run.shown[k][bench::angle_channel] / plant::radians_per_degree);
    csv += '\n';
  }
  return csv;
}

}  // namespace

int main(int argc, char** argv) {
  const bool exports = argc == 3 && std::strcmp(argv[1], "--export") == 0;
  if (argc != 1 && !exports) {
    std::fputs("usage: bench_simulate [--export FOLDER]\n", stderr);
    return 2;
  }
  const sim::Recording recording = bench::babbling(duration_s);
  const bench::Replay reference = bench::replay(recording, {plant::Method::cvode, 1e-12});

  std::printf("Ten minutes of babbling (seed 7, %zu samples), core plant, relative tolerance 1e-6; errors against CVODE at 1e-12.\n\n",
              recording.samples.size());
  std::printf(
      "| method | ms | times real time | goal | | angle error rms, max [deg] | temperature error rms, max [K] | steps | restarts |\n"
      "|---|---|---|---|---|---|---|---|---|\n");
  const std::vector<plant::Method> methods{plant::Method::cvode, plant::Method::arkode};
  std::vector<bench::Replay> runs(methods.size());
  std::vector<std::function<void()>> works;
  for (std::size_t m = 0; m < methods.size(); ++m) works.push_back([&, m] { runs[m] = bench::replay(recording, {methods[m], 1e-6}); });
  const std::vector<double> least_s = bench::fastest_in_turn_s(25, works);
  nlohmann::ordered_json json;
  for (std::size_t m = 0; m < methods.size(); ++m) {
    const bench::Errors e = bench::errors_of(runs[m], reference);
    const double ms = 1e3 * least_s[m];
    std::printf("| %s | %.1f | %.0f | at most %.0f ms | %s | %.1e, %.1e | %.1e, %.1e | %lld | %lld |\n", bench::name_of(methods[m]), ms,
                duration_s / least_s[m], goal_ms, bench::verdict(ms <= goal_ms), e.angle_rms_deg, e.angle_max_deg, e.temperature_rms_K,
                e.temperature_max_K, static_cast<long long>(runs[m].counters.steps), static_cast<long long>(runs[m].counters.restarts));
    json["methods"].push_back({{"name", bench::name_of(methods[m])},
                               {"relative_tolerance", 1e-6},
                               {"time_s", least_s[m]},
                               {"angle_rms_deg", e.angle_rms_deg},
                               {"angle_max_deg", e.angle_max_deg},
                               {"temperature_rms_K", e.temperature_rms_K},
                               {"temperature_max_K", e.temperature_max_K}});
  }
  std::printf("\nLeast of 25 repeats in turn; %s.\n", bench::conditions().c_str());
  if (!exports) return 0;

  const std::filesystem::path folder = argv[2];
  json["duration_s"] = duration_s;
  const plant::Plant limb = plant::default_plant();
  const auto& parameters = limb.system().parameters();
  for (const plant::ParameterId p : parameters.ids())
    if (!parameters[p].effect) json["parameters"][parameters[p].key()] = limb.get_in_file_units(p);
  const plant::Integrator at_start(limb, plant::Start{}, {});
  json["first_state"] = at_start.state();
  for (const plant::StateInfo& state : at_start.states()) json["scales"].push_back(state.scale);
  std::string duty = "time_s,duty_A,duty_B\n";
  for (const sim::Sample& sample : recording.samples) {
    sim::append_shortest(duty, sample.time_s);
    for (const double fraction : sample.inputs) sim::append_shortest(duty += ',', fraction);
    duty += '\n';
  }
  std::ofstream(folder / "duty.csv") << duty;
  for (std::size_t m = 0; m < methods.size(); ++m)
    std::ofstream(folder / (std::string(bench::name_of(methods[m])) + ".csv")) << csv_of(runs[m], recording);
  std::ofstream(folder / "reference.csv") << csv_of(reference, recording);
  std::ofstream(folder / "simulate.json") << json.dump(1) << '\n';
  return 0;
}

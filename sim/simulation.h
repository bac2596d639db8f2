// SPDX-License-Identifier: Apache-2.0
// The loop: a driver, a plant behind the seam, a recording. And the plant that is simulated.
#pragma once

#include <functional>
#include <optional>
#include <string>

#include "plant/integrator.h"
#include "sim/scenario.h"
#include "sim/signals.h"

namespace sinew::sim {

// The plant with its sensors. The truth is written down for people, and never passes the seam.
class SimulatedBackend : public Backend {
 public:
  explicit SimulatedBackend(const Scenario& scenario);
  Measurement begin() override;
  // After a failed integration every measurement is NaN and failure() says why.
  Measurement exchange(const Command& command) override;

  plant::Integrator& integrator() { return *integrator_; }
  const std::optional<plant::IntegrationFailure>& failure() const { return failure_; }
  std::vector<Sensor>& sensors() { return sensors_; }  // one a channel
  void resume(const plant::Checkpoint& from);

 private:
  Measurement measure(std::int64_t tick);
  const Scenario& scenario_;
  std::optional<plant::Integrator> integrator_;
  std::vector<Sensor> sensors_;
  std::optional<plant::IntegrationFailure> failure_;
};

// A run that stopped at a tick where the integrator restarts, with all that was written until then.
struct RunCheckpoint {
  std::int64_t tick = 0;
  Measurement measured;
  plant::Checkpoint plant;
  DriverState driver;
  std::vector<std::optional<double>> sensors;
  std::string recording_csv, truth_csv;
};
std::string to_json(const RunCheckpoint& checkpoint, const std::string& scenario_yaml);
// Throws InputError where the text is no checkpoint, or one of another scenario.
RunCheckpoint checkpoint_from_json(std::string_view text, const std::string& file, const std::string& scenario_yaml);

enum class RunStatus { finished, failed, stopped };

struct RunResult {
  RunStatus status = RunStatus::finished;
  std::string recording_csv, truth_csv;
  plant::SolverCounters counters;
  std::optional<plant::IntegrationFailure> failure;
  std::optional<RunCheckpoint> checkpoint;  // where it stopped
};

struct RunOptions {
  std::optional<RunCheckpoint> resume;
  std::function<bool()> should_stop;            // asked at every restart of the integrator
  std::function<void(double time_s)> progress;  // told at every restart
};

// Rows at every tick: what was measured, and the command given on it. A run that fails has NaN from there on.
RunResult run(const Scenario& scenario, const RunOptions& options = {});

// Commands the inputs of sample k, until the next: held, or going on to those of the next where the System says so.
void command_sample(plant::Integrator& integrator, const plant::System& system, const std::vector<Sample>& samples, std::size_t k);

// Replays a recording's inputs on a plant, in the recording's own times: advances to each sample, calls
// visit(index of the sample), then commands the sample's inputs. Time 0 of the plant is the first sample.
template <class Visitor>
[[nodiscard]] std::optional<plant::IntegrationFailure> replay(plant::Integrator& integrator, const plant::System& system,
                                                              const std::vector<Sample>& samples, Visitor&& visit) {
  for (std::size_t k = 0; k < samples.size(); ++k) {
    if (auto failure = integrator.advance_to(samples[k].time_s - samples.front().time_s)) return failure;
    visit(k);
    command_sample(integrator, system, samples, k);
  }
  return std::nullopt;
}

// The readings in the units of files.
std::vector<double> in_file_units(const plant::System& system, std::vector<double> readings);

}  // namespace sinew::sim

// SPDX-License-Identifier: Apache-2.0
// Many runs of one scenario, each on a plant, with sensors and with a session of its own: what a predictor is trained on so
// that it holds on a plant that it has not seen (domain randomisation, Tobin et al. 2017, arXiv:1703.06907).
//
//     format: 1
//     parameters:                           # of the plant, added to or set, drawn anew for each run
//       PARAMETER: { relative_deviation: 0.08 }           # normal around the scenario's value, cut at 2.5 deviations
//       PARAMETER: { lowest: 20, highest: 30 }            # uniform
//     effects:                              # on with a probability; what is not drawn is typical of the effect
//       EFFECT: { probability: 0.5, PARAMETER: { lowest: 0.3, highest: 2.0 } }
//     sensors:                              # by the short names of the channels; keys as in a scenario
//       CHANNEL: { noise_UNIT: { lowest: 0.05, highest: 0.3 }, dropout_fraction: { lowest: 0.0, highest: 0.01 } }
//     input:                                # of a babbling scenario
//       longest_hold_s: { lowest: 10, highest: 60 }
//
// scenarios/domain.yaml is one for the usual plant. A plain number is that number in every run. Of a sensor, stuck_from_s and
// stuck_until_s are as in a scenario.
// Run k has the seed (scenario's seed) * 1000003 + k and draws from streams of that seed, one a name: to add a line leaves the
// other draws as they were. Draws that make no scenario together are an InputError. A draw outside a parameter's range is drawn again.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "sim/scenario.h"
#include "sim/yaml.h"

namespace sinew::model {

struct Draw {
  std::optional<double> relative_deviation, deviation;  // normal around what the scenario says
  double lowest = 0.0, highest = 0.0;                   // else uniform
};

struct Domain {
  std::vector<std::pair<plant::ParameterId, Draw>> parameters{};  // of the core
  struct Effect {
    plant::EffectId effect;
    double probability = 1.0;
    std::vector<std::pair<plant::ParameterId, Draw>> parameters{};
  };
  std::vector<Effect> effects{};
  struct Sensor {
    plant::ChannelId channel;
    std::string key;  // "dropout_fraction"
    Draw draw;
  };
  std::vector<Sensor> sensors{};
  std::vector<std::pair<std::string, Draw>> input{};  // key of BabbleInput
};

// Throw InputError. The names are those of the System's lists.
Domain read_domain(const sim::YamlValue& value, const plant::System& system);
Domain read_domain(const std::filesystem::path& file, const plant::System& system);

// The scenario of run `run`, and what was drawn for it, by name, in the units of files. The domain is one of the scenario's System.
struct DrawnRun {
  sim::Scenario scenario;
  std::vector<std::pair<std::string, double>> drawn;
};
DrawnRun drawn_run(const sim::Scenario& scenario, const Domain& domain, std::int64_t run);

}  // namespace sinew::model

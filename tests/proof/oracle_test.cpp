// SPDX-License-Identifier: Apache-2.0
// The generator's own law, fitted to what the generator made.
#include "proof/oracle.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>

#include "tests/long_when_sanitized.h"

namespace oracle_test {

using namespace sinew;
using namespace sinew::proof;
using doctest::Approx;
using prove::Sample;
using prove::TruthEffect;

namespace {

constexpr double temperature_noise_K = 0.123, angle_noise_deg = 0.051;  // sensors' noise and steps, generator.cpp

// Both coils in turn, each long enough to transform.
std::vector<Sample> driven(double duration_s) {
  std::vector<Sample> samples;
  for (int k = 0; k * 0.1 < duration_s; ++k) {
    const double time_s = k * 0.1, phase_s = std::fmod(time_s, 30.0);
    samples.push_back({time_s, {phase_s < 8.0 ? 0.6 : 0.0, phase_s > 15.0 && phase_s < 22.0 ? 0.5 : 0.0}, {}, 0.0});
  }
  return samples;
}

TruthEffect latent_heat(double latent_heat_J) { return {"latent_heat", "", "thermal", {{"latent_heat_J", latent_heat_J}}, true, ""}; }

}  // namespace

TEST_CASE("oracle: on a recording without noise it finds the true values, from others" * long_when_sanitized) {
  // What the map does not name has its nominal value, in the recording as in the fit.
  const std::map<std::string, double> truth{{"ambient_temperature_degC", 23.1},
                                            {"heating_midpoint_degC", 77.0},
                                            {"heat_loss_A_W_K", 0.0415}},
      nominal{{"ambient_temperature_degC", 25.0}, {"heating_midpoint_degC", 75.0}, {"heat_loss_A_W_K", 0.040}};
  std::vector<Sample> recording = prove::simulate(truth, {latent_heat(10.0)}, driven(45.0));
  recording[100].angle_deg = std::nan("");
  // Sensors that are hardly wrong leave the prior nothing to say.
  const OracleFit fit = fit_oracle(nominal, {latent_heat(7.0)}, recording, {.noise = {1e-3, 1e-3, 1e-3}, .spread = {}, .should_stop = {}});
  CHECK(fit.converged);
  // Differences of 1e-3 of a unit, and the solver's tolerance of 1e-6 of the misfit.
  for (const auto& [name, value] : truth) CHECK(fit.core_parameters.at(name) == Approx(value).epsilon(1e-4));
  CHECK(fit.effects.at(0).parameters.at("latent_heat_J") == Approx(10.0).epsilon(1e-3));
}

TEST_CASE("oracle: on a concealed other form its held-out error is the sensors' noise, and without the law it is not" *
          long_when_sanitized) {
  const std::vector<prove::Kind> kinds = prove::kinds();
  const auto kind = std::ranges::find(kinds, "convection_nonlinearity.power", &prove::Kind::name);
  REQUIRE(kind != kinds.end());
  prove::Settings plain;
  plain.training_s = plain.heldout_s = 60.0;
  plain.disturbances.moving_air = false;
  const prove::Concealed concealed = prove::make(*kind, 101, plain);
  // Temperatures are fitted; the rest of the core is taken to be known, or the test would take a minute.
  const OracleSettings settings{.noise = {temperature_noise_K, temperature_noise_K, angle_noise_deg},
                                .spread = {.relative = 0.0},
                                .should_stop = {}};
  std::vector<TruthEffect> start = concealed.effects;
  for (auto& [name, value] : start[0].parameters) value *= 0.7;
  std::map<std::string, double> core = concealed.core_parameters;
  core["ambient_temperature_degC"] = 25.0;
  const OracleChannels with = open_loop_rmse(fit_oracle(core, start, concealed.training, settings), concealed.heldout),
                       without = open_loop_rmse(fit_oracle(core, {}, concealed.training, settings), concealed.heldout);
  // 601 samples: the noise's own root mean square is known to 3 % (one deviation), its steps to a little more.
  for (std::size_t c = 0; c < oracle_channels; ++c) CHECK(with[c] < 1.15 * settings.noise[c]);
  CHECK(without[0] > 3.0 * settings.noise[0]);
  CHECK(without[1] > 3.0 * settings.noise[1]);
}

TEST_CASE("oracle: a core parameter that is drawn elsewhere is not drawn to its nominal value, others are") {
  // Nothing is driven, so that nothing shows the stiffness: the prior alone speaks.
  std::vector<Sample> idle(30);
  for (std::size_t k = 0; k < idle.size(); ++k) idle[k] = {0.1 * static_cast<double>(k), {}, {25.0, 25.0}, 0.0};
  const OracleSettings settings{.noise = {0.1, 0.1, 0.1}, .spread = {}, .should_stop = {}};
  CHECK(fit_oracle({{"heating_width_K", 7.4}}, {}, idle, settings).core_parameters.at("heating_width_K") == Approx(7.0).epsilon(1e-3));
  CHECK(fit_oracle({{"heating_width_K", 9.0}}, {}, idle, settings).core_parameters.at("heating_width_K") == Approx(9.0).epsilon(1e-3));
}

TEST_CASE("oracle: stops when it should, and says so") {
  int asked = 0;
  const OracleFit fit = fit_oracle({{"heat_loss_A_W_K", 0.041}}, {}, driven(5.0),
                                   {.noise = {0.1, 0.1, 0.1}, .spread = {}, .should_stop = [&] { return ++asked > 1; }});
  CHECK(fit.stopped);
  CHECK_FALSE(fit.converged);
}

TEST_CASE("oracle: a channel that was never measured has no error") {
  std::vector<Sample> samples = driven(5.0);
  for (Sample& sample : samples) sample.temperature_degC[1] = std::nan("");
  const OracleChannels rmse = open_loop_rmse({{}, {}}, samples);
  CHECK(std::isnan(rmse[1]));
  CHECK_FALSE(std::isnan(rmse[0]));
}

}  // namespace oracle_test

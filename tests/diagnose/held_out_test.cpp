// SPDX-License-Identifier: Apache-2.0
#include "diagnose/held_out.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "tests/diagnose/one_limb.h"

namespace diagnose_held_out_test {

using namespace sinew;
using diagnose::Prediction;

namespace {

constexpr double duration_s = 120.0;

sim::Recording recording_every(double period_s) {
  sim::Recording recording;
  for (int k = 0; k * period_s <= duration_s; ++k) recording.samples.push_back({k * period_s, {0.0, 0.0}, {25.0, 25.0, 0.0}});
  return recording;
}

// The core is off by `before(t)` in every channel, the repaired plant by `after(t)`.
template <class Before, class After>
Prediction prediction_of(const sim::Recording& recording, Before&& before, After&& after) {
  Prediction prediction;
  prediction.recording = &recording;
  prediction.noise = diagnose::per_channel(testing::limb_system(), 0.5);
  for (diagnose::Series* series : {&prediction.measured, &prediction.nominal, &prediction.before, &prediction.after})
    *series = diagnose::Series(testing::limb_system().channels().size(), {});
  for (const sim::Sample& sample : recording.samples) {
    prediction.time_s.push_back(sample.time_s);
    prediction.held_out.push_back(true);
    for (const plant::ChannelId c : testing::limb_system().channels().ids()) {
      const double value = diagnose::measured(sample, c);
      prediction.measured[c].push_back(value);
      prediction.nominal[c].push_back(value + 3.0);
      prediction.before[c].push_back(value + before(sample.time_s));
      prediction.after[c].push_back(value + after(sample.time_s));
    }
  }
  return prediction;
}

}  // namespace

TEST_CASE("held out: correlation is of the same lags where a channel has every third row") {
  const auto wave = [](double time_s) { return std::cos(2.0 * std::numbers::pi * time_s / 2.0); };
  sim::Recording recording = recording_every(0.03);
  auto prediction = prediction_of(recording, wave, [](double) { return 1.0; });
  for (std::size_t k = 0; k < recording.samples.size(); ++k)
    if (k % 3 != 0) recording.samples[k].channels[0] = prediction.measured[testing::temperature_A][k] = std::nan("");
  const auto correlation = diagnose::correlation_of({prediction});
  CHECK(correlation.before[testing::temperature_A].at(2) == doctest::Approx(-1.0).epsilon(0.05));
  CHECK(correlation.before[testing::temperature_A].at(4) == doctest::Approx(1.0).epsilon(0.05));
  CHECK(correlation.before[testing::angle].at(2) == doctest::Approx(-1.0).epsilon(0.05));
}

TEST_CASE("held out: correlation is of the same lags whatever the sampling rate") {
  const auto wave = [](double time_s) { return std::cos(2.0 * std::numbers::pi * time_s / 2.0); };
  for (const double period_s : {0.1, 0.05, 0.02}) {
    CAPTURE(period_s);
    const sim::Recording recording = recording_every(period_s);
    const auto correlation = diagnose::correlation_of({prediction_of(recording, wave, [](double) { return 1.0; })});
    CHECK(correlation.before[testing::temperature_A].at(1) == doctest::Approx(0.0).epsilon(0.02));
    CHECK(correlation.before[testing::angle].at(2) == doctest::Approx(-1.0).epsilon(0.03));
    CHECK(correlation.before[testing::angle].at(4) == doctest::Approx(1.0).epsilon(0.03));
    CHECK(correlation.after[testing::temperature_B].at(4) == doctest::Approx(1.0).epsilon(0.03));
  }
}

TEST_CASE("held out: errors and gains by hand") {
  const sim::Recording recording = recording_every(0.1);
  Prediction prediction = prediction_of(
      recording, [](double) { return 2.0; }, [](double) { return -1.0; });
  for (std::size_t k = 0; k < 300; ++k) prediction.held_out[k] = false;
  prediction.after[testing::temperature_A][200] = 1e6;  // not held out
  prediction.measured[testing::temperature_B].assign(prediction.measured[testing::temperature_B].size(), std::nan(""));
  const diagnose::HeldOutError error = diagnose::error_of({prediction}, 1);
  CHECK(error.nominal[testing::temperature_A] == doctest::Approx(3.0));
  CHECK(error.before[testing::temperature_A] == doctest::Approx(2.0));
  CHECK(error.after[testing::temperature_A] == doctest::Approx(1.0));
  CHECK(error.noise[testing::temperature_A] == doctest::Approx(0.5));
  CHECK(error.gain[testing::temperature_A] == doctest::Approx(0.5));
  CHECK(error.gain_lowest[testing::temperature_A] == doctest::Approx(0.5));
  CHECK(error.gain_highest[testing::temperature_A] == doctest::Approx(0.5));
  CHECK(error.samples[testing::temperature_A] == recording.samples.size() - 300);
  CHECK(error.samples[testing::temperature_B] == 0);
  CHECK(std::isnan(error.gain[testing::temperature_B]));
  // Two channels, each (4 - 1) squares a sample over 0.25.
  CHECK(error.lowest_total_gain == doctest::Approx(2.0 * 12.0 * static_cast<double>(error.samples[testing::temperature_A])).epsilon(0.15));
  CHECK(error.lowest_total_gain <= error.highest_total_gain);
}

TEST_CASE("held out: before is the nearer of two fits, channel by channel, and a gain stands against that") {
  const sim::Recording recording = recording_every(0.1);
  std::vector<Prediction> predictions{prediction_of(
      recording, [](double) { return 2.0; }, [](double) { return 1.0; })};
  Prediction& one = predictions.front();
  one.fitted = one.calibrated = one.before;
  for (double& value : one.calibrated[testing::angle]) value -= 0.8;          // 1.2 off: nearer than the diagnosis' own fit
  for (double& value : one.calibrated[testing::temperature_A]) value += 1.0;  // 3 off
  one.calibrated[testing::temperature_B].back() = std::nan("");               // cannot follow
  diagnose::choose_before(predictions);
  const diagnose::HeldOutError error = diagnose::error_of(predictions, 1);
  CHECK(error.fitted[testing::angle] == doctest::Approx(2.0));
  CHECK(error.calibrated[testing::angle] == doctest::Approx(1.2));
  CHECK(error.before[testing::angle] == doctest::Approx(1.2));
  CHECK(error.gain[testing::angle] == doctest::Approx(1.0 - 1.0 / 1.2));
  CHECK(error.gain_highest[testing::angle] == doctest::Approx(1.0 - 1.0 / 1.2));
  CHECK(error.calibrated[testing::temperature_A] == doctest::Approx(3.0));
  CHECK(error.before[testing::temperature_A] == doctest::Approx(2.0));
  CHECK(error.gain[testing::temperature_A] == doctest::Approx(0.5));
  CHECK(std::isnan(error.calibrated[testing::temperature_B]));
  CHECK(error.before[testing::temperature_B] == doctest::Approx(2.0));
}

TEST_CASE("held out: what one stretch gains and another loses is not beyond chance") {
  const sim::Recording recording = recording_every(0.1);
  const auto error =
      diagnose::error_of({prediction_of(
                             recording, [](double) { return 1.0; }, [](double time_s) { return time_s < 0.5 * duration_s ? 0.5 : 1.2; })},
                         1);
  CHECK(error.lowest_total_gain < 0.0);
  CHECK(error.highest_total_gain > 0.0);
}

TEST_CASE("held out: a plant that cannot follow has no error that is a number") {
  const sim::Recording recording = recording_every(0.1);
  const auto error =
      diagnose::error_of({prediction_of(
                             recording, [](double) { return 1.0; }, [](double time_s) { return time_s < 60.0 ? 0.5 : std::nan(""); })},
                         1);
  CHECK(error.before[testing::angle] == doctest::Approx(1.0));
  CHECK(std::isnan(error.after[testing::angle]));
  CHECK(error.highest_total_gain < 0.0);
}

TEST_CASE("held out: too little of it says nothing about chance") {
  sim::Recording recording = recording_every(0.1);
  recording.samples.resize(90);
  const auto error = diagnose::error_of({prediction_of(
                                            recording, [](double) { return 1.0; }, [](double) { return 2.0; })},
                                        1);
  CHECK(error.after[testing::temperature_A] == doctest::Approx(2.0));
  CHECK(error.highest_total_gain > 0.0);
  CHECK(error.lowest_total_gain < 0.0);
}

TEST_CASE("held out: two blocks, with a guard around them that is in neither part") {
  const diagnose::Split split = diagnose::split(recording_every(0.1), 1e300, true);
  const auto is_masked = [&](double time_s) {
    return std::isnan(split.fitted.samples[static_cast<std::size_t>(std::lround(time_s / 0.1))].channels[2]);
  };
  const auto is_held_out = [&](double time_s) { return bool{split.held_out[static_cast<std::size_t>(std::lround(time_s / 0.1))]}; };
  CHECK(split.sample_count == split.held_out.size());
  CHECK_FALSE(is_masked(42.0));
  CHECK(is_masked(45.0));
  CHECK_FALSE(is_held_out(45.0));
  CHECK(is_masked(54.0));
  CHECK(is_held_out(54.0));
  CHECK(is_masked(63.0));
  CHECK_FALSE(is_held_out(63.0));
  CHECK_FALSE(is_masked(70.0));
  CHECK(is_held_out(119.0));
  CHECK(diagnose::split(recording_every(0.1), 50.0, true).sample_count == 500);
  // Of four seconds a guard of five would take all.
  sim::Recording brief = recording_every(0.1);
  brief.samples.resize(41);
  const diagnose::Split most = diagnose::split(brief, 1e300, true);
  CHECK(std::count_if(most.fitted.samples.begin(), most.fitted.samples.end(),
                      [](const sim::Sample& sample) { return !std::isnan(sample.channels[2]); }) > 20);
  const diagnose::Split whole = diagnose::split(recording_every(0.1), 1e300, false);
  CHECK(std::count(whole.held_out.begin(), whole.held_out.end(), true) == 0);
}

TEST_CASE("held out: which inputs a recording drives that training leaves alone") {
  const auto driving = [](std::size_t input) {
    sim::Recording recording = recording_every(0.1);
    for (sim::Sample& sample : recording.samples)
      if (sample.time_s > 50.0 && sample.time_s < 60.0) sample.inputs[input] = 0.3;
    return recording;
  };
  const sim::Recording first = driving(0), second = driving(1);
  std::vector<diagnose::FitData> training = testing::data_of(first);
  const auto more = [&](const sim::Recording& recording) { return diagnose::driven_more(testing::limb_system(), recording, training); };
  CHECK(more(first).empty());
  CHECK(more(recording_every(0.1)).empty());
  CHECK(more(second) == std::vector{plant::InputId{1}});
  sim::Recording held = first;  // at another value, all along
  for (sim::Sample& sample : held.samples) sample.inputs[1] = 0.2;
  CHECK(more(held) == std::vector{plant::InputId{1}});
  training.push_back(testing::data_of(second).front());
  CHECK(more(second).empty());
  training[1].sample_count = 400;  // driven in what is not fitted
  CHECK(more(second) == std::vector{plant::InputId{1}});
}

}  // namespace diagnose_held_out_test

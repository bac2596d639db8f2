// SPDX-License-Identifier: Apache-2.0
#include "diagnose/thinned.h"

#include <doctest/doctest.h>

#include <cmath>

#include "diagnose/open_loop.h"
#include "tests/diagnose/one_limb.h"

namespace diagnose_thinned_test {

using namespace sinew;

namespace {

constexpr std::size_t samples_per_average = 5;  // a limb's averaging time is half a second, ten samples a second are recorded

// Of the first 20 s of half a minute.
struct Recorded {
  sim::Recording recording = testing::recorded(testing::babbling(30.0));
  std::vector<diagnose::FitData> data{{&recording, 201, testing::paper_noise}};
  diagnose::Thinned few = diagnose::thinned(testing::limb_system(), data);
  const std::vector<sim::Sample>& samples() const { return few.data[0].recording->samples; }
};

const sim::Sample& at_time(const std::vector<sim::Sample>& samples, double time_s) {
  for (const sim::Sample& sample : samples)
    if (sample.time_s == time_s) return sample;
  throw std::out_of_range("no sample at this time");
}

}  // namespace

TEST_CASE("thinned: one sample an averaging time has its readings, and none lies after what is fitted") {
  const Recorded limb;
  for (const std::size_t every : limb.few.every.at(0)) CHECK(every == samples_per_average);
  CHECK(limb.samples().size() == limb.few.data[0].sample_count);
  CHECK(limb.samples().size() < 2 * 201 / 3);
  CHECK(limb.samples().back().time_s == limb.recording.samples[200].time_s);
  std::size_t shown = 0;
  for (const sim::Sample& sample : limb.samples()) {
    if (std::isnan(sample.channels[0])) continue;
    CHECK(sample.channels == limb.recording.samples[shown * samples_per_average].channels);
    ++shown;
  }
  CHECK(shown == 200 / samples_per_average + 1);
}

TEST_CASE("thinned: a plant follows the same inputs") {
  const Recorded limb;
  const auto along = [](const sim::Recording& recording) {
    return diagnose::predict(plant::default_plant(), {}, recording, {plant::Method::rosenbrock, 1e-8});
  };
  const diagnose::Series whole = along(limb.recording), few = along(*limb.few.data[0].recording);
  for (std::size_t k = 0; k < limb.samples().size(); ++k) {
    std::size_t same = 0;
    while (limb.recording.samples[same].time_s != limb.samples()[k].time_s) ++same;
    for (const plant::ChannelId c : whole.ids()) CHECK(few[c][k] == doctest::Approx(whole[c][same]).epsilon(1e-6));
  }
}

TEST_CASE("thinned: every change of an input is kept, without readings where it lies between") {
  Recorded limb;
  const double moved_s = limb.recording.samples[102].time_s;
  for (std::size_t k = 102; k < limb.recording.samples.size(); ++k) limb.recording.samples[k].inputs[0] = 0.123;
  limb.few = diagnose::thinned(testing::limb_system(), limb.data);
  const sim::Sample& moved = at_time(limb.samples(), moved_s);
  CHECK(moved.inputs[0] == 0.123);
  CHECK(std::isnan(moved.channels[0]));
  CHECK(at_time(limb.samples(), limb.recording.samples[101].time_s).inputs == limb.recording.samples[101].inputs);
}

TEST_CASE("thinned: where each reading has a row of its own, as many of each channel are kept") {
  Recorded limb;
  sim::Recording apart = limb.recording;
  apart.samples.clear();
  for (std::size_t k = 0; k <= 200; ++k)
    for (std::size_t c = 0; c < 3; ++c) {
      const sim::Sample& sample = limb.recording.samples[k];
      apart.samples.push_back({sample.time_s + 0.01 * static_cast<double>(c), sample.inputs, std::vector<double>(3, std::nan(""))});
      apart.samples.back().channels[c] = sample.channels[c];
    }
  const diagnose::Thinned few = diagnose::thinned(testing::limb_system(), {{&apart, apart.samples.size(), testing::paper_noise}});
  for (const plant::ChannelId c : few.every.at(0).ids()) {
    CHECK(few.every[0][c] == samples_per_average);
    CHECK(diagnose::measured_rows(*few.data[0].recording, c).rows.size() == 200 / samples_per_average + 1);
  }
}

TEST_CASE("thinned: a recording of no more than one sample an averaging time stays as it is") {
  Recorded limb;
  std::vector<sim::Sample> slow;
  for (std::size_t k = 0; k < limb.recording.samples.size(); k += 2 * samples_per_average) slow.push_back(limb.recording.samples[k]);
  limb.recording.samples = slow;
  limb.data[0].sample_count = slow.size();
  limb.few = diagnose::thinned(testing::limb_system(), limb.data);
  for (const std::size_t every : limb.few.every.at(0)) CHECK(every == 1);
  REQUIRE(limb.samples().size() == slow.size());
  for (std::size_t k = 0; k < slow.size(); ++k) CHECK(limb.samples()[k].channels == slow[k].channels);
}

}  // namespace diagnose_thinned_test

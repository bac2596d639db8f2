// SPDX-License-Identifier: Apache-2.0
#include "diagnose/suitability.h"

#include <doctest/doctest.h>

#include "sim/text.h"
#include "tests/diagnose/one_limb.h"

namespace diagnose_suitability_test {

using namespace sinew;

namespace {

std::vector<std::string> shortcomings_of(const sim::Recording& recording) {
  return diagnose::shortcomings(testing::limb_system(), recording, testing::paper_noise);
}

// Both coils in turn; every channel moves.
sim::Recording rich() {
  sim::Recording recording{.name = "rich"};
  for (int k = 0; k < 1200; ++k) {
    const double t = 0.1 * k, wobble = 0.1 * std::sin(37.0 * k);
    recording.samples.push_back(
        {t,
         {(k / 100) % 2 ? 0.4 : 0.0, (k / 150) % 2 ? 0.3 : 0.0},
         {60.0 + 30.0 * std::sin(0.3 * t) + wobble, 60.0 + 30.0 * std::sin(0.21 * t) + wobble, 20.0 * std::sin(0.25 * t) + wobble}});
  }
  return recording;
}

}  // namespace

TEST_CASE("suitability: of a rich recording nothing is said") { CHECK(shortcomings_of(rich()).empty()); }

TEST_CASE("suitability: too short, nothing driven, one coil alone, coils always equal") {
  sim::Recording recording = rich();
  recording.samples.resize(301);
  CHECK(shortcomings_of(recording) ==
        std::vector<std::string>{"it lasts 30 s, and says little of anything slow: at least 60 s are needed, ten minutes are better"});
  recording = rich();
  for (auto& sample : recording.samples) sample.inputs[1] = 0.0;
  CHECK(shortcomings_of(recording) == std::vector<std::string>{"duty B never changes: what belongs there cannot be learnt"});
  for (auto& sample : recording.samples) sample.inputs[0] = 0.25;
  CHECK(shortcomings_of(recording) ==
        std::vector<std::string>{"no input ever changes: what the plant does when it is driven cannot be learnt"});
  recording = rich();
  for (auto& sample : recording.samples) sample.inputs[1] = sample.inputs[0];
  CHECK(shortcomings_of(recording) == std::vector<std::string>{"duty A and duty B are always equal: what each does alone cannot be told"});
}

TEST_CASE("suitability: a channel that is never measured, that stays at one value, that moves within its noise") {
  sim::Recording recording = rich();
  for (auto& sample : recording.samples) sample.channels[2] = sim::not_a_number;
  CHECK(shortcomings_of(recording) == std::vector<std::string>{"angle is never measured"});
  for (auto& sample : recording.samples) sample.channels[2] = 7.5;
  CHECK(shortcomings_of(recording) ==
        std::vector<std::string>{
            "angle stays at 7.5° all along while it is driven: its sensor is stuck or not connected, or what it measures is held fast"});
  for (std::size_t k = 0; k < recording.samples.size(); ++k) recording.samples[k].channels[2] = 7.5 + 0.1 * static_cast<double>(k % 3);
  CHECK(shortcomings_of(recording) == std::vector<std::string>{"angle never moves by more than its noise: nothing can be learnt from it"});
}

TEST_CASE("suitability: a reading that stands still in a rise and leaps to make up for it is suspected; the rise itself is not") {
  sim::Recording recording = rich();
  CHECK(diagnose::suspected_misreadings(testing::limb_system(), recording, testing::paper_noise).empty());
  // Temperature A rises by 0.6 to 0.9 K a row from 19 s to 23 s. Twelve rows at the value of the first.
  for (std::size_t k = 200; k < 212; ++k) recording.samples[k].channels[0] = recording.samples[200].channels[0];
  const auto found = diagnose::suspected_misreadings(testing::limb_system(), recording, testing::paper_noise);
  REQUIRE(found.size() == 1);
  CHECK(found[0].channel == testing::temperature_A);
  CHECK(found[0].from_s >= 19.7);
  CHECK(found[0].from_s <= 20.1);
  CHECK(found[0].until_s >= 21.2);
  CHECK(found[0].until_s <= 21.4);
  CHECK(found[0].leap > 6.0);
}

TEST_CASE("suitability: rest, a step of the duty and a slow converter are no misreadings") {
  sim::Recording recording = rich();
  for (std::size_t k = 0; k < recording.samples.size(); ++k) {
    const double t = 0.1 * static_cast<double>(k - k % 5);  // a new reading every 0.5 s
    recording.samples[k].channels = {60.0 + 30.0 * std::sin(0.3 * t), k < 600 ? 22.0 : 22.0 + 3.0 * static_cast<double>(k - 600) / 10.0,
                                     0.0};
  }
  CHECK(diagnose::suspected_misreadings(testing::limb_system(), recording, testing::paper_noise).empty());
}

}  // namespace diagnose_suitability_test

// SPDX-License-Identifier: Apache-2.0
#include "diagnose/gate.h"

#include <doctest/doctest.h>

#include "tests/diagnose/one_limb.h"

namespace diagnose_gate_test {

using namespace sinew;

namespace {

// A wire that warms by 13 K/s for three seconds and cools: the steepest motion that the paper's limb makes.
sim::Recording steep() {
  sim::Recording recording{.name = "steep"};
  for (int k = 0; k < 400; ++k) {
    const double time_s = 0.1 * k, warm = std::clamp(13.0 * (time_s - 10.0), 0.0, 39.0);
    const double temperature = 25.0 + (time_s < 13.0 ? warm : 39.0 * std::exp(-(time_s - 13.0) / 21.0));
    const double wobble = 0.1 * std::sin(37.0 * k);
    recording.samples.push_back(
        {time_s, {time_s >= 10.0 && time_s < 13.0 ? 0.6 : 0.0, 0.0}, {temperature + wobble, 25.0 + wobble, wobble}});
  }
  return recording;
}

using Counts = plant::ListOf<plant::ChannelId, std::size_t>;
Counts counts(std::size_t first, std::size_t second, std::size_t third) { return Counts(std::vector<std::size_t>{first, second, third}); }

}  // namespace

TEST_CASE("gate: a steep edge is no outlier, a gross error on it is") {
  sim::Recording recording = steep();
  diagnose::GateNotes notes;
  CHECK(diagnose::gated(testing::limb_system(), recording, nullptr, notes).samples[115].channels[0] == recording.samples[115].channels[0]);
  CHECK(notes.outliers == counts(0, 0, 0));
  recording.samples[115].channels[0] += 15.0;
  recording.samples[300].channels[2] -= 9.0;
  recording.samples[0].channels[1] -= 19.0;  // the first sample too, which has neighbours on one side alone
  diagnose::GateNotes again;
  const sim::Recording clean = diagnose::gated(testing::limb_system(), recording, nullptr, again);
  CHECK(std::isnan(clean.samples[115].channels[0]));
  CHECK(std::isnan(clean.samples[300].channels[2]));
  CHECK(std::isnan(clean.samples[0].channels[1]));
  CHECK(again.outliers == counts(1, 1, 1));
}

TEST_CASE(
    "gate: where the limb swings, an error less than what its neighbours span is one; a turn, a kick and a jump are "
    "none") {
  sim::Recording recording{.name = "swing"};
  for (int k = 0; k < 270; ++k) {
    const double time_s = 0.1 * k, wobble = 0.05 * std::sin(37.0 * k);
    double angle = 30.0 * std::cos(0.7 * time_s);        // 21 deg/s where it passes the middle; at rest at both ends
    if (k >= 135) angle += 12.0;                         // jumps where it turns
    if (k >= 200) angle += 2.5 * std::min(k - 200, 20);  // is kicked, and stopped
    recording.samples.push_back({time_s, {0.3, 0.0}, {25.0 + wobble, 25.0 - wobble, angle + wobble}});
  }
  diagnose::GateNotes notes;
  CHECK(std::isfinite(diagnose::gated(testing::limb_system(), recording, nullptr, notes).samples[112].channels[2]));
  CHECK(notes.outliers == counts(0, 0, 0));
  recording.samples[112].channels[2] += 8.0;  // the six around it span 12 deg
  diagnose::GateNotes again;
  CHECK(std::isnan(diagnose::gated(testing::limb_system(), recording, nullptr, again).samples[112].channels[2]));
  CHECK(again.outliers == counts(0, 0, 1));
  // Beside readings that are missing, what is left is no outlier.
  for (const std::size_t k : {112u, 113u, 116u, 225u, 226u, 227u}) recording.samples[k].channels[2] = std::nan("");
  diagnose::GateNotes gaps;
  static_cast<void>(diagnose::gated(testing::limb_system(), recording, nullptr, gaps));
  CHECK(gaps.outliers == counts(0, 0, 0));
}

TEST_CASE("gate: an outlier is found, and no gap said, where each reading has a row of its own") {
  sim::Recording recording = steep();
  recording.samples[115].channels[0] += 15.0;
  recording.samples[300].channels[2] -= 9.0;
  sim::Recording apart = recording;
  apart.samples.clear();
  for (const sim::Sample& sample : recording.samples)
    for (std::size_t c = 0; c < 3; ++c) {
      apart.samples.push_back({sample.time_s + 0.01 * static_cast<double>(c), sample.inputs, std::vector<double>(3, std::nan(""))});
      apart.samples.back().channels[c] = sample.channels[c];
    }
  diagnose::GateNotes notes;
  const sim::Recording clean = diagnose::gated(testing::limb_system(), apart, nullptr, notes);
  CHECK(notes.outliers == counts(1, 0, 1));
  CHECK(std::isnan(clean.samples[3 * 115].channels[0]));
  CHECK(std::isnan(clean.samples[3 * 300 + 2].channels[2]));
  CHECK(notes.warnings.empty());
}

TEST_CASE("gate: of three outliers within a few samples the one between the others is found, too") {
  sim::Recording recording = steep();
  recording.samples[200].channels[0] -= 14.0;
  recording.samples[203].channels[0] += 13.0;  // its neighbours span 18 K
  recording.samples[205].channels[0] -= 18.0;
  diagnose::GateNotes notes;
  const sim::Recording clean = diagnose::gated(testing::limb_system(), recording, nullptr, notes);
  for (const std::size_t k : {200u, 203u, 205u}) CHECK(std::isnan(clean.samples[k].channels[0]));
  CHECK(notes.outliers == counts(3, 0, 0));
}

TEST_CASE("gate: missing samples are counted, and a recording in which nothing is driven is said to be of little use") {
  sim::Recording recording = steep();
  for (auto& sample : recording.samples) sample.inputs = {0.0, 0.0};
  recording.samples[7].channels[2] = std::nan("");
  diagnose::GateNotes notes;
  static_cast<void>(diagnose::gated(testing::limb_system(), recording, nullptr, notes));
  CHECK(notes.missing[testing::angle] == 1);
  REQUIRE(notes.warnings.size() == 1);
  CHECK(notes.warnings[0] == "nothing is ever driven: little can be learnt from this recording");
}

// Ten seconds on, ten off, from 10 s on; all channels move but those that a test holds.
sim::Recording pulsed() {
  sim::Recording recording{.name = "pulsed"};
  for (int k = 0; k < 900; ++k) {
    const double duty = k >= 100 && (k / 100) % 2 == 1 ? 0.4 : 0.0, wobble = 0.1 * std::sin(37.0 * k);
    recording.samples.push_back({0.1 * k, {duty, 0.5 * duty}, {40.0 + 20.0 * std::sin(0.03 * k) + wobble, 30.0 + wobble, 5.0 + wobble}});
  }
  return recording;
}

TEST_CASE("gate: a bend sensor that shows one value while coils are driven is named, with its value and its time") {
  sim::Recording recording = pulsed();
  for (auto& sample : recording.samples) sample.channels[2] = 5.0;
  diagnose::GateNotes notes;
  static_cast<void>(diagnose::gated(testing::limb_system(), recording, nullptr, notes));
  REQUIRE(notes.unresponsive.size() == 1);
  CHECK(notes.unresponsive[0].channel == testing::angle);
  CHECK(notes.unresponsive[0].value == 5.0);
  CHECK(notes.unresponsive[0].throughout);
  CHECK(notes.unresponsive[0].words ==
        "angle stays at 5° all along while it is driven: its sensor is stuck or not connected, or what it measures is held fast");
  // From 30 s to 70 s: 20 s of 90 s driven in it.
  recording = pulsed();
  for (std::size_t k = 300; k <= 700; ++k) recording.samples[k].channels[0] = 47.25;
  diagnose::GateNotes part;
  static_cast<void>(diagnose::gated(testing::limb_system(), recording, nullptr, part));
  REQUIRE(part.unresponsive.size() == 1);
  CHECK(part.unresponsive[0].channel == testing::temperature_A);
  CHECK(part.unresponsive[0].from_s == 30.0);
  CHECK(part.unresponsive[0].until_s == 70.0);
  CHECK_FALSE(part.unresponsive[0].throughout);
}

TEST_CASE("gate: one value while nothing is driven, or while the drive stays what it was, is no sign of a stuck sensor") {
  sim::Recording rest = pulsed();
  for (std::size_t k = 0; k < 900; ++k) {
    rest.samples[k].inputs = {k >= 600 ? 0.4 : 0.0, 0.0};        // rests for a minute, ...
    if (k <= 601) rest.samples[k].channels = {22.0, 22.0, 0.0};  // in which nothing moves, nor at once when it is driven
  }
  diagnose::GateNotes notes;
  static_cast<void>(diagnose::gated(testing::limb_system(), rest, nullptr, notes));
  CHECK(notes.unresponsive.empty());
  sim::Recording steady = pulsed();
  for (std::size_t k = 0; k < 900; ++k) {
    steady.samples[k].inputs = {0.3, 0.3};
    if (k > 300) steady.samples[k].channels = {80.0, 80.0, 10.0};  // has settled
  }
  diagnose::GateNotes settled;
  static_cast<void>(diagnose::gated(testing::limb_system(), steady, nullptr, settled));
  CHECK(settled.unresponsive.empty());
}

TEST_CASE("gate: a pause is told from a gap, and its times are given") {
  sim::Recording recording = pulsed();
  recording.samples.erase(recording.samples.begin() + 500, recording.samples.begin() + 504);  // 0.5 s: held over
  recording.samples.erase(recording.samples.begin() + 200, recording.samples.begin() + 400);
  diagnose::GateNotes notes;
  static_cast<void>(diagnose::gated(testing::limb_system(), recording, nullptr, notes));
  REQUIRE(notes.pauses_s.size() == 1);
  CHECK(notes.pauses_s[0].first == doctest::Approx(19.9));
  CHECK(notes.pauses_s[0].second == doctest::Approx(40.0));
  CHECK(notes.longest_gap_s == doctest::Approx(0.5));
}

}  // namespace diagnose_gate_test

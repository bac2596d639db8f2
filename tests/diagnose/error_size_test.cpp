// SPDX-License-Identifier: Apache-2.0
#include "diagnose/error_size.h"

#include <doctest/doctest.h>

#include <cmath>

#include "tests/diagnose/one_limb.h"

namespace diagnose_error_size_test {

using namespace sinew;
using testing::angle, testing::temperature_A, testing::temperature_B;

namespace {

constexpr double samples = 400.0;

struct Recorded {
  sim::Recording recording = testing::recorded(testing::babbling(40.0));
  std::vector<diagnose::FitData> data = testing::data_of(recording);
  diagnose::PerChannel scale = diagnose::scale_of(testing::limb_system(), data);
  diagnose::PerChannel independent = diagnose::per_channel(testing::limb_system(), 1.0);

  // Where each channel is off by so much, root mean square.
  diagnose::ErrorSize size_of(const diagnose::PerChannel& off, double alike = 1.0) const {
    diagnose::SquaredErrors errors{{off}, {diagnose::per_channel(testing::limb_system(), samples)}};
    for (double& one : errors.sum[0]) one *= one * samples;
    return diagnose::error_size(errors, data, scale, {diagnose::per_channel(testing::limb_system(), alike)});
  }
};

}  // namespace

TEST_CASE("error size: a share is of how far the widest channel of a unit moves") {
  const Recorded limb;
  CHECK(limb.scale[temperature_A] == limb.scale[temperature_B]);
  double sum = 0.0, squares = 0.0;
  for (const sim::Sample& sample : limb.recording.samples) {
    sum += sample.channels[angle.index];
    squares += sample.channels[angle.index] * sample.channels[angle.index];
  }
  const double count = static_cast<double>(limb.recording.samples.size());
  CHECK(limb.scale[angle] == doctest::Approx(std::sqrt(squares / count - std::pow(sum / count, 2))));
}

TEST_CASE("error size: what is off by its sensors' noise has no other error") {
  const Recorded limb;
  const diagnose::ErrorSize size = limb.size_of(testing::paper_noise);
  CHECK(size.share < 1e-3);
  for (const plant::ChannelId c : limb.scale.ids()) CHECK(size.deviation[0][c] == doctest::Approx(testing::paper_noise[c]).epsilon(0.05));
}

TEST_CASE("error size: the share that all channels are off by is found, beside their noise") {
  const Recorded limb;
  diagnose::PerChannel off = limb.scale;
  for (const plant::ChannelId c : off.ids()) off[c] = std::hypot(0.07 * limb.scale[c], testing::paper_noise[c]);
  const diagnose::ErrorSize size = limb.size_of(off);
  CHECK(size.share == doctest::Approx(0.07).epsilon(0.01));
  for (const plant::ChannelId c : off.ids()) CHECK(size.deviation[0][c] == doctest::Approx(off[c]).epsilon(0.01));
  // A tenth of the errors that are independent says a tenth as much, of the same size.
  const diagnose::ErrorSize alike = limb.size_of(off, 10.0);
  CHECK(alike.share == size.share);
  CHECK(alike.log_likelihood == doctest::Approx(size.log_likelihood / 10.0));
}

TEST_CASE("error size: what lasts long in one recording takes nothing from what is independent in another") {
  const Recorded limb;
  std::vector<diagnose::FitData> data = limb.data;
  data.push_back(data.front());
  const auto squares_of = [&](double share) {
    diagnose::PerChannel sum = limb.scale;
    for (const plant::ChannelId c : sum.ids()) sum[c] = samples * std::pow(std::hypot(share * limb.scale[c], testing::paper_noise[c]), 2);
    return sum;
  };
  const diagnose::PerChannel count = diagnose::per_channel(testing::limb_system(), samples);
  const diagnose::SquaredErrors errors{{squares_of(0.03), squares_of(0.10)}, {count, count}};
  const auto share_of = [&](double first, double second) {
    return diagnose::error_size(errors, data, limb.scale,
                                {diagnose::per_channel(testing::limb_system(), first),
                                 diagnose::per_channel(testing::limb_system(), second)})
        .share;
  };
  CHECK(share_of(1.0, samples) == doctest::Approx(0.03).epsilon(0.05));
  CHECK(share_of(samples, 1.0) == doctest::Approx(0.10).epsilon(0.05));
}

TEST_CASE("error size: to follow one channel to its noise is not worth giving up another") {
  const Recorded limb;
  diagnose::PerChannel even = limb.scale, uneven = limb.scale;
  for (const plant::ChannelId c : even.ids()) even[c] *= 0.05;
  uneven[angle] = testing::paper_noise[angle];
  uneven[temperature_A] *= 0.10;
  uneven[temperature_B] *= 0.05;
  CHECK(limb.size_of(even).log_likelihood > limb.size_of(uneven).log_likelihood);
  // With a size for each channel the other way about.
  double of_each = 0.0;
  for (const plant::ChannelId c : even.ids()) of_each += std::log(even[c] / uneven[c]);
  CHECK(of_each > 0.0);
}

}  // namespace diagnose_error_size_test

// SPDX-License-Identifier: Apache-2.0
#include "sim/random.h"

#include <doctest/doctest.h>

#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <set>
#include <string>
#include <utility>
#include <vector>

namespace sim_random_test {

using namespace sinew::sim;

namespace {

// Statistics of so many draws are taken as right within four of their own standard deviations. Streams are fixed by
// their seeds, so that a test passes always or never.
constexpr std::size_t draws = 100000;
const double one_deviation = 1.0 / std::sqrt(static_cast<double>(draws));

std::vector<double> uniforms(const RandomStream& stream) {
  std::vector<double> values;
  for (std::size_t n = 0; n < draws; ++n) values.push_back(stream.uniform(n));
  return values;
}
std::vector<double> normals(const RandomStream& stream) {
  std::vector<double> values;
  for (std::size_t n = 0; n < draws; ++n) values.push_back(stream.normal(n));
  return values;
}

double mean(const std::vector<double>& x) {
  double sum = 0.0;
  for (const double v : x) sum += v;
  return sum / static_cast<double>(x.size());
}
double moment(const std::vector<double>& x, int power) {
  const double centre = mean(x);
  double sum = 0.0;
  for (const double v : x) sum += std::pow(v - centre, power);
  return sum / static_cast<double>(x.size());
}
// Of x[i] with y[i + lag].
double correlation(const std::vector<double>& x, const std::vector<double>& y, std::size_t lag = 0) {
  const double mean_x = mean(x), mean_y = mean(y);
  double sum = 0.0;
  for (std::size_t i = 0; i + lag < x.size(); ++i) sum += (x[i] - mean_x) * (y[i + lag] - mean_y);
  return sum / static_cast<double>(x.size() - lag) / std::sqrt(moment(x, 2) * moment(y, 2));
}

}  // namespace

TEST_CASE("random: a stream is the sequence of SplitMix64 from its key") {
  // Seeds for which seed and empty name hash to the keys 1234567 and 0, found by running the mixing backwards; the
  // sequences from these keys are published with the generator's reference code and on Rosetta Code.
  const RandomStream from_1234567(15292574352909327050u, "");
  CHECK(from_1234567.bits(0) == 6457827717110365317u);
  CHECK(from_1234567.bits(1) == 3203168211198807973u);
  CHECK(from_1234567.bits(2) == 9817491932198370423u);
  CHECK(from_1234567.bits(3) == 4593380528125082431u);
  CHECK(from_1234567.bits(4) == 16408922859458223821u);
  const RandomStream from_0(1041253797366319359u, "");
  CHECK(from_0.bits(0) == 0xe220a8397b1dcdafu);
  CHECK(from_0.bits(1) == 0x6e789e6aa1b965f4u);
  CHECK(from_0.bits(2) == 0x06c45d188009454fu);
}

TEST_CASE("random: seed and name make the key as another implementation makes it") {
  // Worked in Python with integers of any size: key = mix(mix(seed + golden) ^ FNV-1a(name)), where FNV-1a of "foobar" is
  // 0x85944171f73967e8 as published.
  const RandomStream noise(1, "angle.noise");
  CHECK(noise.bits(0) == 16684132195360400337u);
  CHECK(noise.bits(1) == 11770757479179106910u);
  CHECK(noise.bits(3) == 17859644775927818408u);
  const RandomStream duty(4711, "duty_A");
  CHECK(duty.bits(0) == 13647402255112157880u);
  CHECK(duty.bits(2) == 13510929584469142659u);
}

TEST_CASE("random: a uniform number is the upper 53 bits over 2^53") {
  const RandomStream noise(1, "angle.noise");
  // 16684132195360400337 >> 11 = 8146548923515820.
  CHECK(noise.uniform(0) == 8146548923515820.0 / 9007199254740992.0);
  CHECK(noise.uniform(2) == 2010058421271092.0 / 9007199254740992.0);
}

TEST_CASE("random: a normal number is Box and Muller's of two uniform ones") {
  // Python's math module; libraries of mathematics differ by a few roundings.
  const RandomStream noise(1, "angle.noise"), duty(4711, "duty_A");
  CHECK(noise.normal(0) == doctest::Approx(-1.401237521939932).epsilon(1e-14));
  CHECK(noise.normal(1) == doctest::Approx(0.6965030665088561).epsilon(1e-14));
  CHECK(duty.normal(0) == doctest::Approx(0.8896117384161704).epsilon(1e-14));
}

TEST_CASE("random: uniform numbers fill [0, 1) evenly") {
  const std::vector<double> u = uniforms(RandomStream(7, "a"));
  // Mean 1/2 with variance 1/12; variance 1/12 with variance 1/180.
  CHECK(std::abs(mean(u) - 0.5) < 4.0 * std::sqrt(1.0 / 12.0) * one_deviation);
  CHECK(std::abs(moment(u, 2) - 1.0 / 12.0) < 4.0 * std::sqrt(1.0 / 180.0) * one_deviation);
  std::array<double, 100> bins{};
  bool inside = true;
  for (const double v : u) {
    inside = inside && v >= 0.0 && v < 1.0;
    bins[static_cast<std::size_t>(v * 100.0)] += 1.0;
  }
  CHECK(inside);
  // Chi squared of 99 degrees of freedom: 99 with deviation sqrt(198).
  double chi_squared = 0.0;
  for (const double count : bins) chi_squared += (count - 1000.0) * (count - 1000.0) / 1000.0;
  CHECK(std::abs(chi_squared - 99.0) < 4.0 * std::sqrt(198.0));
}

TEST_CASE("random: each of the 64 bits is set half of the time") {
  const RandomStream stream(7, "a");
  std::array<int, 64> set{};
  for (std::size_t n = 0; n < draws; ++n)
    for (std::size_t bit = 0; bit < 64; ++bit) set[bit] += (stream.bits(n) >> bit & 1u) != 0;
  for (const int count : set) CHECK(std::abs(static_cast<double>(count) / draws - 0.5) < 4.0 * 0.5 * one_deviation);
}

TEST_CASE("random: normal numbers have the moments and the shape of the normal distribution") {
  const std::vector<double> z = normals(RandomStream(7, "a"));
  // Deviations of the sample's mean, variance, third and fourth moment: 1, sqrt(2), sqrt(15), sqrt(96) over sqrt(draws).
  CHECK(std::abs(mean(z)) < 4.0 * one_deviation);
  CHECK(std::abs(moment(z, 2) - 1.0) < 4.0 * std::sqrt(2.0) * one_deviation);
  CHECK(std::abs(moment(z, 3)) < 4.0 * std::sqrt(15.0) * one_deviation);
  CHECK(std::abs(moment(z, 4) - 3.0) < 4.0 * std::sqrt(96.0) * one_deviation);
  // Shares of a table of the normal distribution, each with the binomial's deviation.
  for (const auto& [limit, share] : {std::pair{1.0, 0.682689}, std::pair{2.0, 0.954500}, std::pair{3.0, 0.997300}}) {
    double within = 0.0;
    for (const double v : z) within += std::abs(v) < limit;
    CHECK(std::abs(within / draws - share) < 4.0 * std::sqrt(share * (1.0 - share)) * one_deviation);
  }
}

TEST_CASE("random: numbers of a stream do not depend on the ones before") {
  const RandomStream stream(7, "a");
  const std::vector<double> z = normals(stream), u = uniforms(stream);
  for (const std::size_t lag : {1u, 2u, 3u, 10u}) {
    CHECK(std::abs(correlation(z, z, lag)) < 4.0 * one_deviation);
    CHECK(std::abs(correlation(u, u, lag)) < 4.0 * one_deviation);
  }
}

TEST_CASE("random: streams of other names and of other seeds do not depend on each other") {
  const std::array names{"temperature_A.noise", "temperature_B.noise", "angle.noise", "angle.dropout", "duty_A", "duty_B"};
  std::vector<std::vector<double>> streams;
  for (const char* name : names) streams.push_back(normals(RandomStream(1, name)));
  for (const std::uint64_t seed : {0u, 2u, 3u}) streams.push_back(normals(RandomStream(seed, "angle.noise")));
  for (std::size_t i = 0; i < streams.size(); ++i)
    for (std::size_t j = i + 1; j < streams.size(); ++j) {
      CAPTURE(i);
      CAPTURE(j);
      CHECK(std::abs(correlation(streams[i], streams[j])) < 4.0 * one_deviation);
      CHECK(std::abs(correlation(streams[i], streams[j], 1)) < 4.0 * one_deviation);
    }
}

TEST_CASE("random: the n-th number is the same whatever was drawn before, and whatever other streams there are") {
  const RandomStream alone(5, "temperature_A.noise");
  const double seventh = alone.normal(7);
  RandomStream first(5, "one more sensor");
  for (std::size_t n = 0; n < 100; ++n) static_cast<void>(first.normal(n));
  const RandomStream again(5, "temperature_A.noise");
  static_cast<void>(again.normal(1000000));
  CHECK(again.normal(7) == seventh);
  const RandomStream copy = again;
  CHECK(copy.normal(7) == seventh);
}

TEST_CASE("random: a thousand seeds and names that differ by little give a thousand first numbers") {
  std::set<std::uint64_t> seen;
  for (std::uint64_t seed = 0; seed < 500; ++seed) seen.insert(RandomStream(seed, "x").bits(0));
  for (int i = 0; i < 500; ++i) seen.insert(RandomStream(0, "x" + std::to_string(i)).bits(0));
  CHECK(seen.size() == 1000);
}

}  // namespace sim_random_test

// SPDX-License-Identifier: Apache-2.0
// Chance from one seed, split by consumer, without state: the n-th number of a stream is a function of (seed, name, n).
//
// Adding a sensor leaves the noise of the others as it was, a lost sample moves no other, and a resumed run needs no
// generator's state. The bits are those of SplitMix64 (Steele, Lea, Flood 2014), of which a stream is the sequence that
// begins at a hash of seed and name.
#pragma once

#include <cmath>
#include <cstdint>
#include <numbers>
#include <string_view>

namespace sinew::sim {

class RandomStream {
 public:
  RandomStream(std::uint64_t seed, std::string_view name) {
    std::uint64_t hash = 0xcbf29ce484222325u;  // FNV-1a
    for (const char c : name) hash = (hash ^ static_cast<unsigned char>(c)) * 0x100000001b3u;
    key_ = mixed(mixed(seed + golden) ^ hash);
  }

  std::uint64_t bits(std::uint64_t n) const { return mixed(key_ + (n + 1) * golden); }

  // In [0, 1), 53 bits.
  double uniform(std::uint64_t n) const { return static_cast<double>(bits(n) >> 11) * 0x1p-53; }

  // Standard normal, by Box and Muller 1958; uses the uniforms 2n and 2n + 1.
  double normal(std::uint64_t n) const {
    const double radius = std::sqrt(-2.0 * std::log(1.0 - uniform(2 * n)));
    return radius * std::cos(2.0 * std::numbers::pi * uniform(2 * n + 1));
  }

 private:
  static constexpr std::uint64_t golden = 0x9e3779b97f4a7c15u;
  static constexpr std::uint64_t mixed(std::uint64_t z) {
    z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9u;
    z = (z ^ (z >> 27)) * 0x94d049bb133111ebu;
    return z ^ (z >> 31);
  }
  std::uint64_t key_;
};

}  // namespace sinew::sim

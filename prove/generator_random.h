// SPDX-License-Identifier: Apache-2.0
// Chance by counting: the n-th number of a stream is a function of (seed, name of the stream, n).
//
// Philox4x32-10 (Salmon, Moraes, Dror, Shaw 2011, "Parallel random numbers: as easy as 1, 2, 3"): the seed is its key,
// n and a hash of the name its counter.
#pragma once

#include <array>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <string_view>

namespace sinew::prove {

constexpr std::array<std::uint32_t, 4> philox(std::array<std::uint32_t, 4> counter, std::array<std::uint32_t, 2> key) {
  for (int round = 0; round < 10; ++round) {
    const std::uint64_t first = std::uint64_t{0xD2511F53u} * counter[0];
    const std::uint64_t second = std::uint64_t{0xCD9E8D57u} * counter[2];
    counter = {static_cast<std::uint32_t>(second >> 32) ^ counter[1] ^ key[0], static_cast<std::uint32_t>(second),
               static_cast<std::uint32_t>(first >> 32) ^ counter[3] ^ key[1], static_cast<std::uint32_t>(first)};
    key[0] += 0x9E3779B9u;
    key[1] += 0xBB67AE85u;
  }
  return counter;
}

class Stream {
 public:
  Stream(std::uint64_t seed, std::string_view name) : seed_(seed), name_(hash(name)) {}

  // In (0, 1), 52 bits and a half.
  double uniform(std::uint64_t n) const { return unit(words(n), 0); }
  double uniform(std::uint64_t n, double low, double high) const { return low + (high - low) * uniform(n); }

  // Standard normal, by Box and Muller 1958.
  double normal(std::uint64_t n) const {
    const auto drawn = words(n);
    return std::sqrt(-2.0 * std::log(unit(drawn, 0))) * std::cos(2.0 * std::numbers::pi * unit(drawn, 2));
  }

 private:
  // FNV-1a, 64 bits.
  static constexpr std::uint64_t hash(std::string_view text) {
    std::uint64_t value = 0xcbf29ce484222325u;
    for (const char c : text) value = (value ^ static_cast<unsigned char>(c)) * 0x100000001b3u;
    return value;
  }
  static constexpr std::uint32_t low(std::uint64_t x) { return static_cast<std::uint32_t>(x); }
  static constexpr std::uint32_t high(std::uint64_t x) { return static_cast<std::uint32_t>(x >> 32); }
  std::array<std::uint32_t, 4> words(std::uint64_t n) const {
    return philox({low(n), high(n), low(name_), high(name_)}, {low(seed_), high(seed_)});
  }
  static double unit(const std::array<std::uint32_t, 4>& drawn, std::size_t first) {
    const std::uint64_t bits = (std::uint64_t{drawn[first]} << 32 | drawn[first + 1]) >> 12;
    return (static_cast<double>(bits) + 0.5) * 0x1p-52;
  }

  std::uint64_t seed_, name_;
};

}  // namespace sinew::prove

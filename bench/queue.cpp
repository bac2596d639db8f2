// SPDX-License-Identifier: Apache-2.0
// What a number from the queue of apps/ranks.h costs, where nothing is done with it:
//
//     mpirun -n 8 build/release/bench/bench_queue
#include <chrono>
#include <cstdio>

#include "apps/ranks.h"

int main() {
  using namespace sinew;
  return apps::in_all_ranks([](apps::Ranks& ranks) {
    constexpr std::size_t numbers = 20000;
    for (const std::size_t chunk : {std::size_t{1}, std::size_t{64}}) {
      const auto began = std::chrono::steady_clock::now();
      ranks.share(numbers, {.threads = 1, .chunk = chunk}, [](std::size_t) {});
      const double took_s = std::chrono::duration<double>(std::chrono::steady_clock::now() - began).count();
      if (ranks.first()) std::printf("| %d | %zu | %.3f |\n", ranks.size(), chunk, 1e6 * took_s / static_cast<double>(numbers));
    }
    return 0;
  });
}

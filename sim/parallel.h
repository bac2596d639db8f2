// SPDX-License-Identifier: Apache-2.0
// The same work on several threads. What is worked on may not depend on which thread takes it.
#pragma once

#include <algorithm>
#include <atomic>
#include <cstddef>
#include <exception>
#include <mutex>
#include <thread>
#include <vector>

namespace sinew::sim {

// Calls work(i) for every i below `count`, on up to `threads` threads. Throws one of the exceptions that were thrown.
template <class Work>
void in_parallel(std::size_t count, int threads, Work&& work) {
  std::atomic<std::size_t> next{0};
  std::mutex keeping;
  std::exception_ptr trouble;
  const auto loop = [&] {
    for (std::size_t i = next++; i < count; i = next++) {
      try {
        work(i);
      } catch (...) {
        const std::scoped_lock lock(keeping);
        if (!trouble) trouble = std::current_exception();
      }
    }
  };
  {
    std::vector<std::jthread> others;
    for (std::size_t t = 1; t < std::min(count, static_cast<std::size_t>(std::max(1, threads))); ++t) others.emplace_back(loop);
    loop();
  }
  if (trouble) std::rethrow_exception(trouble);
}

}  // namespace sinew::sim

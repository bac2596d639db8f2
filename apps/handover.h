// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <atomic>
#include <cstddef>
#include <vector>

namespace sinew::apps {

// From one thread to another through a ring that neither locks nor waits: what finds it full is not handed over. A slot keeps its memory:
// nothing is freed by another thread than the one that allocates.
template <class Slot>
class Handover {
 public:
  explicit Handover(std::size_t slots) : slots_(slots) {}
  // By the one thread that gives: `fill` writes into the slot, which holds what was there before. False: the ring is full.
  template <class Fill>
  bool put(Fill&& fill) {
    const std::size_t at = given_.load(std::memory_order_relaxed);
    if (at - taken_.load(std::memory_order_acquire) == slots_.size()) return false;
    fill(slots_[at % slots_.size()]);
    given_.store(at + 1, std::memory_order_release);
    return true;
  }
  // By the one thread that takes: all that is there, in its order.
  template <class Use>
  void take(Use&& use) {
    for (std::size_t at = taken_.load(std::memory_order_relaxed); at != given_.load(std::memory_order_acquire);
         taken_.store(++at, std::memory_order_release))
      use(static_cast<const Slot&>(slots_[at % slots_.size()]));
  }

 private:
  std::vector<Slot> slots_;
  std::atomic<std::size_t> given_{0}, taken_{0};
};

}  // namespace sinew::apps

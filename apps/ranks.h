// SPDX-License-Identifier: Apache-2.0
// Several processes that share one job under mpirun; one process alone otherwise.
#pragma once

#include <chrono>
#include <cstddef>
#include <cstdio>
#include <exception>
#include <functional>
#include <mutex>
#include <string>
#include <vector>

namespace sinew::apps {

// MPI is begun only where mpirun (Open MPI's, or a launcher that speaks PMI) started this process. Where an exception passes
// this object, all ranks are aborted: none waits for one that is gone. To a method that says "every rank" all must come.
class Ranks {
 public:
  Ranks();
  ~Ranks();
  Ranks(const Ranks&) = delete;
  Ranks& operator=(const Ranks&) = delete;
  int size() const { return size_; }
  bool under_mpirun() const { return begun_; }
  bool first() const { return rank_ == 0; }

  // Every rank: calls `work` in the first one, for which the others wait.
  template <class Work>
  void first_alone(Work&& work) {
    if (first()) work();
    wait_for_all();
  }

  // Every rank: calls work(i) once for each i below `count`, somewhere, on `threads` threads of each rank. Whoever is free takes the next
  // `chunk` of them, from one counter that the first rank keeps. After an interrupt of any rank no more are begun: false then, in all.
  struct Sharing {
    int threads = 1;
    std::size_t chunk = 1;
  };
  bool share(std::size_t count, const Sharing& how, const std::function<void(std::size_t)>& work);

  // Every rank: the first one's text, in all of them.
  std::string from_first(std::string text);
  // Every rank: the texts of all, by rank, in the first one; nothing in the others.
  std::vector<std::string> gather(std::string own);

  // Whether this rank was interrupted, or another that has said so: the first to know tells all. To be asked during the work, from
  // any thread; it also lets other ranks reach the counter where the network cannot do that alone.
  bool any_interrupted();

 private:
  class Counter;
  void wait_for_all();
  void listen();
  bool agree_on_interrupt();

  bool begun_ = false, told_ = false;
  int rank_ = 0, size_ = 1;
  std::mutex talking_;
  std::vector<bool> heard_from_;  // by rank
  std::chrono::steady_clock::time_point listens_next_{};
};

// What `command` returns. What it throws is said here where the end of all ranks would leave no time to say it.
template <class Command>
int in_all_ranks(Command&& command) {
  Ranks ranks;
  try {
    return command(ranks);
  } catch (const std::exception& e) {
    if (ranks.under_mpirun()) std::fprintf(stderr, "%s\n", e.what());
    throw;
  }
}

// The processors that this process may use, shared among the ranks on its machine.
int usual_threads();

}  // namespace sinew::apps

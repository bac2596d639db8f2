// SPDX-License-Identifier: Apache-2.0
// Several processes that share one job under mpirun; one process alone otherwise.
#pragma once

#include <atomic>
#include <cstddef>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "apps/app.h"

namespace sinew::apps {

// MPI is begun only where mpirun (Open MPI's, or a launcher that speaks PMI) started this process. To a method that says "every rank" all
// must come; what one throws ends them all (in_all_ranks).
class Ranks {
 public:
  Ranks();
  ~Ranks();
  Ranks(const Ranks&) = delete;
  Ranks& operator=(const Ranks&) = delete;
  int size() const { return size_; }
  bool under_mpirun() const { return shared_ != nullptr; }
  bool first() const { return rank_ == 0; }

  // Every rank: calls `work` in the first one, for which the others wait. False after an interrupt of any rank, in all.
  template <class Work>
  bool first_alone(Work&& work) {
    if (first()) work();
    return !agree_on_interrupt();
  }

  // Every rank: calls work(i) once for each i below `count`, somewhere, on `threads` threads of each rank. Whoever is free takes the next
  // `chunk` of them, from one counter that the first rank keeps. After an interrupt of any rank no more are begun: false then, in all.
  struct Sharing {
    int threads = 1;
    std::size_t chunk = 1;
    std::string doing = {};                             // the first rank shows its progress by this name
    std::function<std::string(std::size_t)> name = {};  // and by that of what was done last
  };
  bool share(std::size_t count, const Sharing& how, const std::function<void(std::size_t)>& work);

  // Every rank: the first one's text, in all of them.
  std::string from_first(std::string text);
  // Every rank: the texts of all, by rank, in the first one; nothing in the others.
  std::vector<std::string> gather(std::string own);

  // Whether this rank was interrupted, or another some tenths of a second ago; also where work of this rank has thrown, which ends all.
  bool any_interrupted() const;

  // Ends all ranks, from any of them, under mpirun.
  [[noreturn]] void abort(int exit_code);

 private:
  class Shared;
  bool agree_on_interrupt();

  int rank_ = 0, size_ = 1;
  std::atomic<bool> failed_{false};
  std::unique_ptr<Shared> shared_;  // none without mpirun
};

// What `command` returns. What it throws is said here, where the end of all ranks would leave no time to say it.
template <class Command>
int in_all_ranks(Command&& command) {
  Ranks ranks;
  try {
    return command(ranks);
  } catch (...) {
    if (!ranks.under_mpirun()) throw;
    ranks.abort(say_what_was_thrown());
  }
}

// The first rank says "stopped; " and `what`; the exit code.
int stopped(const Ranks& ranks, const std::string& what);

// The processors that this process may use, shared among the ranks on its machine.
int usual_threads();

}  // namespace sinew::apps

// SPDX-License-Identifier: Apache-2.0
// Several processes that share one job under mpirun; one process alone otherwise.
#pragma once

namespace sinew::apps {

// MPI is begun only where mpirun (Open MPI's, or a launcher that speaks PMI) started this process. Where an exception passes
// this object, all ranks are aborted: none waits for one that is gone.
class Ranks {
 public:
  Ranks();
  ~Ranks();
  Ranks(const Ranks&) = delete;
  Ranks& operator=(const Ranks&) = delete;
  int rank() const { return rank_; }
  int size() const { return size_; }
  void wait_for_all() const;

 private:
  bool begun_ = false;
  int rank_ = 0, size_ = 1;
};

}  // namespace sinew::apps

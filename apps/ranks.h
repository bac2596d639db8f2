// SPDX-License-Identifier: Apache-2.0
// Several processes that share one job under mpirun; one process alone otherwise.
#pragma once

#include <mutex>
#include <vector>

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

  // Whether this rank was interrupted, or another that has said so: the first to know tells all. To be asked during the work, from
  // any thread.
  bool any_interrupted();
  // When the work is over; every rank must come here. Whether any rank was interrupted: the same answer in all.
  bool agree_on_interrupt();

 private:
  bool begun_ = false, may_talk_ = false, told_ = false;
  int rank_ = 0, size_ = 1;
  std::mutex talking_;
  std::vector<bool> heard_from_;  // by rank
};

}  // namespace sinew::apps

// SPDX-License-Identifier: Apache-2.0
#include "apps/ranks.h"

#define OMPI_SKIP_MPICXX 1  // the C interface alone
#include <mpi.h>

#include <cstdlib>
#include <exception>

#include "apps/app.h"

namespace sinew::apps {
namespace {

constexpr int interrupt_tag = 1;

}  // namespace

Ranks::Ranks() {
  if (!std::getenv("OMPI_COMM_WORLD_SIZE") && !std::getenv("PMI_SIZE") && !std::getenv("PMIX_RANK")) return;
  int provided = 0;
  MPI_Init_thread(nullptr, nullptr, MPI_THREAD_SERIALIZED, &provided);
  begun_ = true;
  may_talk_ = provided >= MPI_THREAD_SERIALIZED;
  MPI_Comm_rank(MPI_COMM_WORLD, &rank_);
  MPI_Comm_size(MPI_COMM_WORLD, &size_);
  heard_from_.assign(static_cast<std::size_t>(size_), false);
}

Ranks::~Ranks() {
  if (!begun_) return;
  if (std::uncaught_exceptions() > 0)
    MPI_Abort(MPI_COMM_WORLD, 1);
  else
    MPI_Finalize();
}

void Ranks::wait_for_all() const {
  if (begun_) MPI_Barrier(MPI_COMM_WORLD);
}

bool Ranks::any_interrupted() {
  if (!may_talk_ || size_ == 1) return interrupted();
  const std::scoped_lock lock(talking_);
  if (interrupted() && !told_) {
    told_ = true;
    char nothing = 0;  // a message of one byte is sent at once, and does not wait for its reader
    for (int other = 0; other < size_; ++other)
      if (other != rank_) MPI_Send(&nothing, 1, MPI_CHAR, other, interrupt_tag, MPI_COMM_WORLD);
  }
  bool any = told_;
  int waiting = 0;
  MPI_Status status;
  for (MPI_Iprobe(MPI_ANY_SOURCE, interrupt_tag, MPI_COMM_WORLD, &waiting, &status); waiting != 0;
       MPI_Iprobe(MPI_ANY_SOURCE, interrupt_tag, MPI_COMM_WORLD, &waiting, &status)) {
    char nothing = 0;
    MPI_Recv(&nothing, 1, MPI_CHAR, status.MPI_SOURCE, interrupt_tag, MPI_COMM_WORLD, MPI_STATUS_IGNORE);
    heard_from_[static_cast<std::size_t>(status.MPI_SOURCE)] = true;
  }
  for (const bool one : heard_from_) any = any || one;
  return any;
}

bool Ranks::agree_on_interrupt() {
  if (!begun_) return interrupted();
  const std::scoped_lock lock(talking_);
  int own[2] = {interrupted() ? 1 : 0, told_ ? 1 : 0};
  std::vector<int> all(2 * static_cast<std::size_t>(size_));
  MPI_Allgather(own, 2, MPI_INT, all.data(), 2, MPI_INT, MPI_COMM_WORLD);
  bool any = false;
  for (int other = 0; other < size_; ++other) {
    const auto at = static_cast<std::size_t>(other);
    any = any || all[2 * at] != 0;
    if (other == rank_ || all[2 * at + 1] == 0 || heard_from_[at]) continue;
    char nothing = 0;  // told, and not heard yet: no message is left behind
    MPI_Recv(&nothing, 1, MPI_CHAR, other, interrupt_tag, MPI_COMM_WORLD, MPI_STATUS_IGNORE);
  }
  return any;
}

}  // namespace sinew::apps

// SPDX-License-Identifier: Apache-2.0
#include "apps/ranks.h"

#define OMPI_SKIP_MPICXX 1  // the C interface alone
#include <mpi.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cstdint>
#include <cstdlib>
#include <stdexcept>
#include <thread>

#include "apps/app.h"
#include "sim/parallel.h"

namespace sinew::apps {
namespace {

constexpr int interrupt_tag = 1, text_tag = 2;
constexpr std::size_t longest_message = std::size_t{1} << 30;  // MPI counts in int

// Where ranks share a processor, MPI gives it away whenever it is asked for messages.
constexpr std::chrono::milliseconds listening_period{10};

// MPI's own waiting keeps a processor busy, which may be one that another rank works on.
void wait_asleep(MPI_Request request) {
  int done = 0;
  for (MPI_Test(&request, &done, MPI_STATUS_IGNORE); !done; MPI_Test(&request, &done, MPI_STATUS_IGNORE))
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
}
void wait_for_all_ranks() {
  MPI_Request request;
  MPI_Ibarrier(MPI_COMM_WORLD, &request);
  wait_asleep(request);
}

// Calls transfer(where, count) for the text's parts, each so long that MPI can count it.
template <class Transfer>
void in_messages(std::string& text, Transfer&& transfer) {
  for (std::size_t at = 0; at < text.size(); at += longest_message)
    transfer(text.data() + at, static_cast<int>(std::min(longest_message, text.size() - at)));
}

}  // namespace

// A number that all ranks count up.
class Ranks::Counter {
 public:
  explicit Counter(Ranks& ranks) : ranks_(ranks) {
    if (!ranks_.begun_) return;
    const std::scoped_lock lock(ranks_.talking_);
    void* memory = nullptr;
    MPI_Win_allocate(ranks_.first() ? sizeof(std::int64_t) : 0, sizeof(std::int64_t), MPI_INFO_NULL, MPI_COMM_WORLD, &memory, &window_);
    MPI_Win_lock_all(MPI_MODE_NOCHECK, window_);
    if (ranks_.first()) at_first(0, MPI_REPLACE);
    wait_for_all_ranks();
  }
  // What it was, and `more` is added.
  std::size_t take(std::size_t more) {
    if (!ranks_.begun_) return alone_.fetch_add(more);
    const std::scoped_lock lock(ranks_.talking_);
    return static_cast<std::size_t>(at_first(static_cast<std::int64_t>(more), MPI_SUM));
  }
  // Every rank. Not in the destructor, which an exception would bring one rank to alone.
  void close() {
    if (!ranks_.begun_) return;
    const std::scoped_lock lock(ranks_.talking_);
    MPI_Win_unlock_all(window_);
    MPI_Win_free(&window_);
  }

 private:
  std::int64_t at_first(std::int64_t value, MPI_Op operation) {
    std::int64_t before = 0;
    MPI_Fetch_and_op(&value, &before, MPI_INT64_T, 0, 0, operation, window_);
    MPI_Win_flush(0, window_);
    return before;
  }

  Ranks& ranks_;
  MPI_Win window_ = MPI_WIN_NULL;
  std::atomic<std::size_t> alone_{0};
};

Ranks::Ranks() {
  if (!std::getenv("OMPI_COMM_WORLD_SIZE") && !std::getenv("PMI_SIZE") && !std::getenv("PMIX_RANK")) return;
  int provided = 0;
  MPI_Init_thread(nullptr, nullptr, MPI_THREAD_SERIALIZED, &provided);
  if (provided < MPI_THREAD_SERIALIZED) throw std::runtime_error("this MPI lets one thread alone speak; Sinew needs MPI_THREAD_SERIALIZED");
  begun_ = true;
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

void Ranks::wait_for_all() {
  const std::scoped_lock lock(talking_);
  if (begun_) wait_for_all_ranks();
}

bool Ranks::share(std::size_t count, const Sharing& how, const std::function<void(std::size_t)>& work) {
  Counter counter(*this);
  std::atomic<bool> failed{false};
  const auto take_and_work = [&](std::size_t) {
    for (std::size_t begin = counter.take(how.chunk); begin < count; begin = counter.take(how.chunk))
      for (std::size_t i = begin; i < std::min(begin + how.chunk, count); ++i) {
        if (failed || any_interrupted()) return;
        try {
          work(i);
        } catch (...) {
          failed = true;
          throw;
        }
      }
  };
  sim::in_parallel(static_cast<std::size_t>(std::max(1, how.threads)), how.threads, take_and_work);
  const bool any = agree_on_interrupt();
  counter.close();
  return !any;
}

std::string Ranks::from_first(std::string text) {
  if (size_ == 1) return text;
  const std::scoped_lock lock(talking_);
  const auto broadcast = [](void* what, int count, MPI_Datatype type) {
    MPI_Request request;
    MPI_Ibcast(what, count, type, 0, MPI_COMM_WORLD, &request);
    wait_asleep(request);
  };
  std::uint64_t length = text.size();
  broadcast(&length, 1, MPI_UINT64_T);
  text.resize(length);
  in_messages(text, [&](char* part, int count) { broadcast(part, count, MPI_CHAR); });
  return text;
}

std::vector<std::string> Ranks::gather(std::string own) {
  if (size_ == 1) return {std::move(own)};
  const std::scoped_lock lock(talking_);
  std::uint64_t length = own.size();
  if (!first()) {
    const auto send = [](const void* what, int count, MPI_Datatype type) {
      MPI_Request request;
      MPI_Isend(what, count, type, 0, text_tag, MPI_COMM_WORLD, &request);
      wait_asleep(request);
    };
    send(&length, 1, MPI_UINT64_T);
    in_messages(own, [&](char* part, int count) { send(part, count, MPI_CHAR); });
    return {};
  }
  std::vector<std::string> all{std::move(own)};
  for (int other = 1; other < size_; ++other) {
    const auto receive = [other](void* what, int count, MPI_Datatype type) {
      MPI_Request request;
      MPI_Irecv(what, count, type, other, text_tag, MPI_COMM_WORLD, &request);
      wait_asleep(request);
    };
    receive(&length, 1, MPI_UINT64_T);
    std::string text(length, '\0');
    in_messages(text, [&](char* part, int count) { receive(part, count, MPI_CHAR); });
    all.push_back(std::move(text));
  }
  return all;
}

bool Ranks::any_interrupted() {
  if (size_ == 1) return interrupted();
  const std::scoped_lock lock(talking_);
  if (interrupted() && !told_) {
    told_ = true;
    char nothing = 0;  // a message of one byte is sent at once, and does not wait for its reader
    for (int other = 0; other < size_; ++other)
      if (other != rank_) MPI_Send(&nothing, 1, MPI_CHAR, other, interrupt_tag, MPI_COMM_WORLD);
  }
  if (const auto now = std::chrono::steady_clock::now(); now >= listens_next_) {
    listens_next_ = now + listening_period;
    listen();
  }
  return told_ || std::find(heard_from_.begin(), heard_from_.end(), true) != heard_from_.end();
}

void Ranks::listen() {
  int waiting = 0;
  MPI_Status status;
  for (MPI_Iprobe(MPI_ANY_SOURCE, interrupt_tag, MPI_COMM_WORLD, &waiting, &status); waiting != 0;
       MPI_Iprobe(MPI_ANY_SOURCE, interrupt_tag, MPI_COMM_WORLD, &waiting, &status)) {
    char nothing = 0;
    MPI_Recv(&nothing, 1, MPI_CHAR, status.MPI_SOURCE, interrupt_tag, MPI_COMM_WORLD, MPI_STATUS_IGNORE);
    heard_from_[static_cast<std::size_t>(status.MPI_SOURCE)] = true;
  }
}

// When the work is over. Whether any rank was interrupted: the same answer in all.
bool Ranks::agree_on_interrupt() {
  if (!begun_) return interrupted();
  const std::scoped_lock lock(talking_);
  int own[2] = {interrupted() ? 1 : 0, told_ ? 1 : 0};
  std::vector<int> all(2 * static_cast<std::size_t>(size_));
  MPI_Request request;
  MPI_Iallgather(own, 2, MPI_INT, all.data(), 2, MPI_INT, MPI_COMM_WORLD, &request);
  wait_asleep(request);
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

int usual_threads() {
  int here = 1;
  for (const char* name : {"OMPI_COMM_WORLD_LOCAL_SIZE", "MPI_LOCALNRANKS"})
    if (const char* text = std::getenv(name)) here = std::max(here, std::atoi(text));
  return std::max(1, static_cast<int>(std::thread::hardware_concurrency()) / here);
}

}  // namespace sinew::apps

// SPDX-License-Identifier: Apache-2.0
#include "apps/ranks.h"

#define OMPI_SKIP_MPICXX 1  // the C interface alone
#include <mpi.h>
#include <sched.h>

#include <algorithm>
#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <mutex>
#include <optional>
#include <thread>

#include "sim/parallel.h"

namespace sinew::apps {
namespace {

constexpr std::size_t longest_message = std::size_t{1} << 30;  // MPI counts in int

// Calls transfer(where, count) for the text's parts, each so long that MPI can count it.
template <class Transfer>
void in_messages(std::string& text, Transfer&& transfer) {
  for (std::size_t at = 0; at < text.size(); at += longest_message)
    transfer(text.data() + at, static_cast<int>(std::min(longest_message, text.size() - at)));
}

}  // namespace

// Two numbers in the first rank's memory: what the work is counted with, and whether any rank was interrupted. A thread looks at the second
// one; in the first rank that also lets others reach both, where the network cannot do so alone.
class Ranks::Shared {
 public:
  explicit Shared(bool first) : period_(first ? 10 : 300) {
    void* memory = nullptr;
    MPI_Win_allocate(first ? 2 * sizeof(std::int64_t) : 0, sizeof(std::int64_t), MPI_INFO_NULL, MPI_COMM_WORLD, &memory, &window_);
    MPI_Win_lock_all(MPI_MODE_NOCHECK, window_);
    if (first)
      for (const MPI_Aint which : {counter, interrupts}) at_first(which, 0, MPI_REPLACE);
    MPI_Barrier(MPI_COMM_WORLD);
    listener_ = std::jthread([this](std::stop_token ended) { listen(ended); });
  }
  // Every rank.
  ~Shared() {
    stop_listening();
    MPI_Win_unlock_all(window_);
    MPI_Win_free(&window_);
  }
  void stop_listening() {
    listener_.request_stop();
    listener_.join();
  }

  static constexpr MPI_Aint counter = 0, interrupts = 1;
  // What the number was.
  std::int64_t at_first(MPI_Aint which, std::int64_t value, MPI_Op operation) {
    const std::scoped_lock lock(talking_);
    std::int64_t before = 0;
    MPI_Fetch_and_op(&value, &before, MPI_INT64_T, 0, which, operation, window_);
    MPI_Win_flush(0, window_);
    return before;
  }

  // Begins with `begin` and waits; MPI's own waiting would keep a processor busy, which may be one that another rank works on.
  template <class Begin>
  void wait_for(Begin&& begin) {
    MPI_Request request;
    const auto speaks = [this](auto&& call) {
      const std::scoped_lock lock(talking_);
      return call();
    };
    speaks([&] { begin(&request); });
    const auto is_done = [&] {
      int done = 0;
      MPI_Test(&request, &done, MPI_STATUS_IGNORE);
      return done != 0;
    };
    while (!speaks(is_done)) std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }

  bool any_interrupted() const { return any_interrupted_; }

 private:
  void listen(const std::stop_token& ended) {
    std::mutex sleeping;
    std::condition_variable_any wakes;
    for (bool told = false; !ended.stop_requested();) {
      if (!told && interrupted()) {
        at_first(interrupts, 1, MPI_REPLACE);
        told = true;
      }
      if (at_first(interrupts, 0, MPI_NO_OP) != 0) any_interrupted_ = true;
      std::unique_lock lock(sleeping);
      wakes.wait_for(lock, ended, period_, [] { return false; });
    }
  }

  MPI_Win window_ = MPI_WIN_NULL;
  std::mutex talking_;  // MPI_THREAD_SERIALIZED: one thread at a time
  std::atomic<bool> any_interrupted_{false};
  const std::chrono::milliseconds period_;
  std::jthread listener_;
};

Ranks::Ranks() {
  if (!std::getenv("OMPI_COMM_WORLD_SIZE") && !std::getenv("PMI_SIZE") && !std::getenv("PMIX_RANK")) return;
  int provided = 0;
  MPI_Init_thread(nullptr, nullptr, MPI_THREAD_SERIALIZED, &provided);
  if (provided < MPI_THREAD_SERIALIZED) {
    std::fputs("sinew: this MPI lets one thread alone speak; MPI_THREAD_SERIALIZED is needed\n", stderr);
    MPI_Abort(MPI_COMM_WORLD, 1);
  }
  MPI_Comm_rank(MPI_COMM_WORLD, &rank_);
  MPI_Comm_size(MPI_COMM_WORLD, &size_);
  shared_ = std::make_unique<Shared>(first());
}

Ranks::~Ranks() {
  if (!shared_) return;
  agree_on_interrupt();  // waits for the first one, which may still write, without keeping processors busy
  shared_.reset();
  MPI_Finalize();
}

void Ranks::abort(int exit_code) {
  shared_->stop_listening();
  MPI_Abort(MPI_COMM_WORLD, exit_code);
  std::_Exit(exit_code);
}

bool Ranks::share(std::size_t count, const Sharing& how, const std::function<void(std::size_t)>& work) {
  std::atomic<std::size_t> next{0};  // of one process alone
  const auto take = [&] {
    if (!shared_) return next.fetch_add(how.chunk);
    return static_cast<std::size_t>(shared_->at_first(Shared::counter, static_cast<std::int64_t>(how.chunk), MPI_SUM));
  };
  if (first() && shared_) shared_->at_first(Shared::counter, 0, MPI_REPLACE);
  if (agree_on_interrupt()) return false;
  std::optional<Progress> progress;
  if (first() && !how.doing.empty()) progress.emplace(how.doing);
  std::mutex showing;
  const auto take_and_work = [&](std::size_t) {
    for (std::size_t begin = take(); begin < count; begin = take())
      for (std::size_t i = begin; i < std::min(begin + how.chunk, count); ++i) {
        if (any_interrupted()) return;
        try {
          work(i);
        } catch (...) {
          failed_ = true;
          throw;
        }
        const std::scoped_lock lock(showing);
        if (progress) progress->show(static_cast<double>(i + 1) / static_cast<double>(count), how.name ? how.name(i) : "");
      }
  };
  sim::in_parallel(static_cast<std::size_t>(std::max(1, how.threads)), how.threads, take_and_work);
  return !agree_on_interrupt();
}

std::string Ranks::from_first(std::string text) {
  if (size_ == 1) return text;
  const auto broadcast = [&](void* what, int count, MPI_Datatype type) {
    shared_->wait_for([&](MPI_Request* request) { MPI_Ibcast(what, count, type, 0, MPI_COMM_WORLD, request); });
  };
  std::uint64_t length = text.size();
  broadcast(&length, 1, MPI_UINT64_T);
  text.resize(length);
  in_messages(text, [&](char* part, int count) { broadcast(part, count, MPI_CHAR); });
  return text;
}

std::vector<std::string> Ranks::gather(std::string own) {
  if (size_ == 1) return {std::move(own)};
  constexpr int tag = 1;
  std::uint64_t length = own.size();
  if (!first()) {
    const auto send = [&](const void* what, int count, MPI_Datatype type) {
      shared_->wait_for([&](MPI_Request* request) { MPI_Isend(what, count, type, 0, tag, MPI_COMM_WORLD, request); });
    };
    send(&length, 1, MPI_UINT64_T);
    in_messages(own, [&](char* part, int count) { send(part, count, MPI_CHAR); });
    return {};
  }
  std::vector<std::string> all{std::move(own)};
  for (int other = 1; other < size_; ++other) {
    const auto receive = [&](void* what, int count, MPI_Datatype type) {
      shared_->wait_for([&](MPI_Request* request) { MPI_Irecv(what, count, type, other, tag, MPI_COMM_WORLD, request); });
    };
    receive(&length, 1, MPI_UINT64_T);
    std::string text(length, '\0');
    in_messages(text, [&](char* part, int count) { receive(part, count, MPI_CHAR); });
    all.push_back(std::move(text));
  }
  return all;
}

bool Ranks::any_interrupted() const { return failed_ || interrupted() || (shared_ && shared_->any_interrupted()); }

// Every rank. Whether any was interrupted: the same answer in all.
bool Ranks::agree_on_interrupt() {
  const int own = any_interrupted() ? 1 : 0;
  int any = own;
  if (shared_) shared_->wait_for([&](MPI_Request* request) { MPI_Iallreduce(&own, &any, 1, MPI_INT, MPI_MAX, MPI_COMM_WORLD, request); });
  return any != 0;
}

int stopped(const Ranks& ranks, const std::string& what) {
  if (ranks.first()) std::fprintf(stderr, "stopped; %s\n", what.c_str());
  return interrupted_exit_code;
}

int usual_threads() {
  int here = 1;
  for (const char* name : {"OMPI_COMM_WORLD_LOCAL_SIZE", "MPI_LOCALNRANKS", "SLURM_STEP_TASKS_PER_NODE"}  // the last one: "32(x4)"
  )
    if (const char* text = std::getenv(name)) here = std::max(here, std::atoi(text));
  const int share = static_cast<int>(std::thread::hardware_concurrency()) / here;
  cpu_set_t bound_to;
  const bool known = sched_getaffinity(0, sizeof bound_to, &bound_to) == 0;  // fails where a machine has more than 1024
  return std::max(1, known ? std::min(CPU_COUNT(&bound_to), share) : share);
}

}  // namespace sinew::apps

// SPDX-License-Identifier: Apache-2.0
#include "apps/ends_soon.h"

#include <chrono>
#include <cstdio>
#include <cstdlib>

#include "apps/app.h"

namespace sinew::apps {
namespace {

constexpr std::chrono::milliseconds between_looks{50}, grace{1000};

}  // namespace

EndsSoon::EndsSoon(Outputs* outputs) : outputs_(outputs), watcher_([this] { watch(); }) {}

EndsSoon::~EndsSoon() {
  {
    const std::lock_guard lock(mutex_);
    over_ = true;
  }
  changed_.notify_all();
  watcher_.join();
}

void EndsSoon::watch() {
  std::unique_lock lock(mutex_);
  const auto is_over = [this] { return over_; };
  while (!interrupted())
    if (changed_.wait_for(lock, between_looks, is_over)) return;
  if (changed_.wait_for(lock, grace, is_over)) return;
  if (outputs_ != nullptr) outputs_->abandon();
  std::fputs("stopped; nothing was written\n", stderr);
  std::_Exit(interrupted_exit_code);  // the other threads compute, and hold nothing that outlives them
}

}  // namespace sinew::apps

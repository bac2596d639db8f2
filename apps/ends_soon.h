// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <condition_variable>
#include <mutex>
#include <thread>

#include "apps/outputs.h"

namespace sinew::apps {

// While one of these lives, Ctrl-C ends the program within two seconds: a long computation asks only now and then whether to stop, and
// where it has not stopped by itself after a second, the program ends as if it had. For commands that write nothing before they are done;
// to be gone before they write.
class EndsSoon {
 public:
  // `outputs`: the folder that is let go of; null where there is none.
  explicit EndsSoon(Outputs* outputs);
  ~EndsSoon();
  EndsSoon(const EndsSoon&) = delete;
  EndsSoon& operator=(const EndsSoon&) = delete;

 private:
  void watch();
  Outputs* outputs_;
  bool over_ = false;
  std::mutex mutex_;
  std::condition_variable changed_;
  std::thread watcher_;
};

}  // namespace sinew::apps

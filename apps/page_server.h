// SPDX-License-Identifier: Apache-2.0
// A page for browsers on this machine alone (127.0.0.1), and events that follow it (server-sent events, HTML Living Standard, 9.2).
//
// All is done by one thread of its own. Each browser gets every event that is kept, from the first one on, at its own pace: one that is
// slow, or away for a while, loses what is no longer kept, and takes nothing from anyone else.
#pragma once

#include <functional>
#include <memory>
#include <string>
#include <string_view>

namespace sinew::apps {

class PageServer {
 public:
  // Listens; nobody is answered yet. Throws sim::InputError where the port cannot be had.
  explicit PageServer(int port);
  // What was emitted until now still goes out to browsers that take it within a second.
  ~PageServer();
  PageServer(const PageServer&) = delete;
  PageServer& operator=(const PageServer&) = delete;

  // `data`: one line.
  using Emit = std::function<void(std::string_view event, const std::string& data)>;
  // Answers from now on: `document` at /, events at /events. The thread asks `next` fifty times a second what there is to emit. What
  // is emitted as `opening` begins the story anew: it comes first to whoever has missed it.
  void start(std::string document, std::string opening, std::function<void(const Emit&)> next);

 private:
  class Implementation;
  std::unique_ptr<Implementation> implementation_;
};

}  // namespace sinew::apps

// SPDX-License-Identifier: Apache-2.0
// What `hil` and `investigate` show with --page: sessions as they go on, in a browser on this machine.
#pragma once

#include <optional>
#include <string>

#include "apps/app.h"
#include "apps/handover.h"
#include "apps/page_server.h"
#include "hil/limb_parts.h"
#include "hil/session.h"

namespace sinew::apps {

inline constexpr int first_page_port = 1024;  // those below are for root
void add_page(CLI::App& command, std::optional<int>& port);

class LivePage {
 public:
  struct Shows {
    std::string title;
    bool twin = false, predictor = false;
  };
  // Throws sim::InputError where the port cannot be had.
  LivePage(int port, const plant::Plant& limb, const Shows& shows);

  // By one thread, or by several one at a time. None of these waits; what finds no room is not shown.
  void begin(const std::string& session, double duration_s);
  void show(const hil::SessionView& now, std::optional<double> predicted_deg);
  void say(const std::string& line);
  // The last that is shown. Waits, half a second at most, until there is room.
  void end(const std::string& words);

 private:
  struct Slot {
    enum class Kind { begin, sample, said, end } kind = Kind::said;
    std::string words;
    double duration_s = 0.0;
    hil::SessionView view;
    std::optional<double> predicted_deg;
  };
  std::string sample(const Slot& slot) const;
  std::shared_ptr<const plant::System> system_;
  hil::LimbParts parts_;
  Shows shows_;
  double next_s_ = 0.0;  // nothing earlier is shown
  Handover<Slot> slots_{1024};
  PageServer server_;  // last: its thread ends first
};

}  // namespace sinew::apps

// SPDX-License-Identifier: Apache-2.0
#include "apps/live_page.h"

#include <array>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <nlohmann/json.hpp>
#include <thread>

#include "report/page.h"
#include "sim/manifest.h"

namespace sinew::apps {
namespace {

// Twenty samples a second are shown of a session that has more.
constexpr double shortest_step_s = 0.05;

constexpr std::array colors_of_parts{report::okabe_ito::blue,   report::okabe_ito::vermillion, report::okabe_ito::green,
                                     report::okabe_ito::purple, report::okabe_ito::orange,     report::okabe_ito::sky_blue};
std::string color_of_part(std::size_t index) { return colors_of_parts[index % colors_of_parts.size()]; }

// Nothing is there yet: a time axis to begin with, and series that will come.
report::TimePlot live_plot(std::string title, std::string label, std::vector<report::Series> series, int height_px) {
  report::TimePlot plot;
  plot.title = std::move(title);
  plot.y_label = std::move(label);
  plot.time_s = {0.0, 1.0};
  for (report::Series& one : series) one.y = {std::nan(""), std::nan("")};
  plot.series = std::move(series);
  plot.height_px = height_px;
  plot.time_axis = "session";
  return plot;
}

report::Series live_line(std::string name, std::string color, int decimals, report::Series::Style style = report::Series::Style::line) {
  report::Series series = report::line(std::move(name), {}, std::move(color), style);
  series.decimals = decimals;
  return series;
}

report::Page live_page_of(const plant::System& system, const hil::LimbParts& parts, const LivePage::Shows& shows) {
  using Style = report::Series::Style;
  const auto words = [&](plant::ChannelId channel) { return system.channels()[channel].words; };
  std::vector<report::Series> temperatures, duty, angles, off_K, off_deg;
  for (std::size_t k = 0; k < parts.thermocouples.size(); ++k) {
    temperatures.push_back(live_line(words(parts.thermocouples[k]), color_of_part(k), 2));
    off_K.push_back(live_line(words(parts.thermocouples[k]), color_of_part(k), 2));
  }
  for (const hil::Coil& coil : parts.coils) {
    temperatures.push_back(
        live_line("coil " + coil.name + ", predicted at its hottest", color_of_part(coil.thermocouple), 1, Style::dashed));
    duty.push_back(live_line("coil " + coil.name, color_of_part(coil.thermocouple), 3, Style::steps));
  }
  for (std::size_t k = 0; k < parts.angles.size(); ++k) {
    angles.push_back(live_line(words(parts.angles[k]), color_of_part(k), 2));
    off_deg.push_back(live_line(words(parts.angles[k]), color_of_part(k), 2));
  }
  if (shows.predictor && !parts.angles.empty()) angles.push_back(live_line("predictor, in open loop", color_of_part(1), 2, Style::dashed));

  report::Page page;
  page.title = shows.title;
  page.lead = "A session while it runs. Nothing here steers the limb, and the recording is whole whatever this page misses.";
  page.events = "events";
  page.blocks.push_back(live_plot("Temperatures", "temperature / °C", temperatures, 200));
  if (!angles.empty()) page.blocks.push_back(live_plot("Bend angle", "angle / °", angles, 180));
  page.blocks.push_back(live_plot("Duty at the pins", "duty", duty, 110));
  if (shows.twin) {
    page.blocks.push_back(live_plot("Temperatures, measured − twin", "difference / K", off_K, 130));
    if (!off_deg.empty()) page.blocks.push_back(live_plot("Bend angle, measured − twin", "difference / °", off_deg, 130));
  }
  page.footer = {"sinew " + sim::this_build().version + " (" + sim::this_build().commit + ")"};
  return page;
}

// JSON has no NaN: null.
void put_number(nlohmann::json& list, double value) { std::isfinite(value) ? list.push_back(value) : list.push_back(nullptr); }

std::string json_text(const std::string& words) {
  return nlohmann::json(words).dump(-1, ' ', true, nlohmann::json::error_handler_t::replace);
}

}  // namespace

void add_page(CLI::App& command, std::optional<int>& port) {
  command.add_option("--page", port, "show it in a browser on this machine, at http://127.0.0.1:PORT/")
      ->option_text("PORT")
      ->check(CLI::Range(first_page_port, 65535));
}

LivePage::LivePage(int port, const plant::Plant& limb, const Shows& shows)
    : system_(limb.shared_system()), parts_(hil::parts_of(limb)), shows_(shows), server_(port) {
  server_.start(report::to_html(live_page_of(*system_, parts_, shows_)), "begin", [this](const PageServer::Emit& emit) {
    slots_.take([&](const Slot& slot) {
      switch (slot.kind) {
        case Slot::Kind::begin:
          return emit("begin", nlohmann::json{{"name", slot.words}, {"duration_s", slot.duration_s}}.dump());
        case Slot::Kind::sample:
          return emit("sample", sample(slot));
        case Slot::Kind::said:
          return emit("said", json_text(slot.words));
        case Slot::Kind::end:
          return emit("end", json_text(slot.words));
      }
    });
  });
  std::fprintf(stderr, "page: http://127.0.0.1:%d/\n", port);
}

void LivePage::begin(const std::string& session, double duration_s) {
  next_s_ = 0.0;
  slots_.put([&](Slot& slot) {
    slot.kind = Slot::Kind::begin;
    slot.words = session;
    slot.duration_s = duration_s;
  });
}

void LivePage::show(const hil::SessionView& now, std::optional<double> predicted_deg) {
  if (now.time_s < next_s_ - 1e-9) return;
  next_s_ = now.time_s + shortest_step_s;
  slots_.put([&](Slot& slot) {
    slot.kind = Slot::Kind::sample;
    slot.view = now;
    slot.predicted_deg = predicted_deg;
  });
}

void LivePage::say(const std::string& line) {
  slots_.put([&](Slot& slot) {
    slot.kind = Slot::Kind::said;
    slot.words = line;
  });
}

void LivePage::end(const std::string& words) {
  for (int k = 0; k < 50; ++k) {
    const bool given = slots_.put([&](Slot& slot) {
      slot.kind = Slot::Kind::end;
      slot.words = words;
    });
    if (given) return;
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
  }
}

// In the order of live_page_of.
std::string LivePage::sample(const Slot& slot) const {
  const hil::SessionView& v = slot.view;
  nlohmann::json temperatures = nlohmann::json::array(), angles = temperatures, duty = temperatures, off_K = temperatures,
                 off_deg = temperatures;
  for (const plant::ChannelId channel : parts_.thermocouples) {
    put_number(temperatures, v.measured.channels[channel.index]);
    if (v.residual) put_number(off_K, (*v.residual)[channel.index]);
  }
  for (std::size_t j = 0; j < parts_.coils.size(); ++j) {
    put_number(temperatures, v.predicted_degC[j]);
    put_number(duty, v.duty_fraction[j]);
  }
  for (const plant::ChannelId channel : parts_.angles) {
    put_number(angles, v.measured.channels[channel.index]);
    if (v.residual) put_number(off_deg, (*v.residual)[channel.index]);
  }
  if (shows_.predictor && !parts_.angles.empty()) put_number(angles, slot.predicted_deg.value_or(std::nan("")));
  nlohmann::json plots = nlohmann::json::array({temperatures});
  if (!parts_.angles.empty()) plots.push_back(angles);
  plots.push_back(duty);
  if (shows_.twin) {
    plots.push_back(off_K);
    if (!parts_.angles.empty()) plots.push_back(off_deg);
  }
  std::string state = v.state == DEVICE_ARMED ? "armed" : v.state == DEVICE_TRIPPED ? "TRIPPED" : "disarmed";
  if (v.lowered) state += ", duty lowered by the host";
  return nlohmann::json{{"t", v.time_s}, {"plots", plots}, {"state", state}}.dump();
}

}  // namespace sinew::apps

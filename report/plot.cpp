// SPDX-License-Identifier: Apache-2.0
#include "report/plot.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <stdexcept>
#include <string_view>

namespace sinew::report {

namespace {

constexpr std::array<std::string_view, 7> palette{okabe_ito::blue,   okabe_ito::vermillion, okabe_ito::green, okabe_ito::purple,
                                                  okabe_ito::orange, okabe_ito::sky_blue,   okabe_ito::black};

[[noreturn]] void refuse(const std::string& plot, const std::string& what) {
  throw std::invalid_argument("plot \"" + plot + "\": " + what);
}

void check_length(const std::string& plot, const std::string& series, std::string_view column, std::size_t found, std::size_t wanted) {
  if (found == wanted) return;
  refuse(plot, "series \"" + series + "\" has " + std::to_string(found) + " values of " + std::string(column) + " for " +
                   std::to_string(wanted) + " points");
}

void check_times(const std::string& plot, const std::vector<double>& time_s) {
  for (std::size_t i = 0; i < time_s.size(); ++i) {
    if (!std::isfinite(time_s[i])) refuse(plot, "time " + std::to_string(i) + " is not finite");
    if (i > 0 && time_s[i] < time_s[i - 1]) refuse(plot, "time falls at row " + std::to_string(i));
  }
}

// Colours end up in style sheets and attributes, so only the one spelling is let through.
void check_color(const std::string& plot, const std::string& series, const std::string& color) {
  if (color.empty()) return;
  const bool hex = color.find_first_not_of("0123456789abcdefABCDEF", 1) == std::string::npos;
  if (color.size() == 7 && color[0] == '#' && hex) return;
  refuse(plot, "series \"" + series + "\" has the color \"" + color + "\", which is not of the form #rrggbb");
}

template <class AnySeries>
std::vector<std::string> assigned(const std::vector<AnySeries>& series) {
  const auto claimed = [&](std::string_view color) {
    return std::any_of(series.begin(), series.end(), [color](const AnySeries& s) { return s.color == color; });
  };
  std::vector<std::string> colors;
  std::size_t next = 0;
  for (const AnySeries& s : series) {
    if (!s.color.empty()) {
      colors.push_back(s.color);
      continue;
    }
    for (std::size_t tried = 0; tried < palette.size() && claimed(palette[next % palette.size()]); ++tried) ++next;
    colors.emplace_back(palette[next++ % palette.size()]);
  }
  return colors;
}

}  // namespace

Series line(std::string name, std::vector<double> y, std::string color, Series::Style style) {
  Series series;
  series.name = std::move(name);
  series.y = std::move(y);
  series.color = std::move(color);
  series.style = style;
  return series;
}

void check(const TimePlot& plot) {
  check_times(plot.title, plot.time_s);
  for (const Series& series : plot.series) {
    check_color(plot.title, series.name, series.color);
    check_length(plot.title, series.name, "y", series.y.size(), plot.time_s.size());
    for (const Move& move : series.moves)
      for (const std::vector<double>* values : {&move.half_way, &move.low})
        check_length(plot.title, series.name, "the slider \"" + move.slider + "\"", values->size(), plot.time_s.size());
    if (series.lower.empty() && series.upper.empty()) continue;
    check_length(plot.title, series.name, "lower", series.lower.size(), plot.time_s.size());
    check_length(plot.title, series.name, "upper", series.upper.size(), plot.time_s.size());
  }
  for (const Band& band : plot.bands) {
    if (!(band.from_s <= band.to_s)) refuse(plot.title, "band \"" + band.label + "\" ends before it begins");
  }
}

void check(const ScatterPlot& plot) {
  for (const ScatterSeries& series : plot.series) {
    check_color(plot.title, series.name, series.color);
    check_length(plot.title, series.name, "y", series.y.size(), series.x.size());
    if (series.time_s.empty()) continue;
    check_length(plot.title, series.name, "time", series.time_s.size(), series.x.size());
    check_times(plot.title, series.time_s);
  }
}

std::vector<std::string> series_colors(const TimePlot& plot) { return assigned(plot.series); }

std::vector<std::string> series_colors(const ScatterPlot& plot) { return assigned(plot.series); }

std::vector<std::size_t> band_lanes(const std::vector<Band>& bands) {
  std::vector<std::size_t> order(bands.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::stable_sort(order.begin(), order.end(), [&bands](std::size_t a, std::size_t b) { return bands[a].from_s < bands[b].from_s; });
  std::vector<std::size_t> lanes(bands.size());
  std::vector<double> lane_ends;
  for (const std::size_t band : order) {
    std::size_t lane = 0;
    while (lane < lane_ends.size() && bands[band].from_s < lane_ends[lane]) ++lane;
    if (lane == lane_ends.size()) lane_ends.emplace_back();
    lane_ends[lane] = bands[band].to_s;
    lanes[band] = lane;
  }
  return lanes;
}

std::vector<std::size_t> band_tints(const std::vector<Band>& bands) {
  std::vector<std::string> labels;
  std::vector<std::size_t> tints;
  for (const Band& band : bands) {
    const auto label = std::find(labels.begin(), labels.end(), band.label);
    tints.push_back(static_cast<std::size_t>(label - labels.begin()));
    if (label == labels.end()) labels.push_back(band.label);
  }
  return tints;
}

}  // namespace sinew::report

// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "report/axis.h"

// Plots as plain values. Labels carry their units ("temperature / °C"); this room converts nothing.

namespace sinew::report {

// Colours that the common colour-blindnesses leave apart (Okabe and Ito 2008). Yellow is for fills, not for lines.
namespace okabe_ito {
inline constexpr char black[] = "#000000";
inline constexpr char blue[] = "#0072B2";
inline constexpr char vermillion[] = "#D55E00";
inline constexpr char green[] = "#009E73";
inline constexpr char purple[] = "#CC79A7";
inline constexpr char orange[] = "#E69F00";
inline constexpr char sky_blue[] = "#56B4E9";
inline constexpr char yellow[] = "#F0E442";
}  // namespace okabe_ito

// What a slider of the page (page.h) makes of a series: its values with that slider half-way and at its low end, and all others at their
// high ends; `y` has all there. In between a parabola runs through the three, and what several sliders do is added.
struct Move {
  std::string slider{};
  std::vector<double> half_way{}, low{};  // as many as y
};

// One quantity over the times of its plot.
struct Series {
  enum class Style { line, dashed, points, steps };  // steps: a value holds until the next sample

  std::string name{};
  std::vector<double> y{};  // one value per time; NaN is a gap
  std::string color{};      // "#rrggbb"; empty: the next of the palette
  Style style = Style::line;
  std::optional<int> decimals{};  // with which a value is read out; otherwise what the data need

  // An area around the line, such as a 95 % interval: both empty, or one value per time each.
  std::vector<double> lower{};
  std::vector<double> upper{};

  std::vector<Move> moves{};
};

Series line(std::string name, std::vector<double> y, std::string color, Series::Style style = Series::Style::line);

// A stretch of time that is shaded and named.
struct Band {
  double from_s = 0.0;
  double to_s = 0.0;
  std::string label{};  // bands of one label share a tint
};

struct TimePlot {
  std::string title{};
  std::string y_label{};         // with its unit
  std::vector<double> time_s{};  // finite, never falling
  std::vector<Series> series{};
  std::vector<Band> bands{};
  std::string caption{};
  std::optional<Range> y_range{};  // otherwise what the data in view need
  int height_px = 200;             // of the plot area; in a stacked figure, its share of the height
  std::string time_axis{};         // plots that name the same time axis zoom, pan and point together
};

// Points in the order in which they are joined.
struct ScatterSeries {
  enum class Style { points, path, dashed };

  std::string name{};
  std::vector<double> x{};
  std::vector<double> y{};       // as many; NaN in either is a gap
  std::vector<double> time_s{};  // empty, or when each point was: links it to the time plots
  std::string color{};
  Style style = Style::points;
  bool arrows = false;  // on a path: which way it was run through
};

// One quantity against another: a residual against temperature, a hysteresis loop.
struct ScatterPlot {
  std::string title{};
  std::string x_label{};
  std::string y_label{};
  std::vector<ScatterSeries> series{};
  std::string caption{};
  int height_px = 320;
  std::string time_axis{};  // the time axis that the points' times belong to
};

// What every rendering demands of a plot: columns as long as their times, times that are finite and never fall,
// bands that end after they begin, colours that are #rrggbb. Throws std::invalid_argument, naming the plot and the
// series.
void check(const TimePlot& plot);
void check(const ScatterPlot& plot);

// The colour of each series: its own, or the next of the palette that no series of the plot has claimed.
std::vector<std::string> series_colors(const TimePlot& plot);
std::vector<std::string> series_colors(const ScatterPlot& plot);

// Where the names of bands stand so that overlapping ones do not cover each other: a lane from 0 for each band, as
// few lanes as can be.
std::vector<std::size_t> band_lanes(const std::vector<Band>& bands);
// The tint of each band: 0 for the first label, 1 for the next new one, and so on.
std::vector<std::size_t> band_tints(const std::vector<Band>& bands);

}  // namespace sinew::report

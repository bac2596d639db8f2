// SPDX-License-Identifier: Apache-2.0
#include "report/svg.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <set>
#include <span>
#include <stdexcept>
#include <string_view>
#include <utility>

#include "report/decimate.h"
#include "report/number.h"
#include "report/text.h"

namespace sinew::report {

namespace {

constexpr double font_px = 11.0;
constexpr double title_px = 12.0;
constexpr double row_px = 17.0;  // of title and legend
constexpr double band_row_px = 13.0;
constexpr double tick_px = 4.0;
constexpr double panel_gap_px = 10.0;
constexpr double swatch_px = 20.0;
constexpr double least_area_px = 24.0;  // what a plot area must have either way

constexpr std::string_view font_family = "Helvetica, Arial, 'Liberation Sans', 'DejaVu Sans', sans-serif";
constexpr std::string_view ink = "#222222";
constexpr std::string_view axis_ink = "#555555";
constexpr std::string_view grid_ink = "#e8e8e8";
constexpr std::string_view zero_ink = "#b4b4b4";
constexpr std::array<std::string_view, 5> tints{"#56B4E9", "#E69F00", "#009E73", "#CC79A7", "#8C8C8C"};

struct Box {
  double x = 0.0, y = 0.0, w = 0.0, h = 0.0;
  double right() const { return x + w; }
  double bottom() const { return y + h; }
};

// Where a plot's numbers lie on the paper.
struct Scale {
  Box area;
  Range x, y;
  double px(double value) const { return area.x + (value - x.low) / (x.high - x.low) * area.w; }
  double py(double value) const { return area.bottom() - (value - y.low) / (y.high - y.low) * area.h; }
};

std::string n(double value) { return compact(value, 2); }
// On the middle of a pixel, where a thin line is sharpest.
std::string crisp(double value) { return compact(std::floor(value) + 0.5, 1); }

// Widths of the printable ASCII characters in em/1000: of Helvetica or DejaVu Sans, whichever runs wider, since the
// reader's machine may have either.
constexpr std::array<int, 95> widths{318, 401, 460, 838, 636, 950, 780, 275, 390, 390, 500, 838, 318, 361,  318, 337, 636, 636, 636,
                                     636, 636, 636, 636, 636, 636, 636, 337, 337, 838, 838, 838, 556, 1015, 684, 686, 722, 770, 667,
                                     611, 778, 752, 295, 500, 667, 557, 863, 748, 787, 667, 787, 722, 667,  611, 732, 684, 989, 685,
                                     667, 685, 390, 337, 390, 838, 556, 500, 613, 635, 550, 635, 615, 352,  635, 634, 278, 278, 579,
                                     278, 974, 634, 612, 635, 635, 411, 521, 392, 634, 592, 818, 592, 592,  525, 636, 337, 636, 838};

double text_width(std::string_view text, double size_px) {
  double em = 0.0;
  while (!text.empty()) {
    const char32_t c = take_code_point(text);
    if (c >= 0x20 && c < 0x7F) {
      em += widths[c - 0x20];
    } else if (c >= 0x300 && c < 0x370) {
      continue;
    } else {
      em += c >= 0x1100 ? 1000 : 640;
    }
  }
  return em / 1000.0 * size_px;
}

// The text, cut short with an ellipsis where it is wider than the room.
std::string fitted(std::string_view text, double room_px, double size_px) {
  if (text_width(text, size_px) <= room_px) return std::string(text);
  std::string kept;
  while (!text.empty()) {
    std::string longer = kept;
    append_utf8(longer, take_code_point(text));
    if (text_width(longer + "\u2026", size_px) > room_px) break;
    kept = std::move(longer);
  }
  return kept.empty() ? kept : kept + "\u2026";
}

class Figure {
 public:
  Figure(int width_px, int height_px, const std::string& title) {
    const std::string width = std::to_string(width_px);
    const std::string height = std::to_string(height_px);
    out_ = "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"" + width + "\" height=\"" + height + "\" viewBox=\"0 0 " + width + " " +
           height + "\" role=\"img\" font-family=\"" + std::string(font_family) + "\" font-size=\"" + n(font_px) + "\" fill=\"" +
           std::string(ink) + "\">\n<title>" + escaped(title) + "</title>\n<rect width=\"" + width + "\" height=\"" + height +
           "\" fill=\"#ffffff\"/>\n";
  }

  std::string finished() const { return out_ + "</svg>\n"; }

  void add(std::string_view markup) { out_ += markup; }

  void text(double x, double y, std::string_view text, std::string_view attributes = {}) {
    if (text.empty()) return;
    out_ += "<text x=\"" + n(x) + "\" y=\"" + n(y) + "\"";
    if (!attributes.empty()) out_ += " " + std::string(attributes);
    out_ += ">" + escaped(text) + "</text>\n";
  }

  void line(double x0, double y0, double x1, double y1, std::string_view stroke, double width) {
    out_ += "<path d=\"M" + crisp(x0) + " " + crisp(y0) + "L" + crisp(x1) + " " + crisp(y1) + "\" stroke=\"" + std::string(stroke) +
            "\" stroke-width=\"" + n(width) + "\"/>\n";
  }

  // Whatever is added until unclip is seen inside the box alone. The name of the clip says its geometry, so that
  // figures put into one document agree on what a name means.
  void clip(const Box& box) {
    std::string id = "area-" + n(box.x) + "-" + n(box.y) + "-" + n(box.w) + "-" + n(box.h);
    std::replace(id.begin(), id.end(), '.', '_');
    out_ += "<clipPath id=\"" + id + "\"><rect x=\"" + n(box.x) + "\" y=\"" + n(box.y) + "\" width=\"" + n(box.w) + "\" height=\"" +
            n(box.h) + "\"/></clipPath>\n<g clip-path=\"url(#" + id + ")\">\n";
  }
  void unclip() { out_ += "</g>\n"; }

 private:
  std::string out_;
};

// ---- title and legend ----

enum class Mark { line, dashed, points, steps };

struct LegendEntry {
  std::string name;
  std::string color;
  Mark mark;
};

Mark mark_of(Series::Style style) {
  switch (style) {
    case Series::Style::line:
      return Mark::line;
    case Series::Style::dashed:
      return Mark::dashed;
    case Series::Style::points:
      return Mark::points;
    case Series::Style::steps:
      return Mark::steps;
  }
  return Mark::line;
}

Mark mark_of(ScatterSeries::Style style) {
  switch (style) {
    case ScatterSeries::Style::points:
      return Mark::points;
    case ScatterSeries::Style::path:
      return Mark::line;
    case ScatterSeries::Style::dashed:
      return Mark::dashed;
  }
  return Mark::points;
}

template <class Plot>
std::vector<LegendEntry> legend_of(const Plot& plot) {
  const std::vector<std::string> colors = series_colors(plot);
  std::vector<LegendEntry> entries;
  for (std::size_t i = 0; i < plot.series.size(); ++i) {
    if (plot.series[i].name.empty()) continue;
    entries.push_back({plot.series[i].name, colors[i], mark_of(plot.series[i].style)});
  }
  return entries;
}

// Title and legend, flowing into as many rows as they need. Draws nothing without a figure; returns their height.
double head(Figure* figure, const std::string& title, const std::vector<LegendEntry>& entries, double x, double y, double width) {
  if (title.empty() && entries.empty()) return 6.0;
  double at = x;
  double row = 0.0;
  if (!title.empty()) {
    const std::string shown = fitted(title, width, title_px);
    if (figure != nullptr) {
      figure->text(at, y + 12.0, shown, "font-size=\"" + n(title_px) + "\" font-weight=\"bold\"");
    }
    at += text_width(shown, title_px) * 1.12 + 12.0;  // bold runs wider
  }
  for (const LegendEntry& entry : entries) {
    const std::string shown = fitted(entry.name, width - swatch_px - 5.0, font_px);
    const double entry_width = swatch_px + 5.0 + text_width(shown, font_px);
    if (at > x && at + entry_width > x + width) {
      at = x;
      row += row_px;
    }
    if (figure != nullptr) {
      const double middle = y + row + 8.0;
      const std::string left = n(at);
      switch (entry.mark) {
        case Mark::points:
          for (const double dx : {4.0, 10.0, 16.0}) {
            figure->add("<circle cx=\"" + n(at + dx) + "\" cy=\"" + n(middle) + "\" r=\"1.8\" fill=\"" + entry.color + "\"/>\n");
          }
          break;
        case Mark::steps:
          figure->add("<path d=\"M" + left + " " + n(middle + 3.0) + "h6v-6h8v6h6\" fill=\"none\" stroke=\"" + entry.color +
                      "\" stroke-width=\"1.3\"/>\n");
          break;
        case Mark::line:
        case Mark::dashed:
          figure->add("<path d=\"M" + left + " " + n(middle) + "h" + n(swatch_px) + "\" stroke=\"" + entry.color +
                      "\" stroke-width=\"1.6\"" + (entry.mark == Mark::dashed ? " stroke-dasharray=\"5 2.5\"" : "") + "/>\n");
          break;
      }
      figure->text(at + swatch_px + 5.0, y + row + 12.0, shown);
    }
    at += entry_width + 13.0;
  }
  return row + row_px + 2.0;
}

// ---- axes ----

Ticks x_ticks(Range range, double width_px) { return nice_ticks(range, static_cast<int>(width_px / 62.0)); }
Ticks y_ticks(Range range, double height_px) { return nice_ticks(range, static_cast<int>(height_px / 22.0)); }

double widest_label(const Ticks& ticks) {
  double width = 0.0;
  for (const double value : ticks.values) width = std::max(width, text_width(tick_label(value, ticks), font_px));
  return width;
}

void draw_grid(Figure& figure, const Scale& scale, const Ticks& across, const Ticks& up) {
  const Box& area = scale.area;
  for (const double value : across.values) {
    figure.line(scale.px(value), area.y, scale.px(value), area.bottom(), grid_ink, 0.7);
  }
  for (const double value : up.values) {
    figure.line(area.x, scale.py(value), area.right(), scale.py(value), grid_ink, 0.7);
  }
  if (scale.y.low < 0.0 && scale.y.high > 0.0) {
    figure.line(area.x, scale.py(0.0), area.right(), scale.py(0.0), zero_ink, 0.8);
  }
}

void draw_axes(Figure& figure, const Scale& scale, const Ticks& across, const Ticks& up, bool label_across, const std::string& y_label) {
  const Box& area = scale.area;
  figure.line(area.x, area.y, area.x, area.bottom(), axis_ink, 0.8);
  figure.line(area.x, area.bottom(), area.right(), area.bottom(), axis_ink, 0.8);
  for (const double value : across.values) {
    const double x = scale.px(value);
    figure.line(x, area.bottom(), x, area.bottom() + tick_px, axis_ink, 0.8);
    if (label_across) {
      figure.text(x, area.bottom() + tick_px + 11.0, tick_label(value, across), "text-anchor=\"middle\"");
    }
  }
  for (const double value : up.values) {
    const double y = scale.py(value);
    figure.line(area.x - tick_px, y, area.x, y, axis_ink, 0.8);
    figure.text(area.x - tick_px - 3.0, y + 3.9, tick_label(value, up), "text-anchor=\"end\"");
  }
  const double middle = area.y + area.h / 2.0;
  figure.text(12.0, middle, fitted(y_label, area.h + 16.0, font_px),
              "text-anchor=\"middle\" transform=\"rotate(-90 12 " + n(middle) + ")\"");
}

// ---- data ----

// A path through the points of the rows; a gap lifts the pen, and a point alone between gaps becomes a dot.
std::string path(const Scale& scale, std::span<const double> x, std::span<const double> y, const std::vector<std::size_t>& rows, bool steps,
                 const std::string& color, bool dashed) {
  std::string d;
  std::string dots;
  std::string start;  // "M x y" of a stroke that has only begun
  std::string last;
  bool down = false;
  const auto lift = [&] {
    if (!start.empty()) {
      const std::size_t space = start.find(' ');
      dots +=
          "<circle cx=\"" + start.substr(1, space - 1) + "\" cy=\"" + start.substr(space + 1) + "\" r=\"1.3\" fill=\"" + color + "\"/>\n";
    }
    start.clear();
    down = false;
  };
  for (const std::size_t row : rows) {
    if (!std::isfinite(x[row]) || !std::isfinite(y[row])) {
      lift();
      continue;
    }
    const std::string px = n(scale.px(x[row]));
    const std::string py = n(scale.py(y[row]));
    const std::string here = px + " " + py;
    if (!down) {
      start = "M" + here;
    } else if (here != last) {
      d += std::exchange(start, {}) + (steps ? "H" + px + "V" + py : "L" + here);
    }
    down = true;
    last = here;
  }
  lift();
  if (d.empty()) return dots;
  return "<path d=\"" + d + "\" fill=\"none\" stroke=\"" + color + "\" stroke-width=\"1.1\" stroke-linejoin=\"round\"" +
         (dashed ? " stroke-dasharray=\"5 2.5\"" : "") + "/>\n" + dots;
}

// Circles at the points of the rows; one that would lie on another of its series is left out.
std::string circles(const Scale& scale, std::span<const double> x, std::span<const double> y, const std::vector<std::size_t>& rows,
                    const std::string& color, double radius) {
  std::set<std::pair<long, long>> taken;
  std::string out = "<g fill=\"" + color + "\" fill-opacity=\"" + (rows.size() > 400 ? "0.6" : "0.85") + "\">\n";
  for (const std::size_t row : rows) {
    if (!std::isfinite(x[row]) || !std::isfinite(y[row])) continue;
    const double px = scale.px(x[row]);
    const double py = scale.py(y[row]);
    if (!(std::abs(px) < 1e6 && std::abs(py) < 1e6)) continue;
    if (!taken.emplace(std::lround(px * 2.0), std::lround(py * 2.0)).second) continue;
    out += "<circle cx=\"" + n(px) + "\" cy=\"" + n(py) + "\" r=\"" + n(radius) + "\"/>\n";
  }
  return out + "</g>\n";
}

std::string area_path(const Scale& scale, const std::vector<double>& time_s, const Series& series, const std::vector<std::size_t>& rows) {
  const auto known = [&series](std::size_t row) { return std::isfinite(series.lower[row]) && std::isfinite(series.upper[row]); };
  std::string d;
  for (std::size_t begin = 0; begin < rows.size();) {
    if (!known(rows[begin])) {
      ++begin;
      continue;
    }
    std::size_t end = begin;
    while (end < rows.size() && known(rows[end])) ++end;
    for (std::size_t i = begin; i < end; ++i) {
      d += (i == begin ? "M" : "L") + n(scale.px(time_s[rows[i]])) + " " + n(scale.py(series.upper[rows[i]]));
    }
    for (std::size_t i = end; i-- > begin;) {
      d += "L" + n(scale.px(time_s[rows[i]])) + " " + n(scale.py(series.lower[rows[i]]));
    }
    d += "Z";
    begin = end;
  }
  return d;
}

// Rows enough that no reader of the printed figure misses one.
std::size_t rows_for(double width_px) { return static_cast<std::size_t>(4.0 * std::max(width_px, 1.0)); }

void draw_series(Figure& figure, const Scale& scale, const TimePlot& plot) {
  const std::vector<std::string> colors = series_colors(plot);
  for (std::size_t i = 0; i < plot.series.size(); ++i) {
    const Series& series = plot.series[i];
    if (series.lower.empty()) continue;
    const std::vector<std::span<const double>> edges{series.lower, series.upper};
    const auto rows = rows_to_draw(plot.time_s.size(), edges, rows_for(scale.area.w));
    figure.add("<path d=\"" + area_path(scale, plot.time_s, series, rows) + "\" fill=\"" + colors[i] + "\" fill-opacity=\"0.22\"/>\n");
  }
  for (std::size_t i = 0; i < plot.series.size(); ++i) {
    const Series& series = plot.series[i];
    const std::vector<std::span<const double>> columns{series.y};
    const auto rows = rows_to_draw(plot.time_s.size(), columns, rows_for(scale.area.w));
    if (series.style == Series::Style::points) {
      figure.add(circles(scale, plot.time_s, series.y, rows, colors[i], 1.3));
      continue;
    }
    figure.add(
        path(scale, plot.time_s, series.y, rows, series.style == Series::Style::steps, colors[i], series.style == Series::Style::dashed));
  }
}

// Four arrows, evenly spaced along the path; each looks some pixels back for its direction, past the noise.
void draw_arrows(Figure& figure, const Scale& scale, const ScatterSeries& series, const std::string& color) {
  constexpr int arrows = 4;
  constexpr double stride_px = 4.0;
  constexpr std::size_t look_back = 4;
  struct Point {
    double x, y, length;
  };
  std::vector<Point> points;
  for (std::size_t i = 0; i < series.x.size(); ++i) {
    if (!std::isfinite(series.x[i]) || !std::isfinite(series.y[i])) continue;
    Point point{scale.px(series.x[i]), scale.py(series.y[i]), 0.0};
    if (!points.empty()) {
      const double step = std::hypot(point.x - points.back().x, point.y - points.back().y);
      if (step < stride_px) continue;
      point.length = points.back().length + step;
    }
    points.push_back(point);
  }
  int drawn = 0;
  for (std::size_t i = look_back; i < points.size() && drawn < arrows; ++i) {
    if (points[i].length < points.back().length * (drawn + 0.5) / arrows) continue;
    ++drawn;
    const double turn = std::atan2(points[i].y - points[i - look_back].y, points[i].x - points[i - look_back].x);
    figure.add("<path d=\"M4.5 0L-4 3.6V-3.6Z\" fill=\"" + color + "\" transform=\"translate(" + n(points[i].x) + " " + n(points[i].y) +
               ") rotate(" + compact(turn * 180.0 / std::numbers::pi, 1) + ")\"/>\n");
  }
}

void draw_series(Figure& figure, const Scale& scale, const ScatterPlot& plot) {
  const std::vector<std::string> colors = series_colors(plot);
  for (std::size_t i = 0; i < plot.series.size(); ++i) {
    const ScatterSeries& series = plot.series[i];
    const std::vector<std::span<const double>> columns{series.x, series.y};
    if (series.style == ScatterSeries::Style::points) {
      const auto rows = rows_to_draw(series.x.size(), columns, 20'000);
      figure.add(circles(scale, series.x, series.y, rows, colors[i], series.x.size() > 1000 ? 1.2 : 1.7));
      continue;
    }
    const auto rows = rows_to_draw(series.x.size(), columns, 4 * rows_for(scale.area.w));
    figure.add(path(scale, series.x, series.y, rows, false, colors[i], series.style == ScatterSeries::Style::dashed));
    if (series.arrows) draw_arrows(figure, scale, series, colors[i]);
  }
}

void draw_band_tints(Figure& figure, const Scale& scale, const std::vector<Band>& bands) {
  const std::vector<std::size_t> tint = band_tints(bands);
  for (std::size_t i = 0; i < bands.size(); ++i) {
    const double left = std::max(scale.px(bands[i].from_s), scale.area.x);
    const double right = std::min(scale.px(bands[i].to_s), scale.area.right());
    if (right < left) continue;
    figure.add("<rect x=\"" + n(left) + "\" y=\"" + n(scale.area.y) + "\" width=\"" + n(std::max(right - left, 0.5)) + "\" height=\"" +
               n(scale.area.h) + "\" fill=\"" + std::string(tints[tint[i] % tints.size()]) + "\" fill-opacity=\"0.14\"><title>" +
               escaped(bands[i].label) + "</title></rect>\n");
  }
}

double band_names_height(const std::vector<Band>& bands) {
  const std::vector<std::size_t> lanes = band_lanes(bands);
  if (lanes.empty()) return 0.0;
  return band_row_px * static_cast<double>(1 + *std::max_element(lanes.begin(), lanes.end()));
}

// Above the plot area, each with the room up to the next name of its lane.
void draw_band_names(Figure& figure, const Scale& scale, const std::vector<Band>& bands, double top) {
  const std::vector<std::size_t> tint = band_tints(bands);
  const std::vector<std::size_t> lanes = band_lanes(bands);
  for (std::size_t i = 0; i < bands.size(); ++i) {
    const double left = std::max(scale.px(bands[i].from_s), scale.area.x);
    if (bands[i].label.empty() || left > scale.area.right() || scale.px(bands[i].to_s) < scale.area.x) continue;
    double right = scale.area.right();
    for (std::size_t k = 0; k < bands.size(); ++k) {
      if (k == i || lanes[k] != lanes[i] || bands[k].label.empty() || bands[k].from_s < bands[i].from_s) continue;
      right = std::min(right, scale.px(bands[k].from_s));
    }
    const std::string shown = fitted(bands[i].label, right - left - 8.0, 10.0);
    if (shown.empty()) continue;
    const double y = top + band_row_px * static_cast<double>(lanes[i]);
    figure.add("<path d=\"M" + n(left + 0.75) + " " + n(y + 1.0) + "v" + n(band_row_px - 2.5) + "\" stroke=\"" +
               std::string(tints[tint[i] % tints.size()]) + "\" stroke-width=\"1.5\"/>\n");
    figure.text(left + 4.5, y + 9.0, shown, "font-size=\"10\" fill=\"#555555\"");
  }
}

Range y_range_of(const TimePlot& plot) {
  if (plot.y_range) return *plot.y_range;
  Range range = no_range;
  for (const Series& series : plot.series) {
    for (const auto* column : {&series.y, &series.lower, &series.upper}) range = including(range, *column);
  }
  return padded(range, 0.05);
}

void require_room(const Box& area) {
  if (area.w >= least_area_px && area.h >= least_area_px) return;
  throw std::invalid_argument("the figure's size leaves no room for its data beside axes and legends");
}

bool same(const std::vector<Band>& a, const std::vector<Band>& b) {
  return std::equal(a.begin(), a.end(), b.begin(), b.end(),
                    [](const Band& p, const Band& q) { return p.from_s == q.from_s && p.to_s == q.to_s && p.label == q.label; });
}

}  // namespace

std::string to_svg(const TimePlot& plot, int width_px, int height_px) { return stacked_svg({plot}, width_px, height_px); }

std::string stacked_svg(const std::vector<TimePlot>& plots, int width_px, int height_px) {
  std::string title;
  Range time = no_range;
  double shares = 0.0;
  for (const TimePlot& plot : plots) {
    check(plot);
    title += (title.empty() || plot.title.empty() ? "" : "; ") + plot.title;
    time = including(time, plot.time_s);
    shares += std::max(plot.height_px, 1);
  }
  if (is_empty(time)) time = {};
  if (!(time.low < time.high)) time = {time.low - 0.5, time.high + 0.5};

  // The left margin is found with ticks for a panel of common height: labels differ by a digit at most from the final.
  double labels_px = 0.0;
  bool named = false;
  for (const TimePlot& plot : plots) {
    labels_px = std::max(labels_px, widest_label(y_ticks(y_range_of(plot), std::max(plot.height_px, 66))));
    named = named || !plot.y_label.empty();
  }
  Box area;
  area.x = std::ceil(labels_px + tick_px + 5.0 + (named ? 19.0 : 4.0));
  area.w = width_px - area.x - 12.0;
  const Ticks across = x_ticks(time, area.w);

  constexpr double bottom_px = tick_px + 12.0 + 17.0;
  double heads_px = 0.0;
  std::vector<double> head_px;
  std::vector<double> names_px;
  for (std::size_t i = 0; i < plots.size(); ++i) {
    head_px.push_back(head(nullptr, plots[i].title, legend_of(plots[i]), area.x, 0.0, area.w));
    const bool repeats = i > 0 && same(plots[i].bands, plots[i - 1].bands);
    names_px.push_back(repeats ? 0.0 : band_names_height(plots[i].bands));
    heads_px += head_px.back() + names_px.back() + (i > 0 ? panel_gap_px : 0.0);
  }
  const double areas_px = height_px - heads_px - bottom_px - 4.0;

  Figure figure(width_px, height_px, title);
  double y = 4.0;
  for (std::size_t i = 0; i < plots.size(); ++i) {
    const TimePlot& plot = plots[i];
    if (i > 0) y += panel_gap_px;
    area.y = y + head_px[i] + names_px[i];
    area.h = std::floor(areas_px * std::max(plot.height_px, 1) / shares);
    require_room(area);
    const Scale scale{area, time, y_range_of(plot)};
    const Ticks up = y_ticks(scale.y, area.h);
    head(&figure, plot.title, legend_of(plot), area.x, y, area.w);
    if (names_px[i] > 0.0) draw_band_names(figure, scale, plot.bands, y + head_px[i]);
    draw_band_tints(figure, scale, plot.bands);
    draw_grid(figure, scale, across, up);
    figure.clip(area);
    draw_series(figure, scale, plot);
    figure.unclip();
    draw_axes(figure, scale, across, up, i + 1 == plots.size(), plot.y_label);
    y = area.bottom();
  }
  figure.text(area.x + area.w / 2.0, y + tick_px + 12.0 + 13.0, "time / s", "text-anchor=\"middle\"");
  return figure.finished();
}

std::string to_svg(const ScatterPlot& plot, int width_px, int height_px) {
  check(plot);
  Range x = no_range;
  Range y = no_range;
  for (const ScatterSeries& series : plot.series) {
    for (std::size_t i = 0; i < series.x.size(); ++i) {
      if (!std::isfinite(series.x[i]) || !std::isfinite(series.y[i])) continue;
      x = including(x, series.x[i]);
      y = including(y, series.y[i]);
    }
  }
  x = padded(x, 0.04);
  y = padded(y, 0.05);

  Box area;
  area.x = std::ceil(widest_label(y_ticks(y, height_px - 60.0)) + tick_px + 5.0 + (plot.y_label.empty() ? 4.0 : 19.0));
  area.w = width_px - area.x - 12.0;
  const double head_px = head(nullptr, plot.title, legend_of(plot), area.x, 0.0, area.w);
  area.y = 4.0 + head_px;
  area.h = std::floor(height_px - area.y - (tick_px + 12.0 + (plot.x_label.empty() ? 4.0 : 17.0)));
  require_room(area);

  const Scale scale{area, x, y};
  const Ticks across = x_ticks(x, area.w);
  const Ticks up = y_ticks(y, area.h);
  Figure figure(width_px, height_px, plot.title);
  head(&figure, plot.title, legend_of(plot), area.x, 4.0, area.w);
  draw_grid(figure, scale, across, up);
  if (x.low < 0.0 && x.high > 0.0) figure.line(scale.px(0.0), area.y, scale.px(0.0), area.bottom(), zero_ink, 0.8);
  figure.clip(area);
  draw_series(figure, scale, plot);
  figure.unclip();
  draw_axes(figure, scale, across, up, true, plot.y_label);
  figure.text(area.x + area.w / 2.0, area.bottom() + tick_px + 12.0 + 13.0, fitted(plot.x_label, area.w, font_px),
              "text-anchor=\"middle\"");
  return figure.finished();
}

}  // namespace sinew::report

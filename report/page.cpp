// SPDX-License-Identifier: Apache-2.0
#include "report/page.h"

#include <algorithm>
#include <cmath>
#include <fstream>
#include <initializer_list>
#include <iterator>
#include <map>
#include <nlohmann/json.hpp>
#include <span>
#include <sstream>
#include <stdexcept>
#include <string_view>
#include <type_traits>

#include "report/decimate.h"
#include "report/number.h"
#include "report/page_assets.h"
#include "report/text.h"

#ifndef SINEW_DYGRAPHS_DIR
#define SINEW_DYGRAPHS_DIR "/usr/share/javascript/dygraphs"
#endif

namespace sinew::report {

namespace {

constexpr std::size_t max_points = 20'000;  // of a series, beyond which it is decimated
constexpr int x_axis_px = 18;               // below the plot area: the labels of the time axis
constexpr int selector_px = 38;             // and the range selector
constexpr int scatter_labels_px = 54;       // around a scatter plot
constexpr std::size_t band_lane_px = 16;
// In a narrow window a column of words is as wide as this allows, so that none stands at one word a line, and a table that does not fit
// scrolls. The widths in page.css belong to these.
constexpr std::size_t narrow_words_ch = 24, narrow_header_ch = 14;
constexpr std::size_t narrow_ch_px = 8, narrow_padding_px = 14;
constexpr std::size_t phone_px = 388, small_window_px = 728;  // what is left of a window of 420 px, and of 760 px
constexpr std::size_t sections_without_contents = 4;

// The MIT licence asks for this wherever the library goes.
constexpr std::string_view dygraphs_licence = R"(/*
dygraphs. Copyright (c) 2006, 2009, 2011, 2012, 2013, 2017 Dan Vanderkam; 2011 Paul Felix; 2011, 2013 Robert Konigsberg;
2013 David Eberlein; 2013 Google, Inc.; 2014, 2022, 2023 mirabilos; 2015 Petr Shevtsov; and numerous contributors.

Permission is hereby granted, free of charge, to any person obtaining a copy of this software and associated
documentation files (the "Software"), to deal in the Software without restriction, including without limitation the
rights to use, copy, modify, merge, publish, distribute, sublicense, and/or sell copies of the Software, and to permit
persons to whom the Software is furnished to do so, subject to the following conditions:

The above copyright notice and this permission notice shall be included in all copies or substantial portions of the
Software.

THE SOFTWARE IS PROVIDED "AS IS", WITHOUT WARRANTY OF ANY KIND, EXPRESS OR IMPLIED, INCLUDING BUT NOT LIMITED TO THE
WARRANTIES OF MERCHANTABILITY, FITNESS FOR A PARTICULAR PURPOSE AND NONINFRINGEMENT. IN NO EVENT SHALL THE AUTHORS OR
COPYRIGHT HOLDERS BE LIABLE FOR ANY CLAIM, DAMAGES OR OTHER LIABILITY, WHETHER IN AN ACTION OF CONTRACT, TORT OR
OTHERWISE, ARISING FROM, OUT OF OR IN CONNECTION WITH THE SOFTWARE OR THE USE OR OTHER DEALINGS IN THE SOFTWARE.
*/
)";

// ---- dygraphs ----

std::string file_text(const std::filesystem::path& path) {
  std::ifstream file(path, std::ios::binary);
  if (!file) {
    throw std::runtime_error("cannot read " + path.string() +
                             ", which draws the plots of a page: install the Debian package libjs-dygraphs");
  }
  return {std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
}

std::size_t characters(std::string_view text) {
  return static_cast<std::size_t>(
      std::count_if(text.begin(), text.end(), [](char c) { return (static_cast<unsigned char>(c) & 0xC0u) != 0x80u; }));
}

// The least width of each column in characters, in a narrow window.
std::vector<std::size_t> narrow_widths(const Table& table, const std::vector<Align>& align) {
  std::vector<std::size_t> widths(align.size(), 0);
  for (std::size_t column = 0; column < align.size(); ++column) {
    if (column < table.header.size()) widths[column] = std::min(characters(table.header[column]), narrow_header_ch);
    for (const Row& row : table.rows) {
      if (column >= row.cells.size()) continue;
      const std::size_t length = characters(row.cells[column]);
      widths[column] = std::max(widths[column], align[column] == Align::right ? length : std::min(length, narrow_words_ch));
    }
  }
  return widths;
}

void replace_all(std::string& text, std::string_view from, std::string_view to) {
  for (std::size_t at = text.find(from); at != std::string::npos; at = text.find(from, at + to.size())) {
    text.replace(at, from.size(), to);
  }
}

// The library's file without its last comment, which would make the browser look for a source map beside the page.
std::string library(const std::filesystem::path& path, std::string_view source_map_comment) {
  std::string text = file_text(path);
  const std::size_t comment = text.rfind(source_map_comment);
  if (comment != std::string::npos) text.erase(comment);
  replace_all(text, "</script", "<\\/script");
  return text + "\n";
}

// ---- numbers and strings for the script ----

std::string json_string(const std::string& text) {
  std::string out = nlohmann::json(text).dump(-1, ' ', true, nlohmann::json::error_handler_t::replace);
  replace_all(out, "<", "\\u003c");
  replace_all(out, ">", "\\u003e");
  replace_all(out, "&", "\\u0026");
  return out;
}

Range finite_range(std::span<const double> values) {
  Range range = no_range;
  for (const double value : values) range = including(range, value);
  return range;
}

// Decimals that resolve 1 / 10^digits of the values' spread (of their size where they do not spread).
int decimals_for(Range range, int digits) {
  if (is_empty(range)) return 0;
  double scale = range.high - range.low;
  if (!(scale > 0.0)) scale = std::abs(range.high);
  if (!(scale > 0.0) || !std::isfinite(scale)) return 0;
  return std::max(0, digits - static_cast<int>(std::floor(std::log10(scale))));
}

// Numbers fine enough to zoom in a hundredfold.
constexpr int embedded_digits = 5;
// Numbers as a cursor reads them out.
constexpr int shown_digits = 3;

std::string json_number(double value, int decimals) {
  if (!std::isfinite(value)) return "null";
  if (decimals > 12 || std::abs(value) >= 1e15) return scientific(value, 8);
  return compact(value, decimals);
}

std::string json_array(std::span<const double> values, const std::vector<std::size_t>& rows, int decimals) {
  std::string out = "[";
  for (const std::size_t row : rows) {
    if (out.size() > 1) out += ',';
    out += json_number(values[row], decimals);
  }
  return out + "]";
}

std::string json_values(std::span<const double> values, const std::vector<std::size_t>& rows) {
  return json_array(values, rows, decimals_for(finite_range(values), embedded_digits));
}

// The digits that the script reads values out with; -1 asks for an exponent.
int readout_decimals(std::span<const double> values) {
  const Range range = finite_range(values);
  const int decimals = decimals_for(range, shown_digits);
  const bool huge = !is_empty(range) && std::max(std::abs(range.low), std::abs(range.high)) >= 1e7;
  return decimals > 8 || huge ? -1 : decimals;
}

std::string grouped(std::size_t count) {
  std::string text = std::to_string(count);
  for (std::size_t at = text.size(); at > 3;) text.insert(at -= 3, "\u202f");
  return text;
}

// ---- time axes ----

struct TimeAxis {
  std::string name;
  Range full = no_range;
  bool has_time_plots = false;
  std::size_t last_plot = 0;  // carries the range selector
  double smallest_step_s = INFINITY;
  double mean_step_s = INFINITY;

  int embedded_decimals() const { return step_decimals(smallest_step_s) + 2; }
  int shown_decimals() const { return std::min(step_decimals(mean_step_s), 6); }

 private:
  static int step_decimals(double step_s) {
    if (!std::isfinite(step_s)) return 3;
    return std::clamp(static_cast<int>(std::ceil(-std::log10(step_s) - 1e-3)), 0, 9);
  }
};

void take_times(TimeAxis& axis, const std::vector<double>& time_s) {
  axis.full = including(axis.full, time_s);
  if (time_s.size() < 2) return;
  for (std::size_t i = 1; i < time_s.size(); ++i) {
    const double step_s = time_s[i] - time_s[i - 1];
    if (step_s > 0.0) axis.smallest_step_s = std::min(axis.smallest_step_s, step_s);
  }
  const double mean_s = (time_s.back() - time_s.front()) / static_cast<double>(time_s.size() - 1);
  if (mean_s > 0.0) axis.mean_step_s = std::min(axis.mean_step_s, mean_s);
}

// ---- the page as it grows ----

// Markup, and beside it the data that the script reads:
//
//   {"axes":  [{"full": [from, to], "decimals": of a time read out}],
//    "times": [[...], ...],                                   each once, however many plots share it
//    "plots": [{"kind": "time", "axis": i, "time": i, "y_label", "selector": bool, "range": [low, high] or null,
//               "bands":  [{"from", "to", "label", "tint": i, "lane": i}],
//               "series": [{"name", "color", "style", "digits", "y": [...], "lower", "upper" where there are,
//                           "moves" where sliders move it: [{"slider": i, "half_way", "low": [...], added to y}]}]},
//              {"kind": "scatter", "axis": i or null, "x_label", "y_label",
//               "series": [{"name", "color", "style", "arrows", "x_digits", "y_digits", "x", "y", "t" where known}]}]}
//
// Plot i belongs to the figure with the id plot-i, slider i to the input with the id slider-i; null is a gap.
class Writer {
 public:
  explicit Writer(const Page& page) {
    std::size_t plot = 0;
    for (const Block& block : page.blocks) {
      if (const auto* group = std::get_if<Sliders>(&block))
        for (const Slider& slider : group->sliders) sliders_.push_back(slider.name);
      if (const auto* time_plot = std::get_if<TimePlot>(&block)) {
        check(*time_plot);
        TimeAxis& axis = axes_[axis_index(time_plot->time_axis)];
        take_times(axis, time_plot->time_s);
        axis.has_time_plots = true;
        axis.last_plot = plot++;
      } else if (const auto* scatter = std::get_if<ScatterPlot>(&block)) {
        check(*scatter);
        ++plot;
      }
    }
    for (const Block& block : page.blocks) {
      const auto* scatter = std::get_if<ScatterPlot>(&block);
      if (scatter == nullptr) continue;
      for (const ScatterSeries& series : scatter->series) {
        if (series.time_s.empty()) continue;
        TimeAxis& axis = axes_[axis_index(scatter->time_axis)];
        if (!axis.has_time_plots) take_times(axis, series.time_s);
      }
    }
    for (TimeAxis& axis : axes_) {
      if (is_empty(axis.full)) axis.full = {};
      if (!(axis.full.low < axis.full.high)) axis.full = {axis.full.low - 0.5, axis.full.high + 0.5};
    }
    for (const Block& block : page.blocks) {
      if (!std::holds_alternative<ScatterPlot>(block)) end_scatters();
      std::visit([this](const auto& content) { write(content); }, block);
    }
    end_scatters();
    end_screen();
  }

  bool has_plots() const { return plot_count_ > 0; }
  bool has_time_plots() const { return hinted_; }
  const std::string& body() const { return body_; }
  const std::vector<std::string>& contents() const { return contents_; }

  std::string data() const {
    std::string out = "{\"axes\":[";
    for (std::size_t i = 0; i < axes_.size(); ++i) {
      const TimeAxis& axis = axes_[i];
      if (i > 0) out += ',';
      out += "{\"full\":[" + json_number(axis.full.low, axis.embedded_decimals()) + "," +
             json_number(axis.full.high, axis.embedded_decimals()) + "],\"decimals\":" + std::to_string(axis.shown_decimals()) + "}";
    }
    out += "],\n\"times\":[";
    for (std::size_t i = 0; i < times_.size(); ++i) out += (i > 0 ? ",\n" : "") + times_[i];
    return out + "],\n\"plots\":[" + plots_ + "]}";
  }

 private:
  std::vector<TimeAxis> axes_;
  std::string body_;
  bool on_screen_only_ = false;  // within what is not printed
  std::string plots_;
  std::vector<std::string> times_;
  std::map<std::string, std::size_t> index_of_times_;
  std::vector<std::string> sliders_;
  std::size_t slider_count_ = 0;
  std::vector<std::string> contents_;  // headings, in order
  std::size_t plot_count_ = 0;
  bool in_scatters_ = false;
  bool hinted_ = false;

  std::size_t axis_index(const std::string& name) {
    for (std::size_t i = 0; i < axes_.size(); ++i) {
      if (axes_[i].name == name) return i;
    }
    axes_.push_back(TimeAxis{.name = name});
    return axes_.size() - 1;
  }

  void end_scatters() {
    if (in_scatters_) body_ += "</div>\n";
    in_scatters_ = false;
  }

  void write_paragraphs(const std::string& text) {
    std::istringstream lines(text);
    std::string line;
    std::string paragraph;
    const auto flush = [&] {
      if (!paragraph.empty()) body_ += "<p>" + escaped(paragraph) + "</p>\n";
      paragraph.clear();
    };
    while (std::getline(lines, line)) {
      if (line.find_first_not_of(" \t\r") == std::string::npos) {
        flush();
      } else {
        if (!paragraph.empty()) paragraph += '\n';
        paragraph += line;
      }
    }
    flush();
  }

  void write_items(const std::vector<std::string>& items, bool numbered) {
    if (items.empty()) return;
    body_ += numbered ? "<ol>\n" : "<ul>\n";
    for (const std::string& item : items) body_ += "<li>" + escaped(item) + "</li>\n";
    body_ += numbered ? "</ol>\n" : "</ul>\n";
  }

  void write_caption(const std::string& caption) {
    if (!caption.empty()) body_ += "<p class=\"caption\">" + escaped(caption) + "</p>\n";
  }

  void end_screen() {
    if (on_screen_only_) body_ += "</div>\n";
    on_screen_only_ = false;
  }

  void write(const Section& section) {
    end_screen();
    if (section.depth <= 1) {
      contents_.push_back(section.heading);
      body_ += "<h2 id=\"section-" + std::to_string(contents_.size()) + "\">" + escaped(section.heading) + "</h2>\n";
    } else {
      body_ += "<h3>" + escaped(section.heading) + "</h3>\n";
    }
    if (section.depth > 2) {
      body_ += "<p class=\"paper\">On the screen only, to keep this short on paper.</p>\n<div class=\"screen\">\n";
      on_screen_only_ = true;
    }
    write_paragraphs(section.text);
    write_items(section.items, false);
  }

  void write(const Paragraph& paragraph) {
    switch (paragraph.tone) {
      case Paragraph::Tone::plain:
        write_paragraphs(paragraph.text);
        return;
      case Paragraph::Tone::finding:
        body_ += "<div class=\"finding\">\n";
        break;
      case Paragraph::Tone::caution:
        body_ += "<div class=\"caution\">\n";
        break;
    }
    write_paragraphs(paragraph.text);
    body_ += "</div>\n";
  }

  void write(const List& list) { write_items(list.items, list.numbered); }

  void write(const Code& code) {
    body_ += "<figure>\n<pre tabindex=\"0\"><code>" + escaped(code.text) + "</code></pre>\n";
    write_caption(code.caption);
    body_ += "</figure>\n";
  }

  void write(const Table& table) {
    const std::vector<Align> align = column_alignment(table);
    const std::vector<std::size_t> widths = narrow_widths(table, align);
    std::size_t width_px = 0;
    for (const std::size_t width : widths) width_px += width * narrow_ch_px + narrow_padding_px;
    const auto write_cells = [&](const std::vector<std::string>& cells, const std::string& element) {
      for (std::size_t column = 0; column < align.size(); ++column) {
        body_ += "<" + element;
        if (align[column] == Align::right) body_ += " class=\"right\"";
        body_ += " style=\"--least:" + std::to_string(widths[column]) + "ch\">";
        if (column < cells.size()) body_ += escaped(cells[column]);
        body_ += "</" + element.substr(0, 2) + ">";
      }
    };
    body_ += "<figure>\n";
    if (!table.title.empty()) body_ += "<figcaption>" + escaped(table.title) + "</figcaption>\n";
    if (width_px > phone_px)
      body_ += "<p class=\"scrolls" + std::string(width_px > small_window_px ? " wide" : "") + "\">This table scrolls sideways.</p>\n";
    body_ += "<div class=\"table\" tabindex=\"0\" role=\"group\" aria-label=\"" + (table.title.empty() ? "table" : escaped(table.title)) +
             "\"><table>\n";
    if (!table.header.empty()) {
      body_ += "<thead><tr>";
      write_cells(table.header, "th scope=\"col\"");
      body_ += "</tr></thead>\n";
    }
    body_ += "<tbody>\n";
    for (const Row& row : table.rows) {
      std::string classes = row.emphasis ? "emphasis" : "";
      if (!row.note.empty()) classes += classes.empty() ? "noted" : " noted";
      body_ += classes.empty() ? "<tr>" : "<tr class=\"" + classes + "\">";
      write_cells(row.cells, "td");
      body_ += "</tr>\n";
      if (row.note.empty()) continue;
      body_ += "<tr class=\"note\"><td colspan=\"" + std::to_string(align.size()) + "\">" + escaped(row.note) + "</td></tr>\n";
    }
    body_ += "</tbody>\n</table></div>\n";
    write_caption(table.caption);
    body_ += "</figure>\n";
  }

  template <class Style>
  static std::string swatch(Style style, const std::string& color) {
    std::string shape = "<path d=\"M0 5H22\" stroke-width=\"2\"/>";
    if (style == Style::points) {
      shape = "<path d=\"M4 5h0M11 5h0M18 5h0\" stroke-width=\"4.5\" stroke-linecap=\"round\"/>";
    } else if (style == Style::dashed) {
      shape = "<path d=\"M0 5H22\" stroke-width=\"2\" stroke-dasharray=\"6 3\"/>";
    }
    if constexpr (std::is_same_v<Style, Series::Style>) {
      if (style == Style::steps) shape = "<path d=\"M0 8H7V2H15V8H22\" stroke-width=\"1.8\"/>";
    }
    return "<svg width=\"22\" height=\"10\" viewBox=\"0 0 22 10\" fill=\"none\" stroke=\"currentColor\" "
           "style=\"color:" +
           color + "\" aria-hidden=\"true\">" + shape + "</svg>";
  }

  inline static const std::string reset_button = "<button type=\"button\" class=\"reset\">Reset zoom</button>\n";

  // What stands above a plot. reading_width: characters to keep free for a value, 0 for none.
  template <class Plot, class Width>
  void write_head(const Plot& plot, const std::vector<std::string>& colors, Width&& reading_width) {
    constexpr bool timed = std::is_same_v<Plot, TimePlot>;
    body_ += "<div class=\"head\"><figcaption>" + escaped(plot.title) +
             "</figcaption>\n<div class=\"legend\" role=\"group\" aria-label=\"series shown in " + escaped(plot.title) + "\">\n";
    for (std::size_t i = 0; i < plot.series.size(); ++i) {
      body_ += "<label><input type=\"checkbox\" checked>" + swatch(plot.series[i].style, colors[i]) + "<span class=\"name\">" +
               escaped(plot.series[i].name) + "</span>";
      const std::size_t width = reading_width(plot.series[i]);
      if (width > 0) body_ += "<span class=\"value\" style=\"min-width:" + std::to_string(width) + "ch\"></span>";
      body_ += "</label>\n";
    }
    body_ += "</div>\n";
    if (timed) body_ += reset_button + "<span class=\"when\" style=\"min-width:11ch\"></span>";
    body_ += "</div>\n";
  }

  void write_chart(const std::string& title, int height_px, const std::string& content = {}) {
    body_ += "<div class=\"chart\" tabindex=\"0\" role=\"application\" aria-roledescription=\"plot\" aria-label=\"" + escaped(title) +
             "\"" + (hinted_ ? " aria-describedby=\"hint\"" : "") + " style=\"height:" + std::to_string(height_px) + "px\">" + content +
             "</div>\n";
  }

  void write_thinned(std::size_t kept, std::size_t of) {
    if (kept >= of) return;
    body_ += "<p class=\"thinned\">Drawn from " + grouped(kept) + " of " + grouped(of) +
             " samples. Of every run of samples the smallest and the largest are kept, so no peak is lost.</p>\n";
  }

  std::size_t times_index(const std::string& json) {
    const auto [entry, is_new] = index_of_times_.try_emplace(json, times_.size());
    if (is_new) times_.push_back(json);
    return entry->second;
  }

  // What sliders add to a series; empty where none moves it.
  std::string moves_json(const TimePlot& plot, const Series& series, const std::vector<std::size_t>& rows) {
    std::string out;
    for (const Move& move : series.moves) {
      const auto slider = std::find(sliders_.begin(), sliders_.end(), move.slider);
      if (slider == sliders_.end())
        throw std::invalid_argument("plot \"" + plot.title + "\": series \"" + series.name + "\" moves with the slider \"" + move.slider +
                                    "\", which is not on the page");
      const int decimals = decimals_for(finite_range(series.y), embedded_digits);
      bool moves = false;  // by more than is embedded
      const auto changes = [&](const std::vector<double>& moved) {
        std::vector<double> change(moved.size());
        for (std::size_t k = 0; k < moved.size(); ++k) {
          change[k] = moved[k] - series.y[k];
          moves = moves || std::abs(change[k]) >= 0.5 * std::pow(10.0, -decimals);
        }
        return json_array(change, rows, decimals);
      };
      const std::string half_way = changes(move.half_way), low = changes(move.low);
      if (!moves) continue;
      out += (out.empty() ? "{\"slider\":" : ",{\"slider\":") + std::to_string(slider - sliders_.begin()) + ",\"half_way\":" + half_way +
             ",\"low\":" + low + "}";
    }
    return out;
  }

  static std::string bands_json(const std::vector<Band>& bands) {
    const std::vector<std::size_t> tints = band_tints(bands);
    const std::vector<std::size_t> lanes = band_lanes(bands);
    std::string out = "[";
    for (std::size_t i = 0; i < bands.size(); ++i) {
      if (i > 0) out += ',';
      out += "{\"from\":" + json_number(bands[i].from_s, 6) + ",\"to\":" + json_number(bands[i].to_s, 6) +
             ",\"label\":" + json_string(bands[i].label) + ",\"tint\":" + std::to_string(tints[i]) +
             ",\"lane\":" + std::to_string(lanes[i]) + "}";
    }
    return out + "]";
  }

  void write(const TimePlot& plot) {
    const std::size_t index = plot_count_++;
    const std::size_t axis_at = axis_index(plot.time_axis);
    const TimeAxis& axis = axes_[axis_at];
    const bool selector = axis.last_plot == index;
    const std::vector<std::string> colors = series_colors(plot);

    std::vector<std::span<const double>> columns;
    for (const Series& series : plot.series) {
      columns.emplace_back(series.y);
      if (!series.lower.empty()) columns.insert(columns.end(), {series.lower, series.upper});
      for (const Move& move : series.moves) columns.insert(columns.end(), {move.half_way, move.low});
    }
    const std::vector<std::size_t> rows = rows_to_draw(plot.time_s.size(), columns, max_points);

    if (!hinted_) {
      body_ +=
          "<p class=\"hint\" id=\"hint\">Drag to zoom: sideways in time, in all plots; up or down in value. "
          "<kbd>Shift</kbd>-drag or scroll sideways to pan, double-click to reset. On the keyboard: "
          "<kbd>\u2190</kbd> <kbd>\u2192</kbd> move the cursor, with <kbd>Shift</kbd> they pan; <kbd>+</kbd> "
          "<kbd>\u2212</kbd> zoom, <kbd>0</kbd> resets.</p>\n";
      hinted_ = true;
    }
    body_ += "<figure class=\"plot time\" id=\"plot-" + std::to_string(index) + "\">\n";
    write_head(plot, colors, [](const Series& series) {
      const Range range = finite_range(series.y);
      const int decimals = series.decimals.value_or(readout_decimals(series.y));
      if (is_empty(range)) return std::size_t{series.decimals ? 7u : 1u};
      if (decimals < 0) return std::size_t{10};
      return std::max(fixed(range.low, decimals).size(), fixed(range.high, decimals).size());
    });
    if (!plot.bands.empty()) {
      const std::vector<std::size_t> lanes = band_lanes(plot.bands);
      body_ += "<div class=\"bands\" style=\"height:" + std::to_string((1 + *std::max_element(lanes.begin(), lanes.end())) * band_lane_px) +
               "px\"></div>\n";
    }
    write_chart(plot.title, plot.height_px + x_axis_px + (selector ? selector_px : 0));
    write_thinned(rows.size(), plot.time_s.size());
    write_caption(plot.caption);
    body_ += "</figure>\n";

    if (index > 0) plots_ += ",\n";
    plots_ += "{\"kind\":\"time\",\"axis\":" + std::to_string(axis_at) +
              ",\"time\":" + std::to_string(times_index(json_array(plot.time_s, rows, axis.embedded_decimals()))) +
              ",\"y_label\":" + json_string(plot.y_label) + ",\"selector\":" + (selector ? "true" : "false") + ",\"range\":";
    if (plot.y_range) {
      plots_ += "[" + json_number(plot.y_range->low, 9) + "," + json_number(plot.y_range->high, 9) + "]";
    } else {
      plots_ += "null";
    }
    plots_ += ",\"bands\":" + bands_json(plot.bands) + ",\n\"series\":[";
    for (std::size_t i = 0; i < plot.series.size(); ++i) {
      const Series& series = plot.series[i];
      if (i > 0) plots_ += ",\n";
      plots_ += "{\"name\":" + json_string(series.name) + ",\"color\":\"" + colors[i] + "\",\"style\":\"" + style_name(series.style) +
                "\",\"digits\":" + std::to_string(series.decimals.value_or(readout_decimals(series.y))) +
                ",\"y\":" + json_values(series.y, rows);
      if (!series.lower.empty()) {
        plots_ += ",\"lower\":" + json_values(series.lower, rows) + ",\"upper\":" + json_values(series.upper, rows);
      }
      if (const std::string moves = moves_json(plot, series, rows); !moves.empty()) plots_ += ",\"moves\":[" + moves + "]";
      plots_ += "}";
    }
    plots_ += "]}";
  }

  void write(const Sliders& group) {
    end_screen();
    body_ += "<div class=\"sliders\">\n<h3>" + escaped(group.heading) + "</h3>\n";
    write_paragraphs(group.text);
    for (const Slider& slider : group.sliders)
      body_ += "<label class=\"slider\"><span class=\"name\">" + escaped(slider.name) + "</span><input type=\"range\" id=\"slider-" +
               std::to_string(slider_count_++) + "\" min=\"0\" max=\"1\" step=\"0.05\" value=\"1\" autocomplete=\"off\" aria-valuetext=\"" +
               escaped(slider.high_words) + "\" data-low=\"" + escaped(slider.low_words) + "\" data-high=\"" + escaped(slider.high_words) +
               "\"><output>" + escaped(slider.high_words) + "</output></label>\n";
    body_ += "</div>\n";
  }

  void write(const ScatterPlot& plot) {
    const std::size_t index = plot_count_++;
    const std::vector<std::string> colors = series_colors(plot);
    if (!in_scatters_) body_ += "<div class=\"scatters\">\n";
    in_scatters_ = true;

    const bool timed =
        std::any_of(plot.series.begin(), plot.series.end(), [](const ScatterSeries& series) { return !series.time_s.empty(); });
    const std::size_t axis_at = timed ? axis_index(plot.time_axis) : 0;

    body_ += "<figure class=\"plot scatter\" id=\"plot-" + std::to_string(index) + "\">\n";
    write_head(plot, colors, [](const ScatterSeries&) { return std::size_t{0}; });
    write_chart(plot.title, plot.height_px + scatter_labels_px, reset_button);

    if (index > 0) plots_ += ",\n";
    plots_ += "{\"kind\":\"scatter\",\"axis\":" + (timed ? std::to_string(axis_at) : "null") + ",\"x_label\":" + json_string(plot.x_label) +
              ",\"y_label\":" + json_string(plot.y_label) + ",\n\"series\":[";
    std::size_t kept = 0;
    std::size_t of = 0;
    for (std::size_t i = 0; i < plot.series.size(); ++i) {
      const ScatterSeries& series = plot.series[i];
      const std::vector<std::span<const double>> columns{series.x, series.y};
      const std::vector<std::size_t> rows = rows_to_draw(series.x.size(), columns, max_points);
      kept += rows.size();
      of += series.x.size();
      if (i > 0) plots_ += ",\n";
      plots_ += "{\"name\":" + json_string(series.name) + ",\"color\":\"" + colors[i] + "\",\"style\":\"" + style_name(series.style) +
                "\",\"arrows\":" + (series.arrows ? "true" : "false") + ",\"x_digits\":" + std::to_string(readout_decimals(series.x)) +
                ",\"y_digits\":" + std::to_string(readout_decimals(series.y)) + ",\"x\":" + json_values(series.x, rows) +
                ",\"y\":" + json_values(series.y, rows);
      if (!series.time_s.empty()) {
        plots_ += ",\"t\":" + json_array(series.time_s, rows, axes_[axis_at].embedded_decimals());
      }
      plots_ += "}";
    }
    plots_ += "]}";
    write_thinned(kept, of);
    write_caption(plot.caption);
    body_ += "</figure>\n";
  }

  static std::string style_name(Series::Style style) {
    switch (style) {
      case Series::Style::line:
        return "line";
      case Series::Style::dashed:
        return "dashed";
      case Series::Style::points:
        return "points";
      case Series::Style::steps:
        return "steps";
    }
    return "line";
  }

  static std::string style_name(ScatterSeries::Style style) {
    switch (style) {
      case ScatterSeries::Style::points:
        return "points";
      case ScatterSeries::Style::path:
        return "path";
      case ScatterSeries::Style::dashed:
        return "dashed";
    }
    return "points";
  }
};

}  // namespace

std::filesystem::path default_dygraphs_dir() { return SINEW_DYGRAPHS_DIR; }

std::string to_html(const Page& page, const std::filesystem::path& dygraphs_dir) {
  const Writer writer(page);
  std::string out =
      "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n"
      "<meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n"
      // The page asks nobody for anything, and the browser is told to see to that.
      "<meta http-equiv=\"Content-Security-Policy\" content=\"default-src 'none'; script-src 'unsafe-inline'; "
      "style-src 'unsafe-inline'; img-src data:";
  if (!page.events.empty()) out += "; connect-src 'self'";
  out +=
      "\">\n"
      "<title>" +
      escaped(page.title) + "</title>\n<style>\n";
  if (writer.has_time_plots()) out += library(dygraphs_dir / "dygraph.min.css", "/*# sourceMappingURL");
  out += page_style;
  out += "</style>\n</head>\n<body>\n<main>\n<h1>" + escaped(page.title) + "</h1>\n";
  if (!page.lead.empty()) out += "<p class=\"lead\">" + escaped(page.lead) + "</p>\n";
  if (writer.has_plots()) {
    out +=
        "<noscript><div class=\"caution\"><p>The plots of this page need JavaScript. Text and tables do not."
        "</p></div></noscript>\n";
  }
  if (writer.contents().size() > sections_without_contents) {
    out += "<nav class=\"contents\" aria-labelledby=\"contents\"><h2 id=\"contents\">Contents</h2>\n<ol>\n";
    for (std::size_t i = 0; i < writer.contents().size(); ++i) {
      out += "<li><a href=\"#section-" + std::to_string(i + 1) + "\">" + escaped(writer.contents()[i]) + "</a></li>\n";
    }
    out += "</ol></nav>\n";
  }
  if (!page.events.empty())
    out += "<div class=\"finding\" id=\"live\" data-events=\"" + escaped(page.events) +
           "\"><p class=\"state\" role=\"status\">Nothing has come yet.</p><ul></ul></div>\n";
  out += writer.body();
  if (!page.footer.empty()) {
    out += "<footer>\n";
    for (const std::string& line : page.footer) out += "<p>" + escaped(line) + "</p>\n";
    out += "</footer>\n";
  }
  out += "</main>\n";
  if (writer.has_plots()) {
    out += "<div class=\"spoken\" id=\"spoken\" role=\"status\"></div>\n";
    out += "<script type=\"application/json\" id=\"report-data\">\n" + writer.data() + "\n</script>\n";
    if (writer.has_time_plots()) {
      out += "<script>\n";
      out += dygraphs_licence;
      out += library(dygraphs_dir / "dygraph.min.js", "//# sourceMappingURL") + "</script>\n";
    }
    out += "<script>";
    out += page_script;
    out += "</script>\n";
    if (!page.events.empty()) {
      out += "<script>";
      out += live_script;
      out += "</script>\n";
    }
  }
  return out + "</body>\n</html>\n";
}

}  // namespace sinew::report

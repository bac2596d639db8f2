#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "report/axis.h"

// A report as plain values, and its rendering to one HTML file.
//
// All text is plain text: it is escaped on the way out, so a channel may be called `</script>`. Labels carry their
// units ("temperature / °C"); this room converts nothing.

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

// One quantity over the times of its plot.
struct Series {
  enum class Style { line, dashed, points, steps };  // steps: a value holds until the next sample

  std::string name{};
  std::vector<double> y{};  // one value per time; NaN is a gap
  std::string color{};      // "#rrggbb"; empty: the next of the palette
  Style style = Style::line;

  // An area around the line, such as a 95 % interval: both empty, or one value per time each.
  std::vector<double> lower{};
  std::vector<double> upper{};
};

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

enum class Align { left, right };

struct Row {
  std::vector<std::string> cells{};
  bool emphasis = false;
  std::string note{};  // a remark, shown under the row
};

struct Table {
  std::string title{};
  std::vector<std::string> header{};  // may be empty
  std::vector<Row> rows{};
  std::vector<Align> align{};  // empty: columns in which every cell is a number or a dash go right
  std::string caption{};
};

// Alignment of each of the table's columns, as given or as the cells suggest.
std::vector<Align> column_alignment(const Table& table);

// A heading, and the text and list that open the section. What follows belongs to it until the next one.
struct Section {
  std::string heading{};
  std::string text{};  // a blank line starts a new paragraph
  std::vector<std::string> items{};
  int depth = 1;  // 2: a part of the section before it, left out of the table of contents
};

struct Paragraph {
  enum class Tone { plain, finding, caution };  // a finding is what the reader came for

  std::string text{};  // a blank line starts a new paragraph
  Tone tone = Tone::plain;
};

struct List {
  std::vector<std::string> items{};
  bool numbered = false;
};

// Text to be kept as it is: a command, a file.
struct Code {
  std::string text{};
  std::string caption{};
};

using Block = std::variant<Section, Paragraph, List, Code, Table, TimePlot, ScatterPlot>;

struct Page {
  std::string title{};
  std::string lead{};  // one sentence: what the page says
  std::vector<Block> blocks{};
  std::vector<std::string> footer{};
};

// Where the browser library of the plots is read from when a page is rendered.
std::filesystem::path default_dygraphs_dir();

// The page as one HTML file that needs no network and no other file. The same page gives the same bytes.
//
// Time plots of one time axis zoom, pan and point together; a range selector stands under the last of them. A
// series of more than 20 000 points is embedded decimated (decimate.h), and the page says so.
//
// Throws std::invalid_argument, naming plot and series, where lengths disagree or time falls; std::runtime_error,
// naming the package to install, where the page has time plots and dygraphs_dir holds no dygraphs.
std::string to_html(const Page& page, const std::filesystem::path& dygraphs_dir = default_dygraphs_dir());

// What to_html and to_svg demand of a plot; throws std::invalid_argument.
void check(const TimePlot& plot);
void check(const ScatterPlot& plot);

// The colour of each series: its own, or the next of the palette that no series of the plot has claimed.
std::vector<std::string> series_colors(const TimePlot& plot);
std::vector<std::string> series_colors(const ScatterPlot& plot);

}  // namespace sinew::report

// SPDX-License-Identifier: Apache-2.0
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <span>
#include <stdexcept>
#include <string>
#include <variant>
#include <vector>

#include "report/axis.h"
#include "report/console.h"
#include "report/decimate.h"
#include "report/markdown.h"
#include "report/number.h"
#include "report/page.h"
#include "report/svg.h"
#include "report/text.h"

namespace report_report_test {

namespace {

using namespace sinew::report;

constexpr double gap = std::numeric_limits<double>::quiet_NaN();

std::size_t count(const std::string& text, const std::string& part) {
  std::size_t found = 0;
  for (std::size_t at = text.find(part); at != std::string::npos; at = text.find(part, at + part.size())) ++found;
  return found;
}

bool contains(const std::string& text, const std::string& part) { return text.find(part) != std::string::npos; }

// The data that the script of a page reads.
std::string data_of(const std::string& html) {
  const std::string opening = "<script type=\"application/json\" id=\"report-data\">";
  const std::size_t begin = html.find(opening);
  REQUIRE(begin != std::string::npos);
  const std::size_t end = html.find("</script>", begin);
  return html.substr(begin + opening.size(), end - begin - opening.size());
}

TimePlot small_plot() {
  return {.title = "Temperature A",
          .y_label = "temperature / °C",
          .time_s = {0.0, 0.1, 0.2, 0.3},
          .series = {{.name = "recording", .y = {25.0, 25.25, gap, 26.0}}, {.name = "model", .y = {25.0, 25.1, 25.2, 25.3}}}};
}

Page small_page() { return {.title = "Step heating", .lead = "The model follows.", .blocks = {Section{"Time series"}, small_plot()}}; }

}  // namespace

TEST_CASE("a channel cannot break out of the page, wherever its name is shown") {
  const std::string evil = "</script><b>\"'&";
  Page page{.title = evil, .lead = evil, .blocks = {}, .footer = {evil}};
  TimePlot plot = small_plot();
  plot.title = plot.y_label = plot.caption = plot.series[0].name = evil;
  plot.bands = {{0.1, 0.2, evil}};
  page.blocks = {Section{.heading = evil, .text = evil, .items = {evil}},
                 Paragraph{evil},
                 List{{evil}},
                 Code{evil, evil},
                 Table{.title = evil, .header = {evil}, .rows = {{.cells = {evil}, .note = evil}}, .caption = evil},
                 plot,
                 ScatterPlot{.title = evil, .x_label = evil, .y_label = evil, .series = {{.name = evil, .x = {1.0}, .y = {2.0}}}}};
  const std::string html = to_html(page);
  CHECK_FALSE(contains(html.substr(0, html.find("report-data")), "<b>"));  // behind it, the library has its own
  CHECK_FALSE(contains(html, "</script><"));
  // As many ends of scripts as there are scripts: the data, the library, the page's own.
  CHECK(count(html, "<script") == 3);
  CHECK(count(html, "</script") == 3);
  CHECK(contains(html, "<title>&lt;/script&gt;&lt;b&gt;&quot;&#39;&amp;</title>"));
  CHECK(contains(data_of(html), "\\u003c/script\\u003e\\u003cb\\u003e\\\"'\\u0026"));
}

TEST_CASE("bytes that are no UTF-8 and control characters become the replacement character") {
  CHECK(escaped("22 \xb0"
                "C") ==
        "22 \uFFFD"
        "C");  // Latin-1
  CHECK(escaped("\x1b[2J") == "\uFFFD[2J");
  CHECK(escaped("\xc0\xaf") == "\uFFFD\uFFFD");  // an overlong slash
  CHECK(escaped("\xed\xa0\x80") == "\uFFFD");    // half of a surrogate pair
  CHECK(escaped("\xe2\x82") == "\uFFFD");        // cut short
  CHECK(escaped("°±µ→𝛼") == "°±µ→𝛼");
}

TEST_CASE("a page needs nothing but itself") {
  const std::string html = to_html(small_page());
  CHECK_FALSE(contains(html, " src="));
  CHECK_FALSE(contains(html, "<link"));
  CHECK_FALSE(contains(html, "@import"));
  CHECK_FALSE(contains(html, "sourceMappingURL"));
  CHECK(contains(html, "default-src 'none'"));
}

TEST_CASE("a page that goes on may ask its own server for its events, and for nothing else; no other page asks for any") {
  Page page = small_page();
  page.events = "events?of=\"this\"";
  const std::string html = to_html(page);
  CHECK(contains(html, "default-src 'none'"));
  CHECK(contains(html, "connect-src 'self'\">"));
  CHECK(contains(html, "data-events=\"events?of=&quot;this&quot;\""));
  CHECK(count(html, "new EventSource(") == 1);
  const std::string whole = to_html(small_page());
  CHECK_FALSE(contains(whole, "connect-src"));
  CHECK_FALSE(contains(whole, "new EventSource("));
  CHECK_FALSE(contains(whole, "id=\"live\""));
}

TEST_CASE("a value is read out with the decimals that its series asks for, whatever its data need") {
  Page page{.title = "Nothing yet", .blocks = {small_plot()}};
  auto& series = std::get<TimePlot>(page.blocks.front()).series;
  series[0].y.assign(4, gap);
  series[0].decimals = 3;
  CHECK(contains(data_of(to_html(page)), "\"digits\":3,\"y\":[null,null,null,null]"));
}

TEST_CASE("the same page gives the same bytes") { CHECK(to_html(small_page()) == to_html(small_page())); }

TEST_CASE("NaN and infinity become gaps in the data of a page") {
  Page page = small_page();
  auto& plot = std::get<TimePlot>(page.blocks[1]);
  plot.series[1].y[0] = INFINITY;
  const std::string data = data_of(to_html(page));
  CHECK(contains(data, "\"y\":[25,25.25,null,26]"));
  CHECK(contains(data, "\"y\":[null,25.1,25.2,25.3]"));
}

TEST_CASE("times are embedded once for all plots that share them, and without rounding dust") {
  Page page = small_page();
  auto& plot = std::get<TimePlot>(page.blocks[1]);
  plot.time_s = {0.0, 0.1, 0.2, 0.1 + 0.2};  // 0.30000000000000004
  page.blocks.push_back(plot);
  const std::string data = data_of(to_html(page));
  CHECK(count(data, "[0,0.1,0.2,0.3]") == 1);
}

TEST_CASE("the range selector stands under the last plot of each time axis") {
  TimePlot other = small_plot();
  other.time_axis = "second recording";
  const Page page{.title = "", .blocks = {small_plot(), other, small_plot(), other}};
  const std::string data = data_of(to_html(page));
  CHECK(count(data, "\"selector\":true") == 2);
  CHECK(data.find("\"selector\":true") > data.rfind("\"selector\":false"));
}

TEST_CASE("a long series is embedded decimated, keeps its one peak, and the page says so") {
  const std::size_t rows = 100'000;
  TimePlot plot{.title = "long", .y_label = "y", .series = {{.name = "s", .y = std::vector<double>(rows, 1.0)}}};
  for (std::size_t i = 0; i < rows; ++i) plot.time_s.push_back(static_cast<double>(i) * 0.01);
  plot.series[0].y[54'321] = 77.5;
  const std::string html = to_html(Page{.title = "", .blocks = {plot}});
  CHECK(contains(html, "100\u202f000 samples"));
  const std::string data = data_of(html);
  CHECK(contains(data, ",77.5,"));
  CHECK(contains(data, ",543.21,"));
  CHECK(data.size() < 400'000);
  CHECK_FALSE(contains(to_html(small_page()), "class=\"thinned\""));
}

TEST_CASE("decimation keeps ends, extremes and gaps, in order, and leaves a short table alone") {
  std::vector<double> column(10'000);
  for (std::size_t i = 0; i < column.size(); ++i) column[i] = std::sin(static_cast<double>(i) * 0.01);
  column[1234] = 9.0;
  column[1235] = -9.0;
  column[7777] = gap;
  const std::vector<std::span<const double>> columns{column};

  const auto rows = rows_to_draw(column.size(), columns, 1'000);
  const auto kept = [&rows](std::size_t row) { return std::binary_search(rows.begin(), rows.end(), row); };
  CHECK(std::is_sorted(rows.begin(), rows.end()));
  CHECK(std::adjacent_find(rows.begin(), rows.end()) == rows.end());
  CHECK(rows.size() <= 1'003);  // the ends and the gap come on top
  CHECK(rows.front() == 0);
  CHECK(rows.back() == 9'999);
  CHECK(kept(1234));
  CHECK(kept(1235));
  CHECK(kept(7777));

  CHECK(rows_to_draw(column.size(), columns, 10'000).size() == 10'000);
}

TEST_CASE("decimation keeps a gap that lies between two extremes of one run") {
  std::vector<double> column{5.0, gap, 9.0, 6.0, gap, 6.0, 1.0, 6.0};
  const std::vector<std::span<const double>> columns{column};
  // One run: largest at 2, smallest at 6, first gap at 1, gap between them at 4.
  CHECK(rows_to_draw(column.size(), columns, 2) == std::vector<std::size_t>{0, 1, 2, 4, 6, 7});
}

TEST_CASE("decimation keeps the extremes of every column") {
  std::vector<double> a(1'000, 0.0);
  std::vector<double> b(1'000, 0.0);
  a[300] = 1.0;
  b[301] = -1.0;
  const std::vector<std::span<const double>> columns{a, b};
  const auto rows = rows_to_draw(1'000, columns, 40);
  CHECK(std::binary_search(rows.begin(), rows.end(), std::size_t{300}));
  CHECK(std::binary_search(rows.begin(), rows.end(), std::size_t{301}));
}

TEST_CASE("ticks are multiples of 1, 2 or 5 times a power of ten") {
  CHECK(nice_ticks({0.0, 100.0}, 6).values == std::vector<double>{0, 20, 40, 60, 80, 100});
  CHECK(nice_ticks({0.0, 100.0}, 5).values == std::vector<double>{0, 50, 100});
  CHECK(nice_ticks({-42.0, 41.0}, 5).values == std::vector<double>{-40, -20, 0, 20, 40});
  CHECK(nice_ticks({23.7, 61.2}, 4).values == std::vector<double>{30, 40, 50, 60});
  CHECK(nice_ticks({0.0, 0.3}, 4).values == std::vector<double>{0.0, 0.1, 0.2, 0.3});
  CHECK(nice_ticks({599.97, 600.03}, 4).values == std::vector<double>{599.98, 600.0, 600.02});
}

TEST_CASE("labels of ticks have the digits that tell them apart, and a true minus sign") {
  const Ticks tenths = nice_ticks({-0.2, 0.2}, 5);
  CHECK(tick_label(tenths.values.front(), tenths) == "\u22120.2");
  CHECK(tick_label(tenths.values[2], tenths) == "0.0");
  const Ticks millions = nice_ticks({9e7, 1.1e8}, 3);
  CHECK(tick_label(1.0e8, millions) == "1.0e8");
  const Ticks tiny = nice_ticks({-4e-10, 4e-10}, 5);
  CHECK(tick_label(tiny.values.front(), tiny) == "\u22124e-10");
  CHECK(tick_label(0.0, tiny) == "0");
}

TEST_CASE("a range of one value gets room, an empty one is 0 to 1") {
  const Range one = padded({25.0, 25.0}, 0.05);
  CHECK(one.low < 25.0);
  CHECK(one.high > 25.0);
  CHECK(padded(no_range, 0.05).high == 1.0);
  CHECK(is_empty(including(no_range, std::vector<double>{gap, INFINITY})));
}

TEST_CASE("numbers are written the way a table wants them") {
  CHECK(fixed(1.005, 1) == "1.0");
  CHECK(fixed(-0.004, 2) == "0.00");
  CHECK(fixed(gap, 2) == "\u2013");
  CHECK(significant(0.0012345, 3) == "0.00123");
  CHECK(significant(9.996, 3) == "10.0");
  CHECK(significant(123456.0, 3) == "123456");
  CHECK(significant(1.5e-7, 2) == "1.5e-7");
  CHECK(significant(0.0, 3) == "0.00");
  CHECK(significant(-INFINITY, 3) == "-\u221e");
  CHECK(compact(2.50, 4) == "2.5");
  CHECK(compact(-0.00001, 3) == "0");
}

TEST_CASE("a plot whose columns disagree is refused by name") {
  TimePlot plot = small_plot();
  plot.series[1].y.pop_back();
  CHECK_THROWS_WITH_AS(to_svg(plot, 400, 300), "plot \"Temperature A\": series \"model\" has 3 values of y for 4 points",
                       std::invalid_argument);
  plot = small_plot();
  plot.series[0].lower = {1.0};
  CHECK_THROWS_WITH_AS(check(plot), "plot \"Temperature A\": series \"recording\" has 1 values of lower for 4 points",
                       std::invalid_argument);
  plot = small_plot();
  plot.time_s[2] = 0.05;
  CHECK_THROWS_WITH_AS(to_html(Page{.title = "", .blocks = {plot}}), "plot \"Temperature A\": time falls at row 2", std::invalid_argument);
  plot = small_plot();
  plot.series[0].color = "red;}</style>";
  CHECK_THROWS_WITH_AS(check(plot),
                       "plot \"Temperature A\": series \"recording\" has the color \"red;}</style>\", which is not of the form #rrggbb",
                       std::invalid_argument);
}

TEST_CASE("what a slider does to its series is embedded as changes, and a series that it leaves alone has none") {
  Page page = small_page();
  auto& plot = std::get<TimePlot>(page.blocks[1]);
  plot.series[1].moves = {{"creep <b>", {25.0, 25.2, 25.4, 25.6}, {25.0, 25.3, 25.6, 25.9}}};
  Series error{.name = "error", .y = {1.0, 1.1, 1.2, 1.3}, .moves = {{"creep <b>", {1.0, 1.2, 1.4, 1.6}, {1.0, 1.3, 1.6, 1.9}}}};
  plot.series.push_back(error);
  plot.series.push_back(
      {.name = "still", .y = {1.0, 1.1, 1.2, 1.3}, .moves = {{"creep <b>", {1.0, 1.1, 1.2, 1.3 + 1e-9}, {1.0, 1.1, 1.2, 1.3}}}});
  CHECK_THROWS_WITH_AS(to_html(page),
                       "plot \"Temperature A\": series \"model\" moves with the slider \"creep <b>\", which is not on the page",
                       std::invalid_argument);
  page.blocks.insert(page.blocks.begin() + 1,
                     Sliders{.heading = "Try <i>", .text = "Move it.", .sliders = {{"creep <b>", "none", "as fitted"}}});
  const std::string html = to_html(page), data = data_of(html);
  CHECK(count(data, "\"moves\":[{\"slider\":0,\"half_way\":[0,0.1,0.2,0.3],\"low\":[0,0.2,0.4,0.6]}]") == 2);
  CHECK(count(data, "\"moves\":") == 2);
  CHECK(contains(html, "<h3>Try &lt;i&gt;</h3>\n<p>Move it.</p>"));
  CHECK(contains(html, "<span class=\"name\">creep &lt;b&gt;</span>"));
  CHECK(count(html, "id=\"slider-0\"") == 1);
  std::get<TimePlot>(page.blocks[2]).series[1].moves[0].low.pop_back();
  CHECK_THROWS_WITH_AS(to_html(page), "plot \"Temperature A\": series \"model\" has 3 values of the slider \"creep <b>\" for 4 points",
                       std::invalid_argument);
}

TEST_CASE("without dygraphs a page with time plots says what to install, and one without needs nothing") {
  CHECK_THROWS_WITH_AS(to_html(small_page(), "/nowhere"),
                       "cannot read /nowhere/dygraph.min.css, which draws the plots of a page: install the Debian package "
                       "libjs-dygraphs",
                       std::runtime_error);
  const Page words{.title = "Words", .blocks = {Section{"One", "text"}, ScatterPlot{.title = "s"}}};
  CHECK(contains(to_html(words, "/nowhere"), "<h2 id=\"section-1\">One</h2>"));
}

TEST_CASE("a page of more than four sections has a table of contents") {
  Page page{.title = "", .blocks = {Section{"1"}, Section{"2"}, Section{"3"}, Section{"4"}, Section{.heading = "4b", .depth = 2}}};
  CHECK_FALSE(contains(to_html(page), "class=\"contents\""));
  page.blocks.push_back(Section{"5"});
  const std::string html = to_html(page);
  CHECK(contains(html, "<a href=\"#section-5\">5</a>"));
  CHECK_FALSE(contains(html, ">4b</a>"));
}

TEST_CASE("what is on the screen only ends with its section, and a line on paper stands in its place") {
  const Page page{.title = "Words",
                  .blocks = {Section{"One"}, Section{.heading = "long", .text = "much", .depth = 3}, Paragraph{"more"}, Section{"Two"}}};
  const std::string html = to_html(page);
  const std::size_t begins = html.find("<div class=\"screen\">"), ends = html.find("</div>", begins);
  CHECK(contains(html, "<h3>long</h3>\n<p class=\"paper\">"));
  CHECK(begins < html.find("much"));
  CHECK(html.find("more") < ends);
  CHECK(ends < html.find(">Two</h2>"));
  CHECK(count(html, "class=\"screen\"") == 1);
}

TEST_CASE("a series without a colour gets one that no other has claimed") {
  TimePlot plot = small_plot();
  plot.series[1].color = okabe_ito::blue;
  CHECK(series_colors(plot) == std::vector<std::string>{okabe_ito::vermillion, okabe_ito::blue});
}

TEST_CASE("bands that overlap are named in different lanes, and one label has one tint") {
  const std::vector<Band> bands{{10, 20, "heating"}, {15, 30, "held out"}, {20, 40, "heating"}};
  CHECK(band_lanes(bands) == std::vector<std::size_t>{0, 1, 0});
  CHECK(band_tints(bands) == std::vector<std::size_t>{0, 1, 0});
}

TEST_CASE("a figure draws a gap as a lifted pen") {
  TimePlot plot = small_plot();
  plot.series = {{.name = "recording", .y = {1.0, 2.0, gap, 3.0}}};
  const std::string svg = to_svg(plot, 400, 300);
  const std::size_t begin = svg.find("<g clip-path");
  const std::string drawn = svg.substr(begin, svg.find("</g>", begin) - begin);
  CHECK(count(drawn, "<path") == 1);  // from the first point to the second
  CHECK(count(drawn, "L") == 1);
  CHECK(count(drawn, "<circle") == 1);  // and the fourth stands alone
}

TEST_CASE("a figure is the same bytes twice, escapes names, and shows title, unit and legend") {
  TimePlot plot = small_plot();
  plot.series[0].name = "<recording & more>";
  const std::string svg = stacked_svg({plot, small_plot()}, 640, 400);
  CHECK(svg == stacked_svg({plot, small_plot()}, 640, 400));
  CHECK(contains(svg, ">&lt;recording &amp; more&gt;</text>"));
  CHECK(count(svg, ">temperature / °C</text>") == 2);
  CHECK(count(svg, ">time / s</text>") == 1);
  CHECK(count(svg, ">model</text>") == 2);
}

TEST_CASE("a figure too small for its data is refused") {
  CHECK_THROWS_WITH_AS(to_svg(small_plot(), 60, 300), "the figure's size leaves no room for its data beside axes and legends",
                       std::invalid_argument);
  CHECK_THROWS_AS(to_svg(small_plot(), 400, 50), std::invalid_argument);
}

TEST_CASE("a scatter figure shows arrows along a path that asks for them") {
  ScatterSeries loop{.name = "loop", .style = ScatterSeries::Style::path, .arrows = true};
  for (int i = 0; i <= 100; ++i) {
    loop.x.push_back(std::cos(0.0628 * i));
    loop.y.push_back(std::sin(0.0628 * i));
  }
  const ScatterPlot plot{.title = "Hysteresis", .x_label = "temperature / °C", .y_label = "angle / °", .series = {loop}};
  CHECK(count(to_svg(plot, 400, 400), "rotate(") == 5);  // four arrows and the label of the y axis
}

TEST_CASE("display width counts columns, not bytes") {
  CHECK(display_width("12.5 ± 0.3 °C") == 13);
  CHECK(display_width("θ\u0307") == 1);  // a dot above
  CHECK(display_width("温度") == 4);
}

TEST_CASE("terminal tables line up under ° and ±, numbers to the right") {
  const Table table{.title = "Fit",
                    .header = {"channel", "RMSE", "share"},
                    .rows = {{{"temperature A / °C", "1.25 ± 0.10", "54.6 %"}}, {{"angle / °", "13.50 ± 0.40", "–"}, true, "see below"}}};
  CHECK(to_text(table) ==
        "Fit\n"
        "  channel                     RMSE   share\n"
        "  ──────────────────  ────────────  ──────\n"
        "  temperature A / °C   1.25 ± 0.10  54.6 %\n"
        "* angle / °           13.50 ± 0.40       –\n"
        "      see below\n");
}

TEST_CASE("a terminal table too wide wraps its words and keeps its numbers") {
  const Table table{.header = {"effect", "verdict"}, .rows = {{{"1.41", "imitates the lag and leaves a residual at switch-off"}}}};
  CHECK(to_text(table, 36) ==
        "effect  verdict\n"
        "──────  ────────────────────────────\n"
        "  1.41  imitates the lag and leaves\n"
        "        a residual at switch-off\n");
}

TEST_CASE("a terminal never receives an escape sequence from a name") {
  const Table table{.header = {"name"}, .rows = {{{"\x1b]0;owned\x07"}}}};
  CHECK_FALSE(contains(to_text(table), "\x1b"));
  CHECK_FALSE(contains(wrap("\x1b[2J"), "\x1b"));
}

TEST_CASE("text is wrapped at words, with its own line feeds kept and every line indented") {
  CHECK(wrap("one two three four", 9) == "one two\nthree\nfour");
  CHECK(wrap("one two\n\nthree", 20, 2) == "  one two\n\n  three");
  CHECK(wrap("incompressible", 5) == "incompressible");
  CHECK(wrap("") == "");
}

TEST_CASE("columns of numbers go right, phrases that begin with a number do not") {
  const Table table{.header = {"a", "b", "c"}, .rows = {{{"12.5 ± 0.3 %", "3 of 5 recordings", "±0.1"}}, {{"–", "2", "< 0.01"}}}};
  CHECK(column_alignment(table) == std::vector<Align>{Align::right, Align::left, Align::right});
}

TEST_CASE("markdown: a row a line, what would end a cell is escaped, emphasis is bold, notes follow the last cell") {
  Table table;
  table.header = {"what", "how much"};
  table.rows = {{{"a|b", "1"}}, {{"two\nlines", ""}, true, "why"}};
  CHECK(to_markdown(table) == "| what | how much |\n|---|---|\n| a\\|b | 1 |\n| **two lines** | why |\n");
}

}  // namespace report_report_test

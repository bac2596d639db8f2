// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <array>
#include <cmath>

#include "plant/contains.h"
#include "plant/systems.h"
#include "proof/score_files.h"
#include "report/number.h"
#include "report/svg.h"

namespace sinew::proof {
namespace {

using Labels = std::vector<std::string>;

// Nothing, the catalogue in its order, its other forms, what was taken out of it, what is outside of it, unknown.
std::pair<int, std::size_t> order_of(const std::string& label) {
  if (label == "(nothing)") return {0, 0};
  if (label == "(unknown)") return {5, 0};
  constexpr std::array<std::string_view, 3> prefixes{"other form: ", "removed: ", "outside: "};
  int group = 1;
  std::string name = label;
  for (std::size_t p = 0; p < prefixes.size(); ++p)
    if (label.starts_with(prefixes[p])) {
      group = static_cast<int>(p) + 2;
      name = label.substr(prefixes[p].size());
    }
  std::size_t place = 0;
  const auto& catalogue = plant::default_plant().system().effects().values();
  while (place < catalogue.size() && catalogue[place].name != name) ++place;
  return {group, place};
}

Labels in_order(Labels labels) {
  std::stable_sort(labels.begin(), labels.end(), [](const std::string& a, const std::string& b) { return order_of(a) < order_of(b); });
  return labels;
}

Labels rows_of(const Score& score) {
  Labels rows;
  for (const auto& [truth, given] : score.confusion) rows.push_back(truth);
  return in_order(rows);
}

Labels columns_of(const Score& score) {
  Labels columns;
  for (const auto& [truth, given] : score.confusion)
    for (const auto& [answer, count] : given)
      if (!contains(columns, answer)) columns.push_back(answer);
  return in_order(columns);
}

constexpr int cell = 24, left = 250, top = 190, beside_last_label = 90;

std::string px(int value) { return std::to_string(value); }
int x_of(std::size_t column) { return left + cell * static_cast<int>(column); }
int y_of(std::size_t row) { return top + cell * static_cast<int>(row); }

std::string confusion_head(std::size_t rows, std::size_t columns) {
  return "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"" + px(x_of(columns) + beside_last_label) + "\" height=\"" +
         px(y_of(rows) + 20) +
         "\" font-family=\"sans-serif\" font-size=\"11\">\n<rect width=\"100%\" height=\"100%\" fill=\"white\"/>\n"
         "<text x=\"10\" y=\"20\" font-size=\"14\">What was concealed (rows) and what was named first (columns)</text>\n"
         "<text x=\"10\" y=\"38\">Cases of one concealed effect, and of none</text>\n";
}

std::string confusion_row(std::size_t row, const std::string& truth, const Labels& columns, const std::map<std::string, int>& given) {
  const std::string y = px(y_of(row)), middle = px(y_of(row) + cell / 2 + 4);
  std::string svg = "<text x=\"" + px(left - 6) + "\" y=\"" + middle + "\" text-anchor=\"end\">" + truth + "</text>\n";
  int all = 0;
  for (const auto& [answer, count] : given) all += count;
  for (std::size_t c = 0; c < columns.size(); ++c) {
    const int count = given.contains(columns[c]) ? given.at(columns[c]) : 0;
    svg += "<rect x=\"" + px(x_of(c)) + "\" y=\"" + y + "\" width=\"" + px(cell) + "\" height=\"" + px(cell) +
           "\" fill=\"#1f5fa8\" fill-opacity=\"" + report::fixed(static_cast<double>(count) / all, 3) + "\" stroke=\"#ddd\"/>\n";
    if (count > 0)
      svg += "<text x=\"" + px(x_of(c) + cell / 2) + "\" y=\"" + middle + "\" text-anchor=\"middle\" fill=\"" +
             (2 * count > all ? "white" : "black") + "\">" + std::to_string(count) + "</text>\n";
  }
  return svg;
}

// Each bin's interval as a line from its lower to its upper end.
report::ScatterSeries intervals(const Reliability& one, const std::string& color) {
  report::ScatterSeries bars{.color = color, .style = report::ScatterSeries::Style::path};
  for (const ReliabilityBin& bin : one.bins) {
    const Interval interval = bin.came_true.interval();
    for (const double y : {interval.lowest, interval.highest, std::nan("")}) {
      bars.x.push_back(bin.mean_probability);
      bars.y.push_back(y);
    }
  }
  return bars;
}

report::ScatterSeries shares(const Reliability& one, const std::string& color) {
  report::ScatterSeries points{.name = one.method, .color = color};
  for (const ReliabilityBin& bin : one.bins) {
    points.x.push_back(bin.mean_probability);
    points.y.push_back(bin.came_true.value());
  }
  return points;
}

}  // namespace

std::string confusion_svg(const Score& score) {
  const Labels rows = rows_of(score), columns = columns_of(score);
  std::string svg = confusion_head(rows.size(), columns.size());
  for (std::size_t c = 0; c < columns.size(); ++c)
    svg += "<text transform=\"translate(" + px(x_of(c) + cell / 2 + 3) + "," + px(top - 6) + ") rotate(-60)\">" + columns[c] + "</text>\n";
  for (std::size_t r = 0; r < rows.size(); ++r) svg += confusion_row(r, rows[r], columns, score.confusion.at(rows[r]));
  return svg + "</svg>\n";
}

std::string reliability_svg(const Score& score) {
  report::ScatterPlot plot{.title = "How often a name is right, by its probability",
                           .x_label = "probability given, mean of a bin",
                           .y_label = "share that came true, 95 % interval",
                           .series = {{.name = "what it should be",
                                       .x = {0.0, 1.0},
                                       .y = {0.0, 1.0},
                                       .color = report::okabe_ito::black,
                                       .style = report::ScatterSeries::Style::dashed}}};
  // Of Sinew all its forecasts, not once more those beside BIC's.
  for (const Reliability& one : score.reliability) {
    const bool is_all = &one == &score.reliability.front(), is_other_method = &one == &score.reliability.back();
    if (one.forecasts == 0 || !(is_all || is_other_method)) continue;
    const std::string color = is_all ? report::okabe_ito::blue : report::okabe_ito::vermillion;
    plot.series.push_back(intervals(one, color));
    plot.series.push_back(shares(one, color));
  }
  return report::to_svg(plot, 420, 420);
}

}  // namespace sinew::proof

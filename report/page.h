// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string>
#include <variant>
#include <vector>

#include "report/plot.h"
#include "report/table.h"

// A report as plain values, and its rendering to one HTML file.
//
// All text is plain text: it is escaped on the way out, so a channel may be called `</script>`.

namespace sinew::report {

// A heading, and the text and list that open the section. What follows belongs to it until the next one.
struct Section {
  std::string heading{};
  std::string text{};  // a blank line starts a new paragraph
  std::vector<std::string> items{};
  // 2: a part of the section before it, left out of the table of contents. 3: the same, but on the screen only: on paper a line says so
  // in place of what belongs to it.
  int depth = 1;
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

// A slider from 0 to 1, which it is at first. Series that name it move (Series::moves).
struct Slider {
  std::string name{};
  std::string low_words{}, high_words{};  // of its ends
};

// Sliders under a heading of depth 2, and what they do. Not there on paper.
struct Sliders {
  std::string heading{};
  std::string text{};
  std::vector<Slider> sliders{};
};

using Block = std::variant<Section, Paragraph, List, Code, Table, TimePlot, ScatterPlot, Sliders>;

struct Page {
  std::string title{};
  std::string lead{};  // one sentence: what the page says
  std::vector<Block> blocks{};
  std::vector<std::string> footer{};
  // Not empty: the page goes on. Its server sends further rows of its time plots, all of one time axis, by server-sent events at this
  // address; live.js says which.
  std::string events{};
};

// Where the browser library of the plots is read from when a page is rendered.
std::filesystem::path default_dygraphs_dir();

// The page as one HTML file that needs no network and no other file (but its events, where it has any). The same page gives the same bytes.
//
// Time plots of one time axis zoom, pan and point together; a range selector stands under the last of them. A
// series of more than 20 000 points is embedded decimated (decimate.h), and the page says so.
//
// Throws std::invalid_argument, naming plot and series, where lengths disagree, time falls or a slider is not there; std::runtime_error,
// naming the package to install, where the page has time plots and dygraphs_dir holds no dygraphs.
std::string to_html(const Page& page, const std::filesystem::path& dygraphs_dir = default_dygraphs_dir());

}  // namespace sinew::report

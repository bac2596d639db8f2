// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "report/plot.h"

// Still figures for papers and slides: SVG with vector text, thin lines and white ground. Legends stand above the
// plot area and never cover data. The same plot gives the same bytes.
//
// Sizes are of the whole figure in CSS pixels of 1/96 inch; text is 11 px high whatever the size, so a figure is best
// made as wide as it will be printed: 321 px for a column of 85 mm. Captions are left to the text around the figure.
//
// All throw std::invalid_argument for what check (plot.h) refuses, and for a size that leaves the data no room.

namespace sinew::report {

std::string to_svg(const TimePlot& plot, int width_px, int height_px);
std::string to_svg(const ScatterPlot& plot, int width_px, int height_px);

// Plots one above the other over one time axis, which holds the times of all. Each gets height in the proportion of its
// height_px.
std::string stacked_svg(const std::vector<TimePlot>& plots, int width_px, int height_px);

}  // namespace sinew::report

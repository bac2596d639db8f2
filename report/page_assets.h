// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string_view>

namespace sinew::report {

// What to_html puts into every page beside its content: page.css and page.js, and live.js into one that goes on; embedded at build
// (cmake/embed.cmake). The classes and data attributes that join them to the markup are those that page.cpp writes.
extern const std::string_view page_style;
extern const std::string_view page_script;
extern const std::string_view live_script;

}  // namespace sinew::report

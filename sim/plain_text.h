// SPDX-License-Identifier: Apache-2.0
// Names that can stand in a file of ours.
#pragma once

#include <string_view>

namespace sinew::sim {

// Whether this is UTF-8 without control characters (line ends among them), so that it can stand in a line of YAML, in JSON and in a comment
// as it is. Names of files may hold anything else, and such a name is refused before the work.
bool is_plain_text(std::string_view text);

}  // namespace sinew::sim

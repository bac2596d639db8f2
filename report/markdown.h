// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "report/table.h"

namespace sinew::report {

// The table for a README: a row a line, cells as they are but for '|' and line feeds, which would end them. Rows with emphasis are
// bold; notes follow in the last cell. Title and caption are left to the text around it. Ends in a line feed.
std::string to_markdown(const Table& table);

}  // namespace sinew::report

// SPDX-License-Identifier: Apache-2.0
// Columns that are not what their names say: kelvin under degC, radians under deg, two exchanged. What is
// fitted to such a recording names physics that no plant has, so this is asked before anything is.
#pragma once

#include <optional>
#include <string>

#include "plant/system.h"
#include "sim/recording.h"

namespace sinew::diagnose {

struct MistakenColumn {
  std::string column;  // as in a recording's header
  std::string range;   // "299.1 to 391.5"
  std::string why;     // a clause, with what to do
};

// The first column that is mistaken beyond doubt, by what the plant predicts of the recording from its duty, begun cold and
// at rest. None where the plant cannot follow, or all inputs are alike.
std::optional<MistakenColumn> mistaken_column(const plant::Plant& nominal, const sim::Recording& recording);

}  // namespace sinew::diagnose

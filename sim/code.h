// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

namespace sinew::sim {

// What computes results that are kept and taken over later: a hash of the sources of plant, sim and model, and of how they are
// compiled. 16 digits. A commit that changes none of them keeps it; a version says less, and a commit too much.
std::string code_identity();

}  // namespace sinew::sim

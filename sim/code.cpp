// SPDX-License-Identifier: Apache-2.0
#include "sim/code.h"

#include "version.h"

namespace sinew::sim {

std::string code_identity() { return SINEW_CODE; }

}  // namespace sinew::sim

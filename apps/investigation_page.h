// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "investigate/story.h"
#include "report/page.h"

namespace sinew::apps {

// `recordings`: of the steps that are recorded, in their order, as they were diagnosed.
report::Page investigation_page(const investigate::Investigation& investigation, const plant::System& system,
                                const std::vector<sim::Recording>& recordings);

}  // namespace sinew::apps

// SPDX-License-Identifier: Apache-2.0
// report.html of `diagnose`: the five questions in their order, for a reader who sees such a report for the first time.
#pragma once

#include "apps/diagnosis_text.h"
#include "report/page.h"

namespace sinew::apps {

report::Page diagnosis_page(const diagnose::Diagnosis& diagnosis, const DiagnosisInputs& inputs);

}  // namespace sinew::apps

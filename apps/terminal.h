// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace sinew::apps {

// Whether standard error is a terminal that knows escapes (TERM is neither unset nor "dumb"), and whose owner wants them (NO_COLOR is unset
// or empty).
bool may_move_cursor();

}  // namespace sinew::apps

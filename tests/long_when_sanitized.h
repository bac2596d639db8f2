// SPDX-License-Identifier: Apache-2.0
// Marks a test that takes long under the sanitizers and runs no code there that shorter tests do not run: a whole search or diagnosis,
// longer trainings and calibrations, sensitivities against differences, the generator's comparisons. And the tests whose limits hold
// for the program as it is released (which corners a step meets goes with the last bit). `./check --long` runs them sanitized, too.
#pragma once

#include <doctest/doctest.h>

inline const auto long_when_sanitized = doctest::test_suite("long when sanitized");

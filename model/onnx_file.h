// SPDX-License-Identifier: Apache-2.0
// An LSTM as an ONNX model: one step of 0.1 s, scaling included, everything that is carried from step to step an input and an output.
//
//   inputs    v         [streams, features]   what the task sees now, in the units and the order of a recording's columns
//             v_before  [streams, features]   the same one step before
//             y_before  [streams, 1]          y one step before: measured, or the y of that step, fed back
//             h, c      [1, streams, hidden]  the state; zero: nothing is remembered. Not there where the network is memoryless
//   outputs   y         [streams, 1]
//             h_next, c_next                  h and c of the next step
//
// All numbers are float32; `streams` is any number of rollouts side by side. Columns and sample period stand in the metadata
// (inputs, output, sample_period_s), what our own weights file says in `sinew`.
//
// Source: onnx.proto3 and Operators.md of ONNX 1.8 (IR version 7, operator set 13), which newer runtimes read as well.
#pragma once

#include <string>

#include "model/series.h"

namespace sinew::model {

// The file's bytes; the same model gives the same.
std::string to_onnx(const Model& model);

}  // namespace sinew::model

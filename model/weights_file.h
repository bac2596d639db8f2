// SPDX-License-Identifier: Apache-2.0
// Weights in HDF5, in Keras's own layouts, both ways. The one source file that includes HDF5 headers is hdf5_file.cpp.
//
//   keras 2, whole model      model.save("x.h5"):           /model_weights/lstm/lstm/lstm_cell/kernel:0, ...; attribute model_config
//   keras 2, weights alone    model.save_weights("x.h5"):   /lstm/lstm/lstm_cell/kernel:0, ...
//   keras 3, weights alone    model.save_weights("x.weights.h5"):  /layers/lstm/cell/vars/0, ...
//
// A GRU has `gru` in the place of `lstm`, and a bias [2, 3 hidden] (reset_after=True). All three are read; the first (a whole model) and
// the last are written. What Keras does not know stands in the attribute `sinew` of the root, as JSON: case, method, names, units and
// scaling of what is given and of what is predicted, and a SHA-256 over all that and the weights' bytes. So a recording can be read for a
// model without its plant.
#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include "model/hdf5_file.h"
#include "model/series.h"
#include "model/sidecar.h"

namespace sinew::model {

enum class Layout { keras2, keras3 };

// The file's bytes; the same model gives the same.
std::string to_hdf5(const Model& model, Layout layout = Layout::keras2);

// For a file that Keras wrote, which says neither task nor scaling.
struct Unsaid {
  std::optional<Task> task;
  std::string method;                     // empty: not given
  std::optional<double> lowest, highest;  // what is 0 and 1 of the network's numbers, in the unit of the channel predicted
  // Order and scaling. Without it, and with lowest and highest, the order is that of our own files, and inputs are not scaled.
  std::optional<Sidecar> sidecar = std::nullopt;
};

// Throws InputError for a file that is no HDF5, a weight that is missing or of another shape than the others ask for, a weight
// that is not a number, a layer that is not known, a checksum that does not fit, and a task that is not the one asked for.
Model read_model(const std::filesystem::path& path, const Unsaid& unsaid = {});

// The same, as values.
Hdf5File file_of(const Model& model, Layout layout = Layout::keras2);
Model model_in(const Hdf5File& file, const std::string& name, const Unsaid& unsaid);

}  // namespace sinew::model

// SPDX-License-Identifier: Apache-2.0
#include "sim/hdf5_log.h"

#include <hdf5.h>

#include <stdexcept>
#include <string>

#include "sim/input_error.h"
#include "sim/mat_log.h"

namespace sinew::sim {
namespace {

constexpr hssize_t most_elements = hssize_t{1} << 28;

// Owns one identifier of the library.
class Handle {
 public:
  Handle(hid_t id, herr_t (*close)(hid_t)) : id_(id), close_(close) {
    if (id < 0) throw std::runtime_error("HDF5 refused");
  }
  Handle(const Handle&) = delete;
  Handle& operator=(const Handle&) = delete;
  ~Handle() { close_(id_); }
  operator hid_t() const { return id_; }

 private:
  hid_t id_;
  herr_t (*close_)(hid_t);
};

struct Reading {
  std::vector<LogArray> arrays;
  bool trouble = false;
};

// Nothing may be thrown through the library.
herr_t read_object(hid_t root, const char* name, const H5O_info_t* info, void* data) {
  auto& reading = *static_cast<Reading*>(data);
  if (info->type != H5O_TYPE_DATASET) return 0;
  try {
    const Handle object(H5Dopen2(root, name, H5P_DEFAULT), H5Dclose);
    const Handle type(H5Dget_type(object), H5Tclose), space(H5Dget_space(object), H5Sclose);
    const H5T_class_t kind = H5Tget_class(type);
    const int rank = H5Sget_simple_extent_ndims(space);
    const hssize_t count = H5Sget_simple_extent_npoints(space);
    if ((kind != H5T_FLOAT && kind != H5T_INTEGER) || rank < 0 || rank > 2 || count < 1) return 0;
    if (count > most_elements) throw std::runtime_error("an array too large");
    hsize_t extents[2] = {1, 1};
    if (rank > 0) H5Sget_simple_extent_dims(space, extents, nullptr);
    std::vector<double> values(static_cast<std::size_t>(count));
    if (H5Dread(object, H5T_NATIVE_DOUBLE, H5S_ALL, H5S_ALL, H5P_DEFAULT, values.data()) < 0) throw std::runtime_error("HDF5 refused");
    append_series(reading.arrays, name, values, extents[0], extents[1], false);
  } catch (const std::exception&) {
    reading.trouble = true;
  }
  return 0;
}

}  // namespace

std::vector<LogArray> read_hdf5(const std::filesystem::path& path) {
  H5Eset_auto2(H5E_DEFAULT, nullptr, nullptr);  // what is wrong is said here
  const auto refuse = [&](const char* why) { throw InputError({.file = path.string(), .advice = why}); };
  const hid_t id = H5Fopen(path.c_str(), H5F_ACC_RDONLY, H5P_DEFAULT);
  if (id < 0) refuse("is not an HDF5 file that can be read, or it is damaged");
  const Handle whole(id, H5Fclose);
  Reading reading;
  if (H5Ovisit(whole, H5_INDEX_NAME, H5_ITER_INC, read_object, &reading) < 0 || reading.trouble)
    refuse("is not an HDF5 file that can be read, or it is damaged");
  if (reading.arrays.empty()) refuse("holds no array of numbers of one or two dimensions");
  return std::move(reading.arrays);
}

}  // namespace sinew::sim

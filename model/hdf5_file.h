// SPDX-License-Identifier: Apache-2.0
// HDF5 files as plain values: arrays and attributes by path. Files are made and read in memory, so that they are written whole
// or not at all.
#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <string_view>
#include <vector>

namespace sinew::model {

// A dense array, its last index running fastest. Kept as 64-bit floats in `doubles` files, else as 32-bit ones.
struct Hdf5Array {
  std::vector<std::uint64_t> extents;
  std::vector<double> values;
  bool single = true;  // 32 bits in the file
};

struct Hdf5File {
  std::map<std::string, Hdf5Array> arrays;                                                 // by absolute path
  std::map<std::string, std::map<std::string, std::string>> text_attributes;               // by path of group or array, "/" the root
  std::map<std::string, std::map<std::string, std::vector<std::string>>> list_attributes;  // of text
};

// The file's bytes; the same content gives the same. Groups are made as paths need them.
std::string to_bytes(const Hdf5File& file);
// Every array of floating-point numbers and every attribute that is text. Throws InputError naming `name` where it is no HDF5.
Hdf5File parse_hdf5(const std::string& bytes, const std::string& name);

}  // namespace sinew::model

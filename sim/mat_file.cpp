// SPDX-License-Identifier: Apache-2.0
#include "sim/mat_file.h"

#include <bit>
#include <cctype>
#include <cstdint>
#include <cstring>
#include <set>

#include "sim/input_error.h"

namespace sinew::sim {
namespace {

static_assert(std::endian::native == std::endian::little);
// Types of data elements, and the class of an array.
constexpr std::uint32_t mi_int8 = 1, mi_int32 = 5, mi_uint32 = 6, mi_double = 9, mi_matrix = 14, mx_double = 6;
constexpr std::size_t most_rows = std::size_t{1} << 27, longest_name = 63;

template <class Number>
void append(std::string& bytes, Number number) {
  char raw[sizeof number];
  std::memcpy(raw, &number, sizeof number);
  bytes.append(raw, sizeof number);
}

// Tag, data, and zeros up to the next multiple of eight.
void append_element(std::string& bytes, std::uint32_t type, std::string_view data) {
  append(bytes, type);
  append(bytes, static_cast<std::uint32_t>(data.size()));
  bytes.append(data);
  bytes.append((8 - data.size() % 8) % 8, '\0');
}

std::string variable_name(const std::string& column) {
  std::string name;
  for (const char c : column) name += std::isalnum(static_cast<unsigned char>(c)) ? c : '_';
  if (name.empty() || !std::isalpha(static_cast<unsigned char>(name.front()))) name = "x" + name;
  return name;
}

}  // namespace

std::string to_mat(const Table& table) {
  std::string file = "MATLAB 5.0 MAT-file, written by sinew";  // without the date that others put here: the same table gives the same bytes
  file.resize(124, ' ');
  append(file, std::uint16_t{0x0100});
  file += "IM";
  std::set<std::string> names;
  for (const TableColumn& column : table.columns) {
    const std::string name = variable_name(column.name);
    const auto refuse = [&](const std::string& advice) { throw InputError({.file = "", .key = column.name, .advice = advice}); };
    if (name.size() > longest_name) refuse("is longer than the 63 letters that MATLAB allows; write HDF5 (.h5)");
    if (column.values.size() > most_rows) refuse("is longer than a MATLAB file of version 5 can hold; write HDF5 (.h5)");
    if (!names.insert(name).second) refuse("would be the variable " + name + ", as another column is; write HDF5 (.h5)");
    std::string flags, extents, numbers, matrix;
    append(flags, mx_double);
    append(flags, std::uint32_t{0});
    append(extents, static_cast<std::int32_t>(column.values.size()));
    append(extents, std::int32_t{1});
    numbers.assign(reinterpret_cast<const char*>(column.values.data()), column.values.size() * sizeof(double));
    append_element(matrix, mi_uint32, flags);
    append_element(matrix, mi_int32, extents);
    append_element(matrix, mi_int8, name);
    append_element(matrix, mi_double, numbers);
    append_element(file, mi_matrix, matrix);
  }
  return file;
}

}  // namespace sinew::sim

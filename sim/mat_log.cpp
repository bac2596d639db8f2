// SPDX-License-Identifier: Apache-2.0
#include "sim/mat_log.h"

#include <matio.h>
#include <zlib.h>

#include <array>
#include <bit>
#include <cstdint>
#include <cstring>
#include <memory>
#include <new>
#include <optional>

#include "sim/input_error.h"
#include "sim/text.h"

namespace sinew::sim {
namespace {

constexpr std::size_t most_values = std::size_t{1} << 28;

struct CloseMat {
  void operator()(mat_t* file) const { Mat_Close(file); }
};
struct FreeVariable {
  void operator()(matvar_t* variable) const { Mat_VarFree(variable); }
};

template <class Number>
std::vector<double> as_doubles(const matvar_t& variable, std::size_t count) {
  const auto* const data = static_cast<const Number*>(variable.data);
  return std::vector<double>(data, data + count);
}

std::optional<std::vector<double>> values_of(const matvar_t& variable, std::size_t count) {
  if (variable.isComplex || variable.data == nullptr || count == 0 || count > most_values) return std::nullopt;
  if (variable.data_size <= 0 || variable.nbytes < count * static_cast<std::size_t>(variable.data_size)) return std::nullopt;
  switch (variable.class_type) {
    case MAT_C_DOUBLE:
    case MAT_C_SINGLE:
    case MAT_C_INT8:
    case MAT_C_UINT8:
    case MAT_C_INT16:
    case MAT_C_UINT16:
    case MAT_C_INT32:
    case MAT_C_UINT32:
    case MAT_C_INT64:
    case MAT_C_UINT64:
      break;
    default:
      return std::nullopt;
  }
  switch (variable.data_type) {
    case MAT_T_DOUBLE:
      return as_doubles<double>(variable, count);
    case MAT_T_SINGLE:
      return as_doubles<float>(variable, count);
    case MAT_T_INT8:
      return as_doubles<std::int8_t>(variable, count);
    case MAT_T_UINT8:
      return as_doubles<std::uint8_t>(variable, count);
    case MAT_T_INT16:
      return as_doubles<std::int16_t>(variable, count);
    case MAT_T_UINT16:
      return as_doubles<std::uint16_t>(variable, count);
    case MAT_T_INT32:
      return as_doubles<std::int32_t>(variable, count);
    case MAT_T_UINT32:
      return as_doubles<std::uint32_t>(variable, count);
    case MAT_T_INT64:
      return as_doubles<std::int64_t>(variable, count);
    case MAT_T_UINT64:
      return as_doubles<std::uint64_t>(variable, count);
    default:
      return std::nullopt;
  }
}

void append(std::vector<LogArray>& to, const std::string& name, matvar_t& variable, int depth = 0) {
  constexpr int deepest = 8;
  if (variable.rank != 2 || depth > deepest) return;
  if (variable.class_type == MAT_C_STRUCT) {
    if (variable.dims[0] * variable.dims[1] != 1) return;
    char* const* const fields = Mat_VarGetStructFieldnames(&variable);
    for (unsigned i = 0; i < Mat_VarGetNumberOfFields(&variable); ++i) {
      matvar_t* const field = Mat_VarGetStructFieldByIndex(&variable, i, 0);
      if (field != nullptr) append(to, name + "." + fields[i], *field, depth + 1);
    }
    return;
  }
  // Extents whose product overflows are those of a damaged file.
  if (variable.dims[0] > most_values || variable.dims[1] > most_values) return;
  if (const auto values = values_of(variable, variable.dims[0] * variable.dims[1])) {
    append_series(to, name, *values, variable.dims[0], variable.dims[1], true);
  }
}

// A file of version 5 (MATLAB 5 to 7.2) is a header and elements, each of which says how long it is; most are compressed, and have a
// checksum. matio takes what it can read of one that is cut off or damaged. Source: MathWorks, MAT-File Format (R2019b), chapter 1.
bool is_whole(const std::string& bytes) {
  constexpr std::size_t header_bytes = 128, tag_bytes = 8;
  constexpr std::uint32_t compressed = 15;
  const std::string version = bytes.size() < header_bytes ? "" : bytes.substr(124, 4);
  const bool is_little = version == std::string("\0\1IM", 4);
  if (!is_little && version != std::string("\1\0MI", 4)) return true;  // of another version
  const bool swapped = is_little != (std::endian::native == std::endian::little);
  const auto number_at = [&](std::size_t at) {
    std::uint32_t number;
    std::memcpy(&number, bytes.data() + at, sizeof number);
    return swapped ? __builtin_bswap32(number) : number;
  };
  for (std::size_t at = header_bytes; at < bytes.size();) {
    if (at + tag_bytes > bytes.size()) return false;
    const std::uint32_t type = number_at(at), length = number_at(at + 4);
    at += tag_bytes;
    if (length > bytes.size() - at) return false;
    if (type == compressed) {
      z_stream stream{};
      if (inflateInit(&stream) != Z_OK) throw std::bad_alloc();
      std::array<Bytef, 1 << 16> thrown_away;
      // zlib does not write to its input.
      stream.next_in = const_cast<Bytef*>(reinterpret_cast<const Bytef*>(bytes.data() + at));  // NOLINT
      stream.avail_in = length;
      int state = Z_OK;
      while (state == Z_OK) {
        stream.next_out = thrown_away.data();
        stream.avail_out = static_cast<uInt>(thrown_away.size());
        state = inflate(&stream, Z_NO_FLUSH);
      }
      inflateEnd(&stream);
      if (state != Z_STREAM_END) return false;
    }
    at += length;
  }
  return true;
}

}  // namespace

void append_series(std::vector<LogArray>& to, const std::string& name, const std::vector<double>& values, std::size_t rows,
                   std::size_t columns, bool by_columns) {
  if (rows == 1 || columns == 1) {
    to.push_back({name, values});
    return;
  }
  const bool wide = columns > rows;
  const std::size_t count = wide ? rows : columns, length = wide ? columns : rows;
  for (std::size_t k = 0; k < count; ++k) {
    LogArray one{name + "[" + std::to_string(k + 1) + "]", std::vector<double>(length)};
    for (std::size_t i = 0; i < length; ++i) {
      const std::size_t row = wide ? k : i, column = wide ? i : k;
      one.values[i] = values[by_columns ? row + column * rows : row * columns + column];
    }
    to.push_back(std::move(one));
  }
}

std::vector<LogArray> read_mat(const std::filesystem::path& path) {
  Mat_LogInitFunc("sinew", [](int, char*) {});  // what is wrong is said here
  const auto refuse = [&](const char* why) { throw InputError({.file = path.string(), .advice = why}); };
  const std::unique_ptr<mat_t, CloseMat> file(Mat_Open(path.c_str(), MAT_ACC_RDONLY));
  if (!file) refuse("is not a MATLAB file that can be read, or it is damaged");
  if (!is_whole(read_file(path))) refuse("is cut off or damaged: a variable in it is not whole");
  std::vector<LogArray> arrays;
  while (const std::unique_ptr<matvar_t, FreeVariable> variable{Mat_VarReadNext(file.get())}) {
    if (variable->name != nullptr) append(arrays, variable->name, *variable);
  }
  if (arrays.empty()) refuse("holds no variable of real numbers that can be read; is it damaged?");
  return arrays;
}

}  // namespace sinew::sim

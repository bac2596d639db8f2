// SPDX-License-Identifier: Apache-2.0
#include "model/hdf5_file.h"

#include <hdf5.h>
#include <hdf5_hl.h>

#include <set>
#include <stdexcept>
#include <utility>

#include "sim/input_error.h"

// H5LTopen_file_image never frees the 72 bytes in which it counts who uses the image, whatever the file (HDF5 1.10.8). What does without
// it, H5Pset_file_image alone, copies a file of up to 1 GiB three times. So the leak is let pass where leaks are looked for.
#if defined(__SANITIZE_ADDRESS__)
extern "C" const char* __lsan_default_suppressions();
extern "C" const char* __lsan_default_suppressions() { return "leak:H5LTopen_file_image\n"; }  // NOLINT: the sanitizer's name
#endif

namespace sinew::model {
namespace {

// Owns one identifier of the library.
class Handle {
 public:
  Handle(hid_t id, herr_t (*close)(hid_t)) : id_(id), close_(close) {
    if (id < 0) throw std::runtime_error("HDF5 refused");
  }
  Handle(Handle&& other) noexcept : id_(std::exchange(other.id_, -1)), close_(other.close_) {}
  Handle& operator=(Handle&&) = delete;
  ~Handle() {
    if (id_ >= 0) close_(id_);
  }
  operator hid_t() const { return id_; }

 private:
  hid_t id_;
  herr_t (*close_)(hid_t);
};

void expect(herr_t status) {
  if (status < 0) throw std::runtime_error("HDF5 refused");
}

Handle text_type(std::size_t size) {
  Handle type(H5Tcopy(H5T_C_S1), H5Tclose);
  expect(H5Tset_size(type, size));
  expect(H5Tset_cset(type, H5T_CSET_UTF8));
  return type;
}

// Of fixed length: text of variable length lies in a heap that the library reads without checking its lengths, so that a
// damaged file could end the program. Attributes have a limit of 64 KiB; what is longer must take that way.
constexpr std::size_t longest_fixed = 32768;

void write_attribute(hid_t where, const std::string& name, const std::string& text) {
  const Handle space(H5Screate(H5S_SCALAR), H5Sclose);
  if (text.size() < longest_fixed) {
    const Handle type = text_type(text.size() + 1);
    const Handle attribute(H5Acreate2(where, name.c_str(), type, space, H5P_DEFAULT, H5P_DEFAULT), H5Aclose);
    expect(H5Awrite(attribute, type, text.c_str()));
    return;
  }
  const Handle type = text_type(H5T_VARIABLE);
  const Handle attribute(H5Acreate2(where, name.c_str(), type, space, H5P_DEFAULT, H5P_DEFAULT), H5Aclose);
  const char* pointer = text.c_str();
  expect(H5Awrite(attribute, type, &pointer));
}
void write_attribute(hid_t where, const std::string& name, const std::vector<std::string>& list) {
  std::size_t longest = 1;
  for (const std::string& one : list) longest = std::max(longest, one.size());
  std::string bytes;
  for (const std::string& one : list) bytes += one + std::string(longest - one.size(), '\0');
  Handle type(H5Tcopy(H5T_C_S1), H5Tclose);
  expect(H5Tset_size(type, longest));
  expect(H5Tset_strpad(type, H5T_STR_NULLPAD));
  const hsize_t count = list.size();
  const Handle space(H5Screate_simple(1, &count, nullptr), H5Sclose);
  const Handle attribute(H5Acreate2(where, name.c_str(), type, space, H5P_DEFAULT, H5P_DEFAULT), H5Aclose);
  expect(H5Awrite(attribute, type, bytes.data()));
}

std::vector<std::string> read_texts(hid_t attribute) {
  const Handle type(H5Aget_type(attribute), H5Tclose), space(H5Aget_space(attribute), H5Sclose);
  if (H5Tget_class(type) != H5T_STRING) return {};
  const auto count = static_cast<std::size_t>(std::max<hssize_t>(0, H5Sget_simple_extent_npoints(space)));
  std::vector<std::string> texts(count);
  if (count == 0) return texts;
  if (H5Tis_variable_str(type) > 0) {
    const Handle memory = text_type(H5T_VARIABLE);
    expect(H5Tset_cset(memory, H5Tget_cset(type)));
    std::vector<char*> pointers(count, nullptr);
    expect(H5Aread(attribute, memory, pointers.data()));
    for (std::size_t i = 0; i < count; ++i) texts[i] = pointers[i] ? pointers[i] : "";
    expect(H5Dvlen_reclaim(memory, space, H5P_DEFAULT, pointers.data()));
  } else {
    const std::size_t size = H5Tget_size(type);
    std::string bytes(count * size, '\0');
    expect(H5Aread(attribute, type, bytes.data()));
    for (std::size_t i = 0; i < count; ++i) {
      texts[i] = bytes.substr(i * size, size);
      texts[i].erase(texts[i].find_last_not_of('\0') + 1);
    }
  }
  return texts;
}

struct Reading {
  Hdf5File file;
  bool trouble = false;
};

herr_t read_attribute(hid_t where, const char* name, const H5A_info_t*, void* data) {
  auto& [reading, path] = *static_cast<std::pair<Reading*, std::string>*>(data);
  try {
    const Handle attribute(H5Aopen(where, name, H5P_DEFAULT), H5Aclose);
    const Handle space(H5Aget_space(attribute), H5Sclose), type(H5Aget_type(attribute), H5Tclose);
    if (H5Tget_class(type) != H5T_STRING) return 0;
    std::vector<std::string> texts = read_texts(attribute);
    if (H5Sget_simple_extent_type(space) == H5S_SCALAR)
      reading->file.text_attributes[path][name] = texts.empty() ? "" : texts.front();
    else
      reading->file.list_attributes[path][name] = std::move(texts);
  } catch (const std::exception&) {
    reading->trouble = true;
  }
  return 0;
}

herr_t read_object(hid_t root, const char* name, const H5O_info_t* info, void* data) {
  auto& reading = *static_cast<Reading*>(data);
  try {
    const std::string path = std::string(name) == "." ? "/" : "/" + std::string(name);
    const Handle object(H5Oopen(root, name, H5P_DEFAULT), H5Oclose);
    std::pair<Reading*, std::string> to{&reading, path};
    H5Aiterate2(object, H5_INDEX_NAME, H5_ITER_INC, nullptr, read_attribute, &to);
    if (info->type != H5O_TYPE_DATASET) return 0;
    const Handle type(H5Dget_type(object), H5Tclose), space(H5Dget_space(object), H5Sclose);
    if (H5Tget_class(type) != H5T_FLOAT) return 0;
    Hdf5Array array;
    array.single = H5Tget_size(type) <= 4;
    const int rank = H5Sget_simple_extent_ndims(space);
    std::vector<hsize_t> extents(static_cast<std::size_t>(std::max(0, rank)));
    H5Sget_simple_extent_dims(space, extents.data(), nullptr);
    array.extents.assign(extents.begin(), extents.end());
    const hssize_t count = H5Sget_simple_extent_npoints(space);
    if (count < 0 || count > (hssize_t{1} << 28)) throw std::runtime_error("an array too large");
    array.values.resize(static_cast<std::size_t>(count));
    expect(H5Dread(object, H5T_NATIVE_DOUBLE, H5S_ALL, H5S_ALL, H5P_DEFAULT, array.values.data()));
    reading.file.arrays[path] = std::move(array);
  } catch (const std::exception&) {
    reading.trouble = true;
  }
  return 0;
}

}  // namespace

std::string to_bytes(const Hdf5File& file) {
  const Handle access(H5Pcreate(H5P_FILE_ACCESS), H5Pclose), creation(H5Pcreate(H5P_FILE_CREATE), H5Pclose);
  expect(H5Pset_fapl_core(access, 1 << 16, false));  // in memory
  expect(H5Pset_libver_bounds(access, H5F_LIBVER_EARLIEST, H5F_LIBVER_V110));
  const Handle whole(H5Fcreate("in memory", H5F_ACC_TRUNC, creation, access), H5Fclose);
  // No times in the file: the same content gives the same bytes.
  const Handle group_creation(H5Pcreate(H5P_GROUP_CREATE), H5Pclose), array_creation(H5Pcreate(H5P_DATASET_CREATE), H5Pclose);
  expect(H5Pset_obj_track_times(group_creation, false));
  expect(H5Pset_obj_track_times(array_creation, false));
  std::set<std::string> groups;
  const auto make_groups = [&](const std::string& path, bool last_too) {
    for (std::size_t at = path.find('/', 1);; at = path.find('/', at + 1)) {
      const bool end = at == std::string::npos;
      if (end && !last_too) break;
      const std::string group = path.substr(0, at);
      if (group.size() > 1 && !file.arrays.count(group) && groups.insert(group).second)
        Handle(H5Gcreate2(whole, group.c_str(), H5P_DEFAULT, group_creation, H5P_DEFAULT), H5Gclose);
      if (end) break;
    }
  };
  for (const auto& [path, array] : file.arrays) {
    make_groups(path, false);
    std::vector<hsize_t> extents(array.extents.begin(), array.extents.end());
    const Handle space(H5Screate_simple(static_cast<int>(extents.size()), extents.data(), nullptr), H5Sclose);
    const Handle data(H5Dcreate2(whole, path.c_str(), array.single ? H5T_IEEE_F32LE : H5T_IEEE_F64LE, space, H5P_DEFAULT, array_creation,
                                 H5P_DEFAULT),
                      H5Dclose);
    expect(H5Dwrite(data, H5T_NATIVE_DOUBLE, H5S_ALL, H5S_ALL, H5P_DEFAULT, array.values.data()));
  }
  const auto write_all = [&](const auto& of_paths) {
    for (const auto& [path, attributes] : of_paths) {
      make_groups(path, true);
      const Handle object(H5Oopen(whole, path.c_str(), H5P_DEFAULT), H5Oclose);
      for (const auto& [name, value] : attributes) write_attribute(object, name, value);
    }
  };
  write_all(file.text_attributes);
  write_all(file.list_attributes);
  expect(H5Fflush(whole, H5F_SCOPE_LOCAL));
  const ssize_t size = H5Fget_file_image(whole, nullptr, 0);
  if (size < 0) throw std::runtime_error("HDF5 refused");
  std::string bytes(static_cast<std::size_t>(size), '\0');
  if (H5Fget_file_image(whole, bytes.data(), bytes.size()) != size) throw std::runtime_error("HDF5 refused");
  return bytes;
}

Hdf5File parse_hdf5(const std::string& bytes, const std::string& name) {
  H5Eset_auto2(H5E_DEFAULT, nullptr, nullptr);  // what is wrong is said here
  std::string copy = bytes;
  const auto refuse = [&]() { throw sim::InputError({.file = name, .advice = "is not an HDF5 file that can be read, or it is damaged"}); };
  const hid_t id = H5LTopen_file_image(copy.data(), copy.size(), H5LT_FILE_IMAGE_DONT_RELEASE | H5LT_FILE_IMAGE_DONT_COPY);
  if (id < 0) refuse();
  const Handle whole(id, H5Fclose);
  Reading reading;
  if (H5Ovisit(whole, H5_INDEX_NAME, H5_ITER_INC, read_object, &reading) < 0 || reading.trouble) refuse();
  return std::move(reading.file);
}

}  // namespace sinew::model

// SPDX-License-Identifier: Apache-2.0
// The format: APPNOTE.TXT 6.3 of PKWARE, sections 4.3.7 (local header), 4.3.12 (central directory) and 4.3.16 (its end).
#include "fmu/archive.h"

#include <zlib.h>

#include <cstdint>
#include <new>
#include <stdexcept>

namespace sinew::fmu {
namespace {

void put(std::string& bytes, std::uint64_t value, int count) {
  for (int b = 0; b < count; ++b) bytes += static_cast<char>(value >> (8 * b) & 0xff);
}

// Without zlib's own header, as a zip archive has it.
std::string deflated(const std::string& content) {
  z_stream stream{};
  if (deflateInit2(&stream, 9, Z_DEFLATED, -MAX_WBITS, 8, Z_DEFAULT_STRATEGY) != Z_OK) throw std::bad_alloc();
  std::string result(deflateBound(&stream, static_cast<uLong>(content.size())), '\0');
  stream.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(content.data()));
  stream.avail_in = static_cast<uInt>(content.size());
  stream.next_out = reinterpret_cast<Bytef*>(result.data());
  stream.avail_out = static_cast<uInt>(result.size());
  const int flag = deflate(&stream, Z_FINISH);
  result.resize(stream.total_out);
  deflateEnd(&stream);
  if (flag != Z_STREAM_END) throw std::runtime_error("zlib did not finish");
  return result;
}

}  // namespace

std::string to_zip(const std::vector<ArchivedFile>& files) {
  constexpr std::uint32_t version = 20, unix_host = 3 << 8, deflate_method = 8, first_date = 1 << 5 | 1;
  std::string archive, directory;
  for (const ArchivedFile& file : files) {
    const std::string packed = deflated(file.content);
    std::string about;  // what both headers say
    put(about, version, 2);
    put(about, 0, 2);
    put(about, deflate_method, 2);
    put(about, first_date << 16, 4);
    put(about,
        static_cast<std::uint32_t>(crc32(0, reinterpret_cast<const Bytef*>(file.content.data()), static_cast<uInt>(file.content.size()))),
        4);
    put(about, static_cast<std::uint32_t>(packed.size()), 4);
    put(about, static_cast<std::uint32_t>(file.content.size()), 4);
    put(about, static_cast<std::uint32_t>(file.path.size()), 2);
    put(about, 0, 2);
    put(directory, 0x02014b50, 4);
    put(directory, version | unix_host, 2);
    directory += about;
    put(directory, 0, 6);
    put(directory, (file.executable ? 0100755u : 0100644u) << 16, 4);
    put(directory, static_cast<std::uint32_t>(archive.size()), 4);
    directory += file.path;
    put(archive, 0x04034b50, 4);
    archive += about + file.path + packed;
  }
  const auto begin = static_cast<std::uint32_t>(archive.size()), length = static_cast<std::uint32_t>(directory.size());
  archive += directory;
  put(archive, 0x06054b50, 4);
  put(archive, 0, 4);
  for (int twice = 0; twice < 2; ++twice) put(archive, static_cast<std::uint32_t>(files.size()), 2);
  put(archive, length, 4);
  put(archive, begin, 4);
  put(archive, 0, 2);
  return archive;
}

}  // namespace sinew::fmu

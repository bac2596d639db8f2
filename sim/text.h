// SPDX-License-Identifier: Apache-2.0
// Numbers as text that reads back as the same number, and files that are read and written whole.
#pragma once

#include <filesystem>
#include <limits>
#include <optional>
#include <string>
#include <string_view>

namespace sinew::sim {

// The shortest decimal form that reads back as the same double (std::to_chars). Any NaN is "nan", the infinities are
// "inf" and "-inf", and zero keeps its sign.
std::string shortest(double value);
void append_shortest(std::string& text, double value);

// Stands for a reading or an input that a row does not have.
inline constexpr double not_a_number = std::numeric_limits<double>::quiet_NaN();

// The number that the whole token is, spaces and tabs around it aside; independent of the locale. One leading '+' is
// accepted, and "nan" in any case. Anything else is nullopt: an empty token, words, "inf", hexadecimal, a number that
// no double is near.
std::optional<double> parse_number(std::string_view token);

// Without spaces and tabs at both ends.
std::string_view trimmed(std::string_view text);

// The letters A to Z as a to z, whatever the locale; everything else as it is.
std::string lower_case(std::string_view text);

// The content of the file, byte by byte: of at most 1 GiB, so that a file without end has one. Throws InputError with the path and the
// system's reason.
std::string read_file(const std::filesystem::path& path);

// Writes the file whole or not at all: as `half_written(path)` in the same folder, then moved to `path`, over what was there.
// A symbolic link is followed; what is not a regular file (a pipe, /dev/stdout) is written to directly.
// Throws InputError with the path and the system's reason, and where another process is writing the same file; nothing is left then.
void write_file_whole(const std::filesystem::path& path, std::string_view content);

// The hidden file beside `path` that write_file_whole writes first. One that was left behind when the machine stopped may go.
std::filesystem::path half_written(const std::filesystem::path& path);
bool is_half_written(const std::filesystem::path& path);

}  // namespace sinew::sim

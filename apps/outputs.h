// SPDX-License-Identifier: Apache-2.0
// How commands write files. Nothing that a user owns is overwritten in silence, and the rules for that stand here alone:
//
// - An output is never an input, whatever its name: files are compared by device and inode.
// - A file that is there already is replaced only with --overwrite, and those of a session with the physical limb never.
// - One command at a time writes into a folder.
// - The files of one result appear together. A command that ends early leaves the folder as it was.
//
// For people: docs/outputs.md.
#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "apps/app.h"

namespace sinew::apps {

// What a command reads, as its arguments name it; empty names are left out. Of a folder all files in it and in its folders count.
// Of a YAML file the files that it names count too, looked for beside it: a recording to replay, the base of a plant.
struct InputPaths {
  std::vector<std::string> files{}, yaml{};
};

// The `limb` of session.json where there was none: all other sessions cannot be made again.
inline constexpr std::string_view emulated_limb = "emulated, lock step";

void add_overwrite(CLI::App& command, bool& overwrite);

// For a command that only reads: finishes what an interrupted one had complete in the folders of these files. Outputs does the same.
void finish_interrupted(const InputPaths& inputs);

// Throws InputError where `file`, the only output of a command, is an input, or is there and may not be replaced.
void check_output_file(const std::filesystem::path& file, const InputPaths& inputs, bool overwrite);

// The folder that a command writes into: locked from construction to destruction. A folder made here goes again if it stays empty.
class Outputs {
 public:
  // Makes and locks the folder, finishes what an interrupted command had complete, removes what it had not. Throws InputError where
  // `folder` is no folder, cannot be written to, or is locked by another process.
  // `just_made`: the caller made the folder for this command, and it goes as if it had been made here.
  Outputs(const std::filesystem::path& folder, const InputPaths& inputs, bool overwrite, bool just_made = false);
  ~Outputs();
  Outputs(const Outputs&) = delete;
  Outputs& operator=(const Outputs&) = delete;

  const std::filesystem::path& folder() const { return folder_; }
  bool overwrite() const { return overwrite_; }

  // Says which files will be written, before the work. Throws InputError where one of them is an input, or is there already;
  // `goes_on`: those there are an earlier state of the same result, and may be replaced without --overwrite.
  void claim(const std::vector<std::string>& names, bool goes_on = false);
  // For what the command writes one by one, by write_file_whole: throws InputError where this file, or one in this folder, is an
  // input. Removes what an interrupted command left half-written there.
  void claim_in_parts(const std::string& name);

  // Keeps a claimed file until `commit`; where it is kept is returned.
  std::filesystem::path stage(const std::string& name, std::string_view content);
  // A file in the same place that is not part of the result.
  std::filesystem::path scratch(const std::string& name);
  // A file that goes when the staged ones come.
  void discard(const std::string& name);
  // Puts all staged files in place, in the order of staging: the one that says that all are there is staged last. Files that are
  // there, were claimed without `goes_on` and not staged belong to the result that is replaced, and go.
  void commit();
  // Lets go of the folder: what was staged goes, the lock, and a folder that was made here and is empty. Nothing may be called after it.
  void abandon() noexcept;

 private:
  using FileId = std::pair<std::uint64_t, std::uint64_t>;
  void check_not_input(const std::filesystem::path& file) const;

  std::filesystem::path folder_;
  bool overwrite_;
  std::map<FileId, std::string> inputs_;
  std::vector<std::filesystem::path> made_folders_;
  std::vector<std::string> claimed_, staged_, replaced_;
  int lock_ = -1;
};

}  // namespace sinew::apps

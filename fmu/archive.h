// SPDX-License-Identifier: Apache-2.0
// Files as the bytes of a zip archive.
#pragma once

#include <string>
#include <vector>

namespace sinew::fmu {

struct ArchivedFile {
  std::string path;  // ASCII, with `/` between folders
  std::string content;
  bool executable = false;
};

// Deflated, in this order, all dated 1 January 1980: the same files give the same bytes. Less than 4 GiB.
std::string to_zip(const std::vector<ArchivedFile>& files);

}  // namespace sinew::fmu

// SPDX-License-Identifier: Apache-2.0
// A session again from its folder, without hardware: the same code over the log of its wire.
#pragma once

#include <filesystem>

#include "hil/session.h"

namespace sinew::hil {

struct Replayed {
  std::map<std::string, std::string> files;  // as they are made now
  std::map<std::string, std::string> stored;
  SessionResult result;
};

// Throws sim::InputError where the folder is no session's, or a file is not what session.json has the hash of; ReplayDiffers
// where the session takes another course.
Replayed replay_session(const std::filesystem::path& folder);

}  // namespace sinew::hil

// SPDX-License-Identifier: Apache-2.0
#include "apps/outputs.h"

#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <csignal>
#include <cstdio>
#include <cstring>
#include <nlohmann/json.hpp>
#include <optional>
#include <sstream>
#include <stdexcept>

#include "plant/contains.h"
#include "sim/input_error.h"
#include "sim/text.h"
#include "sim/yaml.h"

namespace sinew::apps {
namespace {

namespace fs = std::filesystem;
using FileId = std::pair<std::uint64_t, std::uint64_t>;
using Inputs = std::map<FileId, std::string>;

// Beside the results while a command runs. Staged files are in `staging`; when all are, it becomes `complete` in one step, and from
// then on the new result counts: who finds it moves the rest of the files, in the order that `order` gives.
constexpr const char* lock_name = ".sinew.lock";
constexpr const char* staging_name = ".sinew.partial";
constexpr const char* complete_name = ".sinew.complete";
constexpr const char* order_name = ".order";

[[noreturn]] void refuse(const fs::path& folder, const std::string& advice) {
  throw sim::InputError({.file = "", .key = "--out", .value = folder.string(), .advice = advice});
}

bool is_there(const fs::path& file) {  // a link that leads nowhere is there, too
  std::error_code none;
  return fs::exists(fs::symlink_status(file, none));
}

std::optional<FileId> id_of(const fs::path& file) {
  struct stat facts {};
  if (::stat(file.c_str(), &facts) != 0) return std::nullopt;
  return FileId{facts.st_dev, facts.st_ino};
}

// --- One command at a time -------------------------------------------------------------------------------------------------------

// Since boot, in clock ticks: with the process id it names one process for good. Nothing where there is no such process.
std::optional<std::uint64_t> start_of_process(long process) {
  const fs::path file = "/proc/" + std::to_string(process) + "/stat";
  if (!fs::exists(file)) return std::nullopt;
  std::string text;
  try {
    text = sim::read_file(file);
  } catch (const sim::InputError&) {
    return std::nullopt;
  }
  const std::size_t name_end = text.rfind(')');  // the name before it may hold anything
  if (name_end == std::string::npos) return std::nullopt;
  std::istringstream fields(text.substr(name_end + 1));
  std::string field;
  for (int k = 3; k < 22; ++k) fields >> field;
  std::uint64_t start = 0;
  return fields >> start ? std::optional(start) : std::nullopt;
}

std::string own_command_line() {
  std::string text = sim::read_file("/proc/self/cmdline");
  std::replace(text.begin(), text.end(), '\0', ' ');
  return text;
}

struct Holder {
  long process = 0;
  std::uint64_t start = 0;
  std::string command;
};
Holder read_holder(int descriptor) {
  std::string text(1000, '\0');
  const ssize_t got = ::pread(descriptor, text.data(), text.size(), 0);
  text.resize(got > 0 ? static_cast<std::size_t>(got) : 0);
  Holder holder;
  std::istringstream lines(text);
  lines >> holder.process >> holder.start >> std::ws;
  std::getline(lines, holder.command);
  return holder;
}

struct Lock {
  int descriptor = -1;             // -1: not taken
  std::optional<Holder> holder{};  // by whom not
};

// The kernel lets go of the lock when its process ends, however that ends, so that one left behind is simply taken. Where the file
// system has no such locks, the process that the file names decides.
Lock take_lock(const fs::path& folder) {
  const fs::path file = folder / lock_name;
  for (;;) {
    const int descriptor = ::open(file.c_str(), O_RDWR | O_CREAT | O_CLOEXEC | O_NOFOLLOW, 0666);
    if (descriptor < 0 && errno == ENOENT && fs::create_directories(folder)) continue;  // another command, at its end, removed it
    if (descriptor < 0) refuse(folder, std::string("cannot be locked: ") + std::strerror(errno));
    const bool locked = ::flock(descriptor, LOCK_EX | LOCK_NB) == 0;
    const bool has_locks = locked || errno == EWOULDBLOCK;
    const Holder holder = read_holder(descriptor);
    const bool holder_lives = holder.process > 0 && start_of_process(holder.process) == holder.start;
    if (!locked && (has_locks || holder_lives)) {
      ::close(descriptor);
      return {-1, holder};
    }
    // Whoever had it may have removed the file between our opening and locking it.
    struct stat ours {};
    const auto there = id_of(file);
    if (::fstat(descriptor, &ours) != 0 || there != FileId{ours.st_dev, ours.st_ino}) {
      ::close(descriptor);
      continue;
    }
    const std::string text =
        std::to_string(::getpid()) + " " + std::to_string(start_of_process(::getpid()).value_or(0)) + "\n" + own_command_line() + "\n";
    if (::ftruncate(descriptor, 0) != 0 || ::pwrite(descriptor, text.data(), text.size(), 0) != static_cast<ssize_t>(text.size())) {
      const int reason = errno;
      ::unlink(file.c_str());
      ::close(descriptor);
      refuse(folder, std::string("cannot be locked: ") + std::strerror(reason));
    }
    return {descriptor, {}};
  }
}

void release_lock(const fs::path& folder, int descriptor) {
  ::unlink((folder / lock_name).c_str());
  ::close(descriptor);
}

// --- Files that appear together --------------------------------------------------------------------------------------------------

void to_disk(const fs::path& folder) {
  const int descriptor = ::open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  if (descriptor < 0) return;
  ::fsync(descriptor);
  ::close(descriptor);
}

// A second Ctrl-C ends the program at once, but not here.
class SignalsWait {
 public:
  SignalsWait() {
    sigset_t all;
    sigfillset(&all);
    pthread_sigmask(SIG_BLOCK, &all, &before_);
  }
  ~SignalsWait() { pthread_sigmask(SIG_SETMASK, &before_, nullptr); }
  SignalsWait(const SignalsWait&) = delete;
  SignalsWait& operator=(const SignalsWait&) = delete;

 private:
  sigset_t before_{};
};

// Begins anywhere: what is done already is not done again. A folder may come from anybody, and reading it may put it in order, so that an
// order that reaches out of it is refused.
void put_complete_in_place(const fs::path& folder) {
  const fs::path complete = folder / complete_name, around = fs::canonical(folder);
  std::istringstream lines(sim::read_file(complete / order_name));
  std::string what, name;
  while (lines >> what >> std::ws && std::getline(lines, name)) {
    const fs::path inside = fs::weakly_canonical((folder / name).parent_path()).lexically_relative(around);
    if (inside.empty() || *inside.begin() == ".." || fs::path(name).filename() == "..")
      throw sim::InputError({.file = (complete / order_name).string(),
                             .key = what,
                             .value = name,
                             .advice = "lies outside of this folder; no command of sinew wrote that: remove " + complete.string()});
    if (what == "remove") {
      fs::remove(folder / name);
    } else if (is_there(complete / name)) {
      fs::create_directories((folder / name).parent_path());
      fs::rename(complete / name, folder / name);
    }
  }
  to_disk(folder);
  fs::remove_all(complete);
}

void settle(const fs::path& folder) {
  if (fs::exists(folder / complete_name)) put_complete_in_place(folder);
  fs::remove_all(folder / staging_name);
}

// --- Inputs ----------------------------------------------------------------------------------------------------------------------

// What is read next must be one result, not the half of one.
void settle_input_folder(const fs::path& folder) {
  if (!fs::exists(folder / complete_name)) return;
  const Lock lock = take_lock(folder);
  if (lock.descriptor < 0) return;  // whoever has it is about to do it
  try {
    settle(folder);
  } catch (...) {
    release_lock(folder, lock.descriptor);
    throw;
  }
  release_lock(folder, lock.descriptor);
}

void add_file(Inputs& inputs, const fs::path& file) {
  if (const auto id = id_of(file)) inputs.emplace(*id, file.string());
}

void add_file_or_folder(Inputs& inputs, const fs::path& path) {
  if (!fs::is_directory(path)) {
    settle_input_folder(path.has_parent_path() ? path.parent_path() : fs::path("."));
    add_file(inputs, path);
    return;
  }
  settle_input_folder(path);
  constexpr int deepest = 1;  // a set's recordings are one folder down; nothing that a command reads is further
  std::error_code none;
  const auto options = fs::directory_options::skip_permission_denied;
  for (auto it = fs::recursive_directory_iterator(path, options, none); it != fs::recursive_directory_iterator(); it.increment(none)) {
    if (it.depth() >= deepest) it.disable_recursion_pending();
    if (it->is_regular_file(none)) add_file(inputs, it->path());
  }
}

void add_yaml(Inputs& inputs, const fs::path& file);

// Any text that is the name of a file is taken for one: rather one input too many than one too few.
void add_named_files(Inputs& inputs, const sim::YamlValue& value, const fs::path& beside, const std::string& key) {
  for (const auto& entry : value.map) add_named_files(inputs, entry.value, beside, entry.key);
  for (const sim::YamlValue& one : value.list) add_named_files(inputs, one, beside, key);
  if (value.kind != sim::YamlValue::Kind::scalar || value.scalar.empty()) return;
  std::error_code none;
  const fs::path named = beside / value.scalar;
  if (!fs::is_regular_file(named, none)) return;
  if (key == "base")
    add_yaml(inputs, named);
  else
    add_file(inputs, named);
}

void add_yaml(Inputs& inputs, const fs::path& file) {
  settle_input_folder(file.has_parent_path() ? file.parent_path() : fs::path("."));
  const auto id = id_of(file);
  if (!id || inputs.contains(*id)) return;  // who reads it says that it is not there; bases may go in a circle
  std::error_code none;
  if (!fs::is_regular_file(file, none)) return;  // a pipe can be read once
  add_file(inputs, file);
  add_named_files(inputs, sim::read_yaml(file), file.parent_path(), "");
}

Inputs files_of(const InputPaths& paths) {
  Inputs inputs;
  for (const std::string& path : paths.yaml)
    if (!path.empty()) add_yaml(inputs, path);
  for (const std::string& path : paths.files)
    if (!path.empty()) add_file_or_folder(inputs, path);
  return inputs;
}

// --- What is there already -------------------------------------------------------------------------------------------------------

// The files of a session with the physical limb that lies in this folder; none where there is no such session.
std::vector<std::string> files_of_physical_session(const fs::path& folder) {
  const fs::path about = folder / "session.json";
  if (!is_there(about)) return {};
  std::vector<std::string> names{"session.json", "recording.csv", "timed.csv", "wire.bin", "scenario.yaml", "twin.yaml", "prediction.csv"};
  nlohmann::json json;
  try {
    json = nlohmann::json::parse(sim::read_file(about), nullptr, false);
  } catch (const sim::InputError&) {
    return names;
  }
  if (!json.is_object()) return names;  // what cannot be read may be of the limb
  const auto limb = json.find("limb"), hashes = json.find("sha256");
  if (limb != json.end() && limb->is_string() && limb->get<std::string>() == emulated_limb) return {};
  if (hashes != json.end() && hashes->is_object())
    for (const auto& [name, hash] : hashes->items()) names.push_back(name);
  return names;
}

std::string listed_names(const std::vector<std::string>& names) {
  constexpr std::size_t most = 6;
  std::string text;
  for (std::size_t i = 0; i < std::min(most, names.size()); ++i) text += (i == 0 ? "" : ", ") + names[i];
  return text + (names.size() > most ? " and " + std::to_string(names.size() - most) + " more" : "");
}

}  // namespace

void add_overwrite(CLI::App& command, bool& overwrite) {
  command.add_flag("--overwrite", overwrite, "replace results that are there already; never what is read, nor a session with the limb");
}

void finish_interrupted(const InputPaths& inputs) { files_of(inputs); }

void check_output_file(const fs::path& file, const InputPaths& inputs, bool overwrite) {
  const Inputs read = files_of(inputs);
  for (const fs::path& written : {file, sim::half_written(file)}) {
    const auto id = id_of(written);
    if (const auto same = id ? read.find(*id) : read.end(); same != read.end())
      throw sim::InputError(
          {.file = written.string(), .advice = "is the file that is read (" + same->second + "); name another one to write"});
  }
  std::error_code none;
  const bool is_device = fs::exists(file, none) && !fs::is_regular_file(file, none) && !fs::is_directory(file, none);
  if (!is_there(file) || is_device) return;
  if (fs::is_directory(file, none)) throw sim::InputError({.file = file.string(), .advice = "is a folder; name a file to write"});
  const auto session = files_of_physical_session(file.has_parent_path() ? file.parent_path() : fs::path("."));
  if (contains(session, file.filename().string()))
    throw sim::InputError(
        {.file = file.string(), .advice = "belongs to a session with the limb, which cannot be made again; name another file"});
  if (!overwrite)
    throw sim::InputError({.file = file.string(), .advice = "is there already; name another file, or replace it with --overwrite"});
}

Outputs::Outputs(const fs::path& folder, const InputPaths& inputs, bool overwrite, bool just_made)
    : folder_(folder), overwrite_(overwrite) {
  if (folder_.empty()) refuse(folder_, "is empty; a folder is needed");
  check_folder(folder_);
  inputs_ = files_of(inputs);
  for (fs::path there = fs::absolute(folder_); !fs::exists(there) && there.has_relative_path(); there = there.parent_path())
    if (there.has_filename()) made_folders_.push_back(there);
  if (just_made) made_folders_.push_back(fs::absolute(folder_));
  fs::create_directories(folder_);
  const Lock lock = take_lock(folder_);
  if (lock.holder)
    refuse(folder_, "another command is writing into this folder: process " + std::to_string(lock.holder->process) + ", " +
                        sim::printable(lock.holder->command, 200) + "\nwait until it ends, or give another folder");
  lock_ = lock.descriptor;
  try {
    settle(folder_);
  } catch (...) {
    release_lock(folder_, lock_);
    throw;
  }
}

Outputs::~Outputs() {
  if (lock_ >= 0) abandon();
}

void Outputs::abandon() noexcept {
  std::error_code none;
  fs::remove_all(folder_ / staging_name, none);
  release_lock(folder_, lock_);
  lock_ = -1;
  for (const fs::path& made : made_folders_) ::rmdir(made.c_str());  // the innermost first; one that is not empty stays
}

void Outputs::check_not_input(const fs::path& file) const {
  const auto id = id_of(file);
  if (!id) return;
  if (const auto same = inputs_.find(*id); same != inputs_.end())
    refuse(folder_, "would overwrite " + same->second + ", which this command reads" +
                        (same->second == file.string() ? "" : " (it is " + file.string() + ")") + "; give another folder");
}

void Outputs::claim(const std::vector<std::string>& names, bool goes_on) {
  std::vector<std::string> there;
  std::map<fs::path, std::vector<std::string>> sessions;  // of the folders that the files are in
  for (const std::string& name : names) {
    const fs::path file = folder_ / name, around = file.parent_path();
    check_not_input(file);
    claimed_.push_back(name);
    if (!is_there(file)) continue;
    if (fs::is_directory(fs::symlink_status(file))) refuse(folder_, name + " there is a folder; give another folder");
    if (!sessions.contains(around)) sessions[around] = files_of_physical_session(around);
    const std::vector<std::string>& session = sessions[around];
    if (contains(session, file.filename().string()))
      throw sim::InputError({.file = (around / "session.json").string(),
                             .key = "--out",
                             .value = folder_.string(),
                             .advice = "a session is there already, and cannot be made again; give another --out"});
    there.push_back(name);
    if (!goes_on) replaced_.push_back(name);
  }
  if (!there.empty() && !goes_on && !overwrite_)
    refuse(folder_, "holds results already: " + listed_names(there) + "\ngive another folder, or replace them with --overwrite");
}

void Outputs::claim_in_parts(const std::string& name) {
  const fs::path path = folder_ / name;
  if (!fs::is_directory(path)) {
    check_not_input(path);
    check_not_input(sim::half_written(path));
    fs::remove(sim::half_written(path));
    return;
  }
  std::vector<fs::path> half_written;
  for (const auto& entry : fs::recursive_directory_iterator(path)) {
    if (entry.is_regular_file()) check_not_input(entry.path());
    if (entry.is_regular_file() && sim::is_half_written(entry.path())) half_written.push_back(entry.path());
  }
  for (const fs::path& file : half_written) fs::remove(file);
}

fs::path Outputs::scratch(const std::string& name) {
  fs::path file = folder_ / staging_name / name;
  fs::create_directories(file.parent_path());
  return file;
}

fs::path Outputs::stage(const std::string& name, std::string_view content) {
  if (!contains(claimed_, name)) throw std::logic_error(name + " is written but was not claimed");
  fs::path file = scratch(name);
  sim::write_file_whole(file, content);
  staged_.push_back(name);
  return file;
}

void Outputs::discard(const std::string& name) { replaced_.push_back(name); }

void Outputs::commit() {
  std::string order;
  for (const std::string& name : replaced_)
    if (!contains(staged_, name)) order += "remove " + name + "\n";
  for (const std::string& name : staged_) order += "move " + name + "\n";
  sim::write_file_whole(scratch(order_name), order);
  to_disk(folder_ / staging_name);
  const SignalsWait waiting;
  fs::rename(folder_ / staging_name, folder_ / complete_name);
  to_disk(folder_);
  put_complete_in_place(folder_);
}

}  // namespace sinew::apps

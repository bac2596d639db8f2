// SPDX-License-Identifier: Apache-2.0
// A YAML file as plain values that know where they stand, so that every complaint can point there.
//
// The only file that includes the YAML library is yaml.cpp. Keys that stand twice, anchors that are not there and text
// that is no YAML are errors already when the file is read.
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "plant/parameter.h"
#include "sim/input_error.h"

namespace sinew::sim {

struct YamlValue {
  enum class Kind { empty, scalar, map, list };
  struct Entry;

  Kind kind = Kind::empty;
  std::string scalar;
  bool quoted = false;
  std::vector<Entry> map;
  std::vector<YamlValue> list;
  std::string file;
  int line = 0, column = 0;
  std::string path;  // "plant.effects.thermocouple_lag"

  // An error at this value. `advice` says what would be right.
  [[noreturn]] void complain(const std::string& advice) const;

  double number() const;
  double number_in(const plant::Range& range) const;
  std::int64_t whole_number() const;
  bool truth() const;
  const std::string& text() const;
};

struct YamlValue::Entry {
  std::string key;
  int line, column;
  YamlValue value;
};

YamlValue parse_yaml(std::string_view text, const std::string& file);
YamlValue read_yaml(const std::filesystem::path& file);

// Reads a map: every key that may stand there is asked for, and `finish` complains of all others.
class YamlMap {
 public:
  explicit YamlMap(const YamlValue& value);  // must be a map, or empty
  const YamlValue* find(std::string_view key);
  const YamlValue& require(std::string_view key, std::string_view what_for);
  // Complains of the first key that was not asked for, with the nearest that was. `known_elsewhere` completes that.
  void finish(std::string_view advice = "") const;
  const YamlValue& value() const { return value_; }

 private:
  const YamlValue& value_;
  std::vector<std::string> asked_;
};

}  // namespace sinew::sim

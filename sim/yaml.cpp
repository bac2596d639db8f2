// SPDX-License-Identifier: Apache-2.0
#include "sim/yaml.h"

#include <yaml-cpp/yaml.h>

#include <algorithm>
#include <charconv>
#include <cmath>

#include "plant/contains.h"
#include "sim/plain_text.h"
#include "sim/text.h"

namespace sinew::sim {
namespace {

std::string joined(const std::string& path, const std::string& key) { return path.empty() ? key : path + "." + key; }

// Deeper than any file that a person writes. An anchor that contains itself has no end.
constexpr int deepest = 64;
// Of values in a file, with every alias written out, and of bytes: a few lines of aliases could stand for more than any memory holds.
constexpr int most_values = 200'000;
constexpr std::size_t most_bytes = 16 << 20;

YamlValue convert(const YAML::Node& node, const std::string& file, const std::string& path, int& values, int depth = 0) {
  YamlValue value;
  value.file = file;
  value.path = path;
  value.line = node.Mark().line + 1;
  value.column = node.Mark().column + 1;
  if (depth > deepest) throw InputError({file, value.line, value.column, "", "", "is nested too deeply; does an anchor contain itself?"});
  if (++values > most_values)
    throw InputError({file, value.line, value.column, "", "", "the file has more than 200000 values; do its aliases name one another?"});
  switch (node.Type()) {
    case YAML::NodeType::Undefined:
    case YAML::NodeType::Null:
      break;
    case YAML::NodeType::Scalar:
      value.kind = YamlValue::Kind::scalar;
      value.scalar = node.Scalar();
      value.quoted = node.Tag() == "!";
      break;
    case YAML::NodeType::Sequence:
      value.kind = YamlValue::Kind::list;
      for (std::size_t i = 0; i < node.size(); ++i)
        value.list.push_back(convert(node[i], file, path + "[" + std::to_string(i) + "]", values, depth + 1));
      break;
    case YAML::NodeType::Map:
      value.kind = YamlValue::Kind::map;
      for (const auto& pair : node) {
        const int line = pair.first.Mark().line + 1, column = pair.first.Mark().column + 1;
        if (!pair.first.IsScalar()) throw InputError({file, line, column, path, "", "a key must be a plain word"});
        const std::string key = pair.first.Scalar();
        for (const auto& entry : value.map)
          if (entry.key == key)
            throw InputError(
                {file, line, column, joined(path, key), "", "stands twice; the first is in line " + std::to_string(entry.line)});
        value.map.push_back({key, line, column, convert(pair.second, file, joined(path, key), values, depth + 1)});
        // The library places what is not there where the next thing begins.
        YamlValue& added = value.map.back().value;
        if (added.kind == YamlValue::Kind::empty) added.line = line, added.column = column;
      }
      break;
  }
  return value;
}

}  // namespace

void YamlValue::complain(const std::string& advice) const {
  std::string found;
  switch (kind) {
    case Kind::empty:
      found = "(nothing)";
      break;
    case Kind::scalar:
      found = scalar;
      break;
    case Kind::map:
      found = "{ a map }";
      break;
    case Kind::list:
      found = "[ a list ]";
      break;
  }
  throw InputError({file, line, column, path.empty() ? "the file" : path, found, advice});
}

double YamlValue::number() const {
  if (kind != Kind::scalar || quoted) complain("must be a number");
  const auto parsed = parse_number(scalar);
  if (!parsed || !std::isfinite(*parsed)) {
    const bool begins_as_number = !scalar.empty() && (std::isdigit(static_cast<unsigned char>(scalar[0])) || scalar[0] == '-');
    complain(begins_as_number ? "must be a number alone; its unit stands in the key" : "must be a number");
  }
  return *parsed;
}

double YamlValue::number_in(const plant::Range& range) const {
  const double value = number();
  if (!range.contains(value)) complain("must lie in [" + shortest(range.lowest) + ", " + shortest(range.highest) + "]");
  return value;
}

std::int64_t YamlValue::whole_number() const {
  std::int64_t value = 0;
  const char* end = scalar.data() + scalar.size();
  if (kind != Kind::scalar || quoted) complain("must be a whole number");
  const auto result = std::from_chars(scalar.data(), end, value);
  if (result.ec == std::errc::result_out_of_range) complain("must lie in [-9223372036854775808, 9223372036854775807]");
  if (result.ec != std::errc{} || result.ptr != end) complain("must be a whole number");
  return value;
}

bool YamlValue::truth() const {
  if (kind == Kind::scalar && !quoted && scalar == "true") return true;
  if (kind == Kind::scalar && !quoted && scalar == "false") return false;
  complain("must be true or false");
}

const std::string& YamlValue::text() const {
  if (kind != Kind::scalar) complain("must be a word");
  if (!is_plain_text(scalar)) complain("must be UTF-8 without control characters, in one line");
  return scalar;
}

YamlValue parse_yaml(std::string_view text, const std::string& file) {
  if (text.size() > most_bytes) throw InputError({.file = file, .key = "size", .advice = "is larger than 16 MiB; no such file is"});
  try {
    // Mixed with spaces a tab means another depth to each reader: none may indent.
    for (std::size_t at = 0, line = 1; at < text.size(); ++line) {
      const std::size_t end = std::min(text.find('\n', at), text.size());
      const std::string_view row = text.substr(at, end - at);
      const std::size_t word = std::min(row.find_first_not_of(" \t"), row.size());
      if (const std::size_t tab = row.substr(0, word).find('\t'); tab != std::string_view::npos && word < row.size())
        throw InputError({file, static_cast<int>(line), static_cast<int>(tab) + 1, "", "", "no YAML: a tab indents; use spaces"});
      at = end + 1;
    }
    const std::vector<YAML::Node> documents = YAML::LoadAll(std::string(text));
    if (documents.size() > 1)
      throw InputError(
          {file, documents[1].Mark().line + 1, 0, "a second document", "", "only one may stand in a file; '---' begins another"});
    int values = 0;
    return convert(documents.empty() ? YAML::Node() : documents.front(), file, "", values);
  } catch (const YAML::Exception& e) {
    throw InputError({file, e.mark.line + 1, e.mark.column + 1, "", "", "no YAML: " + e.msg});
  }
}

YamlValue read_yaml(const std::filesystem::path& file) { return parse_yaml(read_file(file), file.string()); }

YamlMap::YamlMap(const YamlValue& value) : value_(value) {
  if (value.kind != YamlValue::Kind::map && value.kind != YamlValue::Kind::empty) value.complain("must be a map");
}

const YamlValue* YamlMap::find(std::string_view key) {
  asked_.emplace_back(key);
  for (const auto& entry : value_.map)
    if (entry.key == key) return &entry.value;
  return nullptr;
}

const YamlValue& YamlMap::require(std::string_view key, std::string_view what_for) {
  if (const YamlValue* found = find(key)) return *found;
  throw InputError(
      {value_.file, value_.line, value_.column, joined(value_.path, std::string(key)), "", "is missing: " + std::string(what_for)});
}

void YamlMap::finish(std::string_view advice) const {
  for (const auto& entry : value_.map) {
    if (contains(asked_, entry.key)) continue;
    std::string near = nearest(entry.key, asked_);
    // A key with another unit is nearest to the one that shares its first words.
    if (near.empty())
      for (const std::string& candidate : asked_)
        if (candidate.substr(0, candidate.rfind('_')) == entry.key.substr(0, entry.key.rfind('_'))) near = candidate;
    std::string words = "no such key here";
    if (!near.empty()) words += "; did you mean " + near + "?";
    std::string all;
    for (const std::string& candidate : asked_) all += (all.empty() ? "" : ", ") + candidate;
    if (near.empty()) words += "; what may stand here: " + all;
    if (!advice.empty()) words += "\n" + std::string(advice);
    throw InputError({value_.file, entry.line, entry.column, joined(value_.path, entry.key), "", words});
  }
}

}  // namespace sinew::sim

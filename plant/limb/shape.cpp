// SPDX-License-Identifier: Apache-2.0
#include "plant/limb/shape.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <numbers>
#include <set>

#include "plant/contains.h"

namespace sinew::plant {
namespace {

constexpr std::size_t most_segments = 64, most_coils = 256;

// Exact at multiples of 60 and of 90 degrees, and of the same size in every quadrant, so that what cancels on paper cancels to the
// last digit.
double cosine_deg(double degrees) {
  const double from_axis = std::abs(std::remainder(degrees, 360.0));  // 0 to 180, without rounding
  const double folded = std::min(from_axis, 180.0 - from_axis);
  const double size = folded == 90.0 ? 0.0 : folded == 60.0 ? 0.5 : std::cos(folded * std::numbers::pi / 180.0);
  return from_axis > 90.0 ? -size : size;
}

std::string joined(const std::string& first, const std::string& second) {
  return first.empty() ? second : second.empty() ? first : first + "_" + second;
}

const std::string axis_names[] = {"x", "y"};

// A map of a description: each key is asked for, and what was not asked for is an error.
class Fields {
 public:
  Fields(const Description& of, const char* what) : of_(of) {
    if (of.kind != Description::Kind::map) throw DescriptionError(of.path, std::string("must be a map: ") + what);
  }
  const Description* find(const std::string& key) {
    asked_.insert(key);
    for (const auto& [name, value] : of_.map)
      if (name == key) return &value;
    return nullptr;
  }
  const Description& require(const std::string& key, const std::string& what_for) {
    if (const Description* found = find(key)) return *found;
    throw DescriptionError(of_.path, "needs `" + key + "`: " + what_for);
  }
  void finish() const {
    std::string all;
    for (const std::string& key : asked_) all += (all.empty() ? "" : ", ") + key;
    for (const auto& [name, value] : of_.map)
      if (!asked_.contains(name)) throw DescriptionError(value.path, "unknown key; may stand here: " + all);
  }

 private:
  const Description& of_;
  std::set<std::string> asked_;
};

const std::vector<Description>& list_of(const Description& value, const char* what) {
  if (value.kind != Description::Kind::list || value.list.empty())
    throw DescriptionError(value.path, std::string("must be a list of at least one: ") + what);
  return value.list;
}

// Names become parts of keys and columns.
std::string name_of(const Description& value, std::set<std::string>& taken) {
  const auto fine = [](char c) { return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '_'; };
  if (value.kind != Description::Kind::scalar || value.scalar.empty() || value.scalar.size() > 40 ||
      !std::all_of(value.scalar.begin(), value.scalar.end(), fine))
    throw DescriptionError(value.path, "a name is up to 40 letters, digits and underscores");
  if (!taken.insert(value.scalar).second) throw DescriptionError(value.path, "this name stands twice");
  return value.scalar;
}

double number_of(const Description& value, double lowest, double highest) {
  double number = NAN;
  const char* end = value.scalar.data() + value.scalar.size();
  const auto [stop, error] = std::from_chars(value.scalar.data(), end, number);
  if (value.kind != Description::Kind::scalar || error != std::errc() || stop != end || !(number >= lowest && number <= highest))
    throw DescriptionError(value.path, "must be a number from " + std::to_string(static_cast<int>(lowest)) + " to " +
                                           std::to_string(static_cast<int>(highest)));
  return number;
}

template <class Named>
std::size_t index_of(const Description& value, const std::vector<Named>& list, const char* what) {
  std::string all;
  for (std::size_t i = 0; i < list.size(); ++i) {
    if (value.scalar == list[i].name) return i;
    all += (i ? ", " : "") + list[i].name;
  }
  throw DescriptionError(value.path, std::string("no such ") + what + "; there are " + all);
}

std::string number_text(double value) {
  char text[32];
  return std::string(text, std::to_chars(text, text + sizeof text, value).ptr);
}

}  // namespace

void Shape::complete() {
  bends.clear(), couplings.clear(), pairs.clear(), segment_names.clear(), bends_before.clear();
  thermocouple_coils.clear(), sensor_bends.clear();
  coils_of.assign(segments.size(), {});
  for (std::size_t s = 0; s < segments.size(); ++s) {
    segment_names.push_back(segments.size() == 1 ? "" : segments[s].name);
    for (int axis = 0; axis < segments[s].axes; ++axis)
      bends.push_back({s, axis, joined(segment_names[s], segments[s].axes == 1 ? "" : axis_names[axis])});
  }
  for (std::size_t j = 0; j < coils.size(); ++j) coils_of[coils[j].segment].push_back(j);
  for (std::size_t b = 0; b < bends.size(); ++b) {
    for (const std::size_t j : coils_of[bends[b].segment])
      if (const double cosine = cosine_deg(coils[j].direction_deg - 90.0 * bends[b].axis); cosine != 0.0)
        couplings.push_back({j, b, cosine});
    bends_before.emplace_back();
    for (std::size_t before = 0; before <= b; ++before)
      if (bends[before].axis == bends[b].axis) bends_before.back().push_back(before);
  }
  for (const auto& on_segment : coils_of)
    for (std::size_t a = 0; a < on_segment.size(); ++a)
      for (std::size_t b = a + 1; b < on_segment.size(); ++b) pairs.push_back({on_segment[a], on_segment[b]});
  for (const Sensor& sensor : sensors) {
    auto& parts = sensor.kind == Sensing::thermocouple ? thermocouple_coils : sensor_bends;
    if (sensor.kind != Sensing::camera && !contains(parts, sensor.part)) parts.push_back(sensor.part);
  }
}

Shape two_coil_shape() {
  Shape shape;
  shape.segments = {{"limb", 1}};
  shape.coils = {{"A", 0, 0.0}, {"B", 0, 180.0}};
  shape.sensors = {{"temperature_A_degC", Sensing::thermocouple, 0},
                   {"temperature_B_degC", Sensing::thermocouple, 1},
                   {"angle_deg", Sensing::bend, 0}};
  shape.is_two_coil_limb = true;
  shape.complete();
  return shape;
}

Shape shape_of(const Description& limb) {
  Shape shape;
  Fields fields(limb, "segments, coils, channels");
  const Description& segments = fields.require("segments", "[{name: limb, axes: 1}]");
  const Description& coils = fields.require("coils", "[{name: A, segment: limb, direction_deg: 0}]");
  const Description& channels = fields.require("channels", "[{column: temperature_A_degC, thermocouple: A}]");
  fields.finish();

  std::set<std::string> names;
  for (const Description& one : list_of(segments, "segments, from base to tip")) {
    Fields of(one, "{name: limb, axes: 1}");
    Shape::Segment segment;
    segment.name = name_of(of.require("name", "that coils and channels refer to"), names);
    if (const Description* axes = of.find("axes")) {
      if (axes->scalar != "1" && axes->scalar != "2") throw DescriptionError(axes->path, "a segment bends about 1 axis or 2");
      segment.axes = axes->scalar == "1" ? 1 : 2;
    }
    of.finish();
    shape.segments.push_back(segment);
  }
  if (shape.segments.size() > most_segments) throw DescriptionError(segments.path, "at most 64 segments");
  names.clear();
  for (const Description& one : list_of(coils, "coils")) {
    Fields of(one, "{name: A, segment: limb, direction_deg: 0}");
    Shape::Coil coil;
    coil.name = name_of(of.require("name", "parameters and columns have it in theirs"), names);
    if (const Description* segment = of.find("segment"))
      coil.segment = index_of(*segment, shape.segments, "segment");
    else if (shape.segments.size() > 1)
      throw DescriptionError(one.path, "needs `segment`: the one that this coil bends");
    coil.direction_deg = number_of(of.require("direction_deg", "towards which it bends the segment, 0 to 360"), -360.0, 360.0);
    of.finish();
    shape.coils.push_back(coil);
  }
  if (shape.coils.size() > most_coils) throw DescriptionError(coils.path, "at most 256 coils");
  shape.complete();  // for the bends, which channels refer to
  // Names that are put together: "base" with two axes has the bends base_x and base_y.
  names.clear();
  for (const Shape::Bend& bend : shape.bends)
    if (!names.insert(bend.name).second)
      throw DescriptionError(segments.list[bend.segment].path + ".name", "another segment's axis is called " + bend.name + ", too");
  names.clear();
  for (const auto& [first, second] : shape.pairs)
    if (const std::string name = joined(shape.coils[first].name, shape.coils[second].name); !names.insert(name).second)
      throw DescriptionError(coils.list[second].path + ".name", "another pair of coils is called " + name + ", too");

  names.clear();
  std::set<std::string> without_unit;
  for (const Description& one : list_of(channels, "what is measured")) {
    Fields of(one, "{column: angle_deg, bend: limb}");
    Shape::Sensor sensor{name_of(of.require("column", "in recordings"), names), Sensing::thermocouple, 0};
    for (const Shape::Coil& coil : shape.coils)
      if (sensor.column == "duty_" + coil.name) throw DescriptionError(one.path + ".column", "is the column of a coil's duty");
    // Settings and random streams of a sensor go by its column without the unit.
    if (!without_unit.insert(sensor.column.substr(0, sensor.column.rfind('_'))).second)
      throw DescriptionError(one.path + ".column", "must differ from the other columns in more than its unit");
    const Description* const sources[] = {of.find("thermocouple"), of.find("bend"), of.find("camera")};
    const Description* axis = of.find("axis");
    of.finish();
    const Description* source = nullptr;
    for (std::size_t k = 0; k < std::size(sources); ++k) {
      if (!sources[k]) continue;
      if (source) throw DescriptionError(sources[k]->path, "a channel is one of thermocouple, bend, camera");
      source = sources[k];
      sensor.kind = static_cast<Sensing>(k);
    }
    if (!source) throw DescriptionError(one.path, "needs one of thermocouple: COIL, bend: SEGMENT, camera: SEGMENT");
    if (sensor.kind == Sensing::thermocouple) {
      sensor.part = index_of(*source, shape.coils, "coil");
      if (axis) throw DescriptionError(axis->path, "a thermocouple has no axis");
      if (!sensor.column.ends_with("_degC")) throw DescriptionError(one.path + ".column", "must end in its unit, _degC");
    } else {
      const std::size_t segment = index_of(*source, shape.segments, "segment");
      int wanted = 0;
      if (axis) {
        if (axis->scalar != "x" && axis->scalar != "y") throw DescriptionError(axis->path, "must be x or y");
        wanted = axis->scalar == "y";
      } else if (shape.segments[segment].axes == 2) {
        throw DescriptionError(one.path, "needs `axis`: x or y, since this segment bends about two");
      }
      if (wanted >= shape.segments[segment].axes) throw DescriptionError(axis->path, "this segment bends about one axis, x");
      for (std::size_t b = 0; b < shape.bends.size(); ++b)
        if (shape.bends[b].segment == segment && shape.bends[b].axis == wanted) sensor.part = b;
      if (!sensor.column.ends_with("_deg")) throw DescriptionError(one.path + ".column", "must end in its unit, _deg");
    }
    shape.sensors.push_back(sensor);
  }
  shape.complete();
  return shape;
}

bool Shape::is_own(std::string_view quantity, std::size_t coil) const {
  return std::any_of(own.begin(), own.end(), [&](const auto& one) { return one.first == quantity && one.second == coil; });
}

std::string yaml_of(const Shape& shape) {
  std::string text = "limb:\n  segments:\n";
  for (const auto& segment : shape.segments) text += "    - {name: " + segment.name + ", axes: " + std::to_string(segment.axes) + "}\n";
  text += "  coils:\n";
  for (const auto& coil : shape.coils)
    text += "    - {name: " + coil.name + ", segment: " + shape.segments[coil.segment].name +
            ", direction_deg: " + number_text(coil.direction_deg) + "}\n";
  text += "  channels:\n";
  for (const auto& sensor : shape.sensors) {
    text += "    - {column: " + sensor.column;
    if (sensor.kind == Sensing::thermocouple) {
      text += ", thermocouple: " + shape.coils[sensor.part].name;
    } else {
      const Shape::Bend& bend = shape.bends[sensor.part];
      text += std::string(sensor.kind == Sensing::bend ? ", bend: " : ", camera: ") + shape.segments[bend.segment].name;
      if (shape.segments[bend.segment].axes == 2) text += ", axis: " + axis_names[bend.axis];
    }
    text += "}\n";
  }
  return text;
}

}  // namespace sinew::plant

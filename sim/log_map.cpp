// SPDX-License-Identifier: Apache-2.0
#include "sim/log_map.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <chrono>
#include <cmath>
#include <map>
#include <numbers>
#include <utility>

#include "plant/contains.h"
#include "sim/input_error.h"
#include "sim/text.h"

namespace sinew::sim {
namespace {

constexpr double uneven_share = 0.1;       // of the median period: as in recordings
constexpr double gap_periods = 2.5;        // a longer step is a gap
constexpr double backward_periods = 10.0;  // time that goes back by less is a row out of order
constexpr double day_s = 86'400.0;
constexpr double full_turn_deg = 360.0;
constexpr std::size_t listed_names = 40;
constexpr std::size_t most_lines_before = 1'000'000;

std::string list(const std::vector<std::string>& names) {
  std::string text;
  for (std::size_t i = 0; i < std::min(names.size(), listed_names); ++i) {
    text += (i > 0 ? ", " : "") + (names[i].empty() ? "(no name)" : printable(names[i]));
  }
  return names.size() > listed_names ? text + " and " + std::to_string(names.size() - listed_names) + " more" : text;
}

std::string place_of(const YamlValue& value) {
  return value.file + ":" + std::to_string(value.line) + ":" + std::to_string(value.column) + ": " + value.path;
}

// ---- reading the map ----

Ratio ratio(const YamlValue& value) {
  const std::size_t slash = value.scalar.find('/');
  if (value.kind != YamlValue::Kind::scalar || value.quoted || slash == std::string::npos) return {value.number(), 1.0};
  const auto above = parse_number(value.scalar.substr(0, slash)), below = parse_number(value.scalar.substr(slash + 1));
  if (!above || !below || !std::isfinite(*above / *below)) value.complain("must be a number, or a ratio such as 1/255");
  return {*above, *below};
}

template <class Enum, std::size_t n>
Enum one_of(const YamlValue& value, const std::array<std::pair<std::string_view, Enum>, n>& choices) {
  const std::string& word = value.text();
  std::vector<std::string> all;
  for (const auto& [name, choice] : choices) {
    if (name == word) return choice;
    all.emplace_back(name);
  }
  value.complain("must be one of: " + list(all) + did_you_mean(word, all));
}

// One value, or a list of them.
std::vector<const YamlValue*> one_or_more(const YamlValue& value) {
  std::vector<const YamlValue*> all;
  if (value.kind == YamlValue::Kind::scalar) all.push_back(&value);
  if (value.kind == YamlValue::Kind::list) {
    for (const YamlValue& one : value.list) all.push_back(&one);
  }
  if (all.empty()) value.complain("must be a value, or a list of values");
  return all;
}

void read_missing(const YamlValue& value, LogColumn& column) {
  for (const YamlValue* one : one_or_more(value)) {
    const auto number = one->quoted ? std::nullopt : parse_number(one->text());
    if (number)
      column.missing_numbers.push_back(*number);
    else
      column.missing_words.push_back(one->text());
  }
}

LogColumn column_of_log(const YamlValue& named) {
  LogColumn column{.named = named};
  if (named.text().empty()) named.complain("must be the name of a column of the file, or its number from 1");
  const bool digits = std::all_of(named.scalar.begin(), named.scalar.end(), [](char c) { return c >= '0' && c <= '9'; });
  if (!named.quoted && digits) {
    const std::int64_t number = named.whole_number();
    if (number < 1) named.complain("columns are numbered from 1");
    column.number = static_cast<std::size_t>(number);
  }
  return column;
}

// `missing` and `repeats`, which stand beside a column or a point.
void read_what_counts(YamlMap& keys, LogColumn& column) {
  if (const YamlValue* missing = keys.find("missing")) read_missing(*missing, column);
  const YamlValue* repeats = keys.find("repeats");
  if (repeats == nullptr) return;
  if (repeats->kind == YamlValue::Kind::scalar) {
    const double every_s = one_of<double>(*repeats, std::array<std::pair<std::string_view, double>, 2>{
                                                        {{"missing", std::numeric_limits<double>::infinity()}, {"readings", 0.0}}});
    column.repeats_missing_s = every_s;
    return;
  }
  YamlMap inner(*repeats);
  const YamlValue& every = inner.require("reading_every_s", "how often the converter brings a new reading");
  column.repeats_missing_s = ratio(every).times(1.0);
  if (!(column.repeats_missing_s > 0.0)) every.complain("must be greater than 0");
  inner.finish();
}

LogLayout read_layout(const YamlValue* value) {
  LogLayout layout;
  if (value == nullptr) return layout;
  YamlMap keys(*value);
  if (const YamlValue* header = keys.find("header")) layout.header = header->truth();
  const YamlValue* before = keys.find(layout.header ? "lines_before_header" : "lines_before_rows");
  if (before != nullptr && before->kind == YamlValue::Kind::scalar && before->scalar == "any" && layout.header) {
    layout.lines_before = std::nullopt;
  } else if (before != nullptr) {
    const std::int64_t lines = before->whole_number();
    if (lines < 0 || lines > static_cast<std::int64_t>(most_lines_before))
      before->complain(layout.header ? "must be a number of lines, or `any`, which looks for the header" : "must be a number of lines");
    layout.lines_before = static_cast<std::size_t>(lines);
  }
  if (const YamlValue* delimiter = keys.find("delimiter")) {
    layout.delimiter = one_of<char>(*delimiter, std::array<std::pair<std::string_view, char>, 10>{{{"comma", ','},
                                                                                                   {"semicolon", ';'},
                                                                                                   {"tab", '\t'},
                                                                                                   {"spaces", ' '},
                                                                                                   {"bar", '|'},
                                                                                                   {",", ','},
                                                                                                   {";", ';'},
                                                                                                   {"\t", '\t'},
                                                                                                   {" ", ' '},
                                                                                                   {"|", '|'}}});
  }
  const YamlValue* decimal = keys.find("decimal");
  if (decimal != nullptr) {
    layout.decimal_comma = one_of<bool>(*decimal, std::array<std::pair<std::string_view, bool>, 2>{{{"point", false}, {"comma", true}}});
  }
  if (const YamlValue* text = keys.find("text_lines")) {
    if (text->kind == YamlValue::Kind::scalar && !text->quoted) {
      layout.ignore_text = one_of<bool>(*text, std::array<std::pair<std::string_view, bool>, 2>{{{"ignore", true}, {"error", false}}});
    } else {
      for (const YamlValue* one : one_or_more(*text)) {
        if (one->text().find_first_not_of('*') == std::string::npos) one->complain("this pattern matches every line");
        layout.ignore.push_back(one->text());
      }
    }
  }
  keys.finish();
  if (layout.decimal_comma && layout.delimiter == ',')
    decimal->complain("a comma cannot be in the numbers and between them; which delimiter has the file?");
  return layout;
}

TimeRule read_time(const YamlValue& value) {
  TimeRule time{.at = value};
  if (value.kind == YamlValue::Kind::scalar) {
    time.column = column_of_log(value);
    return time;
  }
  YamlMap keys(value);
  const YamlValue* column = keys.find("column");
  const YamlValue* period = keys.find("period_s");
  if ((column == nullptr) == (period == nullptr))
    value.complain("needs either `column`, the file's column of time, or `period_s`, where it has none: one row each period");
  if (period != nullptr) {
    time.period_s = ratio(*period);
    if (!(time.period_s.times(1.0) > 0.0)) period->complain("must be greater than 0");
  } else {
    time.column = column_of_log(*column);
    if (const YamlValue* unit = keys.find("unit")) {
      time.unit = one_of<TimeUnit>(*unit, std::array<std::pair<std::string_view, TimeUnit>, 8>{{{"s", TimeUnit::s},
                                                                                                {"ms", TimeUnit::ms},
                                                                                                {"us", TimeUnit::us},
                                                                                                {"ns", TimeUnit::ns},
                                                                                                {"min", TimeUnit::min},
                                                                                                {"h", TimeUnit::h},
                                                                                                {"ms_of_day", TimeUnit::ms_of_day},
                                                                                                {"clock", TimeUnit::clock}}});
    }
    if (const YamlValue* first = keys.find("first_row")) {
      time.first_row_at_zero =
          one_of<bool>(*first, std::array<std::pair<std::string_view, bool>, 2>{{{"zero", true}, {"as_logged", false}}});
    }
  }
  keys.finish();
  return time;
}

struct Unit {
  std::string_view of_column;  // how the column's name ends
  std::string_view name;
  Ratio factor;
  double offset_before;  // value = (raw + offset_before) factor
};
constexpr double deg_per_rad = 180.0 / std::numbers::pi;
constexpr Unit units[] = {
    {"fraction", "fraction", {1.0, 1.0}, 0.0},
    {"fraction", "percent", {1.0, 100.0}, 0.0},
    {"fraction", "counts_255", {1.0, 255.0}, 0.0},
    {"fraction", "counts_1023", {1.0, 1023.0}, 0.0},
    {"fraction", "counts_4095", {1.0, 4095.0}, 0.0},
    {"fraction", "counts_65535", {1.0, 65535.0}, 0.0},
    {"degC", "degC", {1.0, 1.0}, 0.0},
    {"degC", "K", {1.0, 1.0}, -273.15},
    {"degC", "degF", {5.0, 9.0}, -32.0},
    {"deg", "deg", {1.0, 1.0}, 0.0},
    {"deg", "rad", {deg_per_rad, 1.0}, 0.0},
    {"deg", "turns", {360.0, 1.0}, 0.0},
    {"rad", "rad", {1.0, 1.0}, 0.0},
    {"rad", "deg", {1.0, deg_per_rad}, 0.0},
    {"V", "V", {1.0, 1.0}, 0.0},
    {"V", "mV", {1.0, 1000.0}, 0.0},
    {"A", "A", {1.0, 1.0}, 0.0},
    {"A", "mA", {1.0, 1000.0}, 0.0},
    {"m", "m", {1.0, 1.0}, 0.0},
    {"m", "cm", {1.0, 100.0}, 0.0},
    {"m", "mm", {1.0, 1000.0}, 0.0},
    {"m", "um", {1.0, 1e6}, 0.0},
    {"N", "N", {1.0, 1.0}, 0.0},
    {"N", "mN", {1.0, 1000.0}, 0.0},
    {"Pa", "Pa", {1.0, 1.0}, 0.0},
    {"Pa", "kPa", {1000.0, 1.0}, 0.0},
    {"Pa", "bar", {1e5, 1.0}, 0.0},
    {"s", "s", {1.0, 1.0}, 0.0},
    {"s", "ms", {1.0, 1000.0}, 0.0},
};

bool is_duty(const std::string& name) { return name == "duty" || name.starts_with("duty_"); }

std::string unit_of(const std::string& name) {
  if (is_duty(name)) return "fraction";
  const std::size_t end = name.rfind('_');
  return end == std::string::npos ? "" : name.substr(end + 1);
}

void read_unit(const YamlValue& value, ColumnRule& rule) {
  const std::string target = unit_of(rule.name);
  std::vector<std::string> all;
  for (const Unit& unit : units) {
    if (unit.of_column != target) continue;
    all.emplace_back(unit.name);
    if (unit.name != value.text()) continue;
    rule.unit = unit.factor;
    rule.unit_offset = unit.offset_before;
    return;
  }
  if (all.empty()) value.complain("the name " + rule.name + " ends in no unit that one can be converted to; use `scale` and `offset`");
  value.complain("for " + rule.name + " must be one of: " + list(all) + did_you_mean(value.text(), all) + "\nor use `scale` and `offset`");
}

// What stands where names are looked up, with the value that names it: resolved when all are known.
struct Links {
  const YamlValue* first = nullptr;
  const YamlValue* second = nullptr;
};

std::size_t zero_rows(const YamlValue& zero) {
  if (zero.kind == YamlValue::Kind::scalar)
    return one_of<std::size_t>(zero, std::array<std::pair<std::string_view, std::size_t>, 2>{{{"as_logged", 0}, {"first_row", 1}}});
  YamlMap keys(zero);
  const YamlValue& rows = keys.require("median_of_rows", "how many of the first samples the zero is the median of");
  const std::int64_t count = rows.whole_number();
  if (count < 1 || count > 10000) rows.complain("must lie in [1, 10000]");
  keys.finish();
  return static_cast<std::size_t>(count);
}

ColumnRule read_column(const YamlValue::Entry& entry, bool written, Links& links) {
  ColumnRule rule{.name = entry.key, .at = entry.value, .written = written};
  rule.at.line = entry.line, rule.at.column = entry.column;
  if (rule.name.empty() || rule.name.find_first_of(",\"\n\r\t ") != std::string::npos || rule.name.front() == '#')
    rule.at.complain("a column's name has no spaces, commas and quotes");
  if (rule.name == "time_s") rule.at.complain("time_s is written always, and comes from `time`");
  if (is_duty(rule.name)) rule.lowest = 0.0, rule.highest = 1.0;
  if (unit_of(rule.name) == "degC") rule.lowest = -273.15;
  if (entry.value.kind == YamlValue::Kind::scalar) {
    rule.read = column_of_log(entry.value);
    return rule;
  }
  YamlMap keys(entry.value);
  const YamlValue* column = keys.find("column");
  const YamlValue* constant = keys.find("constant");
  const YamlValue* difference = keys.find("difference");
  const YamlValue* direction = keys.find("direction");
  if ((column != nullptr) + (constant != nullptr) + (difference != nullptr) + (direction != nullptr) != 1) {
    for (const auto& e : entry.value.map) {  // a misspelled one is likelier than none
      const std::vector<std::string> kinds{"column", "constant", "difference", "direction"};
      const bool is_kind = contains(kinds, e.key);
      if (!is_kind && column == nullptr && constant == nullptr && difference == nullptr && direction == nullptr &&
          !nearest(e.key, kinds).empty())
        throw InputError(
            {rule.at.file, e.line, e.column, entry.value.path + "." + e.key, "", "no such key here" + did_you_mean(e.key, kinds)});
    }
    rule.at.complain("needs exactly one of `column`, `constant`, `difference`, `direction`: where its values come from");
  }
  if (column != nullptr) {
    rule.read = column_of_log(*column);
    read_what_counts(keys, rule.read);
  } else if (constant != nullptr) {
    rule.kind = ColumnKind::constant;
    rule.constant = ratio(*constant).times(1.0);
  } else {
    const bool is_direction = direction != nullptr;
    rule.kind = is_direction ? ColumnKind::direction : ColumnKind::difference;
    YamlMap pair(is_direction ? *direction : *difference);
    links.first =
        &pair.require(is_direction ? "from" : "of", is_direction ? "the point it begins at" : "the column that is subtracted from");
    links.second = &pair.require(is_direction ? "to" : "less", is_direction ? "the point it leads to" : "the column that is subtracted");
    pair.finish();
  }
  if (const YamlValue* unit = keys.find("unit")) read_unit(*unit, rule);
  if (const YamlValue* scale = keys.find("scale")) {
    rule.scale = ratio(*scale);
    if (rule.scale.numerator == 0.0) scale->complain("must not be 0");
  }
  if (const YamlValue* offset = keys.find("offset")) rule.offset = ratio(*offset).times(1.0);
  if (const YamlValue* sense = keys.find("sense"))
    rule.reversed = one_of<bool>(*sense, std::array<std::pair<std::string_view, bool>, 2>{{{"same", false}, {"reversed", true}}});
  if (const YamlValue* zero = keys.find("zero")) rule.zero_rows = zero_rows(*zero);
  if (const YamlValue* lowest = keys.find("lowest")) rule.lowest = lowest->number();
  if (const YamlValue* highest = keys.find("highest")) {
    rule.highest = highest->number();
    if (!(rule.highest > rule.lowest)) highest->complain("must be greater than `lowest`, " + shortest(rule.lowest));
  }
  if (const YamlValue* outside = keys.find("outside")) {
    rule.outside = one_of<Outside>(*outside, std::array<std::pair<std::string_view, Outside>, 3>{
                                                 {{"error", Outside::error}, {"missing", Outside::missing}, {"clip", Outside::clip}}});
  }
  keys.finish();
  return rule;
}

template <class Rules>
std::size_t index_of(const Rules& rules, const YamlValue& named, const std::string& what) {
  std::vector<std::string> names;
  for (std::size_t i = 0; i < rules.size(); ++i) {
    if (rules[i].name == named.text()) return i;
    names.push_back(rules[i].name);
  }
  named.complain("no such " + what + did_you_mean(named.text(), names) + (names.empty() ? "" : "\nthere are: " + list(names)));
}

// Puts the columns that `at` is computed from before it; complains of a cycle.
void put_in_order(LogMap& map, std::size_t at, std::vector<int>& state) {
  enum { unseen, open, done };
  if (state[at] == done) return;
  const ColumnRule& rule = map.columns[at];
  if (state[at] == open) rule.at.complain("is computed from itself, through `difference`");
  state[at] = open;
  if (rule.kind == ColumnKind::difference) {
    put_in_order(map, rule.of, state);
    put_in_order(map, rule.less, state);
  }
  state[at] = done;
  map.order.push_back(at);
}

template <class Visit>
void for_each_log_column(const LogMap& map, Visit&& visit) {
  if (map.time.column) visit(*map.time.column);
  for (const PointRule& point : map.points) visit(point.x), visit(point.y);
  for (const ColumnRule& rule : map.columns) {
    if (rule.kind == ColumnKind::read) visit(rule.read);
  }
}

// ---- applying it ----

bool same_letters(std::string_view a, std::string_view b) {
  return std::equal(a.begin(), a.end(), b.begin(), b.end(), [](char x, char y) {
    const auto lower = [](char c) { return c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c; };
    return lower(x) == lower(y);
  });
}

class Application {
 public:
  Application(const LogMap& map, const Log& log) : map_(map), log_(log) {}

  Conversion run() {
    find_columns();
    read_times();
    keep_rows();
    look_at_steps();
    compute();
    say_what_is_read_twice();
    if (map_.pauses) fill_pauses(*map_.pauses);
    Conversion result;
    result.table.comments = log_.comments;
    for (std::string& comment : result.table.comments) comment = shifted_clock(comment);
    result.table.columns.push_back({"time_s", time_s_});
    for (std::size_t i = 0; i < map_.columns.size(); ++i) {
      if (map_.columns[i].written) result.table.columns.push_back({map_.columns[i].name, std::move(values_[i])});
    }
    result.notes = log_.notes.summary() + notes_;
    return result;
  }

 private:
  static std::string text_of(const LogColumn& column) { return column.named.scalar; }

  // The place of the column in the log; none where it is not there.
  std::optional<std::size_t> find(const LogColumn& column) const {
    if (column.number > 0) {
      if (!log_.is_text()) column.named.complain("this file has variables; name one of them: " + list(log_.names));
      if (column.number <= log_.columns()) return column.number - 1;
      return std::nullopt;
    }
    const std::string_view name = trimmed(column.named.scalar);
    for (const bool exact : {true, false}) {
      std::vector<std::size_t> found;
      for (std::size_t i = 0; i < log_.columns(); ++i) {
        if (exact ? log_.names[i] == name : same_letters(log_.names[i], name)) found.push_back(i);
      }
      if (found.size() == 1) return found.front();
      if (found.size() > 1) {
        column.named.complain("stands twice in the header of " + log_.file + ", as columns " + std::to_string(found[0] + 1) + " and " +
                              std::to_string(found[1] + 1) + "; name it by its number");
      }
    }
    return std::nullopt;
  }

  std::string where_names_stand() const {
    return log_.header_line() > 0 ? log_.file + ":" + std::to_string(log_.header_line()) : log_.file;
  }

  // A row for each pause, one period after the last row before it.
  void fill_pauses(const PauseRule& rule) {
    std::vector<double> steps_s;
    for (std::size_t k = 1; k < time_s_.size(); ++k) steps_s.push_back(time_s_[k] - time_s_[k - 1]);
    const double period_s = lower_median(std::move(steps_s));
    std::vector<double> time_s;
    std::vector<std::vector<double>> values(values_.size());
    std::size_t pauses = 0;
    double ended_s = -std::numeric_limits<double>::infinity();
    for (std::size_t k = 0; k < time_s_.size(); ++k) {
      if (k > 0 && time_s_[k] - time_s_[k - 1] > rule.longer_than_s) {
        ++pauses;
        ended_s = time_s_[k];
        time_s.push_back(time_s_[k - 1] + std::min(period_s, 0.5 * (time_s_[k] - time_s_[k - 1])));
        for (auto& column : values) column.push_back(not_a_number);
        for (const auto& [column, value] : rule.then) values[column].back() = value;
      }
      time_s.push_back(time_s_[k]);
      for (std::size_t i = 0; i < values_.size(); ++i) values[i].push_back(values_[i][k]);
      for (const auto& [column, settling_s] : rule.settling)
        if (time_s_[k] < ended_s + settling_s) values[column].back() = not_a_number;
    }
    time_s_ = std::move(time_s);
    values_ = std::move(values);
    notes_ += std::to_string(pauses) + (pauses == 1 ? " pause" : " pauses") + " of more than " + shortest(rule.longer_than_s) +
              " s, each with a row of its own as the map says\n";
  }

  void find_columns() {
    const LogColumn* missing = nullptr;
    std::size_t asked = 0, found = 0;
    std::string others;
    for_each_log_column(map_, [&](const LogColumn& column) {
      ++asked;
      if (find(column)) {
        ++found;
      } else if (missing == nullptr) {
        missing = &column;
      } else {
        others += (others.empty() ? "" : ", ") + text_of(column);
      }
    });
    if (missing == nullptr) return;
    const YamlValue& named = missing->named;
    std::string advice;
    if (missing->number > 0) {
      advice = "there are " + std::to_string(log_.columns()) + " columns in " + log_.file;
    } else {
      const bool nameless = log_.is_text() && log_.header_line() == 0;
      advice = "no such column in " + where_names_stand() + did_you_mean(named.scalar, log_.names);
      const std::string first_of_matrix = named.scalar + "[1]";
      if (contains(log_.names, first_of_matrix))
        advice += "\nit is a matrix: name its columns " + first_of_matrix + ", " + named.scalar + "[2] and so on";
      advice += nameless ? "\nthis file has no header: name its columns by number, from 1 to " + std::to_string(log_.columns())
                         : "\nits columns are: " + list(log_.names);
      if (log_.is_text() && log_.columns() == 1) advice += "\none column alone: is `delimiter` right?";
    }
    if (!others.empty()) advice += "\nnor is there: " + others;
    if (found == 0 && asked > 0) advice += "\nthe map matches nothing in this file: is it for another logger?";
    named.complain(advice);
  }

  bool is_missing_word(const LogColumn& column, std::string_view field) const {
    return std::any_of(column.missing_words.begin(), column.missing_words.end(),
                       [&](const std::string& word) { return same_letters(trimmed(word), field); });
  }

  // Two columns of a recording from one of the log: seldom what was meant.
  void say_what_is_read_twice() {
    std::map<std::size_t, std::vector<std::string>> readers;
    for (const ColumnRule& rule : map_.columns)
      if (rule.written && rule.kind == ColumnKind::read) readers[*find(rule.read)].push_back(rule.name);
    for (const auto& [column, names] : readers)
      if (names.size() > 1) notes_ += list(names) + ": all from the column " + log_.title(column) + "; is it so?\n";
  }

  // The numbers of a column in all rows of the log; what the map calls missing is NaN.
  std::vector<double> numbers(const LogColumn& column) const {
    const std::size_t at = *find(column);
    check_length(column, at);
    std::vector<double> values(log_.rows(at));
    for (std::size_t row = 0; row < values.size(); ++row) {
      const std::optional<double> number = log_.number(row, at);
      if (!number && !is_missing_word(column, log_.field(row, at))) {
        log_.fail_at(row, at, std::string(log_.field(row, at)),
                     "must be a number; an empty field and nan are missing ones, and what `missing` names\n" + place_of(column.named) +
                         " reads it");
      }
      values[row] = number.value_or(not_a_number);
      if (std::isinf(values[row])) log_.fail_at(row, at, shortest(values[row]), "must be finite");
      for (const double absent : column.missing_numbers) {
        if (values[row] == absent) values[row] = not_a_number;
      }
    }
    return values;
  }

  void check_length(const LogColumn& column, std::size_t at) const {
    const std::size_t length = log_.rows(at);
    if (length == 1 && !log_.is_text()) column.named.complain("is a single number in " + log_.file + ", not a series; use `constant`");
    if (log_rows_ == 0 || length == log_rows_) return;
    column.named.complain("has " + std::to_string(length) + " values in " + log_.file + ", and " + rows_from_ + " has " +
                          std::to_string(log_rows_));
  }

  void read_times() {
    if (!map_.time.column) {
      for_each_log_column(map_, [&](const LogColumn& column) {
        if (log_rows_ == 0) log_rows_ = log_.rows(*find(column)), rows_from_ = text_of(column);
      });
      for (std::size_t row = 0; row < log_rows_; ++row) all_time_s_.push_back(map_.time.period_s.times(static_cast<double>(row)));
      check_enough(log_rows_);
      return;
    }
    const LogColumn& column = *map_.time.column;
    const std::size_t at = *find(column);
    check_length(column, at);
    log_rows_ = log_.rows(at);
    rows_from_ = text_of(column);
    check_enough(log_rows_);
    const TimeUnit unit = map_.time.unit;
    if (unit == TimeUnit::clock && !log_.is_text()) map_.time.at.complain("a clock is text, and this file has numbers");
    std::vector<double> raw(log_rows_);
    bool of_day = unit == TimeUnit::ms_of_day;
    if (unit == TimeUnit::clock) {
      bool dated = false;
      for (std::size_t row = 0; row < raw.size(); ++row) {
        const std::string field(log_.field(row, at));
        const std::optional<ClockTime> clock = parse_clock(field);
        if (!clock) log_.fail_at(row, at, field.empty() ? "(empty)" : field, "must be a time such as 10:30:48.949" + because());
        if (row == 0) dated = clock->dated;
        if (clock->dated != dated) log_.fail_at(row, at, field, "has a date, or has none, unlike the rows before it" + because());
        raw[row] = clock->seconds;
      }
      of_day = !dated;
    } else {
      raw = numbers(column);
      for (std::size_t row = 0; row < raw.size(); ++row) {
        if (std::isnan(raw[row])) log_.fail_at(row, at, "(nothing)", "every row needs its time" + because());
      }
    }
    const double day = unit == TimeUnit::ms_of_day ? 1000.0 * day_s : day_s;
    if (of_day) continue_over_midnight(raw, day, at);
    Ratio seconds{};
    if (unit == TimeUnit::ms || unit == TimeUnit::ms_of_day) seconds.denominator = 1000.0;
    if (unit == TimeUnit::us) seconds.denominator = 1e6;
    if (unit == TimeUnit::ns) seconds.denominator = 1e9;
    if (unit == TimeUnit::min) seconds.numerator = 60.0;
    if (unit == TimeUnit::h) seconds.numerator = 3600.0;
    const double first = map_.time.first_row_at_zero ? raw.front() : 0.0;
    for (const double value : raw) all_time_s_.push_back(seconds.times(value - first));
    shifted_by_s_ = seconds.times(first);
  }

  // When the log's time is 0 (sim/recording.h), the recording's is not, where that begins with its first row.
  std::string shifted_clock(const std::string& comment) const {
    constexpr std::string_view key = "time_zero_s:";
    if (!comment.starts_with(key) || shifted_by_s_ == 0.0) return comment;
    const double time_s = std::strtod(comment.c_str() + key.size(), nullptr);
    return std::string(key) + " " + shortest(time_s + shifted_by_s_);
  }

  std::string because() const { return "\n" + place_of(map_.time.at) + " says so"; }

  void check_enough(std::size_t rows) const {
    if (rows >= 2) return;
    throw InputError({.file = log_.file, .key = "rows", .value = std::to_string(rows), .advice = "a recording has at least two rows"});
  }

  // A clock that starts anew from 0 is midnight; a row out of order may take it over again.
  void continue_over_midnight(std::vector<double>& raw, double day, std::size_t at) {
    int days = 0;
    double last = raw.front();
    for (std::size_t row = 0; row < raw.size(); ++row) {
      const double value = raw[row];
      if (value < 0.0 || value > day) log_.fail_at(row, at, shortest(value), "must lie within a day" + because());
      if (value < last - day / 2) {
        if (++days > static_cast<int>(midnights_.count)) midnights_.add(log_.line_of(row));
      } else if (value > last + day / 2 && days > 0) {
        --days;
      }
      last = value;
      raw[row] = days * day + value;
    }
  }

  // Drops rows that repeat a time or go back in it.
  void keep_rows() {
    std::vector<double> forward_s;
    for (std::size_t i = 1; i < all_time_s_.size(); ++i) {
      if (all_time_s_[i] > all_time_s_[i - 1]) forward_s.push_back(all_time_s_[i] - all_time_s_[i - 1]);
    }
    if (forward_s.empty()) {
      throw InputError(
          {.file = log_.file, .line = log_.line_of(1), .key = "time", .advice = "never moves forward in this file" + because()});
    }
    const double tolerated_s = backward_periods * lower_median(std::move(forward_s));
    Tally repeated, conflicting, backward;
    kept_ = {0};
    for (std::size_t row = 1; row < all_time_s_.size(); ++row) {
      const double back_s = all_time_s_[kept_.back()] - all_time_s_[row];
      if (back_s < 0.0) {
        kept_.push_back(row);
      } else if (back_s == 0.0) {
        (same_row(row, kept_.back()) ? repeated : conflicting).add(log_.line_of(row));
      } else if (back_s < tolerated_s) {
        backward.add(log_.line_of(row));
      } else {
        const std::string advice =
            "goes back by " + shortest(back_s) + " s; two recordings in one file? then cut it in two here" + because();
        if (map_.time.column && log_.is_text()) {
          const std::size_t at = *find(*map_.time.column);
          log_.fail_at(row, at, std::string(log_.field(row, at)), advice);
        }
        log_.fail_in_row(row, "time", "", advice);
      }
    }
    check_enough(kept_.size());
    for (const std::size_t row : kept_) time_s_.push_back(all_time_s_[row]);
    notes_ += counted(repeated, "row repeats", "rows repeat", " the row before, time and values; dropped");
    notes_ += counted(conflicting, "row has", "rows have", " the time of the row before but other values; dropped");
    notes_ += counted(backward, "row goes", "rows go", " back in time by a little; dropped");
    notes_ += counted(midnights_, "midnight", "midnights", " at which the logger's clock began anew; time continued");
  }

  bool same_row(std::size_t a, std::size_t b) const {
    bool same = true;
    for_each_log_column(map_, [&](const LogColumn& column) {
      const std::size_t at = *find(column);
      if (log_.is_text()) {
        const auto x = log_.number(a, at), y = log_.number(b, at);
        same = same && (x && y ? *x == *y || (std::isnan(*x) && std::isnan(*y)) : log_.field(a, at) == log_.field(b, at));
      } else {
        const double x = *log_.number(a, at), y = *log_.number(b, at);
        same = same && (x == y || (std::isnan(x) && std::isnan(y)));
      }
    });
    return same;
  }

  void look_at_steps() {
    std::vector<double> steps_s;
    for (std::size_t i = 1; i < time_s_.size(); ++i) steps_s.push_back(time_s_[i] - time_s_[i - 1]);
    period_s_ = lower_median(steps_s);
    Tally uneven, gaps;
    double shortest_s = std::numeric_limits<double>::infinity(), longest_s = 0.0, longest_gap_s = 0.0;
    for (std::size_t i = 0; i < steps_s.size(); ++i) {
      const int line = log_.line_of(kept_[i + 1]);
      if (steps_s[i] > gap_periods * period_s_) {
        gaps.add(line);
        longest_gap_s = std::max(longest_gap_s, steps_s[i]);
      } else if (std::abs(steps_s[i] - period_s_) > uneven_share * period_s_) {
        uneven.add(line);
        shortest_s = std::min(shortest_s, steps_s[i]);
        longest_s = std::max(longest_s, steps_s[i]);
      }
    }
    notes_ +=
        counted(uneven, "uneven step", "uneven steps", " of time, from " + rounded(shortest_s) + " to " + rounded(longest_s) + " s; kept");
    notes_ += counted(gaps, "gap", "gaps", " in time, the longest of " + rounded(longest_gap_s) + " s; kept");
  }

  std::vector<double> kept_numbers(const LogColumn& column) const {
    const std::vector<double> all = numbers(column);
    std::vector<double> kept;
    kept.reserve(kept_.size());
    for (const std::size_t row : kept_) kept.push_back(all[row]);
    return kept;
  }

  // Marks as missing the rows in which all series repeat their last reading, within the time that this may last.
  std::size_t drop_repeats(std::vector<std::vector<double>*> series, double missing_for_s, const std::string& name) {
    if (missing_for_s == 0.0) return 0;
    constexpr double rounding = 0.99;
    Tally repeats;
    std::optional<std::size_t> last;
    std::vector<double> reading(series.size());
    for (std::size_t i = 0; i < time_s_.size(); ++i) {
      if (std::any_of(series.begin(), series.end(), [&](const auto* s) { return std::isnan((*s)[i]); })) continue;
      bool same = last.has_value();
      for (std::size_t k = 0; k < series.size(); ++k) same = same && (*series[k])[i] == reading[k];
      if (same && time_s_[i] - time_s_[*last] < rounding * missing_for_s) {
        repeats.add(log_.line_of(kept_[i]));
        for (auto* s : series) (*s)[i] = not_a_number;
        continue;
      }
      last = i;
      for (std::size_t k = 0; k < series.size(); ++k) reading[k] = (*series[k])[i];
    }
    if (repeats.count > 0)
      notes_ += name + ": " +
                counted(repeats, "row repeats", "rows repeat",
                        " the last reading, of " + std::to_string(time_s_.size()) + "; each reading is counted once");
    return repeats.count;
  }

  void compute() {
    for (const PointRule& point : map_.points) {
      points_.emplace_back(kept_numbers(point.x), kept_numbers(point.y));
      auto& [x, y] = points_.back();
      drop_repeats({&x, &y}, point.x.repeats_missing_s, point.name);
    }
    values_.resize(map_.columns.size());
    periodic_.resize(map_.columns.size());
    for (const std::size_t i : map_.order) compute_column(i);
  }

  void compute_column(std::size_t at) {
    const ColumnRule& rule = map_.columns[at];
    std::vector<double>& values = values_[at];
    std::size_t repeats = 0;
    switch (rule.kind) {
      case ColumnKind::read:
        values = kept_numbers(rule.read);
        hint_at_slow_converter(rule, values);
        repeats = drop_repeats({&values}, rule.read.repeats_missing_s, rule.name);
        break;
      case ColumnKind::constant:
        values.assign(time_s_.size(), rule.constant);
        break;
      case ColumnKind::difference:
        for (std::size_t i = 0; i < time_s_.size(); ++i) values.push_back(values_[rule.of][i] - values_[rule.less][i]);
        periodic_[at] = periodic_[rule.of] && periodic_[rule.less];
        if (periodic_[at]) begin_within_half_a_turn(values);
        break;
      case ColumnKind::direction:
        values = direction_deg(points_[rule.from], points_[rule.to]);
        periodic_[at] = true;
        break;
    }
    const bool unchanged = rule.unit.numerator == 1.0 && rule.unit.denominator == 1.0 && rule.scale.numerator == 1.0 &&
                           rule.scale.denominator == 1.0 && rule.zero_rows == 0;
    periodic_[at] = periodic_[at] && unchanged;
    for (double& value : values) {
      value = rule.scale.times(rule.unit.times(value + rule.unit_offset)) + rule.offset;
      if (rule.reversed) value = 0.0 - value;  // not -0
    }
    if (rule.zero_rows > 0) set_zero(rule, values);
    check_range(rule, values);
    Tally missing;
    for (std::size_t i = 0; i < values.size(); ++i) {
      if (std::isnan(values[i])) missing.add(log_.line_of(kept_[i]));
    }
    if (missing.count == values.size() && rule.written)
      rule.at.complain("not one sample in " + log_.file + " is there: all " + std::to_string(values.size()) + " are missing");
    if (!rule.written || missing.count == repeats) return;
    notes_ += rule.name + ": " +
              counted(missing, "missing sample", "missing samples", repeats > 0 ? ", these repeats among them" : ", left missing");
  }

  void hint_at_slow_converter(const ColumnRule& rule, const std::vector<double>& values) {
    if (rule.read.repeats_missing_s > 0.0 || unit_of(rule.name) != "degC") return;
    const auto rows = rows_per_reading(values);
    if (!rows) return;
    notes_ += rule.name + ": repeats each reading for about " + rounded(*rows, 2) +
              " rows, as a converter does that is slower than the logger; " +
              "`repeats: {reading_every_s: " + rounded(*rows * period_s_, 2) + "}` in the map counts each once\n";
  }

  static void begin_within_half_a_turn(std::vector<double>& values) {
    const auto first = std::find_if(values.begin(), values.end(), [](double v) { return !std::isnan(v); });
    if (first == values.end()) return;
    const double turns = -std::ceil(*first / full_turn_deg - 0.5);
    for (double& value : values) value += turns * full_turn_deg;
  }

  using Points = std::pair<std::vector<double>, std::vector<double>>;
  static std::vector<double> direction_deg(const Points& from, const Points& to) {
    std::vector<double> values;
    double last = not_a_number;
    for (std::size_t i = 0; i < from.first.size(); ++i) {
      const double dx = to.first[i] - from.first[i], dy = to.second[i] - from.second[i];
      // Two points in one place have no direction.
      double direction = dx == 0.0 && dy == 0.0 ? not_a_number : std::atan2(dy, dx) * deg_per_rad;
      if (!std::isnan(direction) && !std::isnan(last)) direction += full_turn_deg * std::round((last - direction) / full_turn_deg);
      if (!std::isnan(direction)) last = direction;
      values.push_back(direction);
    }
    return values;
  }

  void set_zero(const ColumnRule& rule, std::vector<double>& values) {
    std::vector<double> first;
    std::size_t row = 0, last = 0;
    for (std::size_t i = 0; i < values.size() && first.size() < rule.zero_rows; ++i) {
      if (std::isnan(values[i])) continue;
      if (first.empty()) row = i;
      last = i;
      first.push_back(values[i]);
    }
    if (first.empty()) return;
    const std::size_t count = first.size();
    const double zero = lower_median(std::move(first));
    for (double& value : values) value -= zero;
    const int line = log_.line_of(kept_[row]);
    notes_ +=
        rule.name + ": its zero is " + rounded(zero) +
        (count == 1 ? ", of the first row that has it" : ", the median of the first " + std::to_string(count) + " rows that have it") +
        (line > 0 ? (count == 1 ? " (line " : " (from line ") + std::to_string(line) + ")" : "");
    for (std::size_t k = 0; k < map_.columns.size(); ++k) {
      const ColumnRule& other = map_.columns[k];
      if (!is_duty(other.name) || other.kind != ColumnKind::read) continue;
      const std::vector<double> duty = kept_numbers(other.read);
      const auto driven =
          std::find_if(duty.begin(), duty.begin() + static_cast<std::ptrdiff_t>(last), [](double d) { return std::abs(d) > 0.0; });
      if (driven == duty.begin() + static_cast<std::ptrdiff_t>(last)) continue;
      const auto at = static_cast<std::size_t>(driven - duty.begin());
      notes_ += "; not at rest: " + other.name + " is driven " + rounded(time_s_[last] - time_s_[at]) + " s earlier";
    }
    notes_ += '\n';
  }

  void check_range(const ColumnRule& rule, std::vector<double>& values) {
    Tally outside;
    for (std::size_t i = 0; i < values.size(); ++i) {
      double& value = values[i];
      if (std::isinf(value)) log_.fail_in_row(kept_[i], rule.name, "", rule.name + " is infinite here\n" + place_of(rule.at) + " says so");
      if (std::isnan(value) || (value >= rule.lowest && value <= rule.highest)) continue;
      outside.add(log_.line_of(kept_[i]));
      if (rule.outside == Outside::missing) value = not_a_number;
      if (rule.outside == Outside::clip) value = std::clamp(value, rule.lowest, rule.highest);
      if (rule.outside == Outside::error) fail_outside(rule, i, value);
    }
    if (outside.count == 0) return;
    const std::string what = rule.outside == Outside::clip ? " outside its range, put to its edge" : " outside its range, left missing";
    notes_ += rule.name + ": " + counted(outside, "value", "values", what);
  }

  [[noreturn]] void fail_outside(const ColumnRule& rule, std::size_t i, double value) const {
    std::string advice =
        rule.name + " is " + shortest(value) + " here, and must lie in [" + shortest(rule.lowest) + ", " + shortest(rule.highest) + "]";
    if (is_duty(rule.name) && value > 1.0) {
      advice += "\nis it in percent, or in counts? then say `unit: percent`, or `unit: counts_255`";
    } else if (is_duty(rule.name) && value < 0.0) {
      advice += "\na duty has no direction: each part that is driven has a column of its own";
    }
    advice += "\n" + place_of(rule.at) + " says so; `outside: clip` and `outside: missing` count such values";
    if (rule.kind != ColumnKind::read) log_.fail_in_row(kept_[i], rule.name, "", advice);
    const std::size_t at = *find(rule.read);
    log_.fail_at(kept_[i], at, log_.is_text() ? std::string(log_.field(kept_[i], at)) : shortest(*log_.number(kept_[i], at)), advice);
  }

  const LogMap& map_;
  const Log& log_;
  std::size_t log_rows_ = 0;
  std::string rows_from_;
  std::vector<double> all_time_s_, time_s_;
  double shifted_by_s_ = 0.0;
  std::vector<std::size_t> kept_;
  double period_s_ = 0.0;
  Tally midnights_;
  std::vector<Points> points_;
  std::vector<std::vector<double>> values_;
  std::vector<bool> periodic_;  // angles that are known but for whole turns
  std::string notes_;
};

}  // namespace

std::vector<std::string> LogMap::wanted_names() const {
  std::vector<std::string> names;
  for_each_log_column(*this, [&](const LogColumn& column) {
    if (column.number == 0) names.emplace_back(trimmed(column.named.scalar));
  });
  return names;
}

namespace {

PauseRule read_pauses(const YamlValue& value, const LogMap& map) {
  YamlMap keys(value);
  PauseRule rule;
  const YamlValue& longer = keys.require("longer_than_s", "how long a gap must be to be a pause, in seconds");
  rule.longer_than_s = longer.number();
  if (!(rule.longer_than_s > 0.0)) longer.complain("must be greater than 0");
  const auto by_column = [&](const YamlValue& list) {
    YamlMap checked(list);
    std::vector<std::pair<std::size_t, const YamlValue*>> all;
    for (const auto& entry : list.map) {
      std::vector<std::string> names;
      for (const ColumnRule& column : map.columns) {
        if (column.written && column.name == entry.key)
          all.push_back({static_cast<std::size_t>(&column - map.columns.data()), &entry.value});
        if (column.written) names.push_back(column.name);
      }
      if (!contains(names, entry.key))
        throw InputError({value.file, entry.line, entry.column, list.path + "." + entry.key, "",
                          "no such column in `columns`" + did_you_mean(entry.key, names)});
    }
    return all;
  };
  for (const auto& [column, given] : by_column(keys.require("then", "the value of each input while a pause lasts: {duty_A: 0}"))) {
    const double lowest = map.columns[column].lowest, highest = map.columns[column].highest;
    if (!(given->number() >= lowest && given->number() <= highest))
      given->complain("must lie in [" + shortest(lowest) + ", " + shortest(highest) + "]");
    rule.then.emplace_back(column, given->number());
  }
  if (const YamlValue* settling = keys.find("settling"))
    for (const auto& [column, given] : by_column(*settling)) {
      if (!(given->number() >= 0.0)) given->complain("must be at least 0");
      rule.settling.emplace_back(column, given->number());
    }
  keys.finish();
  return rule;
}

}  // namespace

LogMap parse_log_map(const YamlValue& value) {
  LogMap map;
  map.file = value.file;
  YamlMap keys(value);
  const YamlValue& format = keys.require("format", "1 in this version");
  if (format.whole_number() != 1) format.complain("must be 1");
  map.layout = read_layout(keys.find("file"));
  map.time = read_time(keys.require("time", "the file's column of time, or `{period_s: ...}` where it has none"));
  if (const YamlValue* points = keys.find("points")) {
    YamlMap checked(*points);
    for (const auto& entry : points->map) {
      YamlMap point(entry.value);
      PointRule rule{entry.key, column_of_log(point.require("x", "the column of its first coordinate")),
                     column_of_log(point.require("y", "the column of its second coordinate"))};
      read_what_counts(point, rule.x);
      rule.y.missing_numbers = rule.x.missing_numbers;
      rule.y.missing_words = rule.x.missing_words;
      point.finish();
      map.points.push_back(std::move(rule));
    }
  }
  std::vector<Links> links;
  const auto read_columns = [&](const YamlValue& columns, bool written) {
    YamlMap checked(columns);
    for (const auto& entry : columns.map) {
      for (const ColumnRule& other : map.columns) {
        if (other.name == entry.key) {
          throw InputError({value.file, entry.line, entry.column, columns.path + "." + entry.key, "",
                            "stands twice; the first is in line " + std::to_string(other.at.line)});
        }
      }
      links.emplace_back();
      map.columns.push_back(read_column(entry, written, links.back()));
    }
  };
  if (const YamlValue* helpers = keys.find("helpers")) read_columns(*helpers, false);
  const YamlValue& columns = keys.require("columns", "what is written: a name for each column, and where it comes from");
  read_columns(columns, true);
  if (columns.map.empty()) columns.complain("names no column");
  const YamlValue* pauses = keys.find("pauses");
  keys.finish();
  if (pauses != nullptr) map.pauses = read_pauses(*pauses, map);
  for (std::size_t i = 0; i < map.columns.size(); ++i) {
    ColumnRule& rule = map.columns[i];
    if (rule.kind == ColumnKind::difference) {
      rule.of = index_of(map.columns, *links[i].first, "column in `helpers` or `columns`");
      rule.less = index_of(map.columns, *links[i].second, "column in `helpers` or `columns`");
    } else if (rule.kind == ColumnKind::direction) {
      rule.from = index_of(map.points, *links[i].first, "point in `points`");
      rule.to = index_of(map.points, *links[i].second, "point in `points`");
    }
  }
  std::vector<int> state(map.columns.size(), 0);
  for (std::size_t i = 0; i < map.columns.size(); ++i) put_in_order(map, i, state);
  if (!map.layout.header) {
    for_each_log_column(map, [](const LogColumn& column) {
      if (column.number == 0) column.named.complain("the map says `header: false`: columns have numbers, from 1");
    });
  }
  bool reads = false;
  for_each_log_column(map, [&](const LogColumn&) { reads = true; });
  if (!reads) columns.complain("nothing of this is read from the file");
  if (!map.layout.lines_before && map.wanted_names().empty()) columns.complain("with `lines_before_header: any`, some column needs a name");
  return map;
}

LogMap read_log_map(const std::filesystem::path& path) { return parse_log_map(read_yaml(path)); }

Conversion apply_log_map(const LogMap& map, const Log& log) { return Application(map, log).run(); }

Conversion convert_log(const std::filesystem::path& log, const LogMap& map) {
  return apply_log_map(map, read_log(log, map.layout, map.wanted_names()));
}

std::optional<double> rows_per_reading(const std::vector<double>& values) {
  constexpr double fast_steps = 3.5;      // of the converter's resolution, from one reading to the next
  constexpr std::size_t least_runs = 10;  // with fewer, nothing is said
  constexpr double least_rows = 1.5, most_rows = 50.0;
  std::vector<std::pair<double, double>> runs;  // rows, change at its end
  double resolution = std::numeric_limits<double>::infinity();
  for (std::size_t i = 1, start = 0; i < values.size(); ++i) {
    if (values[i] == values[start]) continue;
    const double change = std::abs(values[i] - values[i - 1]);
    if (!std::isnan(change)) {
      runs.emplace_back(static_cast<double>(i - start), change);
      resolution = std::min(resolution, change);
    }
    start = i;
  }
  std::vector<double> fast;
  for (const auto& [rows, change] : runs) {
    if (change > fast_steps * resolution) fast.push_back(rows);
  }
  if (fast.size() < least_runs) return std::nullopt;
  // Beyond one and a half times the usual length a reading came out the same again.
  const double usual = lower_median(fast);
  double sum = 0.0, count = 0.0;
  for (const double rows : fast) {
    if (rows <= 1.5 * usual) sum += rows, ++count;
  }
  const double mean = sum / count;
  if (mean < least_rows || mean > most_rows) return std::nullopt;
  return mean;
}

std::optional<ClockTime> parse_clock(std::string_view text) {
  text = trimmed(text);
  const auto digits = [&](std::size_t least, std::size_t most) -> std::optional<int> {
    std::size_t n = 0;
    while (n < text.size() && n < most && text[n] >= '0' && text[n] <= '9') ++n;
    if (n < least) return std::nullopt;
    int value = 0;
    std::from_chars(text.data(), text.data() + n, value);
    text.remove_prefix(n);
    return value;
  };
  const auto skip = [&](std::string_view any) {
    if (text.empty() || any.find(text.front()) == std::string_view::npos) return false;
    text.remove_prefix(1);
    return true;
  };
  double days = 0.0;
  const bool dated = text.size() > 10 && (text[4] == '-' || text[4] == '/');
  if (dated) {
    const auto year = digits(4, 4);
    if (!year || !skip("-/")) return std::nullopt;
    const auto month = digits(1, 2);
    if (!month || !skip("-/")) return std::nullopt;
    const auto day = digits(1, 2);
    if (!day || !skip(" T")) return std::nullopt;
    const std::chrono::year_month_day date{std::chrono::year(*year), std::chrono::month(static_cast<unsigned>(*month)),
                                           std::chrono::day(static_cast<unsigned>(*day))};
    if (!date.ok()) return std::nullopt;
    days = static_cast<double>(std::chrono::sys_days(date).time_since_epoch().count());
    text = trimmed(text);
    if (text.ends_with('Z')) text.remove_suffix(1);
  }
  const auto hours = digits(1, 2);
  if (!hours || *hours > 24 || !skip(":")) return std::nullopt;
  const auto minutes = digits(2, 2);
  if (!minutes || *minutes > 59) return std::nullopt;
  double seconds = 0.0;
  if (skip(":")) {
    if (text.empty() || text.front() < '0' || text.front() > '9') return std::nullopt;
    const auto parsed = parse_field(text, true);
    if (!parsed || !(*parsed < 61.0)) return std::nullopt;
    seconds = *parsed;
    text = {};
  }
  if (!text.empty()) return std::nullopt;
  return ClockTime{days * day_s + *hours * 3600.0 + *minutes * 60.0 + seconds, dated};
}

std::string rounded(double value, int digits_kept) {
  std::array<char, 32> digits;
  const auto end = std::to_chars(digits.data(), digits.data() + digits.size(), value, std::chars_format::general, digits_kept);
  return std::string(digits.data(), end.ptr);
}

}  // namespace sinew::sim

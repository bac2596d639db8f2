// SPDX-License-Identifier: Apache-2.0
#include "sim/log_suggest.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>
#include <limits>
#include <map>
#include <optional>
#include <utility>
#include <vector>

#include "plant/contains.h"
#include "sim/input_error.h"
#include "sim/log_map.h"
#include "sim/plain_text.h"
#include "sim/text.h"

namespace sinew::sim {
namespace {

constexpr std::size_t looked_at_lines = 400;  // to find the layout
constexpr double held_share = 0.8;            // an input is the same as in the row before more often than this

bool holds_any(const std::string& lower, std::initializer_list<std::string_view> words) {
  return std::any_of(words.begin(), words.end(), [&](std::string_view word) { return lower.find(word) != std::string::npos; });
}

std::string_view without_quotes(std::string_view field) {
  field = trimmed(field);
  if (field.size() >= 2 && field.front() == '"' && field.back() == '"') field = field.substr(1, field.size() - 2);
  return trimmed(field);
}

// ---- layout ----

struct Guess {
  LogLayout layout{};
  std::size_t fields = 0;
  double score = 0.0;  // over the rows of that many fields: numbers, less half of what is none
};

struct LineFacts {
  std::size_t fields = 0, numbers = 0;
  bool first_is_text = false;
};

LineFacts facts_of(std::string_view line, char delimiter, bool decimal_comma) {
  LineFacts facts;
  std::vector<std::string_view> fields = split_fields(line, delimiter);
  if (fields.size() > 1 && without_quotes(fields.back()).empty()) fields.pop_back();
  facts.fields = fields.size();
  for (const std::string_view raw : fields) {
    const std::string_view field = without_quotes(raw);
    facts.numbers += field.empty() || parse_field(field, decimal_comma).has_value() || parse_clock(field).has_value();
  }
  const std::string_view first = without_quotes(fields.front());
  facts.first_is_text = !first.empty() && !parse_field(first, decimal_comma) && !parse_clock(first);
  return facts;
}

std::vector<std::string_view> some_lines(std::string_view text) {
  std::vector<std::string_view> lines;
  if (text.starts_with("\xef\xbb\xbf")) text.remove_prefix(3);
  while (!text.empty() && lines.size() < looked_at_lines) {
    const std::size_t end = std::min(text.find('\n'), text.size());
    std::string_view line = text.substr(0, end);
    if (line.ends_with('\r')) line.remove_suffix(1);
    if (line.size() > longest_line)
      throw InputError({.file = "",
                        .line = static_cast<int>(lines.size()) + 1,
                        .key = "bytes in this line",
                        .value = std::to_string(line.size()),
                        .advice = "a line has at most " + std::to_string(longest_line)});
    lines.push_back(line);
    text.remove_prefix(std::min(end + 1, text.size()));
  }
  return lines;
}

LogLayout guess_layout(std::string_view text) {
  const std::vector<std::string_view> lines = some_lines(text);
  Guess best;
  for (const bool decimal_comma : {false, true}) {
    for (const char delimiter : {',', ';', '\t', '|', ' '}) {
      if (decimal_comma && delimiter == ',') continue;
      std::map<std::size_t, double> score_of_width;
      for (const std::string_view line : lines) {
        if (trimmed(line).empty() || line.front() == '#') continue;
        const LineFacts facts = facts_of(line, delimiter, decimal_comma);
        if (!facts.first_is_text && 2 * facts.numbers > facts.fields)
          score_of_width[facts.fields] += 1.5 * static_cast<double>(facts.numbers) - 0.5 * static_cast<double>(facts.fields);
      }
      for (const auto& [fields, score] : score_of_width) {
        // The first wins of two layouts that tell as many numbers apart.
        if (score > best.score) {
          best.fields = fields, best.score = score;
          best.layout.delimiter = delimiter, best.layout.decimal_comma = decimal_comma;
        }
      }
    }
  }
  if (best.fields == 0) {
    throw InputError(
        {.key = "no rows of numbers", .advice = "in the first " + std::to_string(lines.size()) + " lines, whatever delimiter is tried"});
  }
  LogLayout layout = best.layout;
  const auto is_row = [&](std::string_view line) {
    const LineFacts facts = facts_of(line, layout.delimiter, layout.decimal_comma);
    return facts.fields == best.fields && !facts.first_is_text && 2 * facts.numbers > facts.fields;
  };
  std::size_t first_row = 0;
  while (first_row < lines.size() && (trimmed(lines[first_row]).empty() || lines[first_row].front() == '#' || !is_row(lines[first_row])))
    ++first_row;
  // The header is the line above, where it has a name for each column.
  layout.header = false;
  layout.lines_before = first_row;
  for (std::size_t above = first_row; above-- > 0;) {
    if (trimmed(lines[above]).empty()) continue;
    const LineFacts facts = facts_of(lines[above], layout.delimiter, layout.decimal_comma);
    if (facts.fields == best.fields && 2 * facts.numbers <= facts.fields) {
      layout.header = true;
      layout.lines_before = above;
    }
    break;
  }
  for (std::size_t i = first_row; i < lines.size(); ++i) {
    const bool last = i + 1 == lines.size();
    if (last || trimmed(lines[i]).empty() || lines[i].front() == '#') continue;
    const LineFacts facts = facts_of(lines[i], layout.delimiter, layout.decimal_comma);
    layout.ignore_text = layout.ignore_text || facts.fields != best.fields || facts.first_is_text;
  }
  return layout;
}

std::string layout_yaml(const LogLayout& layout) {
  std::string keys;
  const auto say = [&](const std::string& key) { keys += (keys.empty() ? "" : ", ") + key; };
  if (!layout.header) say("header: false");
  if (layout.lines_before.value_or(0) > 0)
    say((layout.header ? "lines_before_header: " : "lines_before_rows: ") + std::to_string(*layout.lines_before));
  if (layout.delimiter != ',')
    say(std::string("delimiter: ") + (layout.delimiter == ';'    ? "semicolon"
                                      : layout.delimiter == '\t' ? "tab"
                                      : layout.delimiter == '|'  ? "bar"
                                                                 : "spaces"));
  if (layout.decimal_comma) say("decimal: comma");
  if (layout.ignore_text) say("text_lines: ignore");
  return keys.empty() ? "" : "file: {" + keys + "}\n";
}

// ---- columns ----

enum class Looks { unknown, named, time, duty, counts, temperature, angle, radians, constant, text };

struct Seen {
  std::size_t column = 0;
  std::string title, lower;  // name in the file, and in lower case
  std::vector<double> values;
  double lowest = 0.0, highest = 0.0, held = 0.0;  // held: share of rows that repeat the one before
  std::size_t missing = 0, texts = 0;
  Looks looks = Looks::unknown;
  std::string unit{};  // of time
};

Seen look_at(const Log& log, std::size_t column) {
  Seen seen{.column = column, .title = log.title(column), .lower = lower_case(log.names[column]), .values = {}};
  seen.lowest = std::numeric_limits<double>::infinity(), seen.highest = -seen.lowest;
  std::size_t repeats = 0;
  for (std::size_t row = 0; row < log.rows(column); ++row) {
    const auto number = log.number(row, column);
    seen.texts += !number;
    const double value = number.value_or(std::numeric_limits<double>::quiet_NaN());
    if (std::isnan(value)) {
      ++seen.missing;
    } else {
      seen.lowest = std::min(seen.lowest, value);
      seen.highest = std::max(seen.highest, value);
    }
    repeats += !seen.values.empty() && value == seen.values.back();
    seen.values.push_back(value);
  }
  seen.held = seen.values.size() < 2 ? 0.0 : static_cast<double>(repeats) / static_cast<double>(seen.values.size() - 1);
  return seen;
}

std::vector<double> steps_of(const Seen& seen) {
  std::vector<double> steps;
  for (std::size_t i = 1; i < seen.values.size(); ++i) steps.push_back(seen.values[i] - seen.values[i - 1]);
  return steps;
}

bool sounds_like_time(const std::string& lower) {
  return lower == "t" || holds_any(lower, {"time", "clock", "millis", "elapsed", "seconds"}) || lower == "ms" || lower == "s";
}

// Whether the column goes forward from row to row; a clock, or a name that says so, may stand still or start anew now and then.
bool looks_like_time(const Log& log, Seen& seen) {
  if (seen.texts > 0) {
    std::size_t clocks = 0;
    for (std::size_t row = 0; row < log.rows(seen.column); ++row) clocks += parse_clock(log.field(row, seen.column)).has_value();
    if (clocks != log.rows(seen.column)) return false;
    seen.unit = "clock";
    return true;
  }
  if (seen.missing > 0 || seen.values.size() < 2) return false;
  std::vector<double> steps = steps_of(seen);
  const auto forward = static_cast<double>(std::count_if(steps.begin(), steps.end(), [](double s) { return s > 0.0; }));
  const auto share = forward / static_cast<double>(steps.size());
  const double median = lower_median(steps);
  if (!(median > 0.0) || share < (sounds_like_time(seen.lower) ? 0.7 : 1.0)) return false;
  // Without a name, only even steps are time's.
  if (!sounds_like_time(seen.lower)) {
    const auto even = std::count_if(steps.begin(), steps.end(), [&](double s) { return std::abs(s - median) < 0.2 * median; });
    if (static_cast<double>(even) < 0.8 * static_cast<double>(steps.size())) return false;
  }
  if (holds_any(seen.lower, {"midnight"}))
    seen.unit = "ms_of_day";
  else if (holds_any(seen.lower, {"_us", "micros"}))
    seen.unit = "us";
  else if (holds_any(seen.lower, {"_ms", "(ms)", "[ms]", "milli", "msec"}) || seen.lower == "ms")
    seen.unit = "ms";
  else if (seen.lower.ends_with("_s") || holds_any(seen.lower, {"sec", "(s)", "[s]"}))
    seen.unit = "s";
  else
    seen.unit = median >= 1e6 && seen.values.front() > 1e17                               ? "ns"  // since 1970, as ROS exports it
                : median >= 5.0 && std::floor(seen.values.front()) == seen.values.front() ? "ms"
                                                                                          : "s";
  return true;
}

Looks kind_of(const Seen& seen) {
  if (seen.texts > 0) return Looks::text;
  if (seen.missing == seen.values.size()) return Looks::constant;
  const std::string& name = seen.lower;
  const bool constant = seen.lowest == seen.highest;
  const bool input_name = holds_any(name, {"duty", "pwm"});
  const bool count_name = input_name || holds_any(name, {"raw", "count"});
  if (input_name && !holds_any(name, {"unconstrained", "setpoint", "freq"}) && seen.lowest >= 0.0 && seen.highest <= 1.0)
    return Looks::duty;
  if (constant) return Looks::constant;
  if (count_name && seen.lowest >= 0.0 && seen.highest > 1.0 && seen.highest <= 255.0) return Looks::counts;
  const bool sane_temperature = seen.lowest > -60.0 && seen.highest < 400.0;
  const bool short_temperature =
      name.size() <= 3 && name.starts_with("t") && (name.size() == 1 || std::isalnum(static_cast<unsigned char>(name[1])));
  if (sane_temperature && !holds_any(name, {"limit", "target", "setpoint"}) &&
      (holds_any(name, {"temp", "thermo", "degc", "celsius"}) || (short_temperature && seen.lowest > 5.0)))
    return Looks::temperature;
  if (std::abs(seen.lowest) <= 720.0 && std::abs(seen.highest) <= 720.0 && !holds_any(name, {"targ", "setpoint"}) &&
      (holds_any(name, {"angle", "theta", "bend", "_deg", "(deg", "pitch", "roll", "yaw", "tilt", "_rad"}) || name == "phi"))
    return holds_any(name, {"rad"}) && std::abs(seen.highest) < 7.0 ? Looks::radians : Looks::angle;
  // What is held from row to row, between 0 and 255, is likelier an input than a measurement.
  if (seen.held > held_share && seen.lowest >= 0.0 && seen.highest > 1.0 && seen.highest <= 255.0 &&
      !holds_any(name, {"targ", "setpoint", "limit", "tag"}))
    return Looks::counts;
  const std::size_t end = name.rfind('_');
  const std::string_view unit = end == std::string::npos ? "" : std::string_view(seen.title).substr(end + 1);
  for (const std::string_view known : {"V", "A", "m", "N", "Pa", "W", "rad", "K", "m_s", "Nm"}) {
    if (unit == known) return Looks::named;
  }
  return Looks::unknown;
}

// Letters, digits and _ alone.
std::string plain_name(std::string_view name) {
  std::string plain;
  for (const char c : name) {
    const bool keeps = std::isalnum(static_cast<unsigned char>(c)) != 0;
    if (keeps)
      plain += c;
    else if (!plain.empty() && plain.back() != '_')
      plain += '_';
  }
  while (plain.ends_with('_')) plain.pop_back();
  return plain;
}

std::string quoted(const std::string& name) {
  std::string text = "\"";
  for (const char c : name) {
    if (c == '"' || c == '\\') text += '\\';
    text += c;
  }
  return text + "\"";
}

class Suggestion {
 public:
  Suggestion(const Log& log, std::string layout) : log_(log), layout_(std::move(layout)) {
    for (std::size_t i = 0; i < log.columns(); ++i) seen_.push_back(look_at(log, i));
    find_time();
    find_points();
  }

  std::string text() {
    std::string columns, others;
    for (Seen& seen : seen_) {
      if (seen.looks == Looks::time) continue;
      if (is_point_[seen.column]) continue;
      if (!as_long_as_time(seen)) {
        others += comment(seen);
        continue;
      }
      seen.looks = kind_of(seen);
      const std::string line = mapped(seen);
      if (line.empty())
        others += comment(seen);
      else
        columns += line;
    }
    std::string text = "# A map to begin with, from `sinew convert --suggest`. Look at each line, and put right what is not so.\n# " +
                       facts() + "\nformat: 1\n" + layout_;
    if (time_) {
      text += "time: {column: " + named(seen_[*time_]) + ", unit: " + seen_[*time_].unit + "}   # " + range(seen_[*time_]) + "\n";
    } else {
      text += "# No column looks like time. Where rows come at an even rate: how many seconds apart?\n# time: {period_s: 0.1}\n";
    }
    text += points_;
    if (columns.empty()) {
      text += "# No column looks like duty, temperature or angle: here is all that changes. A name ends in its unit.\n";
      others.clear();
      for (Seen& seen : seen_) {
        if (seen.looks == Looks::time || is_point_[seen.column]) continue;
        const bool changes = seen.looks == Looks::unknown && as_long_as_time(seen);
        if (changes) seen.looks = Looks::named;
        (changes ? columns : others) += changes ? mapped(seen) : comment(seen);
      }
    }
    text += "columns:\n" + columns;
    if (!others.empty()) text += "  # What else is there:\n" + others;
    return text;
  }

 private:
  bool is_constant(const Seen& seen) const { return seen.lowest == seen.highest; }

  void find_time() {
    for (const bool by_name : {true, false}) {
      for (Seen& seen : seen_) {
        if (time_ || sounds_like_time(seen.lower) != by_name) continue;
        if (seen.values.size() > 1 && (!is_constant(seen) || seen.texts > 0) && looks_like_time(log_, seen)) {
          seen.looks = Looks::time;
          time_ = seen.column;
        }
      }
    }
  }

  // Two columns whose names differ by x for y alone.
  void find_points() {
    is_point_.assign(seen_.size(), false);
    for (const Seen& x : seen_) {
      for (std::size_t at = 0; at < x.lower.size(); ++at) {
        const bool alone = (at == 0 || !std::isalpha(static_cast<unsigned char>(x.lower[at - 1]))) &&
                           (at + 1 == x.lower.size() || !std::isalpha(static_cast<unsigned char>(x.lower[at + 1])));
        if (x.lower[at] != 'x' || !alone || x.values.empty() || is_point_[x.column]) continue;
        if (holds_any(x.lower, {"theta", "angle", "throttle", "bend", "pwm", "duty"}) || !(x.highest > 1.0)) continue;
        std::string wanted = x.lower;
        wanted[at] = 'y';
        const auto y = std::find_if(seen_.begin(), seen_.end(), [&](const Seen& s) { return s.lower == wanted; });
        if (y == seen_.end() || is_constant(x) || is_constant(*y)) continue;
        is_point_[x.column] = is_point_[y->column] = true;
        std::string name = x.title;
        name.erase(at, 1);
        name = plain_name(name);
        if (name.empty()) name = "point";
        const bool zeros = contains(x.values, 0.0);
        if (points_.empty()) {
          points_ =
              "# A helper `{direction: {from: ..., to: ...}}` is the direction from one point to another, in degrees; 0 is taken for \"not "
              "seen\".\npoints:\n";
        }
        points_ += "  " + unique(name) + ": {x: " + named(x) + ", y: " + named(*y) + (zeros ? ", missing: 0" : "") + "}\n";
      }
    }
  }

  bool as_long_as_time(const Seen& seen) const {
    if (log_.is_text()) return true;
    if (seen.values.size() < 2) return false;
    return !time_ || seen.values.size() == seen_[*time_].values.size();
  }

  std::string named(const Seen& seen) const {
    return log_.names[seen.column].empty() || twice(seen) ? std::to_string(seen.column + 1) : quoted(log_.names[seen.column]);
  }
  bool twice(const Seen& seen) const {
    return log_.is_text() && std::count_if(seen_.begin(), seen_.end(), [&](const Seen& s) { return s.lower == seen.lower; }) > 1;
  }

  std::string unique(std::string name) {
    while (contains(taken_, name)) name += "_2";
    taken_.push_back(name);
    return name;
  }

  std::string range(const Seen& seen) const {
    std::string text;
    if (seen.texts == seen.values.size()) {
      text = log_.is_text() ? "text, such as " + printable(log_.field(0, seen.column), 30) : "no numbers";
    } else if (seen.missing == seen.values.size()) {
      text = "empty";
    } else if (is_constant(seen)) {
      text = "always " + shortest(seen.lowest);
    } else {
      text = rounded(seen.lowest) + " to " + rounded(seen.highest);
    }
    if (seen.missing > seen.texts && seen.missing < seen.values.size()) text += ", " + std::to_string(seen.missing - seen.texts) + " empty";
    if (seen.texts > 0 && seen.texts < seen.values.size()) text += ", " + std::to_string(seen.texts) + " fields no numbers";
    return text;
  }

  std::string comment(const Seen& seen) {
    std::string name = plain_name(log_.names[seen.column]);
    if (name.empty()) name = "column_" + std::to_string(seen.column + 1);
    const std::string length =
        as_long_as_time(seen) ? ""
                              : (seen.values.size() == 1 ? ", a single number" : ", " + std::to_string(seen.values.size()) + " values");
    return "  # " + printable(name) + ": {column: " + printable(named(seen), 200) + "}   # " + range(seen) + length + "\n";
  }

  static bool is_percent(const Seen& seen) {
    return holds_any(seen.lower, {"%", "percent", "prozent", "pct"}) &&
           std::none_of(seen.values.begin(), seen.values.end(), [](double value) { return value > 100.0; });
  }

  std::string mapped(const Seen& seen) {
    std::string name = plain_name(log_.names[seen.column]);
    if (name.empty()) name = "column_" + std::to_string(seen.column + 1);
    std::string keys = "column: " + named(seen), looks;
    const auto with_suffix = [](std::string base, const std::string& suffix) {
      return lower_case(base).ends_with(lower_case(suffix)) ? base.substr(0, base.size() - suffix.size()) + suffix : base + suffix;
    };
    switch (seen.looks) {
      case Looks::named:
        break;
      case Looks::duty:
        name = duty_name(name);
        looks = "a duty";
        break;
      case Looks::counts:
        name = duty_name(name);
        keys += is_percent(seen) ? ", unit: percent" : ", unit: counts_255";
        looks = is_percent(seen)        ? "a duty in percent"
                : seen.highest <= 100.0 ? "PWM counts of 255, or percent: then unit: percent"
                                        : "PWM counts of 255";
        break;
      case Looks::temperature: {
        if (!holds_any(seen.lower, {"temp"})) name = "temperature_" + name;
        name = with_suffix(name, "_degC");
        looks = "a temperature";
        const auto rows = rows_per_reading(seen.values);
        const double period_s = row_period_s();
        if (rows && period_s > 0.0) {
          keys += ", repeats: {reading_every_s: " + rounded(*rows * period_s, 2) + "}";
          looks += " that repeats each reading for about " + rounded(*rows, 2) + " rows";
        }
        break;
      }
      case Looks::angle:
      case Looks::radians:
        name = with_suffix(name, "_deg");
        if (seen.looks == Looks::radians) keys += ", unit: rad";
        looks = "an angle";
        break;
      default:
        return "";
    }
    return "  " + unique(name) + ": {" + keys + "}   # " + range(seen) + (looks.empty() ? "" : ": looks like " + looks) + "\n";
  }

  // duty_ and what distinguishes it: pwm_duty_limb0 is duty_limb0.
  static std::string duty_name(const std::string& name) {
    std::string rest;
    for (std::size_t start = 0; start <= name.size();) {
      const std::size_t end = std::min(name.find('_', start), name.size());
      const std::string word = name.substr(start, end - start);
      if (const std::string lower = lower_case(word); lower != "pwm" && lower != "duty" && lower != "raw" && !word.empty())
        rest += "_" + word;
      start = end + 1;
    }
    return "duty" + rest;
  }

  double row_period_s() const {
    if (!time_ || seen_[*time_].unit == "clock") return 0.0;
    const std::string& unit = seen_[*time_].unit;
    const double median = lower_median(steps_of(seen_[*time_]));
    return unit == "ns" ? median / 1e9 : unit == "us" ? median / 1e6 : unit == "s" ? median : median / 1000.0;
  }

  std::string facts() const {
    const std::size_t rows = time_ ? seen_[*time_].values.size() : seen_.empty() ? 0 : seen_.front().values.size();
    std::string text = std::to_string(rows) + " rows, " + std::to_string(seen_.size()) + " columns";
    const double period_s = row_period_s();
    if (period_s > 0.0) text += ", a row every " + rounded(period_s) + " s in the median (" + rounded(1.0 / period_s) + " Hz)";
    return text;
  }

  const Log& log_;
  std::string layout_;
  std::vector<Seen> seen_;
  std::optional<std::size_t> time_;
  std::vector<bool> is_point_;
  std::string points_;
  std::vector<std::string> taken_;
};

}  // namespace

std::string suggest_text_map(const std::string& text, const std::string& file) {
  LogLayout layout{};
  try {
    layout = guess_layout(text);
  } catch (InputError& error) {
    throw InputError({.file = file, .line = error.line, .key = error.key, .value = error.value, .advice = error.advice});
  }
  const Log log = parse_text_log(text, file, layout);
  for (const std::string& name : log.names)
    if (!is_plain_text(name))
      throw InputError({.file = file,
                        .line = log.header_line(),
                        .key = "column",
                        .value = name,
                        .advice =
                            "is not UTF-8 without control characters, so that no map can name it: save the file as UTF-8, where it is in "
                            "Latin-1 by `iconv -f latin1 -t utf8`"});
  return Suggestion(log, layout_yaml(layout)).text();
}

std::string suggest_map(const std::filesystem::path& path) {
  if (kind_of_log(path) == LogKind::text) return suggest_text_map(read_file(path), path.string());
  return Suggestion(read_log(path, {}), "").text();
}

}  // namespace sinew::sim

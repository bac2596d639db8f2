// SPDX-License-Identifier: Apache-2.0
#include "sim/yaml.h"

#include <doctest/doctest.h>

#include <string>
#include <string_view>

namespace sim_yaml_test {

using namespace sinew::sim;

namespace {

YamlValue parse(std::string_view text) { return parse_yaml(text, "t.yaml"); }

template <class Action>
std::string error_of(Action action) {
  try {
    action();
  } catch (const InputError& error) {
    return error.what();
  }
  return "nothing was thrown";
}

std::string parsing_error(std::string_view text) {
  return error_of([&] { parse(text); });
}

// What a reader of one value says of the value of key `a` in the text.
template <class Read>
std::string error_at_a(std::string_view text, Read read) {
  const YamlValue root = parse(text);
  return error_of([&] {
    YamlMap map(root);
    const YamlValue* a = map.find("a");
    REQUIRE(a != nullptr);
    read(*a);
  });
}

std::string number_error(std::string_view text) {
  return error_at_a(text, [](const YamlValue& a) { static_cast<void>(a.number()); });
}

double number_in(std::string_view text) {
  const YamlValue root = parse(text);
  return YamlMap(root).find("a")->number();
}

}  // namespace

TEST_CASE("yaml: every value knows its line, its column and the way to it") {
  const YamlValue root = parse("one: 1\ntwo:\n  - x\n  - { deep: [ p, q ] }\n");
  CHECK(root.kind == YamlValue::Kind::map);
  CHECK(root.path.empty());
  REQUIRE(root.map.size() == 2);
  CHECK(root.map[0].key == "one");
  CHECK(root.map[0].line == 1);
  CHECK(root.map[0].column == 1);
  CHECK(root.map[0].value.line == 1);
  CHECK(root.map[0].value.column == 6);
  const YamlValue& two = root.map[1].value;
  CHECK(two.kind == YamlValue::Kind::list);
  REQUIRE(two.list.size() == 2);
  CHECK(two.list[0].scalar == "x");
  CHECK(two.list[0].path == "two[0]");
  CHECK(two.list[0].line == 3);
  CHECK(two.list[0].column == 5);
  const YamlValue& deep = two.list[1].map[0].value;
  CHECK(two.list[1].map[0].line == 4);
  CHECK(two.list[1].map[0].column == 7);
  CHECK(deep.list[1].scalar == "q");
  CHECK(deep.list[1].path == "two[1].deep[1]");
  CHECK(deep.list[1].line == 4);
  CHECK(deep.list[1].column == 18);
  CHECK(deep.list[1].file == "t.yaml");
}

TEST_CASE("yaml: numbers are read whatever their form, and exactly") {
  CHECK(number_in("a: 600") == 600.0);
  CHECK(number_in("a: -0.25") == -0.25);
  CHECK(number_in("a: 1.0e-5") == 1.0e-5);
  CHECK(number_in("a: .5") == 0.5);
  CHECK(number_in("a: +3") == 3.0);
  CHECK(number_in("a: 0.1   # a comment") == 0.1);
}

TEST_CASE("yaml: a number with its unit is told that the unit stands in the key") {
  CHECK(number_error("b: 2\na: 600 s\n") == "t.yaml:2:4: a = 600 s\n  must be a number alone; its unit stands in the key");
  CHECK(number_error("a: -3degC") == "t.yaml:1:4: a = -3degC\n  must be a number alone; its unit stands in the key");
  CHECK(number_error("a: 1,5") == "t.yaml:1:4: a = 1,5\n  must be a number alone; its unit stands in the key");
  CHECK(number_error("a: 0x10") == "t.yaml:1:4: a = 0x10\n  must be a number alone; its unit stands in the key");
}

TEST_CASE("yaml: what is no number is shown where a number is due") {
  CHECK(number_error("a: fast") == "t.yaml:1:4: a = fast\n  must be a number");
  CHECK(number_error("a: nan") == "t.yaml:1:4: a = nan\n  must be a number");
  CHECK(number_error("a: .inf") == "t.yaml:1:4: a = .inf\n  must be a number");
  CHECK(number_error("a: inf") == "t.yaml:1:4: a = inf\n  must be a number");
  CHECK(number_error("a: 1e999") == "t.yaml:1:4: a = 1e999\n  must be a number alone; its unit stands in the key");
  CHECK(number_error("a:\n  b: 1\n") == "t.yaml:2:3: a = { a map }\n  must be a number");
  CHECK(number_error("a: [1, 2]\n") == "t.yaml:1:4: a = [ a list ]\n  must be a number");
}

TEST_CASE("yaml: a number in quotes is text") {
  CHECK(number_error("a: \"600\"") == "t.yaml:1:4: a = 600\n  must be a number");
  CHECK(number_error("a: '600'") == "t.yaml:1:4: a = 600\n  must be a number");
  CHECK(error_at_a("a: '3'", [](const YamlValue& a) { a.whole_number(); }) == "t.yaml:1:4: a = 3\n  must be a whole number");
  CHECK(error_at_a("a: 'true'", [](const YamlValue& a) { a.truth(); }) == "t.yaml:1:4: a = true\n  must be true or false");
}

TEST_CASE("yaml: a value that is not there is pointed at by its key") {
  // The next thing in this file stands in line 4, and has nothing to do with it.
  CHECK(number_error("a:\n\n\nb: 2\n") == "t.yaml:1:1: a = (nothing)\n  must be a number");
  CHECK(number_error("b: 2\na:\n") == "t.yaml:2:1: a = (nothing)\n  must be a number");
  CHECK(number_error("a: null\n") == "t.yaml:1:1: a = (nothing)\n  must be a number");
  CHECK(number_error("{ b: 1, a: ~ }\n") == "t.yaml:1:9: a = (nothing)\n  must be a number");
}

TEST_CASE("yaml: a range is closed, and an error says it") {
  const auto read = [](const YamlValue& a) { static_cast<void>(a.number_in({0.001, 60.0})); };
  CHECK(error_at_a("a: 0.001", read) == "nothing was thrown");
  CHECK(error_at_a("a: 60", read) == "nothing was thrown");
  CHECK(error_at_a("a: 60.1", read) == "t.yaml:1:4: a = 60.1\n  must lie in [0.001, 60]");
  CHECK(error_at_a("a: -1", read) == "t.yaml:1:4: a = -1\n  must lie in [0.001, 60]");
}

TEST_CASE("yaml: whole numbers are whole, of 64 bits, and not in quotes") {
  const auto read = [](const YamlValue& a) { static_cast<void>(a.whole_number()); };
  const YamlValue root = parse("a: 9223372036854775807\nb: -5");
  CHECK(YamlMap(root).find("a")->whole_number() == 9223372036854775807LL);
  CHECK(YamlMap(root).find("b")->whole_number() == -5);
  CHECK(error_at_a("a: 1.0", read) == "t.yaml:1:4: a = 1.0\n  must be a whole number");
  CHECK(error_at_a("a: 1e3", read) == "t.yaml:1:4: a = 1e3\n  must be a whole number");
  CHECK(error_at_a("a: 9223372036854775808", read) ==
        "t.yaml:1:4: a = 9223372036854775808\n  must lie in [-9223372036854775808, 9223372036854775807]");
  CHECK(error_at_a("a:", read) == "t.yaml:1:1: a = (nothing)\n  must be a whole number");
  CHECK(error_at_a("a: [1]", read) == "t.yaml:1:4: a = [ a list ]\n  must be a whole number");
}

TEST_CASE("yaml: truth is true or false and nothing else") {
  const auto read = [](const YamlValue& a) { static_cast<void>(a.truth()); };
  const YamlValue root = parse("a: true\nb: false");
  CHECK(YamlMap(root).find("a")->truth());
  CHECK_FALSE(YamlMap(root).find("b")->truth());
  CHECK(error_at_a("a: yes", read) == "t.yaml:1:4: a = yes\n  must be true or false");
  CHECK(error_at_a("a: 1", read) == "t.yaml:1:4: a = 1\n  must be true or false");
  CHECK(error_at_a("a: True", read) == "t.yaml:1:4: a = True\n  must be true or false");
}

TEST_CASE("yaml: a word is a scalar") {
  const auto read = [](const YamlValue& a) { static_cast<void>(a.text()); };
  CHECK(error_at_a("a: 'a word'", read) == "nothing was thrown");
  CHECK(error_at_a("a: [x]", read) == "t.yaml:1:4: a = [ a list ]\n  must be a word");
  CHECK(error_at_a("a: {x: y}", read) == "t.yaml:1:4: a = { a map }\n  must be a word");
  CHECK(error_at_a("a:", read) == "t.yaml:1:1: a = (nothing)\n  must be a word");
}

TEST_CASE("yaml: a list or a word where a map is due is an error, nothing at all is an empty map") {
  const auto read = [](const YamlValue& a) { YamlMap{a}.finish(); };
  CHECK(error_at_a("a: {}", read) == "nothing was thrown");
  CHECK(error_at_a("a:", read) == "nothing was thrown");
  CHECK(error_at_a("a:\n  - x: 1\n", read) == "t.yaml:2:3: a = [ a list ]\n  must be a map");
  CHECK(error_at_a("a: 0.5", read) == "t.yaml:1:4: a = 0.5\n  must be a map");
  const YamlValue list = parse("- 1\n- 2\n");
  CHECK(error_of([&] { YamlMap{list}; }) == "t.yaml:1:1: the file = [ a list ]\n  must be a map");
  const YamlValue nothing = parse("");
  CHECK(nothing.kind == YamlValue::Kind::empty);
  CHECK(error_of([&] { YamlMap{nothing}; }) == "nothing was thrown");
}

TEST_CASE("yaml: a key that stands twice is an error at the second") {
  CHECK(parsing_error("a: 1\nb: 2\na: 3\n") == "t.yaml:3:1: a\n  stands twice; the first is in line 1");
  CHECK(parsing_error("top:\n  inner: { x: 1, y: 2, x: 1 }\n") == "t.yaml:2:24: top.inner.x\n  stands twice; the first is in line 2");
  CHECK(parsing_error("a: 1\n'a': 3\n") == "t.yaml:2:1: a\n  stands twice; the first is in line 1");
}

TEST_CASE("yaml: a key that is a list is an error") {
  CHECK(parsing_error("b: 1\n? [x, y]\n: 3\n") == "t.yaml:2:3\n  a key must be a plain word");
}

TEST_CASE("yaml: a missing key is said at the map it is missing from, with what it is for") {
  const YamlValue root = parse("a:\n  b: { c: 1 }\n");
  const auto missing = [&] {
    YamlMap outer(root);
    YamlMap inner(*outer.find("a"));
    YamlMap innermost(*inner.find("b"));
    innermost.require("from_s", "begin");
  };
  CHECK(error_of(missing) == "t.yaml:2:6: a.b.from_s\n  is missing: begin");
  const YamlValue nothing = parse("");
  CHECK(error_of([&] { YamlMap{nothing}.require("format", "format: 1"); }) == "t.yaml: format\n  is missing: format: 1");
}

TEST_CASE("yaml: an unknown key is an error with the nearest that was asked for") {
  const auto read = [](std::string_view text, std::string_view advice) {
    const YamlValue root = parse(text);
    return error_of([&] {
      YamlMap map(root);
      map.find("duration_s");
      map.find("sample_period_s");
      map.find("seed");
      map.finish(advice);
    });
  };
  CHECK(read("seed: 1\nduration_s: 2\n", "") == "nothing was thrown");
  CHECK(read("seed: 1\nsample_perod_s: 2\n", "") == "t.yaml:2:1: sample_perod_s\n  no such key here; did you mean sample_period_s?");
  CHECK(read("Seed: 1\n", "") == "t.yaml:1:1: Seed\n  no such key here; did you mean seed?");
  CHECK(read("{ seed: 1, sede: 2 }", "see there") == "t.yaml:1:12: sede\n  no such key here; did you mean seed?\n  see there");
  CHECK(read("gravity: 1\n", "") == "t.yaml:1:1: gravity\n  no such key here; what may stand here: duration_s, sample_period_s, seed");
}

TEST_CASE("yaml: a key with another unit is nearest to the one with the same words") {
  const auto read = [](std::string_view text) {
    const YamlValue root = parse(text);
    return error_of([&] {
      YamlMap map(root);
      map.find("rise_s");
      map.find("duration_s");
      map.finish();
    });
  };
  CHECK(read("duration_ms: 600000\n") == "t.yaml:1:1: duration_ms\n  no such key here; did you mean duration_s?");
  CHECK(read("rise_minutes: 600000\n") == "t.yaml:1:1: rise_minutes\n  no such key here; did you mean rise_s?");
}

TEST_CASE("yaml: text that is no YAML is an error where it breaks off") {
  CHECK(parsing_error("a: 1\nb:\n\tc: 2\n") == "t.yaml:3:1\n  no YAML: a tab indents; use spaces");
  CHECK(parsing_error("a: { b: 1\n") == "t.yaml:2:1\n  no YAML: end of map flow not found");
  CHECK(parsing_error("a: [ 1, 2\n") == "t.yaml:2:1\n  no YAML: end of sequence flow not found");
  CHECK(parsing_error("a: 1\n b: 2\n") == "t.yaml:2:3\n  no YAML: illegal map value");
  CHECK(parsing_error("a: @x\n") == "t.yaml:1:4\n  no YAML: unknown token");
  CHECK(parsing_error("a: 1\nb: *nowhere\n") == "t.yaml:2:4\n  no YAML: the referenced anchor is not defined");
}

TEST_CASE("yaml: an anchor may stand for its value, but not contain itself") {
  const YamlValue root = parse("a: &one { x: 1 }\nb: *one\n");
  CHECK(root.map[1].value.map[0].value.number() == 1.0);
  CHECK(root.map[1].value.map[0].value.path == "b.x");
  CHECK(parsing_error("b: 1\na: &one { x: *one }\n") == "t.yaml:2:4\n  is nested too deeply; does an anchor contain itself?");
  CHECK(parsing_error("a: &one [ *one ]\n") == "t.yaml:1:4\n  is nested too deeply; does an anchor contain itself?");
}

TEST_CASE("yaml: a file that is not there is an error with the system's reason") {
  CHECK(error_of([] { read_yaml("/nowhere/at/all.yaml"); }) == "/nowhere/at/all.yaml: cannot read\n  No such file or directory");
}

}  // namespace sim_yaml_test

// SPDX-License-Identifier: Apache-2.0
// Indices into the lists of a System. An effect, a parameter, a channel are all numbers inside and never the same number, so
// each list has an index type of its own, and the compiler finds what a reader would not.
#pragma once

#include <compare>
#include <cstddef>
#include <vector>

namespace sinew::plant {

template <class Tag>
struct Id {
  std::size_t index = 0;
  friend auto operator<=>(const Id&, const Id&) = default;
};

using StateId = Id<struct StateTag>;
using InputId = Id<struct InputTag>;
using ChannelId = Id<struct ChannelTag>;
using ParameterId = Id<struct ParameterTag>;
using EffectId = Id<struct EffectTag>;
using EntryId = Id<struct EntryTag>;            // of entries: one equation or reading of one part
using EntryGroupId = Id<struct EntryGroupTag>;  // of groups of entries: the same equation in all parts
using VariableId = Id<struct VariableTag>;

// Walks the indices of a list: for (const ChannelId c : all<ChannelId>(count)).
template <class Key>
class IdRange {
 public:
  struct Iterator {
    std::size_t at;
    Key operator*() const { return Key{at}; }
    Iterator& operator++() {
      ++at;
      return *this;
    }
    friend bool operator==(const Iterator&, const Iterator&) = default;
  };
  explicit IdRange(std::size_t count) : count_(count) {}
  Iterator begin() const { return {0}; }
  Iterator end() const { return {count_}; }

 private:
  std::size_t count_;
};

// A vector that only its own index type reads. What is not there throws std::out_of_range.
template <class Key, class Value>
class ListOf {
 public:
  ListOf() = default;
  explicit ListOf(std::vector<Value> values) : values_(std::move(values)) {}
  ListOf(std::size_t count, const Value& value) : values_(count, value) {}
  std::size_t size() const { return values_.size(); }
  bool empty() const { return values_.empty(); }
  decltype(auto) operator[](Key key) { return values_.at(key.index); }
  decltype(auto) operator[](Key key) const { return values_.at(key.index); }
  void push_back(Value value) { values_.push_back(std::move(value)); }
  auto begin() { return values_.begin(); }
  auto end() { return values_.end(); }
  auto begin() const { return values_.begin(); }
  auto end() const { return values_.end(); }
  IdRange<Key> ids() const { return IdRange<Key>(values_.size()); }
  const std::vector<Value>& values() const { return values_; }
  std::vector<Value>& values() { return values_; }
  friend bool operator==(const ListOf&, const ListOf&) = default;

 private:
  std::vector<Value> values_;
};

}  // namespace sinew::plant

// SPDX-License-Identifier: Apache-2.0
#include "plant/ids.h"

#include <doctest/doctest.h>

#include <stdexcept>
#include <type_traits>
#include <utility>

namespace plant_ids_test {

using namespace sinew::plant;

namespace {

template <class From, class To>
constexpr bool goes_into = std::is_convertible_v<From, To> || std::is_constructible_v<To, From>;

template <class List, class Key>
concept ReadBy = requires(List list, Key key) {
  list[key];
};

// No index goes into any other.
template <class... Key>
constexpr bool all_apart() {
  const auto apart_from_others = []<class One>(std::type_identity<One>) {
    return ((std::is_same_v<One, Key> || !goes_into<One, Key>)&&...);
  };
  return (apart_from_others(std::type_identity<Key>{}) && ...);
}

}  // namespace

static_assert(all_apart<StateId, InputId, ChannelId, ParameterId, EffectId, EntryId, EntryGroupId, VariableId>());
static_assert(!std::is_convertible_v<std::size_t, ChannelId> && !std::is_convertible_v<int, ChannelId>);
static_assert(!goes_into<ChannelId, std::size_t> && !goes_into<ChannelId, int> && !goes_into<ChannelId, bool>);
static_assert(ReadBy<ListOf<ChannelId, double>, ChannelId>);
static_assert(!ReadBy<ListOf<ChannelId, double>, ParameterId>);
static_assert(!ReadBy<ListOf<ChannelId, double>, std::size_t> && !ReadBy<ListOf<ChannelId, double>, int>);

TEST_CASE("ids: a list is walked by its own indices, in order, and read by them alone") {
  ListOf<ChannelId, double> list(std::vector<double>{1.5, 2.5});
  list.push_back(3.5);
  std::size_t next = 0;
  for (const ChannelId c : list.ids()) {
    CHECK(c == ChannelId{next});
    CHECK(list[c] == 1.5 + static_cast<double>(next));
    ++next;
  }
  CHECK(next == list.size());
  CHECK_THROWS_AS(static_cast<void>(list[ChannelId{3}]), std::out_of_range);
  CHECK(ChannelId{1} < ChannelId{2});
}

}  // namespace plant_ids_test

#include "drivers/measurement/sweep.hpp"

#include <gtest/gtest.h>

#include <cstdint>
#include <cstring>
#include <string>
#include <vector>

namespace infuse {
namespace {

/// Calls `visit(name, channel)` for each array of a sweep.
template <class Visit>
void for_each_field(Sweep& sweep, Visit visit) {
  visit("x", sweep.x);
  visit("y", sweep.y);
  visit("z", sweep.z);
  visit("range", sweep.range);
  visit("reflectivity", sweep.reflectivity);
  visit("ring", sweep.ring);
  visit("column", sweep.column);
  visit("time_offset_ns", sweep.time_offset_ns);
  visit("return_kind", sweep.return_kind);
}

/// Addresses of the arrays: while they stay the same, nothing was allocated.
std::vector<const void*> data_pointers(Sweep& sweep) {
  std::vector<const void*> memory;
  for_each_field(sweep, [&](const char*, auto& field) { memory.push_back(field.data()); });
  return memory;
}

TEST(Sweep, ResizingSetsTheLengthOfEveryArray) {
  Sweep sweep;
  for (const size_t returns : {0u, 1u, 1000u, 17u}) {
    sweep.resize(returns);
    EXPECT_EQ(sweep.size(), returns);
    for_each_field(
        sweep, [&](const char* name, auto& field) { EXPECT_EQ(field.size(), returns) << name; });
  }
}

TEST(Sweep, ArraysBeginOnACacheLine) {
  Sweep sweep;
  sweep.resize(5);
  for_each_field(sweep, [](const char* name, auto& field) {
    EXPECT_EQ(reinterpret_cast<uintptr_t>(field.data()) % 64, 0u) << name;
  });
}

TEST(Sweep, ResizingWithinItsCapacityDoesNotAllocate) {
  Sweep sweep;
  sweep.reserve(70'000);
  EXPECT_EQ(sweep.size(), 0u);
  const std::vector<const void*> memory = data_pointers(sweep);
  for (const size_t returns : {1u, 70'000u, 3u, 69'999u}) {
    sweep.resize(returns);
    EXPECT_EQ(data_pointers(sweep), memory);
    sweep.clear();
    EXPECT_EQ(data_pointers(sweep), memory);
    for_each_field(sweep, [&](const char* name, auto& field) {
      EXPECT_EQ(field.size(), 0u) << name;
      EXPECT_GE(field.capacity(), 70'000u) << name;
    });
  }
}

TEST(Sweep, GrowingWithinItsCapacityDoesNotInitialise) {
  Sweep sweep;
  sweep.resize(100);
  for (size_t i = 0; i < 100; ++i) sweep.x[i] = static_cast<float>(i);
  sweep.resize(10);
  sweep.resize(100);
  for (size_t i = 0; i < 10; ++i) EXPECT_EQ(sweep.x[i], static_cast<float>(i));
  // Entries 10 … 99 are not initialised; that they still hold the old values shows that no time was
  // spent clearing them.
  const std::vector<float> kept(sweep.x.begin() + 10, sweep.x.end());
  EXPECT_EQ(kept.front(), 10.0f);
  EXPECT_EQ(kept.back(), 99.0f);
}

TEST(Sweep, ClearResetsEveryMember) {
  Sweep sweep;
  sweep.stamp = Stamp::from_ns(1);
  sweep.span = Duration(2);
  sweep.rings = 32;
  sweep.columns = 4;
  sweep.has_times = false;
  sweep.clock = {.source = ClockState::Source::kTopOfHour,
                 .trusted = true,
                 .offset = Duration(5),
                 .skew_ppm = 6,
                 .jitter = Duration(7),
                 .jumps = 8,
                 .reason = "x"};
  sweep.lost_packets = 9;
  sweep.sequence = 10;
  sweep.gaps.push_back({0.1, 0.2});
  sweep.resize(11);
  sweep.clear();
  EXPECT_EQ(sweep.stamp, Stamp());
  EXPECT_EQ(sweep.span, Duration::zero());
  EXPECT_EQ(sweep.rings, 0);
  EXPECT_EQ(sweep.columns, 0u);
  EXPECT_TRUE(sweep.has_times);
  EXPECT_EQ(sweep.clock.source, ClockState::Source::kNone);
  EXPECT_FALSE(sweep.clock.trusted);
  EXPECT_EQ(sweep.clock.offset, Duration::zero());
  EXPECT_EQ(sweep.clock.skew_ppm, 0);
  EXPECT_EQ(sweep.clock.jitter, Duration::zero());
  EXPECT_EQ(sweep.clock.jumps, 0u);
  EXPECT_STREQ(sweep.clock.reason, "");
  EXPECT_EQ(sweep.lost_packets, 0u);
  EXPECT_EQ(sweep.sequence, 0u);
  EXPECT_TRUE(sweep.gaps.empty());
  EXPECT_EQ(sweep.size(), 0u);
}

TEST(ClockState, EverySourceHasItsOwnDescription) {
  std::vector<std::string> texts;
  for (const auto source :
       {ClockState::Source::kNone, ClockState::Source::kHost, ClockState::Source::kPowerUp,
        ClockState::Source::kTopOfHour, ClockState::Source::kUtc, ClockState::Source::kPtp}) {
    const std::string text = describe(source);
    EXPECT_FALSE(text.empty());
    for (const std::string& other : texts) EXPECT_NE(text, other);
    texts.push_back(text);
  }
}

}  // namespace
}  // namespace infuse

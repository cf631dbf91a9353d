#include "drivers/measurement/slot_ring.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <thread>
#include <vector>
#include "tests/drivers/measurement/slot_ring_object.hpp"

namespace infuse {
namespace {

TEST(SlotRing, CreatesItsObjectsOnceAndReusesThem) {
  int made = 0;
  Ring ring(3, [&] {
    ++made;
    return Object();
  });
  EXPECT_EQ(made, 4);
  std::vector<const uint64_t*> bodies;
  for (uint64_t number = 0; number < 20; ++number) {
    bodies.push_back(ring.slot().body.data());
    ring.slot().fill(number, at(0));
    ring.publish();
  }
  EXPECT_EQ(made, 4);
  std::sort(bodies.begin(), bodies.end());
  bodies.erase(std::unique(bodies.begin(), bodies.end()), bodies.end());
  EXPECT_EQ(bodies.size(), 4u);
  EXPECT_THROW(Ring(0, [] { return Object(); }), std::invalid_argument);
}

TEST(SlotRing, APinOutlivesItsReaderAndItsMove) {
  Ring ring(2, [] { return Object(); });
  Pin<Object> kept;
  EXPECT_FALSE(kept);
  {
    auto reader = ring.make_reader();
    ring.slot().fill(0, at(0));
    ring.publish();
    Pin<Object> pin = reader.next();
    kept = std::move(pin);
  }
  for (uint64_t number = 1; number < 10; ++number) {
    ring.slot().fill(number, at(0));
    EXPECT_TRUE(ring.publish());
    EXPECT_EQ(kept->number, 0u);
    EXPECT_TRUE(kept->is_intact());
  }
  auto reader = ring.make_reader();
  ring.slot().fill(10, at(0));
  EXPECT_TRUE(ring.publish());
  const Pin<Object> other = reader.next();
  EXPECT_EQ(other->number, 10u);
  EXPECT_FALSE(ring.publish());  // both are pinned
  kept.reset();
  EXPECT_FALSE(kept);
  EXPECT_TRUE(ring.publish());
  EXPECT_EQ(ring.dropped(), 1u);
}

TEST(SlotRing, UnpinningAndReadingMakeRoom) {
  Ring ring(1, [] { return Object(); });
  auto reader = ring.make_reader();
  ASSERT_TRUE(ring.wait_for_room());
  ring.publish();
  EXPECT_FALSE(ring.wait_for_room(1ms));  // unread
  Pin<Object> pin = reader.next();
  EXPECT_FALSE(ring.wait_for_room(1ms));  // pinned
  std::thread releaser([&] { pin.reset(); });
  EXPECT_TRUE(ring.wait_for_room());
  releaser.join();
  ring.close();
  EXPECT_FALSE(ring.wait_for_room());
  EXPECT_FALSE(reader.wait());
}

TEST(SlotRing, LiveReadersSeeIntactObjectsInOrderAndCountLostOnes) {
  constexpr uint64_t kObjects = 30'000;
  Ring ring(4, [] { return Object(); });
  std::atomic<uint64_t> wrong{0};
  std::array<uint64_t, 2> read{}, lost{};
  std::vector<std::thread> threads;
  for (size_t id = 0; id < read.size(); ++id) {
    threads.emplace_back([&, id, reader = ring.make_reader()]() mutable {
      std::array<Pin<Object>, 2> kept;
      while (reader.wait()) {
        while (Pin<Object> pin = reader.next()) {
          ++read[id];
          if (!pin->is_intact() || pin->number + 1 != read[id] + reader.lost()) ++wrong;
          Pin<Object>& old = kept[read[id] % 2];
          if (old && (!old->is_intact() || old->number != old.position())) ++wrong;
          old = std::move(pin);
        }
      }
      lost[id] = reader.lost();
    });
  }
  for (uint64_t number = 0; number < kObjects; ++number) {
    ring.slot().fill(number, at(static_cast<int64_t>(number)));
    ring.publish(number % 50 == 0 ? Ring::Keep::kUntilRead : Ring::Keep::kNo);
  }
  ring.close();
  for (std::thread& thread : threads) thread.join();
  EXPECT_EQ(wrong, 0u);
  for (size_t id = 0; id < read.size(); ++id) EXPECT_EQ(read[id] + lost[id], kObjects);
}

TEST(SlotRing, ASlowReaderGetsWhatIsKept) {
  Ring ring(12, [] { return Object(); });
  Ring::Reader slow = ring.make_reader();
  for (uint64_t number = 0; number < 1000; ++number) {
    ring.slot().fill(number, at(0));
    ring.publish(number % 150 == 0 ? Ring::Keep::kUntilRead : Ring::Keep::kNo);  // 0 … 900
  }
  std::vector<uint64_t> kept, others;
  while (const Pin<Object> pin = slow.next()) {
    (pin->number % 150 == 0 ? kept : others).push_back(pin->number);
  }
  EXPECT_EQ(kept, (std::vector<uint64_t>{0, 150, 300, 450, 600, 750, 900}));
  EXPECT_EQ(others, (std::vector<uint64_t>{995, 996, 997, 998, 999}));
  EXPECT_EQ(slow.lost(), 1000 - kept.size() - others.size());
}

TEST(SlotRing, AReaderThatStandsStillDoesNotKeepTheRing) {
  Ring ring(12, [] { return Object(); });
  const Ring::Reader still = ring.make_reader();
  Ring::Reader reader = ring.make_reader();
  for (uint64_t number = 0; number < 1000; ++number) {
    ring.slot().fill(number, at(0));
    EXPECT_TRUE(ring.publish(Ring::Keep::kUntilRead));
  }
  EXPECT_EQ(reader.next()->number, 988U);
}

TEST(SlotRing, ReplayThatWaitsForRoomLosesNothing) {
  constexpr uint64_t kObjects = 10'000;
  Ring ring(4, [] { return Object(); });
  std::atomic<uint64_t> wrong{0};
  std::vector<std::thread> threads;
  for (int id = 0; id < 2; ++id) {
    threads.emplace_back([&, reader = ring.make_reader()]() mutable {
      uint64_t expected = 0;
      Pin<Object> kept;
      while (reader.wait()) {
        while (Pin<Object> pin = reader.next()) {
          if (!pin->is_intact() || pin->number != expected++) ++wrong;
          kept = std::move(pin);
        }
      }
      if (expected != kObjects || reader.lost() != 0) ++wrong;
    });
  }
  for (uint64_t number = 0; number < kObjects; ++number) {
    ASSERT_TRUE(ring.wait_for_room());
    ring.slot().fill(number, at(static_cast<int64_t>(number)));
    ASSERT_TRUE(ring.publish());
  }
  ring.close();
  for (std::thread& thread : threads) thread.join();
  EXPECT_EQ(wrong, 0u);
}

}  // namespace
}  // namespace infuse

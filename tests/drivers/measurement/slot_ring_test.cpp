#include "drivers/measurement/slot_ring.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <deque>
#include <random>
#include <thread>
#include <vector>

namespace infuse {
namespace {

using namespace std::chrono_literals;

Stamp at(int64_t ns) { return Stamp::from_ns(ns); }

/// A large object whose every entry is its number.
struct Object {
  Stamp stamp;
  uint64_t number = 0;
  std::vector<uint64_t> body = std::vector<uint64_t>(200);

  void fill(uint64_t its_number, Stamp its_stamp) {
    stamp = its_stamp;
    number = its_number;
    std::fill(body.begin(), body.end(), its_number);
  }
  bool is_intact() const {
    return std::all_of(body.begin(), body.end(), [&](uint64_t entry) { return entry == number; });
  }
};

using Ring = SlotRing<Object>;

/// Reference implementation of the ring.
class Model {
 public:
  struct Entry {
    uint64_t position;
    Stamp stamp;
    int pins = 0;
  };
  struct Reader {
    uint64_t cursor = 0;
    uint64_t lost = 0;
  };

  explicit Model(size_t capacity) : unused_(capacity) {}

  bool publish(Stamp stamp, bool keep, const std::vector<Reader>& readers) {
    const uint64_t slowest = slowest_of(readers);
    const bool has_slot = reserved_ || claim_slot(UINT64_MAX, slowest) || claim_slot(UINT64_MAX);
    reserved_ = false;
    if (has_slot) entries_.push_back({published_, stamp});
    if (has_slot && keep) kept_.push_back(published_);
    if (kept_.size() > Ring::kMaxKept) kept_.pop_front();
    ++published_;
    return has_slot;
  }
  bool has_room(const std::vector<Reader>& readers) {
    reserved_ = reserved_ || claim_slot(slowest_of(readers));
    return reserved_;
  }
  Entry* next(Reader& reader) {
    for (Entry& entry : entries_) {
      if (entry.position < reader.cursor) continue;
      reader.lost += entry.position - reader.cursor;
      reader.cursor = entry.position + 1;
      return &entry;
    }
    reader.lost += published_ - reader.cursor;
    reader.cursor = published_;
    return nullptr;
  }
  Entry& entry(uint64_t position) {
    return *std::find_if(entries_.begin(), entries_.end(),
                         [&](const Entry& entry) { return entry.position == position; });
  }

  std::vector<Entry> entries_;
  uint64_t published_ = 0;

 private:
  static uint64_t slowest_of(const std::vector<Reader>& readers) {
    uint64_t slowest = UINT64_MAX;
    for (const Reader& reader : readers) slowest = std::min(slowest, reader.cursor);
    return slowest;
  }
  /// `kept_from`: kept entries from this position on are not claimed.
  bool claim_slot(uint64_t before, uint64_t kept_from = UINT64_MAX) {
    if (unused_ > 0) return unused_-- > 0;
    const auto kept = [&](const Entry& entry) {
      return entry.position >= kept_from &&
             std::find(kept_.begin(), kept_.end(), entry.position) != kept_.end();
    };
    const auto oldest = std::find_if(entries_.begin(), entries_.end(), [&](const Entry& entry) {
      return entry.pins == 0 && !kept(entry);
    });
    if (oldest == entries_.end() || oldest->position >= before) return false;
    entries_.erase(oldest);
    return true;
  }
  size_t unused_;
  bool reserved_ = false;
  std::deque<uint64_t> kept_;
};

/// Performs random operations on the ring and on the model; all observable results must be equal.
void compare_with_model(size_t capacity, uint32_t seed, bool replay) {
  std::mt19937 random(seed);
  const auto random_below = [&](size_t n) { return static_cast<size_t>(random() % n); };
  Ring ring(capacity, [] { return Object(); });
  ASSERT_EQ(ring.capacity(), capacity);
  Model model(capacity);
  std::vector<Ring::Reader> readers;
  std::vector<Model::Reader> model_readers;
  std::vector<Pin<Object>> pins;
  uint64_t dropped = 0;
  int64_t time = 0;

  const auto check = [&](const Pin<Object>& pin, const Model::Entry* expected) {
    ASSERT_EQ(static_cast<bool>(pin), expected != nullptr);
    if (!pin) return;
    ASSERT_EQ(pin.position(), expected->position);
    ASSERT_EQ(pin->number, expected->position);
    ASSERT_EQ(pin->stamp, expected->stamp);
    ASSERT_TRUE(pin->is_intact());
  };
  const auto keep_sometimes = [&](Pin<Object> pin, Model::Entry* entry) {
    check(pin, entry);
    if (!pin || pins.size() > capacity || random_below(3) > 0) return;
    ++entry->pins;
    pins.push_back(std::move(pin));
  };

  for (int step = 0; step < 20'000; ++step) {
    switch (random_below(9)) {
      case 0:
      case 1:
      case 2: {
        if (replay) {
          const bool room = ring.has_room();
          ASSERT_EQ(room, model.has_room(model_readers));
          if (!room) break;
        }
        time += static_cast<int64_t>(random_below(10));
        const Stamp stamp =
            at(seed % 2 == 0 ? time : time - static_cast<int64_t>(random_below(30)));
        ring.slot().fill(model.published_, stamp);
        const bool keep = random_below(4) == 0;
        const bool published = ring.publish(keep ? Ring::Keep::kUntilRead : Ring::Keep::kNo);
        ASSERT_EQ(published, model.publish(stamp, keep, model_readers));
        dropped += published ? 0 : 1;
        ASSERT_EQ(ring.dropped(), dropped);
        break;
      }
      case 3: {
        if (readers.size() < 4) {
          readers.push_back(ring.make_reader());
          model_readers.push_back({.cursor = model.published_, .lost = 0});
        } else if (random_below(20) == 0) {
          const auto which = static_cast<ptrdiff_t>(random_below(readers.size()));
          readers.erase(readers.begin() + which);
          model_readers.erase(model_readers.begin() + which);
        }
        break;
      }
      case 4:
      case 5:
      case 6: {
        if (readers.empty()) break;
        const size_t which = random_below(readers.size());
        for (size_t n = random_below(capacity + 2) + 1; n > 0; --n) {
          keep_sometimes(readers[which].next(), model.next(model_readers[which]));
          ASSERT_EQ(readers[which].lost(), model_readers[which].lost);
          ASSERT_EQ(readers[which].backlog(), model.published_ - model_readers[which].cursor);
          if (replay) {
            ASSERT_EQ(readers[which].lost(), 0u);
          }
        }
        break;
      }
      default: {
        if (pins.empty()) break;
        const size_t which = random_below(pins.size());
        Model::Entry& entry = model.entry(pins[which].position());
        check(pins[which], &entry);
        --entry.pins;
        pins.erase(pins.begin() + static_cast<ptrdiff_t>(which));
        break;
      }
    }
  }
  EXPECT_GT(model.published_, 100u);
  EXPECT_EQ(replay, dropped == 0);
}

TEST(SlotRing, MatchesALockedDeque) {
  for (const size_t capacity : {1u, 2u, 3u, 8u}) {
    for (uint32_t seed = 0; seed < 4; ++seed) {
      ASSERT_NO_FATAL_FAILURE(compare_with_model(capacity, seed, false));
    }
  }
}

TEST(SlotRing, MatchesALockedDequeInAReplay) {
  for (const size_t capacity : {1u, 2u, 3u, 8u}) {
    for (uint32_t seed = 0; seed < 4; ++seed) {
      ASSERT_NO_FATAL_FAILURE(compare_with_model(capacity, seed, true));
    }
  }
}

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

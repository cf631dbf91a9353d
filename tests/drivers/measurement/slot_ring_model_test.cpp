#include "drivers/measurement/slot_ring.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <deque>
#include <random>
#include <vector>
#include "tests/drivers/measurement/slot_ring_object.hpp"

namespace infuse {
namespace {

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

}  // namespace
}  // namespace infuse

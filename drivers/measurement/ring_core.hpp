#pragma once

#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <utility>

#include "drivers/measurement/event_count.hpp"

namespace infuse {

/// What `RecordRing` and `SlotRing` share: how many entries have been published, where each reader
/// stands and what it has lost, waiting, and closing. Entries are counted from 0; that number is an
/// entry's position. All operations are sequentially consistent, as `Signal` asks.
class RingCore {
 public:
  static constexpr size_t kMaxReaders = 16;
  static constexpr uint64_t kNoReader = UINT64_MAX;

  /// Announces entries through `arrivals`, which may be shared between rings and outlives them, or
  /// through a signal of its own where that is null.
  explicit RingCore(EventCount* arrivals)
      : arrivals_(arrivals == nullptr ? &own_arrivals_ : arrivals) {
    for (ReaderEntry& reader : readers_) reader.cursor.store(kNoReader);
  }

  /// Entries published so far, lost and dropped ones included.
  uint64_t published() const { return published_.load(); }

  /// The producer's: makes `count` entries known in all and wakes readers.
  void publish(uint64_t count) {
    published_.store(count);
    arrivals_->notify();
  }

  /// Registers a reader that stands behind the last published entry, and returns its number.
  /// Throws std::length_error where there are already kMaxReaders.
  size_t add_reader();
  void remove_reader(size_t reader);

  uint64_t cursor(size_t reader) const { return readers_[reader].cursor.load(); }
  uint64_t lost(size_t reader) const { return readers_[reader].lost.load(); }

  /// The reader's: it has passed everything before `cursor`, and `lost` of that unseen.
  void advance(size_t reader, uint64_t cursor, uint64_t lost) {
    if (lost > 0) readers_[reader].lost.fetch_add(lost);
    readers_[reader].cursor.store(cursor);
    room_.notify();
  }

  /// The reader's: sleeps until there is something to read. False where the time is over, or the
  /// ring is closed and everything has been read.
  bool wait_for_entry(size_t reader, Duration timeout);

  /// The smallest cursor of all readers; kNoReader where there is no reader.
  uint64_t slowest_cursor() const;

  /// Where the producer sleeps until readers have made room.
  EventCount& room() { return room_; }

  void close();
  bool closed() const { return closed_.load(); }

 private:
  struct alignas(64) ReaderEntry {
    std::atomic<uint64_t> cursor{0};
    std::atomic<uint64_t> lost{0};
  };

  alignas(64) std::atomic<uint64_t> published_{0};
  std::atomic<bool> closed_{false};
  EventCount own_arrivals_;
  EventCount* arrivals_;
  alignas(64) EventCount room_;
  std::array<ReaderEntry, kMaxReaders> readers_;
};

/// A registered reader's place in a ring, without the reading: the part that all rings share. For
/// one thread; movable. The ring must outlive it.
class RingReader {
 public:
  /// Sleeps until there is an entry that was not read (or lost). False where the time is over, or
  /// the ring is closed and everything was read.
  bool wait(Duration timeout = EventCount::kNoTimeout) {
    return core_->wait_for_entry(id_, timeout);
  }

  /// Entries that were gone (overwritten, dropped) before this reader came to them. Grows as it
  /// reads.
  uint64_t lost() const { return core_->lost(id_); }

  /// Entries published that this reader has not passed yet.
  uint64_t backlog() const { return core_->published() - core_->cursor(id_); }

 protected:
  explicit RingReader(RingCore& core) : core_(&core), id_(core.add_reader()) {}
  RingReader(RingReader&& other) noexcept
      : core_(std::exchange(other.core_, nullptr)), id_(other.id_) {}
  RingReader& operator=(RingReader&& other) noexcept {
    std::swap(core_, other.core_);
    std::swap(id_, other.id_);
    return *this;
  }
  ~RingReader() {
    if (core_ != nullptr) core_->remove_reader(id_);
  }

  uint64_t cursor() const { return core_->cursor(id_); }
  void advance(uint64_t cursor, uint64_t lost) { core_->advance(id_, cursor, lost); }

 private:
  RingCore* core_;
  size_t id_;
};

/// What a look-up by interval found.
struct IntervalResult {
  size_t count = 0;       ///< entries inside the interval
  bool complete = false;  ///< false where entries of the interval may have been overwritten before
};

}  // namespace infuse

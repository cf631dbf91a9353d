#pragma once

#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <utility>

#include "drivers/measurement/event_count.hpp"

namespace infuse {

/// State of a ring apart from its entries: number of published entries, position and losses of each
/// reader, waiting, and closing. Entries are counted from 0; that number is an entry's position.
/// All operations are sequentially consistent, as `EventCount` requires.
class RingCore {
 public:
  static constexpr size_t kMaxReaders = 16;
  static constexpr uint64_t kNoReader = UINT64_MAX;

  /// Announces entries through `arrivals`, which several rings may share and which must outlive
  /// them, or through an EventCount of its own if that is null.
  explicit RingCore(EventCount* arrivals)
      : arrivals_(arrivals == nullptr ? &own_arrivals_ : arrivals) {
    for (ReaderEntry& reader : readers_) reader.cursor.store(kNoReader);
  }

  /// Number of entries published so far, lost and dropped ones included.
  uint64_t published() const { return published_.load(); }

  /// For the producer: sets the number of published entries to `count` and wakes readers.
  void publish(uint64_t count) {
    published_.store(count);
    arrivals_->notify();
  }

  /// Registers a reader that begins with the next entry, and returns its number. Throws
  /// std::length_error if there are already kMaxReaders.
  size_t add_reader();
  void remove_reader(size_t reader);

  uint64_t cursor(size_t reader) const { return readers_[reader].cursor.load(); }
  uint64_t lost(size_t reader) const { return readers_[reader].lost.load(); }

  /// For the reader: it has passed all entries before `cursor` and missed `lost` of them.
  void advance(size_t reader, uint64_t cursor, uint64_t lost) {
    if (lost > 0) readers_[reader].lost.fetch_add(lost);
    readers_[reader].cursor.store(cursor);
    room_.notify();
  }

  /// For the reader: sleeps until there is an entry to read. False if the timeout expired, or if
  /// the ring is closed and everything has been read.
  bool wait_for_entry(size_t reader, Duration timeout);

  /// The smallest cursor of all readers; kNoReader if there is no reader.
  uint64_t slowest_cursor() const;

  /// Event on which the producer waits until readers have made room.
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

/// Position of a registered reader in a ring. For one thread; movable. The ring must outlive it.
class RingReader {
 public:
  /// Sleeps until there is an unread (or lost) entry. False if the timeout expired, or if the ring
  /// is closed and everything has been read.
  bool wait(Duration timeout = EventCount::kNoTimeout) {
    return core_->wait_for_entry(id_, timeout);
  }

  /// Number of entries that were overwritten or dropped before this reader reached them. Updated by
  /// reading.
  uint64_t lost() const { return core_->lost(id_); }

  /// Number of published entries that this reader has not passed yet.
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

}  // namespace infuse

#pragma once

#include <array>
#include <atomic>
#include <bit>
#include <concepts>
#include <cstring>
#include <memory>
#include <optional>
#include <span>
#include <stdexcept>
#include <type_traits>
#include <utility>

#include "drivers/measurement/ring_core.hpp"
#include "drivers/measurement/stamp.hpp"

namespace infuse {

/// A small record that can be copied word by word and knows its time.
template <class T>
concept StampedRecord = std::is_trivially_copyable_v<T> && std::default_initializable<T> &&
    requires(const T& record) {
  { record.stamp } -> std::convertible_to<Stamp>;
};

/// The last records of a stream, for one producer and any number of threads that look.
///
/// The producer never waits, locks or allocates: it overwrites the oldest. `Reader` takes records
/// in order and counts exactly what was overwritten before it came. Look-ups by time need no
/// registration.
///
/// A seqlock whose payload is atomic words. The producer first stores in `begun_` that it begins
/// record n, then stores the words (release), then `published`. A reader of record i copies the
/// words (acquire), then looks at `begun_`: had any word come from record i + capacity or later,
/// that acquire would have made `begun_` > i + capacity visible, and the copy is thrown away. No
/// fence is needed and no access is a data race.
template <StampedRecord T>
class RecordRing {
 public:
  class Reader;

  /// `capacity` is rounded up to a power of two. `arrivals`: see RingCore.
  explicit RecordRing(size_t capacity, EventCount* arrivals = nullptr);

  /// Records held at most.
  size_t capacity() const { return capacity_; }

  // --- the producer's ---

  /// Appends a record, over the oldest where the ring is full. Wait-free.
  void push(const T& record);

  /// Whether the next push overwrites nothing that a registered reader has yet to read.
  bool has_room() const;

  /// For a replay: sleeps until `has_room`. False where the time is over or the ring is closed.
  bool wait_for_room(Duration timeout = EventCount::kNoTimeout);

  // --- anyone's ---

  /// Says that nothing more comes (or that nobody will listen): all who wait wake up. What is held
  /// can still be read.
  void close() { core_.close(); }
  bool closed() const { return core_.closed(); }

  /// Records pushed so far.
  uint64_t published() const { return core_.published(); }

  /// Registers a reader (at most RingCore::kMaxReaders at a time) that begins with the next push.
  Reader make_reader() { return Reader(*this); }

  /// The last record pushed; none before the first.
  std::optional<T> latest() const;

  /// The record held whose stamp is nearest; of two equally near the one pushed later. Linear in
  /// the capacity; stamps need not be in order.
  std::optional<T> nearest(Stamp stamp) const;

  /// Calls `visit(const T&)` for all records held with from ≤ stamp ≤ to, in order of pushing.
  /// Linear in the capacity. `complete` supposes that stamps do not go back.
  template <std::invocable<const T&> Visit>
  IntervalResult visit_interval(Stamp from, Stamp to, Visit visit) const;

  /// Writes the first out.size() of them to `out`; `count` is how many there are.
  IntervalResult copy_interval(Stamp from, Stamp to, std::span<T> out) const;

 private:
  static constexpr size_t kWords = (sizeof(T) + sizeof(uint64_t) - 1) / sizeof(uint64_t);
  using Words = std::array<std::atomic<uint64_t>, kWords>;

  /// Copies the record at a published position. False where it has been overwritten.
  bool read(uint64_t position, T& record) const;
  /// The oldest position that is not overwritten yet.
  uint64_t oldest() const;

  size_t capacity_;
  std::unique_ptr<Words[]> slots_;
  alignas(64) std::atomic<uint64_t> begun_{0};
  RingCore core_;
};

/// Takes the records of a ring in order; for one thread. The ring must outlive it.
template <StampedRecord T>
class RecordRing<T>::Reader : public RingReader {
 public:
  explicit Reader(RecordRing& ring) : RingReader(ring.core_), ring_(&ring) {}

  /// The oldest record that was not read and is still held; none where everything was read.
  std::optional<T> next();

 private:
  RecordRing* ring_;
};

// --- implementation ---

template <StampedRecord T>
RecordRing<T>::RecordRing(size_t capacity, EventCount* arrivals)
    : capacity_(std::bit_ceil(capacity)), slots_(new Words[capacity_]), core_(arrivals) {
  if (capacity == 0) throw std::invalid_argument("a ring needs room for at least one record");
}

template <StampedRecord T>
void RecordRing<T>::push(const T& record) {
  std::array<uint64_t, kWords> words{};
  std::memcpy(words.data(), &record, sizeof(T));
  const uint64_t position = begun_.load(std::memory_order_relaxed);
  begun_.store(position + 1, std::memory_order_relaxed);
  Words& slot = slots_[position & (capacity_ - 1)];
  for (size_t i = 0; i < kWords; ++i) slot[i].store(words[i], std::memory_order_release);
  core_.publish(position + 1);
}

template <StampedRecord T>
bool RecordRing<T>::has_room() const {
  const uint64_t slowest = core_.slowest_cursor();
  return slowest == RingCore::kNoReader || core_.published() - slowest < capacity_;
}

template <StampedRecord T>
bool RecordRing<T>::wait_for_room(Duration timeout) {
  core_.room().wait([&] { return closed() || has_room(); }, timeout);
  return !closed() && has_room();
}

template <StampedRecord T>
bool RecordRing<T>::read(uint64_t position, T& record) const {
  std::array<uint64_t, kWords> words;
  const Words& slot = slots_[position & (capacity_ - 1)];
  for (size_t i = 0; i < kWords; ++i) words[i] = slot[i].load(std::memory_order_acquire);
  if (begun_.load(std::memory_order_relaxed) > position + capacity_) return false;
  std::memcpy(static_cast<void*>(&record), words.data(), sizeof(T));
  return true;
}

template <StampedRecord T>
uint64_t RecordRing<T>::oldest() const {
  const uint64_t begun = begun_.load(std::memory_order_relaxed);
  return begun > capacity_ ? begun - capacity_ : 0;
}

template <StampedRecord T>
std::optional<T> RecordRing<T>::latest() const {
  T record;
  while (true) {
    const uint64_t end = published();
    if (end == 0) return std::nullopt;
    if (read(end - 1, record)) return record;
  }
}

template <StampedRecord T>
std::optional<T> RecordRing<T>::nearest(Stamp stamp) const {
  std::optional<T> best;
  Duration best_distance = Duration::max();
  T record;
  while (true) {
    const uint64_t end = published();
    // From the newest back: the producer overwrites from the other end.
    for (uint64_t position = end; position-- > 0 && read(position, record);) {
      const Duration distance = distance_between(record.stamp, stamp);
      if (best && distance >= best_distance) continue;
      best = record;
      best_distance = distance;
    }
    if (best || end == 0) return best;
  }
}

template <StampedRecord T>
template <std::invocable<const T&> Visit>
IntervalResult RecordRing<T>::visit_interval(Stamp from, Stamp to, Visit visit) const {
  const uint64_t end = published();
  uint64_t position = oldest();
  IntervalResult result{.count = 0, .complete = position == 0};
  T record;
  while (position < end) {
    if (!read(position, record)) {
      position = oldest();
      result.complete = false;
      continue;
    }
    ++position;
    if (record.stamp < from) result.complete = true;
    if (record.stamp < from || record.stamp > to) continue;
    ++result.count;
    visit(record);
  }
  return result;
}

template <StampedRecord T>
IntervalResult RecordRing<T>::copy_interval(Stamp from, Stamp to, std::span<T> out) const {
  size_t written = 0;
  return visit_interval(from, to, [&](const T& record) {
    if (written < out.size()) out[written++] = record;
  });
}

template <StampedRecord T>
std::optional<T> RecordRing<T>::Reader::next() {
  uint64_t position = cursor();
  uint64_t lost = 0;
  T record;
  while (position < ring_->published()) {
    if (ring_->read(position, record)) {
      advance(position + 1, lost);
      return record;
    }
    const uint64_t oldest = ring_->oldest();
    lost += oldest - position;
    position = oldest;
  }
  if (lost > 0) advance(position, lost);
  return std::nullopt;
}

}  // namespace infuse

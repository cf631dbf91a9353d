#pragma once

#include <algorithm>
#include <array>
#include <atomic>
#include <concepts>
#include <optional>
#include <span>
#include <stdexcept>
#include <utility>
#include <vector>

#include "drivers/measurement/ring_core.hpp"
#include "drivers/measurement/slot_states.hpp"

namespace infuse {

/// Holds one entry of a `SlotRing` so that it is not overwritten; empty if there was none. The ring
/// must outlive it. Hold few pins and for a short time: the producer cannot use pinned slots.
template <std::movable T>
class Pin {
 public:
  Pin() = default;
  Pin(Pin&& other) noexcept
      : object_(std::exchange(other.object_, nullptr)),
        states_(other.states_),
        slot_(other.slot_),
        position_(other.position_) {}
  Pin& operator=(Pin&& other) noexcept {
    std::swap(object_, other.object_);
    std::swap(states_, other.states_);
    std::swap(slot_, other.slot_);
    std::swap(position_, other.position_);
    return *this;
  }
  ~Pin() { reset(); }

  explicit operator bool() const { return object_ != nullptr; }
  const T& operator*() const { return *object_; }
  const T* operator->() const { return object_; }

  /// Position of the entry in the stream, counted from 0, dropped entries included.
  uint64_t position() const { return position_; }

  /// Releases the entry.
  void reset() {
    if (std::exchange(object_, nullptr) != nullptr) states_->unpin(slot_);
  }

 private:
  template <std::movable>
  friend class SlotRing;
  /// Takes over an entry that is already pinned.
  Pin(const T& object, SlotStates& states, const SlotStates::Entry& entry)
      : object_(&object), states_(&states), slot_(entry.slot), position_(entry.position) {}

  const T* object_ = nullptr;
  SlotStates* states_ = nullptr;
  size_t slot_ = 0;
  uint64_t position_ = 0;
};

/// Ring of the last large objects of a stream (sweeps, camera frames), for one producer and any
/// number of reading threads. The objects are created once, by a factory, and reused; nothing is
/// allocated or copied afterwards.
///
/// The producer fills `slot()` and calls `publish()`, which then claims the slot of the oldest
/// unpinned entry. The producer never waits: if every other slot is pinned, the current entry is
/// dropped. A dropped entry has a position, and is lost to every reader. An entry that must not be
/// lost to a slow reader is published with `Keep::kUntilRead`.
///
/// SlotStates documents why no entry is overwritten while a reader holds it.
template <std::movable T>
class SlotRing {
 public:
  class Reader;

  /// Whether an entry may be overwritten before every registered reader has passed it.
  enum class Keep : uint8_t {
    kNo,
    kUntilRead,  ///< not while it is one of the last `kMaxKept` of these
  };
  /// Maximum number of entries that are kept for slow readers. A capacity that is larger by more
  /// than the pins that readers hold always leaves room for the others.
  static constexpr size_t kMaxKept = 8;

  /// Holds up to `capacity` published entries, plus the slot that the producer fills. Each slot is
  /// created by `factory()`. `arrivals`: see RingCore.
  template <std::invocable Factory>
  SlotRing(size_t capacity, Factory factory, EventCount* arrivals = nullptr);

  /// Maximum number of published entries held.
  size_t capacity() const { return objects_.size() - 1; }

  // --- for the producer ---

  /// The object to fill. It still holds the content of an earlier entry.
  T& slot() { return objects_[slot_]; }

  /// Publishes the current slot and claims another one. False if the entry was dropped because all
  /// other slots are pinned. Wait-free.
  bool publish(Keep keep = Keep::kNo);

  /// True if the next `publish` neither overwrites an entry that a registered reader has yet to
  /// read nor drops one. Reserves that slot at once, so that the answer stays true.
  bool has_room();

  /// For a replay: sleeps until `has_room`. False if the timeout expired or the ring is closed. A
  /// reader that holds `capacity` pins and waits for more blocks the producer for ever.
  bool wait_for_room(Duration timeout = EventCount::kNoTimeout);

  // --- for any thread ---

  /// Ends the stream and wakes all waiting threads. The entries held can still be read.
  void close() { core_.close(); }
  bool closed() const { return core_.closed(); }

  /// Number of entries so far, dropped ones included.
  uint64_t published() const { return core_.published(); }

  /// Number of entries dropped because all slots were pinned.
  uint64_t dropped() const { return dropped_.load(std::memory_order_relaxed); }

  /// Registers a reader (at most RingCore::kMaxReaders at a time) that begins with the next entry.
  Reader make_reader() { return Reader(*this); }

 private:
  /// Pins the first entry at positions [from, end); empty if all are gone.
  Pin<T> pin_first(uint64_t from, uint64_t end);
  /// Returns a slot for the producer: an unused one, or that of the oldest unpinned entry before
  /// position `before`.
  std::optional<size_t> claim_slot(uint64_t before);
  /// The same before any position, that of a kept entry only if there is no other.
  std::optional<size_t> claim_unkept_slot();

  std::vector<T> objects_;
  RingCore core_;
  SlotStates states_;
  // Used by the producer only:
  size_t slot_ = 0;
  size_t unused_ = 1;                      ///< slots from here on have never been claimed
  std::optional<size_t> reserved_;         ///< the next slot, if `has_room` has reserved it
  std::array<uint64_t, kMaxKept> kept_{};  ///< positions of the last kept entries, a ring
  size_t kept_count_ = 0;                  ///< so far
  std::atomic<uint64_t> dropped_{0};
};

/// Reads the entries of a ring in order; for one thread. The ring must outlive it.
template <std::movable T>
class SlotRing<T>::Reader : public RingReader {
 public:
  explicit Reader(SlotRing& ring) : RingReader(ring.core_), ring_(&ring) {}

  /// The oldest unread entry that is still held; empty if everything was read.
  Pin<T> next();

 private:
  SlotRing* ring_;
};

// --- implementation ---

template <std::movable T>
template <std::invocable Factory>
SlotRing<T>::SlotRing(size_t capacity, Factory factory, EventCount* arrivals)
    : core_(arrivals), states_(capacity + 1, core_.room()) {
  if (capacity == 0) throw std::invalid_argument("the capacity of a ring must be at least 1");
  objects_.reserve(capacity + 1);
  while (objects_.size() <= capacity) objects_.push_back(factory());
}

template <std::movable T>
std::optional<size_t> SlotRing<T>::claim_slot(uint64_t before) {
  if (unused_ < objects_.size()) return unused_++;
  return states_.claim_oldest(before);
}

template <std::movable T>
std::optional<size_t> SlotRing<T>::claim_unkept_slot() {
  if (unused_ < objects_.size()) return unused_++;
  const uint64_t slowest = core_.slowest_cursor();
  std::array<uint64_t, kMaxKept> unread;
  size_t count = 0;
  for (size_t i = 0; i < std::min(kept_count_, kMaxKept); ++i) {
    if (kept_[i] >= slowest) unread[count++] = kept_[i];
  }
  const auto slot = states_.claim_oldest(RingCore::kNoReader, std::span(unread.data(), count));
  return slot ? slot : states_.claim_oldest(RingCore::kNoReader);
}

template <std::movable T>
bool SlotRing<T>::publish(Keep keep) {
  const std::optional<size_t> next =
      reserved_ ? std::exchange(reserved_, std::nullopt) : claim_unkept_slot();
  const uint64_t position = core_.published();
  if (next && keep == Keep::kUntilRead) kept_[kept_count_++ % kMaxKept] = position;
  if (next) {
    states_.publish(slot_, position);
    slot_ = *next;
  } else {
    dropped_.fetch_add(1, std::memory_order_relaxed);
  }
  core_.publish(position + 1);
  return next.has_value();
}

template <std::movable T>
bool SlotRing<T>::has_room() {
  if (!reserved_) reserved_ = claim_slot(core_.slowest_cursor());
  return reserved_.has_value();
}

template <std::movable T>
bool SlotRing<T>::wait_for_room(Duration timeout) {
  core_.room().wait([&] { return closed() || has_room(); }, timeout);
  return !closed() && has_room();
}

template <std::movable T>
Pin<T> SlotRing<T>::pin_first(uint64_t from, uint64_t end) {
  while (const std::optional<SlotStates::Entry> entry = states_.first(from, end)) {
    if (states_.pin(*entry)) return Pin<T>(objects_[entry->slot], states_, *entry);
  }
  return {};
}

template <std::movable T>
Pin<T> SlotRing<T>::Reader::next() {
  uint64_t position = cursor();
  uint64_t lost = 0;
  while (position < ring_->published()) {
    const uint64_t end = ring_->published();
    // An entry published before `end` that is not found now has been overwritten or dropped.
    Pin<T> pin = ring_->pin_first(position, end);
    const uint64_t found = pin ? pin.position() : end;
    lost += found - position;
    position = found;
    if (!pin) continue;
    advance(position + 1, lost);
    return pin;
  }
  if (lost > 0) advance(position, lost);
  return {};
}

}  // namespace infuse

#pragma once

#include <atomic>
#include <concepts>
#include <memory>
#include <optional>
#include <span>
#include <stdexcept>
#include <utility>
#include <vector>

#include "drivers/measurement/ring_core.hpp"
#include "drivers/measurement/slot_states.hpp"
#include "drivers/measurement/stamp.hpp"

namespace infuse {

/// An object that knows its time.
template <class T>
concept StampedObject = std::movable<T> && requires(const T& object) {
  { object.stamp } -> std::convertible_to<Stamp>;
};

/// Holds one entry of a `SlotRing` so that it is not overwritten; empty where there was none. The
/// ring must outlive it. Hold few and not for long: what is pinned is room that the producer lacks.
template <StampedObject T>
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

  /// Which entry of the stream this is, counted from 0 and including those that were dropped.
  uint64_t position() const { return position_; }

  /// Lets go.
  void reset() {
    if (std::exchange(object_, nullptr) != nullptr) states_->unpin(slot_);
  }

 private:
  template <StampedObject>
  friend class SlotRing;
  /// Of an entry that has been pinned.
  Pin(const T& object, SlotStates& states, const SlotStates::Entry& entry)
      : object_(&object), states_(&states), slot_(entry.slot), position_(entry.position) {}

  const T* object_ = nullptr;
  SlotStates* states_ = nullptr;
  size_t slot_ = 0;
  uint64_t position_ = 0;
};

/// The last big objects of a stream (sweeps, camera frames), for one producer and any number of
/// threads that look. The objects are made once, by a factory, and used again and again; nothing is
/// allocated or copied afterwards.
///
/// The producer fills `hand()` and calls `publish()`, which takes the oldest entry that nobody has
/// pinned as the next hand. It never waits: where every other slot is pinned, the entry in hand is
/// dropped instead. A dropped entry has a position, and is lost to every reader.
///
/// Why nothing is overwritten under a reader: see SlotStates.
template <StampedObject T>
class SlotRing {
 public:
  class Reader;

  /// Holds up to `capacity` published entries, and one slot in the producer's hand. Each slot is
  /// made by `factory()`. `arrivals`: see RingCore.
  template <std::invocable Factory>
  SlotRing(size_t capacity, Factory factory, EventCount* arrivals = nullptr);

  /// Published entries held at most.
  size_t capacity() const { return objects_.size() - 1; }

  // --- the producer's ---

  /// The object to fill. It holds whatever an earlier entry left there.
  T& slot() { return objects_[slot_]; }

  /// Publishes what is in hand, by its stamp, and takes another slot in hand. False where it was
  /// dropped because all other slots are pinned. Wait-free.
  bool publish();

  /// Whether the next `publish` overwrites nothing that a registered reader has yet to read, and
  /// drops nothing. Sets that slot aside at once, so that the answer stays true.
  bool has_room();

  /// For a replay: sleeps until `has_room`. False where the time is over or the ring is closed.
  /// Readers that hold `capacity` pins and wait for more would wait for ever.
  bool wait_for_room(Duration timeout = EventCount::kNoTimeout);

  // --- anyone's ---

  /// Says that nothing more comes (or that nobody will listen): all who wait wake up. What is held
  /// can still be read.
  void close() { core_.close(); }
  bool closed() const { return core_.closed(); }

  /// Entries so far, dropped ones included.
  uint64_t published() const { return core_.published(); }

  /// Entries dropped because all slots were pinned.
  uint64_t dropped() const { return dropped_.load(std::memory_order_relaxed); }

  /// Registers a reader (at most RingCore::kMaxReaders at a time) that begins with the next entry.
  Reader make_reader() { return Reader(*this); }

  /// The newest entry held; empty where there is none. While the producer changes hands and all
  /// else is pinned, it may for a moment be an older one (or none, where the capacity is 1).
  Pin<T> latest();

  /// The entry held whose stamp is nearest; of two equally near the one published later. Stamps
  /// need not be in order.
  Pin<T> nearest(Stamp stamp);

  /// Calls `visit(const T&)` for all entries held with from ≤ stamp ≤ to, in order of publishing,
  /// each pinned meanwhile. `complete` supposes that stamps do not go back.
  template <std::invocable<const T&> Visit>
  IntervalResult visit_interval(Stamp from, Stamp to, Visit visit);

  /// Pins the first out.size() of them into `out`; `count` is how many there are.
  IntervalResult pin_interval(Stamp from, Stamp to, std::span<Pin<T>> out);

 private:
  /// Pins the first entry of positions [from, end); empty where all are gone.
  Pin<T> pin_first(uint64_t from, uint64_t end);
  /// Pins what `choose()` names, and chooses again where the producer was faster.
  template <class Choose>
  Pin<T> pin_chosen(Choose choose);
  /// As `interval`, but hands over the pin.
  template <class Visit>
  IntervalResult visit_pins(Stamp from, Stamp to, Visit visit);
  /// A slot for the producer: a new one, or that of the oldest unpinned entry before `before`.
  std::optional<size_t> claim_slot(uint64_t before);

  std::vector<T> objects_;
  RingCore core_;
  SlotStates states_;
  // The producer's own:
  size_t slot_ = 0;
  size_t unused_ = 1;               ///< slots from here on have never been in hand
  std::optional<size_t> reserved_;  ///< the next hand, where `has_room` has taken it
  std::atomic<uint64_t> dropped_{0};
};

/// Takes the entries of a ring in order; for one thread. The ring must outlive it.
template <StampedObject T>
class SlotRing<T>::Reader : public RingReader {
 public:
  explicit Reader(SlotRing& ring) : RingReader(ring.core_), ring_(&ring) {}

  /// The oldest entry that was not read and is still held; empty where everything was read.
  Pin<T> next();

 private:
  SlotRing* ring_;
};

// --- implementation ---

template <StampedObject T>
template <std::invocable Factory>
SlotRing<T>::SlotRing(size_t capacity, Factory factory, EventCount* arrivals)
    : core_(arrivals), states_(capacity + 1, core_.room()) {
  if (capacity == 0) throw std::invalid_argument("a ring needs room for at least one entry");
  objects_.reserve(capacity + 1);
  while (objects_.size() <= capacity) objects_.push_back(factory());
}

template <StampedObject T>
std::optional<size_t> SlotRing<T>::claim_slot(uint64_t before) {
  if (unused_ < objects_.size()) return unused_++;
  return states_.claim_oldest(before);
}

template <StampedObject T>
bool SlotRing<T>::publish() {
  const std::optional<size_t> next =
      reserved_ ? std::exchange(reserved_, std::nullopt) : claim_slot(RingCore::kNoReader);
  const uint64_t position = core_.published();
  if (next) {
    states_.publish(slot_, position, slot().stamp);
    slot_ = *next;
  } else {
    dropped_.fetch_add(1, std::memory_order_relaxed);
  }
  core_.publish(position + 1);
  return next.has_value();
}

template <StampedObject T>
bool SlotRing<T>::has_room() {
  if (!reserved_) reserved_ = claim_slot(core_.slowest_cursor());
  return reserved_.has_value();
}

template <StampedObject T>
bool SlotRing<T>::wait_for_room(Duration timeout) {
  core_.room().wait([&] { return closed() || has_room(); }, timeout);
  return !closed() && has_room();
}

template <StampedObject T>
Pin<T> SlotRing<T>::pin_first(uint64_t from, uint64_t end) {
  while (const std::optional<SlotStates::Entry> entry = states_.first(from, end)) {
    if (states_.pin(*entry)) return Pin<T>(objects_[entry->slot], states_, *entry);
  }
  return {};
}

template <StampedObject T>
template <class Choose>
Pin<T> SlotRing<T>::pin_chosen(Choose choose) {
  while (true) {
    const uint64_t before = published();
    const std::optional<SlotStates::Entry> entry = choose();
    if (entry && states_.pin(*entry)) return Pin<T>(objects_[entry->slot], states_, *entry);
    if (!entry && published() == before) return {};
  }
}

template <StampedObject T>
Pin<T> SlotRing<T>::latest() {
  return pin_chosen([&] { return states_.last(); });
}

template <StampedObject T>
Pin<T> SlotRing<T>::nearest(Stamp stamp) {
  return pin_chosen([&] { return states_.nearest(stamp); });
}

template <StampedObject T>
template <class Visit>
IntervalResult SlotRing<T>::visit_pins(Stamp from, Stamp to, Visit visit) {
  const uint64_t end = published();
  IntervalResult result{.count = 0, .complete = true};
  uint64_t position = 0;
  while (true) {
    Pin<T> pin = pin_first(position, end);
    const uint64_t found = pin ? pin.position() : end;
    if (found > position) result.complete = false;
    if (!pin) return result;
    position = found + 1;
    const Stamp stamp = pin->stamp;
    if (stamp < from) result.complete = true;
    if (stamp < from || stamp > to) continue;
    ++result.count;
    visit(pin);
  }
}

template <StampedObject T>
template <std::invocable<const T&> Visit>
IntervalResult SlotRing<T>::visit_interval(Stamp from, Stamp to, Visit visit) {
  return visit_pins(from, to, [&](const Pin<T>& pin) { visit(*pin); });
}

template <StampedObject T>
IntervalResult SlotRing<T>::pin_interval(Stamp from, Stamp to, std::span<Pin<T>> out) {
  size_t written = 0;
  return visit_pins(from, to, [&](Pin<T>& pin) {
    if (written < out.size()) out[written++] = std::move(pin);
  });
}

template <StampedObject T>
Pin<T> SlotRing<T>::Reader::next() {
  uint64_t position = cursor();
  uint64_t lost = 0;
  while (position < ring_->published()) {
    const uint64_t end = ring_->published();
    // What was published before `end` and is not found now has been overwritten or dropped.
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

#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>

#include "drivers/measurement/event_count.hpp"
#include "drivers/measurement/stamp.hpp"

namespace infuse {

/// What each slot of a `SlotRing` holds and how many pin it.
///
/// A slot's state is one atomic word: the position of its entry and the number of pins, or 0 while
/// the producer owns it. Both sides change it by compare-and-swap of the whole word: a reader can
/// pin only the entry that it means, and the producer can claim only a slot without pins, so a
/// pinned slot is never the producer's. Positions do not come back, so a word never means two
/// things. All operations are sequentially consistent, as `Signal` asks.
class SlotStates {
 public:
  /// An entry as it was seen at some moment; `pin` says whether it is still there.
  struct Entry {
    size_t slot = 0;
    uint64_t position = 0;
    Stamp stamp;
  };

  /// `room` is told of every unpinning.
  SlotStates(size_t slots, EventCount& room);

  // --- the producer's ---

  /// Hands over a slot that the producer owns. Positions below 2^48.
  void publish(size_t slot, uint64_t position, Stamp stamp);

  /// Takes the slot with the oldest unpinned entry of those before position `before`. None where
  /// there is no such entry, or where readers pinned the candidate in as many tries as there are
  /// slots.
  std::optional<size_t> claim_oldest(uint64_t before);

  // --- anyone's ---

  /// The entry with the smallest position in [from, end). Where everything below `end` had been
  /// published before the call, none means that all of them are gone.
  std::optional<Entry> first(uint64_t from, uint64_t end) const;
  /// The entry with the largest position.
  std::optional<Entry> last() const;
  /// The entry nearest in time; of two equally near, the larger position.
  std::optional<Entry> nearest(Stamp stamp) const;

  /// Pins the entry. False where it has been overwritten. At most 65 535 pins on a slot.
  bool pin(const Entry& entry);
  void unpin(size_t slot);

 private:
  struct Slot {
    std::atomic<uint64_t> state{0};
    std::atomic<int64_t> stamp_ns{0};
  };

  std::optional<Entry> load_entry(size_t slot) const;
  /// Of the entries that `allowed(entry)`, the one that is `better(entry, any other)`.
  template <class Allowed, class Better>
  std::optional<Entry> best(Allowed allowed, Better better) const;

  size_t count_;
  std::unique_ptr<Slot[]> slots_;
  EventCount& room_;
};

}  // namespace infuse

#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>

#include "drivers/measurement/event_count.hpp"

namespace infuse {

/// Entry and number of pins of each slot of a `SlotRing`.
///
/// A slot's state is one atomic word: the position of its entry and the number of pins, or 0 while
/// the producer owns it. Both sides change it by compare-and-swap of the whole word: a reader can
/// pin only the entry that it expects, and the producer can claim only a slot without pins, so the
/// producer never owns a pinned slot. Positions are never reused, so equal words mean the same
/// state. All operations are sequentially consistent, as `EventCount` requires.
class SlotStates {
 public:
  /// An entry as read at some moment; `pin` checks that it is still there.
  struct Entry {
    size_t slot = 0;
    uint64_t position = 0;
  };

  /// Notifies `room` of every unpinning.
  SlotStates(size_t slots, EventCount& room);

  // --- for the producer ---

  /// Publishes a slot that the producer owns. Positions below 2^48.
  void publish(size_t slot, uint64_t position);

  /// Claims the slot with the oldest unpinned entry before position `before` that is none of
  /// `kept`. Nothing if there is no such entry, or if readers pinned the candidate in as many
  /// attempts as there are slots.
  std::optional<size_t> claim_oldest(uint64_t before, std::span<const uint64_t> kept = {});

  // --- for any thread ---

  /// The entry with the smallest position in [from, end). If everything below `end` was published
  /// before the call, an empty result means that all of it is gone.
  std::optional<Entry> first(uint64_t from, uint64_t end) const;

  /// Pins the entry. False if it has been overwritten. At most 65 535 pins per slot.
  bool pin(const Entry& entry);
  void unpin(size_t slot);

 private:
  size_t count_;
  std::unique_ptr<std::atomic<uint64_t>[]> slots_;  ///< the states
  EventCount& room_;
};

}  // namespace infuse

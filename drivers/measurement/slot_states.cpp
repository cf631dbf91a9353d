#include "drivers/measurement/slot_states.hpp"

#include <algorithm>

#include "drivers/measurement/ring_core.hpp"

namespace infuse {
namespace {

constexpr int kPinBits = 16;
constexpr uint64_t kPinMask = (uint64_t{1} << kPinBits) - 1;

/// State of an entry that no reader pins.
constexpr uint64_t unpinned(uint64_t position) { return (position + 1) << kPinBits; }
constexpr bool is_entry(uint64_t state) { return state != 0; }
constexpr uint64_t position_of(uint64_t state) { return (state >> kPinBits) - 1; }

}  // namespace

SlotStates::SlotStates(size_t slots, EventCount& room)
    : count_(slots), slots_(new std::atomic<uint64_t>[slots]()), room_(room) {}

void SlotStates::publish(size_t slot, uint64_t position) { slots_[slot].store(unpinned(position)); }

std::optional<size_t> SlotStates::claim_oldest(uint64_t before, std::span<const uint64_t> kept) {
  for (size_t attempt = 0; attempt < count_; ++attempt) {
    std::optional<size_t> oldest;
    uint64_t oldest_state = UINT64_MAX;
    for (size_t slot = 0; slot < count_; ++slot) {
      const uint64_t state = slots_[slot].load();
      if (!is_entry(state) || (state & kPinMask) != 0 || position_of(state) >= before) continue;
      if (state >= oldest_state) continue;
      if (std::find(kept.begin(), kept.end(), position_of(state)) != kept.end()) continue;
      oldest = slot;
      oldest_state = state;
    }
    if (!oldest) return std::nullopt;
    if (slots_[*oldest].compare_exchange_strong(oldest_state, 0)) return oldest;
  }
  return std::nullopt;
}

std::optional<SlotStates::Entry> SlotStates::first(uint64_t from, uint64_t end) const {
  std::optional<Entry> first;
  for (size_t slot = 0; slot < count_; ++slot) {
    const uint64_t state = slots_[slot].load();
    if (!is_entry(state)) continue;
    const uint64_t position = position_of(state);
    if (position < from || position >= end) continue;
    if (!first || position < first->position) first = Entry{.slot = slot, .position = position};
  }
  return first;
}

bool SlotStates::pin(const Entry& entry) {
  std::atomic<uint64_t>& state = slots_[entry.slot];
  uint64_t seen = unpinned(entry.position);
  while (!state.compare_exchange_weak(seen, seen + 1)) {
    if (!is_entry(seen) || position_of(seen) != entry.position) return false;
  }
  return true;
}

void SlotStates::unpin(size_t slot) {
  slots_[slot].fetch_sub(1);
  room_.notify();
}

}  // namespace infuse

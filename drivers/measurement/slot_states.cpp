#include "drivers/measurement/slot_states.hpp"

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
    : count_(slots), slots_(new Slot[slots]), room_(room) {}

void SlotStates::publish(size_t slot, uint64_t position, Stamp stamp) {
  slots_[slot].stamp_ns.store(stamp.ns());
  slots_[slot].state.store(unpinned(position));
}

std::optional<size_t> SlotStates::claim_oldest(uint64_t before) {
  for (size_t attempt = 0; attempt < count_; ++attempt) {
    std::optional<size_t> oldest;
    uint64_t oldest_state = UINT64_MAX;
    for (size_t slot = 0; slot < count_; ++slot) {
      const uint64_t state = slots_[slot].state.load();
      if (!is_entry(state) || (state & kPinMask) != 0 || position_of(state) >= before) continue;
      if (state >= oldest_state) continue;
      oldest = slot;
      oldest_state = state;
    }
    if (!oldest) return std::nullopt;
    if (slots_[*oldest].state.compare_exchange_strong(oldest_state, 0)) return oldest;
  }
  return std::nullopt;
}

std::optional<SlotStates::Entry> SlotStates::load_entry(size_t slot) const {
  const uint64_t state = slots_[slot].state.load();
  if (!is_entry(state)) return std::nullopt;
  const Stamp stamp = Stamp::from_ns(slots_[slot].stamp_ns.load());
  // The stamp belongs to the entry only if the entry is still in the slot.
  const uint64_t again = slots_[slot].state.load();
  if (!is_entry(again) || position_of(again) != position_of(state)) return std::nullopt;
  return Entry{.slot = slot, .position = position_of(state), .stamp = stamp};
}

template <class Allowed, class Better>
std::optional<SlotStates::Entry> SlotStates::best(Allowed allowed, Better better) const {
  std::optional<Entry> best;
  for (size_t slot = 0; slot < count_; ++slot) {
    const std::optional<Entry> entry = load_entry(slot);
    if (entry && allowed(*entry) && (!best || better(*entry, *best))) best = entry;
  }
  return best;
}

std::optional<SlotStates::Entry> SlotStates::first(uint64_t from, uint64_t end) const {
  return best([&](const Entry& entry) { return entry.position >= from && entry.position < end; },
              [](const Entry& a, const Entry& b) { return a.position < b.position; });
}

std::optional<SlotStates::Entry> SlotStates::last() const {
  return best([](const Entry&) { return true; },
              [](const Entry& a, const Entry& b) { return a.position > b.position; });
}

std::optional<SlotStates::Entry> SlotStates::nearest(Stamp stamp) const {
  return best([](const Entry&) { return true; },
              [&](const Entry& a, const Entry& b) {
                const Duration distance_a = distance_between(a.stamp, stamp);
                const Duration distance_b = distance_between(b.stamp, stamp);
                return distance_a < distance_b ||
                       (distance_a == distance_b && a.position > b.position);
              });
}

bool SlotStates::pin(const Entry& entry) {
  std::atomic<uint64_t>& state = slots_[entry.slot].state;
  uint64_t seen = unpinned(entry.position);
  while (!state.compare_exchange_weak(seen, seen + 1)) {
    if (!is_entry(seen) || position_of(seen) != entry.position) return false;
  }
  return true;
}

void SlotStates::unpin(size_t slot) {
  slots_[slot].state.fetch_sub(1);
  room_.notify();
}

}  // namespace infuse

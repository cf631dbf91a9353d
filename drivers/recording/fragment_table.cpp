#include "drivers/recording/fragment_table.hpp"

#include <algorithm>

namespace infuse::recording {

FragmentTable::FragmentTable(size_t slots, Duration timeout) : slots_(slots), timeout_(timeout) {
  for (Slot& slot : slots_) slot.bytes = std::make_unique_for_overwrite<uint8_t[]>(kMaxBytes);
}

std::span<const uint8_t> FragmentTable::add(const IpFragment& fragment) {
  drop_expired(fragment.stamp);
  const size_t end = fragment.offset + fragment.bytes.size();
  const bool impossible = fragment.bytes.empty() || end > kMaxBytes || slots_.empty() ||
                          (fragment.more_fragments && fragment.bytes.size() % 8 != 0);
  if (impossible) {
    ++dropped_;
    return {};
  }
  Slot* found = find(fragment);
  Slot& slot = found != nullptr ? *found : allocate_slot(fragment);
  ++slot.fragments;
  slot.max_end = std::max(slot.max_end, end);
  if (!fragment.more_fragments) {
    if (slot.total_bytes != 0 && slot.total_bytes != end) {
      drop(slot);
      return {};
    }
    slot.total_bytes = end;
  }
  if (slot.total_bytes != 0 && slot.max_end > slot.total_bytes) {
    drop(slot);
    return {};
  }
  std::copy(fragment.bytes.begin(), fragment.bytes.end(), &slot.bytes[fragment.offset]);
  for (size_t unit = fragment.offset / 8; unit < (end + 7) / 8; ++unit) {
    if (!slot.present.test(unit)) {
      slot.present.set(unit);
      ++slot.units_present;
    }
  }
  if (slot.total_bytes == 0 || slot.units_present != (slot.total_bytes + 7) / 8) return {};
  slot.used = false;
  return {slot.bytes.get(), slot.total_bytes};
}

void FragmentTable::drop_all() {
  for (Slot& slot : slots_) {
    if (slot.used) drop(slot);
  }
}

FragmentTable::Slot* FragmentTable::find(const IpFragment& fragment) {
  for (Slot& slot : slots_) {
    if (slot.used && slot.identification == fragment.identification &&
        slot.source == fragment.source && slot.destination == fragment.destination) {
      return &slot;
    }
  }
  return nullptr;
}

FragmentTable::Slot& FragmentTable::allocate_slot(const IpFragment& fragment) {
  // A free slot, otherwise the oldest.
  Slot& slot = *std::min_element(slots_.begin(), slots_.end(), [](const Slot& a, const Slot& b) {
    return a.used != b.used ? !a.used : a.first_stamp < b.first_stamp;
  });
  if (slot.used) drop(slot);
  slot.used = true;
  slot.first_stamp = fragment.stamp;
  slot.source = fragment.source;
  slot.destination = fragment.destination;
  slot.identification = fragment.identification;
  slot.fragments = 0;
  slot.total_bytes = 0;
  slot.units_present = 0;
  slot.max_end = 0;
  slot.present.reset();
  return slot;
}

void FragmentTable::drop(Slot& slot) {
  dropped_ += slot.fragments;
  slot.used = false;
}

void FragmentTable::drop_expired(Stamp now) {
  for (Slot& slot : slots_) {
    // In both directions: after a clock step backward a slot must not stay in use forever.
    if (slot.used && (now - slot.first_stamp > timeout_ || slot.first_stamp - now > timeout_))
      drop(slot);
  }
}

}  // namespace infuse::recording

#pragma once

#include <array>
#include <bitset>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "drivers/measurement/stamp.hpp"

namespace infuse::recording {

/// One fragment of an IPv4 packet (RFC 791).
struct Ipv4Fragment {
  Stamp stamp;
  uint32_t source = 0;
  uint32_t destination = 0;
  uint16_t identification = 0;
  size_t offset = 0;            ///< bytes into the packet's payload, a multiple of 8
  bool more_fragments = false;  ///< others follow
  std::span<const uint8_t> bytes;
};

/// Puts IPv4 fragments together, in fixed memory: when all slots are taken the oldest packet goes,
/// and so does one that is not whole after `age`. Where fragments overlap, the later one counts.
class FragmentTable {
 public:
  FragmentTable(size_t slots, Duration age);

  /// Takes a fragment. Gives the payload of the packet that it completes, valid until the next
  /// call, otherwise nothing.
  std::span<const uint8_t> add(const Ipv4Fragment& fragment);

  /// Fragments that were given up: too old, pushed out, contradictory, beyond 65 535 bytes.
  uint64_t dropped() const { return dropped_; }

  /// Gives up what is not whole. Call at the end of the stream.
  void drop_all();

 private:
  static constexpr size_t kMaxBytes = 65535;
  static constexpr size_t kMaxUnits = 8192;  // of 8 bytes
  struct Slot {
    bool used = false;
    Stamp first_stamp;
    uint32_t source = 0, destination = 0;
    uint16_t identification = 0;
    uint64_t fragments = 0;
    size_t total_bytes = 0;  // bytes; 0 until the last fragment has come
    size_t units_present = 0;
    size_t max_end = 0;  // end of the furthest fragment, bytes
    std::bitset<kMaxUnits> present;
    std::unique_ptr<uint8_t[]> bytes;
  };
  Slot* find(const Ipv4Fragment& fragment);
  Slot& allocate_slot(const Ipv4Fragment& fragment);
  void drop(Slot& slot);
  void drop_expired(Stamp now);

  std::vector<Slot> slots_;
  Duration timeout_;
  uint64_t dropped_ = 0;
};

}  // namespace infuse::recording

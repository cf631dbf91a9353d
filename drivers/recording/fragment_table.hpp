#pragma once

#include <array>
#include <bitset>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "drivers/measurement/stamp.hpp"

namespace infuse::recording {

/// One fragment of an IP packet (RFC 791, RFC 8200).
struct IpFragment {
  Stamp stamp;
  uint32_t source = 0;
  uint32_t destination = 0;
  uint32_t identification = 0;
  size_t offset = 0;            ///< bytes into the packet's payload, a multiple of 8
  bool more_fragments = false;  ///< false for the last fragment of a packet
  std::span<const uint8_t> bytes;
};

/// Reassembles IP fragments in fixed memory. A packet is dropped if it is incomplete after
/// `timeout`, or if it is the oldest and all slots are in use. If fragments overlap, the later one
/// wins.
class FragmentTable {
 public:
  FragmentTable(size_t slots, Duration timeout);

  /// Adds a fragment. Returns the payload of the packet that it completes, valid until the next
  /// call; otherwise an empty span.
  std::span<const uint8_t> add(const IpFragment& fragment);

  /// Number of fragments dropped: timed out, evicted, contradictory, or beyond 65 535 bytes.
  uint64_t dropped() const { return dropped_; }

  /// Drops all incomplete packets. Call at the end of the stream.
  void drop_all();

 private:
  static constexpr size_t kMaxBytes = 65535;
  static constexpr size_t kMaxUnits = 8192;  // of 8 bytes
  struct Slot {
    bool used = false;
    Stamp first_stamp;
    uint32_t source = 0, destination = 0;
    uint32_t identification = 0;
    uint64_t fragments = 0;
    size_t total_bytes = 0;  // 0 until the last fragment has arrived
    size_t units_present = 0;
    size_t max_end = 0;  // largest end of a fragment, bytes
    std::bitset<kMaxUnits> present;
    std::unique_ptr<uint8_t[]> bytes;
  };
  Slot* find(const IpFragment& fragment);
  Slot& allocate_slot(const IpFragment& fragment);
  void drop(Slot& slot);
  void drop_expired(Stamp now);

  std::vector<Slot> slots_;
  Duration timeout_;
  uint64_t dropped_ = 0;
};

}  // namespace infuse::recording

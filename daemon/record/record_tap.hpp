#pragma once

#include <atomic>
#include <span>

#include "daemon/record/record_chunk.hpp"
#include "drivers/measurement/datagram.hpp"
#include "drivers/measurement/vehicle_samples.hpp"
#include "drivers/vehicle/can_frame.hpp"

namespace infuse::daemon {

/// Copies what the sensors say into the ring of chunks while somebody wants it. Of the io thread;
/// waits for nobody and allocates nothing.
class RecordTap {
 public:
  /// How long a chunk is filled at most.
  static constexpr Duration kLongest{250'000'000};

  /// `ring` outlives this.
  explicit RecordTap(RecordRing& ring) : ring_(ring) { begin_chunk(); }

  void take(const Datagram& datagram);
  void take(const vehicle::CanFrame& frame);
  void take(size_t camera, const camera::StreamedPicture& picture);
  void take(const GpsFix& fix);

  /// Hands over what has waited long enough at `now`.
  void look_after(Stamp now);

  /// Hands over what has been taken: no more comes.
  void finish() {
    if (!ring_.hand().bytes.empty()) hand_over();
  }

  /// From any thread: whether what is taken is kept.
  void want(bool wanted) { wanted_.store(wanted, std::memory_order_relaxed); }

 private:
  bool wanted() const { return wanted_.load(std::memory_order_relaxed); }
  void begin_chunk();
  void hand_over();
  void put(RecordKind kind, uint32_t source, Stamp stamp, std::span<const uint8_t> head,
           std::span<const uint8_t> body);
  void append(std::span<const uint8_t> bytes);

  RecordRing& ring_;
  std::atomic<bool> wanted_{false};
  uint64_t number_ = 0;   // of the chunk in hand
  uint64_t records_ = 0;  // begun so far
  Stamp last_;            // of them
  Stamp begun_;           // when the chunk in hand had its first byte, by look_after
};

}  // namespace infuse::daemon

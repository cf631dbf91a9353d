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
  static constexpr Duration kMaxChunkAge{250'000'000};

  /// `ring` outlives this.
  explicit RecordTap(RecordRing& ring) : ring_(ring) { begin_chunk(); }

  void add_datagram(const Datagram& datagram);
  void add_can_frame(const vehicle::CanFrame& frame);
  void add_image(size_t camera, const camera::StreamedImage& image);
  void add_gnss(const GnssFix& fix);

  /// Hands over what has waited long enough at `now`.
  void flush_if_due(Stamp now);

  /// Hands over what has been taken: no more comes.
  void finish() {
    if (!ring_.slot().bytes.empty()) push_chunk();
  }

  /// From any thread: whether what is taken is kept.
  void set_enabled(bool enabled) { enabled_.store(enabled, std::memory_order_relaxed); }

 private:
  bool enabled() const { return enabled_.load(std::memory_order_relaxed); }
  void begin_chunk();
  void push_chunk();
  void append_record(RecordKind kind, uint32_t source, Stamp stamp, std::span<const uint8_t> header,
                     std::span<const uint8_t> body);
  void append_bytes(std::span<const uint8_t> bytes);

  RecordRing& ring_;
  std::atomic<bool> enabled_{false};
  uint64_t chunk_number_ = 0;  // of the chunk in hand
  uint64_t record_count_ = 0;  // begun so far
  Stamp last_stamp_;           // of them
  Stamp chunk_begun_;          // when the chunk in hand had its first byte, by look_after
};

}  // namespace infuse::daemon

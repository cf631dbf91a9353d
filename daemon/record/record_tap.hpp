#pragma once

#include <atomic>
#include <span>

#include "daemon/record/record_chunk.hpp"
#include "drivers/measurement/datagram.hpp"
#include "drivers/measurement/vehicle_samples.hpp"
#include "drivers/vehicle/can_frame.hpp"

namespace infuse::daemon {

/// Copies sensor data into the ring of chunks while recording or the flight recorder is on. Used by
/// the io thread; never blocks and never allocates.
class RecordTap {
 public:
  /// Maximum age of a chunk before it is handed over.
  static constexpr Duration kMaxChunkAge{250'000'000};

  /// `ring` must outlive this object.
  explicit RecordTap(RecordRing& ring) : ring_(ring) { begin_chunk(); }

  void add_datagram(const Datagram& datagram);
  void add_can_frame(const vehicle::CanFrame& frame);
  void add_image(size_t camera, const camera::StreamedImage& image);
  void add_gnss(const GnssFix& fix);

  /// Hands over the current chunk if it is old enough at `now`.
  void flush_if_due(Stamp now);

  /// Hands over the current chunk. Nothing may be added afterwards.
  void finish() {
    if (!ring_.slot().bytes.empty()) push_chunk();
  }

  /// Turns the tap on or off. Thread-safe.
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
  uint64_t chunk_number_ = 0;  // of the current chunk
  uint64_t record_count_ = 0;  // records begun so far
  Stamp last_stamp_;           // of the last record
  Stamp chunk_begun_;  // when the current chunk received its first byte, as seen by `flush_if_due`
};

}  // namespace infuse::daemon

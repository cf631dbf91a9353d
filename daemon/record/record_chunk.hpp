#pragma once

#include <cstddef>
#include <cstdint>
#include <limits>
#include <vector>

#include "drivers/camera/raw_image.hpp"
#include "drivers/measurement/slot_ring.hpp"
#include "drivers/measurement/stamp.hpp"

namespace infuse::daemon {

/// What a record is of.
enum class RecordKind : uint32_t { kDatagram, kCanFrame, kImage, kGnssFix };

/// Before every record's body, `bytes` long.
struct RecordHeader {
  int64_t stamp_ns = 0;
  RecordKind kind = RecordKind::kDatagram;
  uint32_t source = 0;  ///< the camera, of a picture
  uint64_t bytes = 0;
};

/// Before a datagram's payload.
struct DatagramHeader {
  uint32_t sender = 0;
  uint16_t sender_port = 0;
  uint16_t destination_port = 0;
};

/// Before a picture's bytes.
struct ImageHeader {
  uint64_t sequence = 0;
  uint64_t row_bytes = 0;
  int32_t width = 0;
  int32_t height = 0;
  camera::RawFormat format = camera::RawFormat::kGrey;
};

/// A stretch of the stream of records. Records follow each other without a gap, and go on in the
/// next chunk where they do not fit.
struct RecordChunk {
  static constexpr size_t kMaxBytes = 256 << 10;
  static constexpr size_t kNoRecord = std::numeric_limits<size_t>::max();

  Stamp stamp;                      ///< of the last record that begins here or before
  uint64_t number = 0;              ///< of the chunk; one that is missing was overwritten
  uint64_t records_before = 0;      ///< that began in earlier chunks
  size_t first_record = kNoRecord;  ///< where the first record that begins here does
  std::vector<uint8_t> bytes;       ///< at most kMaxBytes
};

/// The last chunks of the stream, from the io thread to the recorder's.
using RecordRing = SlotRing<RecordChunk>;

}  // namespace infuse::daemon

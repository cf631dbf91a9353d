#pragma once

#include <cstddef>
#include <cstdint>
#include <limits>
#include <vector>

#include "drivers/camera/raw_image.hpp"
#include "drivers/measurement/slot_ring.hpp"
#include "drivers/measurement/stamp.hpp"

namespace infuse::daemon {

/// Kind of a record.
enum class RecordKind : uint32_t { kDatagram, kCanFrame, kImage, kGnssFix };

/// Header of every record, followed by a body of `bytes` bytes.
struct RecordHeader {
  int64_t stamp_ns = 0;
  RecordKind kind = RecordKind::kDatagram;
  uint32_t source = 0;  ///< camera index of an image, otherwise 0
  uint64_t bytes = 0;
};

/// Header of a datagram's payload.
struct DatagramHeader {
  uint32_t sender = 0;
  uint16_t sender_port = 0;
  uint16_t destination_port = 0;
};

/// Header of an image's bytes.
struct ImageHeader {
  uint64_t sequence = 0;
  uint64_t row_bytes = 0;
  int32_t width = 0;
  int32_t height = 0;
  camera::RawFormat format = camera::RawFormat::kGrey;
};

/// A section of the record stream. Records follow each other without a gap and continue in the next
/// chunk if they do not fit.
struct RecordChunk {
  static constexpr size_t kMaxBytes = 256 << 10;
  static constexpr size_t kNoRecord = std::numeric_limits<size_t>::max();

  Stamp stamp;                      ///< of the last record that begins in this chunk or before it
  uint64_t number = 0;              ///< of the chunk, consecutive; a missing number was overwritten
  uint64_t records_before = 0;      ///< number of records that began in earlier chunks
  size_t first_record = kNoRecord;  ///< offset of the first record that begins in this chunk
  std::vector<uint8_t> bytes;       ///< at most kMaxBytes
};

/// The last chunks of the record stream, passed from the io thread to the recorder's thread.
using RecordRing = SlotRing<RecordChunk>;

}  // namespace infuse::daemon

#pragma once

#include <cstring>
#include <span>
#include <vector>

#include "daemon/record/record_chunk.hpp"

namespace infuse::daemon {

/// One record. Its body is valid until the next chunk is parsed.
struct Record {
  RecordHeader header;
  std::span<const uint8_t> body;

  Stamp stamp() const { return Stamp::from_ns(header.stamp_ns); }
};

/// Reassembles records from the chunks that remain of their stream.
class RecordParser {
 public:
  /// Calls `on(const Record&)` for every record that ends in this chunk.
  template <class OnRecord>
  void parse(const RecordChunk& chunk, OnRecord on) {
    if (!append_chunk(chunk)) return;
    size_t at = 0;
    RecordHeader header;
    while (pending_.size() - at >= sizeof(header)) {
      std::memcpy(&header, pending_.data() + at, sizeof(header));
      if (pending_.size() - at - sizeof(header) < header.bytes) break;
      const std::span<const uint8_t> body(pending_.data() + at + sizeof(header), header.bytes);
      ++next_record_;
      on(Record{header, body});
      at += sizeof(header) + header.bytes;
    }
    pending_.erase(pending_.begin(), pending_.begin() + static_cast<std::ptrdiff_t>(at));
  }

  /// Number of records that were overwritten between the first and the last parsed record.
  uint64_t lost() const { return lost_; }

 private:
  bool append_chunk(const RecordChunk& chunk);

  std::vector<uint8_t> pending_;  // incomplete record
  bool in_sync_ = false;          // true if the previous chunk was parsed
  uint64_t next_chunk_ = 0, next_record_ = 0;
  uint64_t lost_ = 0;
};

}  // namespace infuse::daemon

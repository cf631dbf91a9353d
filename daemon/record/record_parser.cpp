#include "daemon/record/record_parser.hpp"

namespace infuse::daemon {

// After a gap, drop the incomplete record and resume with the first record that begins in this
// chunk.
bool RecordParser::append_chunk(const RecordChunk& chunk) {
  auto from = chunk.bytes.begin();
  if (!in_sync_ || chunk.number != next_chunk_) {
    pending_.clear();
    in_sync_ = chunk.first_record != RecordChunk::kNoRecord;
    if (!in_sync_) return false;
    if (next_record_ != 0) lost_ += chunk.records_before - next_record_;
    next_record_ = chunk.records_before;
    from += static_cast<std::ptrdiff_t>(chunk.first_record);
  }
  next_chunk_ = chunk.number + 1;
  pending_.insert(pending_.end(), from, chunk.bytes.end());
  return true;
}

}  // namespace infuse::daemon

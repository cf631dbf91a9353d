#include "daemon/record/record_parser.hpp"

namespace infuse::daemon {

// After a gap what was begun is given up, and the next record that begins in a chunk is the first.
bool RecordParser::join(const RecordChunk& chunk) {
  auto from = chunk.bytes.begin();
  if (!joined_ || chunk.number != next_chunk_) {
    waiting_.clear();
    joined_ = chunk.first != RecordChunk::kNone;
    if (!joined_) return false;
    if (next_record_ != 0) lost_ += chunk.records_before - next_record_;
    next_record_ = chunk.records_before;
    from += static_cast<std::ptrdiff_t>(chunk.first);
  }
  next_chunk_ = chunk.number + 1;
  waiting_.insert(waiting_.end(), from, chunk.bytes.end());
  return true;
}

}  // namespace infuse::daemon

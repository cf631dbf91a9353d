#include "drivers/measurement/ring_core.hpp"

#include <algorithm>
#include <stdexcept>

namespace infuse {

size_t RingCore::add_reader() {
  for (size_t reader = 0; reader < kMaxReaders; ++reader) {
    uint64_t no_reader = kNoReader;
    if (readers_[reader].cursor.compare_exchange_strong(no_reader, published())) {
      readers_[reader].lost.store(0);
      return reader;
    }
  }
  throw std::length_error("a ring has at most 16 readers");
}

void RingCore::remove_reader(size_t reader) {
  readers_[reader].cursor.store(kNoReader);
  room_.notify();
}

bool RingCore::wait_for_entry(size_t reader, Duration timeout) {
  const uint64_t here = cursor(reader);
  arrivals_->wait([&] { return closed() || published() > here; }, timeout);
  return published() > here;
}

uint64_t RingCore::slowest_cursor() const {
  uint64_t slowest = kNoReader;
  for (const ReaderEntry& reader : readers_) slowest = std::min(slowest, reader.cursor.load());
  return slowest;
}

void RingCore::close() {
  closed_.store(true);
  arrivals_->notify();
  room_.notify();
}

}  // namespace infuse

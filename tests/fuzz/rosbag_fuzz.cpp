#include <cstdlib>

#include "drivers/rosbag/bag_reader.hpp"

// Any bytes as a bag of ROS 1. Messages lie within a chunk or the file.
extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  using namespace infuse;
  auto reader = rosbag::BagReader::open({data, size}, "fuzz");
  if (!reader) {
    if (reader.error().what.empty()) std::abort();
    return 0;
  }
  rosbag::BagMessage message;
  uint64_t messages = 0;
  uint8_t sum = 0;  // reads every byte
  while (reader->next(message)) {
    ++messages;
    if (message.connection == nullptr || message.time < Stamp()) std::abort();
    for (const uint8_t byte : message.data) sum = static_cast<uint8_t>(sum + byte);
  }
  if (reader->counters().messages != messages) std::abort();
  std::vector<Error> notes(sum % 2);
  reader->append_notes(notes);
  return 0;
}

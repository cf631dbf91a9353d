#include <cstddef>
#include <cstdint>
#include <cstdlib>

#include "drivers/recording/pcap_reader.hpp"

// Any bytes as a capture: read to the end, payloads inside what a datagram can hold.
extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  infuse::recording::PcapOptions options;
  options.fragmented_datagrams = 2;
  auto reader = infuse::recording::PcapReader::from_bytes({data, size}, "fuzz", options);
  if (!reader) return 0;
  infuse::Datagram datagram;
  uint32_t sum = 0;
  while (reader->next(datagram)) {
    for (const uint8_t byte : datagram.payload) sum += byte;
    if (datagram.payload.size() > 65507 && sum != 0) std::abort();
  }
  const auto& counters = reader->counters();
  if (counters.fragments_dropped > counters.fragments) std::abort();
  return 0;
}

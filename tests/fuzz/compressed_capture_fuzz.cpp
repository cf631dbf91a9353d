#include <cstdlib>

#include "drivers/recording/capture_reader.hpp"
#include "tests/fuzz/fuzz_file.hpp"

// Any bytes as a capture on disk, which may be compressed: read to the end.
extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  using namespace infuse;
  static fuzz::FuzzFile file(".pcap.gz");
  auto reader = recording::CaptureReader::open(file.write({data, size}));
  if (!reader) {
    if (reader.error().what.empty()) std::abort();
    return 0;
  }
  Datagram datagram;
  for (size_t i = 0; i < 10'000 && reader->next(datagram); ++i) {
    if (datagram.payload.size() > 65527) std::abort();
  }
  return 0;
}

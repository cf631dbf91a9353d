#include <cstdlib>

#include "drivers/import/lcm_packets.hpp"
#include "drivers/lcm/lcm_log.hpp"

// Any bytes as a log of LCM: every byte is of an event or counted as skipped, and packets lie
// within their message.
extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  using namespace infuse;
  auto reader = lcm::LcmReader::open({data, size}, "fuzz");
  if (!reader) {
    if (reader.error().what.empty()) std::abort();
    return 0;
  }
  constexpr size_t kHeader = 28;
  lcm::LcmEvent event;
  std::vector<importers::EmbeddedPacket> packets;
  size_t read = 0;
  uint64_t events = 0;
  while (reader->next(event)) {
    ++events;
    read += kHeader + event.channel.size() + event.data.size();
    if (event.channel.empty() || event.time < Stamp()) std::abort();
    importers::find_packets(event.data, packets);
    for (const auto& packet : packets) {
      if (packet.payload.data() < event.data.data() ||
          packet.payload.data() + packet.payload.size() > event.data.data() + event.data.size())
        std::abort();
    }
  }
  if (reader->counters().events != events || read + reader->counters().skipped_bytes != size)
    std::abort();
  std::vector<Error> notes;
  reader->append_notes(notes);
  if (notes.empty() != (reader->counters().skipped_bytes == 0)) std::abort();
  return 0;
}

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <span>
#include <vector>

#include "drivers/recording/pcap_reader.hpp"

namespace {

void add_u32(std::vector<uint8_t>& bytes, size_t value) {
  for (int shift = 0; shift < 32; shift += 8) bytes.push_back(static_cast<uint8_t>(value >> shift));
}

// A sound capture around arbitrary frames, each led by a byte that says its length: fuzzing from
// nothing would spend its time on the file header.
std::vector<uint8_t> wrap(std::span<const uint8_t> input) {
  constexpr std::array<size_t, 8> kLinkTypes = {0, 1, 101, 108, 113, 228, 276, 1};
  std::vector<uint8_t> file;
  for (const size_t word : {size_t{0xA1B23C4D}, size_t{0x00040002}, size_t{0}, size_t{0},
                            size_t{65535}, kLinkTypes[input[0] % 8]}) {
    add_u32(file, word);
  }
  input = input.subspan(1);
  for (size_t i = 0; !input.empty(); ++i) {
    const size_t length = std::min<size_t>(input[0], input.size() - 1);
    add_u32(file, i);
    add_u32(file, 0);
    add_u32(file, length);
    add_u32(file, length);
    file.insert(file.end(), input.begin() + 1, input.begin() + 1 + static_cast<ptrdiff_t>(length));
    input = input.subspan(1 + length);
  }
  return file;
}

void read_all(std::span<const uint8_t> file) {
  infuse::recording::PcapOptions options;
  options.max_fragmented_datagrams = 2;
  auto reader = infuse::recording::PcapReader::from_bytes(file, "fuzz", options);
  if (!reader) return;
  infuse::Datagram datagram;
  uint32_t sum = 0;
  while (reader->next(datagram)) {
    for (const uint8_t byte : datagram.payload) sum += byte;
    if (datagram.payload.size() > 65527) std::abort();
  }
  const auto& counters = reader->counters();
  if (counters.fragments_dropped > counters.fragments) std::abort();
  if (counters.datagrams > counters.packets || (sum > 0 && counters.datagrams == 0)) std::abort();
}

}  // namespace

// Any bytes as a capture, and as the frames of a sound one: read to the end.
extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  if (size == 0) return 0;
  const std::span<const uint8_t> input(data, size);
  read_all(input);
  read_all(wrap(input));
  return 0;
}

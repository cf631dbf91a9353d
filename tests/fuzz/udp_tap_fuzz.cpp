// Any bytes as a packet from a tap.

#include <cstdlib>

#include "drivers/lidar/udp_tap.hpp"

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  const auto datagram = infuse::lidar::parse_tapped({data, size});
  if (!datagram) return 0;
  uint32_t sum = 0;
  for (const uint8_t byte : datagram->payload) sum += byte;
  if (datagram->payload.size() + 28 > size || (datagram->payload.empty() && sum > 0)) std::abort();
  return 0;
}

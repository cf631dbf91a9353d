// Position packets and the sentences in them.

#include <cstdint>
#include <string_view>

#include "drivers/velodyne/position_packet.hpp"

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  using namespace infuse::velodyne;
  (void)parse_position_packet({data, size});
  (void)infuse::gnss::parse_nmea({reinterpret_cast<const char*>(data), size});
  return 0;
}

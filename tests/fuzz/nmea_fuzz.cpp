#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <string_view>

#include "drivers/gnss/nmea.hpp"

// Any text from a GNSS receiver: a sentence that is accepted has a place on the earth.
extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  const auto parsed =
      infuse::gnss::parse_nmea(std::string_view(reinterpret_cast<const char*>(data), size));
  if (!parsed || !parsed->fix.valid) return 0;
  if (!(std::abs(parsed->fix.latitude) < 1.6) || !(std::abs(parsed->fix.longitude) < 3.2)) {
    std::abort();
  }
  return 0;
}

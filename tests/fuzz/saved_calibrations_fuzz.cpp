#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <string_view>

#include "daemon/calibration/saved_calibrations.hpp"

// Any text as the daemon's saved calibrations: refused, or accepted, and then written and read
// back.
extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  using namespace infuse::daemon;
  const auto saved = parse_calibrations({reinterpret_cast<const char*>(data), size});
  if (!saved) {
    if (saved.error().what.empty()) std::abort();
    return 0;
  }
  if (!parse_calibrations(format_calibrations(*saved))) std::abort();
  return 0;
}

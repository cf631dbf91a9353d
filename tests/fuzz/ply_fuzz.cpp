#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <string_view>

#include "drivers/recording/ply_sweep.hpp"

// Any bytes as a PLY file.
extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  infuse::Sweep sweep;
  const auto parsed =
      infuse::recording::parse_ply_sweep({reinterpret_cast<const char*>(data), size}, sweep);
  if (!parsed && parsed.error().what.empty()) std::abort();
  if (sweep.size() != sweep.ring.size() || sweep.size() > 4'000'000) std::abort();
  return 0;
}

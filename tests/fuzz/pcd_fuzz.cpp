#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <string>
#include <string_view>

#include "drivers/recording/pcd_sweep.hpp"

namespace {

void read(std::string_view bytes) {
  infuse::Sweep sweep;
  const auto parsed = infuse::recording::parse_pcd_sweep(bytes, sweep);
  if (!parsed && parsed.error().what.empty()) std::abort();
  if (sweep.size() != sweep.ring.size() || sweep.size() > 4'000'000) std::abort();
}

}  // namespace

// Any bytes as a PCD file, and as the packed points of a sound one.
extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  const std::string_view bytes(reinterpret_cast<const char*>(data), size);
  read(bytes);
  std::string file =
      "FIELDS x y z intensity ring\nSIZE 4 4 4 1 2\nTYPE F F F U U\nCOUNT 1 1 1 1 1\nWIDTH 16\n"
      "HEIGHT 1\nPOINTS 16\nDATA binary_compressed\n";
  for (const size_t word : {size, size_t{16 * 15}}) {
    for (int shift = 0; shift < 32; shift += 8) file += static_cast<char>(word >> shift);
  }
  read(file.append(bytes));
  return 0;
}

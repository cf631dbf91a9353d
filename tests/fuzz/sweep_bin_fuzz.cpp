#include <cstdlib>

#include "drivers/recording/sweep_files.hpp"
#include "tests/fuzz/fuzz_file.hpp"

// Any bytes as a KITTI .bin sweep: points, and rings for all of them or for none.
extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  using namespace infuse;
  static fuzz::FuzzFile file(".bin");
  Sweep sweep;
  if (!recording::read_sweep_file(file.write({data, size}), sweep)) return 0;
  if (sweep.size() * 16 > size || sweep.ring.size() != sweep.size()) std::abort();
  for (const auto ring : sweep.ring) {
    if (sweep.rings > 0 && ring >= sweep.rings) std::abort();
  }
  return 0;
}

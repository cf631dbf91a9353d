#include <cstdlib>

#include "drivers/import/kitti_calibration.hpp"
#include "drivers/import/kitti_files.hpp"
#include "tests/fuzz/fuzz_file.hpp"

// The first byte selects the kind of KITTI's text files, the rest is the content.
extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  using namespace infuse;
  static fuzz::FuzzFile file(".txt");
  if (size == 0) return 0;
  const auto& path = file.write({data + 1, size - 1});
  switch (data[0] % 3) {
    case 0: {
      const auto calibration = importers::read_kitti_calibration(path);
      if (!calibration && calibration.error().what.empty()) std::abort();
      break;
    }
    case 1: {
      const auto times = importers::read_kitti_times(path);
      if (times && times->size() > size) std::abort();
      break;
    }
    default: {
      const auto lines = importers::read_number_lines(path, 30);
      if (lines && lines->size() > size) std::abort();
    }
  }
  return 0;
}

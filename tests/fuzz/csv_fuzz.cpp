#include <cstdlib>

#include "drivers/gnss/gnss_csv.hpp"
#include "drivers/recording/imu_csv.hpp"
#include "drivers/recording/speed_csv.hpp"
#include "drivers/recording/times_csv.hpp"
#include "tests/fuzz/fuzz_file.hpp"

namespace {

template <class Csv, class Sample>
void read_all(const std::filesystem::path& path, size_t size) {
  auto csv = Csv::open(path);
  if (!csv) {
    if (csv.error().what.empty()) std::abort();
    return;
  }
  Sample sample;
  size_t rows = 0;
  while (csv->next(sample)) ++rows;
  if (rows > size) std::abort();
}

}  // namespace

// The first byte selects the kind of file, the rest is its content.
extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  using namespace infuse;
  static fuzz::FuzzFile file(".csv");
  if (size == 0) return 0;
  const auto& path = file.write({data + 1, size - 1});
  switch (data[0] % 4) {
    case 0:
      read_all<gnss::GnssCsv, GnssFix>(path, size);
      break;
    case 1:
      read_all<recording::ImuCsv, ImuSample>(path, size);
      break;
    case 2:
      read_all<recording::SpeedCsv, WheelOdometry>(path, size);
      break;
    default: {
      const auto times = recording::read_times(path);
      if (times && times->size() > size) std::abort();
    }
  }
  return 0;
}

// An HDL-64E's db.xml.

#include <cstdint>
#include <cstdlib>
#include <string_view>

#include "drivers/velodyne/calibration_file.hpp"

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  using namespace infuse::velodyne;
  const auto calibration = parse_db_xml({reinterpret_cast<const char*>(data), size});
  if (calibration && calibration->invalid(model_info(Model::kHdl64eS3))) std::abort();
  return 0;
}

// The metadata of an Ouster, in both layouts.

#include <cstdint>
#include <string_view>

#include "drivers/ouster/beam_table.hpp"
#include "drivers/ouster/metadata.hpp"

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  using namespace infuse::ouster;
  const auto metadata =
      parse_metadata({reinterpret_cast<const char*>(data), size}, "metadata.json");
  if (!metadata) return 0;
  static_cast<void>(metadata->model());
  static_cast<void>(BeamTable(*metadata));
  return 0;
}

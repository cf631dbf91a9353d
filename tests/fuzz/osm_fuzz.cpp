#include <cstdlib>

#include "drivers/osm/openstreetmap.hpp"
#include "tests/fuzz/fuzz_file.hpp"

// An OpenStreetMap extract: XML if the first byte is even, else the binary form.
extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  using namespace infuse;
  static fuzz::FuzzFile xml(".osm"), binary(".osm.pbf");
  if (size == 0) return 0;
  const auto& path = (data[0] % 2 == 0 ? xml : binary).write({data + 1, size - 1});
  const auto map = osm::read_openstreetmap(path, {.max_elements = 100'000});
  if (!map && map.error().what.empty()) std::abort();
  return 0;
}

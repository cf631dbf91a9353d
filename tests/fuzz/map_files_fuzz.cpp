#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <string_view>

#include "daemon/mapping/cloud_file.hpp"
#include "daemon/mapping/map_tables.hpp"
#include "daemon/mapping/place_map.hpp"

namespace {

/// What is accepted is accepted again when written; what is refused says why.
template <class Parse, class Format>
void check(std::string_view text, Parse parse, Format format) {
  const auto parsed = parse(text, "fuzz");
  if (!parsed) {
    if (parsed.error().what.empty()) std::abort();
    return;
  }
  if (!parse(format(*parsed), "again")) std::abort();
}

}  // namespace

// The first byte selects the file of a map folder and the stated points of a compressed cloud; the
// rest is its content.
extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  using namespace infuse::daemon;
  constexpr uint8_t kKinds = 6;
  if (size == 0) return 0;
  const std::string_view text(reinterpret_cast<const char*>(data) + 1, size - 1);
  switch (data[0] % kKinds) {
    case 0:
      check(text, parse_keyframes, format_keyframes);
      break;
    case 1:
      check(text, parse_fixes, format_fixes);
      break;
    case 2:
      check(text, parse_closures, format_closures);
      break;
    case 3:
      check(text, parse_places, format_places);
      break;
    case 4:
      check(text, parse_cloud_pcd, format_cloud_pcd);
      break;
    default: {
      const size_t points = data[0] / kKinds;
      check(
          text,
          [&](std::string_view bytes, const char* name) {
            return parse_compressed_cloud(bytes, points, name);
          },
          [](const auto& cloud) { return compress_cloud(cloud).value(); });
    }
  }
  return 0;
}

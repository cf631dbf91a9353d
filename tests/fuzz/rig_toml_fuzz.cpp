#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <string_view>

#include "drivers/recording/drive_toml.hpp"

// Any text as a rig.toml: refused with a place, or accepted, and then written and read back.
extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  const std::string_view text(reinterpret_cast<const char*>(data), size);
  const auto rig = infuse::recording::parse_rig(text);
  if (!rig) {
    if (rig.error().where.empty()) std::abort();
    return 0;
  }
  if (!infuse::recording::parse_rig(infuse::recording::format_rig(*rig))) std::abort();
  return 0;
}

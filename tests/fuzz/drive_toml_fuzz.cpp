#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <string_view>

#include "drivers/recording/drive_toml.hpp"

// Any text as a drive.toml: refused with a place, or accepted, and then written and read back.
extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  const std::string_view text(reinterpret_cast<const char*>(data), size);
  const auto drive = infuse::recording::parse_drive(text);
  if (!drive) {
    if (drive.error().where.empty()) std::abort();
    return 0;
  }
  if (!infuse::recording::parse_drive(infuse::recording::format_drive(*drive))) std::abort();
  return 0;
}

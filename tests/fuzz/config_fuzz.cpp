// Any text is a configuration or an error that says where and why.

#include <cstdint>
#include <cstdlib>

#include "daemon/config/config.hpp"

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  const std::string_view text(reinterpret_cast<const char*>(data), size);
  const auto config = infuse::daemon::parse_config(text, "x.toml");
  if (!config && (config.error().what.empty() || config.error().where.empty())) std::abort();
  return 0;
}

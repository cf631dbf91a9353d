// Any line from a client is a request or an error that says why.

#include <cstdint>
#include <cstdlib>

#include "daemon/protocol/request.hpp"

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  const std::string_view line(reinterpret_cast<const char*>(data), size);
  const auto request = infuse::daemon::parse_request(line);
  if (!request && (request.error().what.empty() || request.error().what.size() > 200)) std::abort();
  return 0;
}

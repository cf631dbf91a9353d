#include <cstdlib>
#include <string_view>

#include "daemon/view/foxglove_protocol.hpp"

// Any bytes as what a viewer sends, and as the subprotocols that it offers.
extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  using namespace infuse::daemon;
  const std::string_view text(reinterpret_cast<const char*>(data), size);
  const ViewerRequest request = parse_viewer_request(text);
  if (!request.refused.empty() && (!request.subscribe.empty() || !request.unsubscribe.empty()))
    std::abort();
  const std::string_view chosen = choose_subprotocol(text);
  if (!chosen.empty() && text.find(chosen) == std::string_view::npos) std::abort();
  return 0;
}

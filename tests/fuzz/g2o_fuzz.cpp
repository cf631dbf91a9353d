#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <string_view>

#include "daemon/mapping/g2o_file.hpp"

// Any text as a pose graph: an accepted one has finite poses, sound indices, and is read again when
// written.
extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  using namespace infuse::daemon;
  const std::string_view text(reinterpret_cast<const char*>(data), size);
  const auto parsed = parse_g2o(text, "fuzz");
  if (!parsed) {
    if (parsed.error().what.empty()) std::abort();
    return 0;
  }
  std::visit(
      [](const auto& file) {
        if (file.ids.size() != file.graph.poses.size()) std::abort();
        for (const auto& pose : file.graph.poses) {
          if (!pose.matrix().allFinite()) std::abort();
        }
        for (const auto& edge : file.graph.edges) {
          if (std::max(edge.from, edge.to) >= file.graph.poses.size()) std::abort();
          if (!edge.T_from_to.matrix().allFinite()) std::abort();
        }
        const auto again = parse_g2o(format_g2o(file), "again");
        if (!again) std::abort();
      },
      *parsed);
  return 0;
}

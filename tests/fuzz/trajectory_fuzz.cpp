#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <string_view>

#include "drivers/recording/trajectory_file.hpp"

// Any text as a trajectory of either format: an accepted one has rigid, finite poses.
extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  using namespace infuse::recording;
  const std::string_view text(reinterpret_cast<const char*>(data), size);
  for (const auto& parsed : {parse_tum(text, "fuzz"), parse_kitti(text, "fuzz")}) {
    if (!parsed && parsed.error().what.empty()) std::abort();
    for (const TrajectoryPose& pose : parsed.value_or(std::vector<TrajectoryPose>())) {
      if (!pose.T_frame_body.matrix().allFinite()) std::abort();
      if (!(std::abs(pose.T_frame_body.linear().determinant() - 1) < 1e-6)) std::abort();
    }
  }
  return 0;
}

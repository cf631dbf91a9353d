#include "daemon/command_line/trajectory_output.hpp"

#include "drivers/text/text_file.hpp"

namespace infuse::daemon {

void TrajectoryOutput::collect(Publisher& publisher, bool has_map) {
  if (path_.empty()) return;
  publisher.set_pose_listener([this, has_map](const PoseReport& pose) {
    const bool right_frame = pose.frame == (has_map ? PoseFrame::kMap : PoseFrame::kOdom);
    if (right_frame && pose.usable()) poses_.push_back({pose.stamp, pose.T_frame_vehicle});
  });
}

Result<void> TrajectoryOutput::write() const {
  if (path_.empty()) return {};
  const bool kitti = path_.extension() == ".kitti";
  return text::write_text(path_,
                          kitti ? recording::format_kitti(poses_) : recording::format_tum(poses_));
}

}  // namespace infuse::daemon

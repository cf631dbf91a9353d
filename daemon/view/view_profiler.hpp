#pragma once

#include <deque>
#include <string>

#include "daemon/pipeline/view_tap.hpp"
#include "drivers/measurement/rig.hpp"
#include "fusion/monitoring/dependence_profile.hpp"

namespace infuse::daemon {

/// Makes dependence profiles of images, of the order of 50 ms each: for the thread of the view.
class ViewProfiler {
 public:
  /// The cameras of `rig` must be valid.
  explicit ViewProfiler(const Rig& rig);

  /// Returns the profiles of an image that has its returns, under the calibration in use, the saved
  /// one (`rig`, as the run began) and the last re-estimated one, if there is one. As a binary
  /// message of the view (view_frames.hpp): kind "profile", device, stamp, no points, reason
  /// (empty, or why there are no profiles), rotation and translation (rad and m, half widths), and
  /// profiles: by name ("saved", "estimate", "use") six lists of nats, along the axes (rx, ry, rz,
  /// tx, ty, tz) from minus to plus the half width.
  std::string encode(const ViewImage& image);

 private:
  const Rig rig_;
  std::deque<monitoring::ProfileSampler> samplers_;  // by CameraIndex
  CameraFrame grey_;                                 // memory that is used again
};

}  // namespace infuse::daemon

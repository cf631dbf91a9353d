#pragma once

#include <string>
#include <vector>

#include "drivers/measurement/camera_frame.hpp"
#include "drivers/measurement/error.hpp"
#include "drivers/measurement/rig.hpp"
#include "drivers/measurement/stamp.hpp"
#include "drivers/recording/times_csv.hpp"

namespace infuse::daemon {

struct SensorSetup;

/// The images of one camera of a drive.
struct CameraImages {
  size_t camera = 0;  ///< index in the rig
  std::vector<recording::SequenceEntry> entries;

  /// The image whose exposure is nearest. There must be one.
  const recording::SequenceEntry& nearest(Stamp time) const;
};

/// Lists the images of the cameras whose extrinsics refer to a lidar, at least one of each. Errors:
/// a drive that cannot be read, no such camera.
Result<std::vector<CameraImages>> list_camera_images(const std::string& drive,
                                                     const std::string& lidar);

/// Images that were taken together.
struct ImageSet {
  std::vector<CameraMount> cameras;
  std::vector<CameraFrame> images;  ///< one per camera
};

/// Reads the image of each camera that is nearest to a time. Errors: one that cannot be read, or is
/// more than 50 ms off.
Result<ImageSet> read_nearest_images(const std::vector<CameraImages>& cameras,
                                     const SensorSetup& setup, Stamp time);

inline constexpr Duration kMaxImageGap{50'000'000};  ///< from a sweep's reference to an exposure

}  // namespace infuse::daemon

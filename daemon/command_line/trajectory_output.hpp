#pragma once

#include <filesystem>
#include <vector>

#include "daemon/pipeline/publisher.hpp"
#include "drivers/recording/trajectory_file.hpp"

namespace infuse::daemon {

/// The file of poses that a replay writes at its end.
class TrajectoryOutput {
 public:
  /// `path`: empty for none; the format is KITTI's if it ends in .kitti, else TUM's.
  explicit TrajectoryOutput(std::filesystem::path path) : path_(std::move(path)) {}

  /// Collects usable poses, in the map frame if `has_map`, otherwise in the odometry frame.
  void collect(Publisher& publisher, bool has_map);

  /// Writes the file. Errors: it cannot be written.
  Result<void> write() const;

 private:
  std::filesystem::path path_;
  std::vector<recording::TrajectoryPose> poses_;
};

}  // namespace infuse::daemon

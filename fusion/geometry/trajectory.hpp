#pragma once

#include <optional>
#include <string>
#include <vector>

#include "drivers/measurement/stamp.hpp"
#include "fusion/geometry/rigid_motion.hpp"

namespace infuse::geometry {

/// Where the vehicle was at one moment.
struct StampedPose {
  Stamp stamp;
  Eigen::Isometry3d T_odom_vehicle = Eigen::Isometry3d::Identity();
  Matrix6 covariance = Matrix6::Zero();  ///< left perturbation, map frame
};

/// How a trajectory keeps and answers.
struct TrajectoryOptions {
  size_t capacity = 4096;         ///< poses kept; the oldest give way
  Duration max_gap{200'000'000};  ///< ns; between two poses further apart nothing is known
  Duration max_extrapolation{0};  ///< ns past the last pose that are answered, at the last twist
  double rotation_growth = 3e-4;  ///< rad/√s: how fast an extrapolated pose's rotation gets vaguer,
                                  ///< each axis
  double translation_growth = 0.1;  ///< m/√s: as above, translation

  /// What is wrong with the options, or nothing.
  std::optional<std::string> invalid() const;
};

/// A pose asked of a trajectory, or why there is none.
struct PoseAt {
  Eigen::Isometry3d T_odom_vehicle = Eigen::Isometry3d::Identity();
  Matrix6 covariance = Matrix6::Zero();  ///< left perturbation, map frame
  const char* reason = "";               ///< static text; empty when the pose can be used

  bool usable() const { return *reason == '\0'; }
};

/// The motion between two moments, or why it is not known.
struct MotionBetween {
  Eigen::Isometry3d T_from_to =
      Eigen::Isometry3d::Identity();     ///< vehicle at `to` seen from `from`
  Matrix6 covariance = Matrix6::Zero();  ///< left perturbation, vehicle frame at `from`
  const char* reason = "";               ///< static text; empty when the motion can be used

  bool usable() const { return *reason == '\0'; }
};

/// Stamped poses in order of time, bounded; a pose between two of them moves at constant twist and
/// its covariance grows linearly from one to the other, as dead reckoning's does.
class Trajectory {
 public:
  /// `options.invalid()` must be empty. All memory is taken here.
  explicit Trajectory(const TrajectoryOptions& options = {});

  /// Adds a pose; false, and nothing happens, where it is not later than the last.
  bool append(const StampedPose& pose);

  /// Forgets all poses, keeps the memory.
  void clear();

  size_t size() const { return size_; }
  bool empty() const { return size_ == 0; }

  /// Poses in order of time; index < size().
  const StampedPose& operator[](size_t index) const;

  /// The pose at a time.
  PoseAt at(Stamp stamp) const;

  /// The motion from one time to another (either may be the earlier). Its covariance is the growth
  /// between the two: errors common to both are none of the motion's.
  MotionBetween between(Stamp from, Stamp to) const;

  /// Why some of the span from one time to a later one is not covered, static text; empty where all
  /// of it is.
  const char* uncovered_reason(Stamp from, Stamp to) const;

  /// The first pose that is not before the stamp; size() where there is none.
  size_t index_at_or_after(Stamp stamp) const;

 private:
  PoseAt extrapolate(Stamp stamp) const;

  TrajectoryOptions options_;
  std::vector<StampedPose> ring_;
  size_t first_ = 0;
  size_t size_ = 0;
};

}  // namespace infuse::geometry

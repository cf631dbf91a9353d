#pragma once

#include <array>
#include <optional>
#include <string>
#include <vector>

#include "fusion/calibration/pool_calibrations.hpp"

namespace infuse::calibration {

/// Settings of the search for a change among the calibrations of one camera.
struct PoseDriftOptions {
  double significance = 1e-3;  ///< p-value of a real difference: one in a thousand by chance
  size_t max_changes = 8;      ///< that are looked for

  /// What is wrong with the settings, or nothing.
  std::optional<std::string> invalid() const;
};

/// How a camera's pose changed.
enum class ChangeKind : uint8_t {
  kStep,  ///< between two drives
  kRamp,  ///< steadily, to the last drive of the segment
};

/// Names of the axes of a left perturbation: "rotation about x", …
inline constexpr std::array<const char*, 6> kPoseAxes{"rotation about x",    "rotation about y",
                                                      "rotation about z",    "translation along x",
                                                      "translation along y", "translation along z"};

/// A change of a camera's pose among dated calibrations.
struct PoseChange {
  ChangeKind kind = ChangeKind::kStep;
  size_t first = 0;  ///< index of the first calibration that has moved
  size_t last = 0;   ///< that at which the change is complete; `first` of a step
  geometry::Vector6 change = geometry::Vector6::Zero();  ///< left perturbation, rad and m
  geometry::Vector6 sigma = geometry::Vector6::Zero();   ///< of it
  /// The axis along which a change alone explains the most, and what share of what all explain.
  int axis = 0;
  double share = 0;
  double p_value = 1;  ///< of so large a change in poses that do not change
};

/// What the calibrations of one camera say together.
enum class PoseVerdict : uint8_t {
  kNone,          ///< no usable calibration
  kSingle,        ///< one calibration: nothing to compare it with
  kOnePose,       ///< differences as the covariances have them
  kDrift,         ///< a change is found
  kInconsistent,  ///< larger differences than stated, without a change that explains them
};

/// Result of `find_pose_drift`.
struct PoseHistory {
  PoseVerdict verdict = PoseVerdict::kNone;
  PooledPose all;                   ///< of all calibrations, as if of one pose
  std::vector<PoseChange> changes;  ///< in the order of time
  /// The pose after the last change; `all` without a change. Where differences are larger than the
  /// covariances have them, its covariance is as much larger.
  PooledPose current;
  double scale = 1;    ///< factor of that, of covariances
  std::string reason;  ///< why there is no current pose; empty if there is

  bool usable() const { return reason.empty(); }
};

/// Combines calibrations, sorted by date, and tests whether they are of one pose (χ²). If not,
/// looks for the change that explains most: a step before any drive, or a ramp from any drive on to
/// the last. A change counts if so large a decrease of χ² is improbable among as many candidates
/// (Bonferroni), by Fisher's distribution where the scatter that remains is larger than stated:
/// covariances that are all too small make no drift. What lies before and after a step is searched
/// again, and what lies before a ramp.
PoseHistory find_pose_drift(std::span<const DatedCalibration> calibrations,
                            const Eigen::Isometry3d& T_reference, const PoseDriftOptions& options);

}  // namespace infuse::calibration

#pragma once

#include <array>
#include <span>
#include <vector>

#include "fusion/geometry/trajectory.hpp"

namespace infuse::motion {

/// The lengths of KITTI odometry's score, m.
inline constexpr std::array<double, 8> kKittiLengths{100, 200, 300, 400, 500, 600, 700, 800};

/// A pose of an estimate and the true pose at its time.
struct PosePair {
  Stamp stamp;
  Eigen::Isometry3d estimate = Eigen::Isometry3d::Identity();
  Eigen::Isometry3d truth = Eigen::Isometry3d::Identity();
};

/// Root mean square, mean, median and largest of some errors, and how many there were.
struct ErrorStatistics {
  size_t count = 0;
  double rms = 0, mean = 0, median = 0, max = 0;
};

/// What an estimate's positions are moved by before they are compared.
enum class Alignment {
  kNone,        ///< both are in one frame already
  kFirstPose,   ///< the first poses are laid on each other
  kRigid,       ///< least squares over all positions (Umeyama 1991), TUM's convention
  kSimilarity,  ///< as `kRigid`, with a scale
};

/// Absolute trajectory error, TUM's convention.
struct AbsoluteError {
  ErrorStatistics translation;                                         ///< m
  ErrorStatistics rotation;                                            ///< rad
  Eigen::Isometry3d T_truth_estimate = Eigen::Isometry3d::Identity();  ///< the alignment
  double scale = 1;                                                    ///< the alignment's
  const char* reason = "";  ///< static text: why there is no score; empty when there is

  bool usable() const { return *reason == '\0'; }
};

/// Relative error over a fixed span of time, TUM's convention.
struct RelativeError {
  ErrorStatistics translation;  ///< m
  ErrorStatistics rotation;     ///< rad
  const char* reason = "";      ///< static text; empty when there is a score

  bool usable() const { return *reason == '\0'; }
};

/// Mean error over all parts of one length, KITTI's convention.
struct SegmentError {
  double length = 0;       ///< m along the truth
  size_t count = 0;        ///< parts of that length
  double translation = 0;  ///< m a metre
  double rotation = 0;     ///< rad a metre
};

/// KITTI odometry's score: over parts of 100 … 800 m from every tenth pose.
struct KittiError {
  std::vector<SegmentError> segments;  ///< one a length; `count` 0 where the truth is too short
  double translation = 0;              ///< m a metre, over all parts (times 100: per cent)
  double rotation = 0;                 ///< rad a metre, over all parts
  size_t count = 0;                    ///< parts
  const char* reason = "";             ///< static text; empty when there is a score

  bool usable() const { return *reason == '\0'; }
};

/// Pairs each estimated pose with the truth at its time, interpolated on SE(3) where the truth has
/// poses on both sides no further apart than `max_gap`; others are left out. Both in order of time.
std::vector<PosePair> pair_by_time(std::span<const geometry::StampedPose> estimate,
                                   std::span<const geometry::StampedPose> truth,
                                   Duration max_gap = Duration(500'000'000));

/// Absolute error after alignment. Rotations are compared after the alignment's rotation.
AbsoluteError absolute_error(std::span<const PosePair> pairs,
                             Alignment alignment = Alignment::kRigid);

/// Error of the motion over `span`, from every pose to the one nearest to `span` later, at most
/// half a span off it.
RelativeError relative_error(std::span<const PosePair> pairs, Duration span);

/// KITTI's error over the lengths (m) from every `step`-th pose, as its development kit computes
/// it.
KittiError kitti_error(std::span<const PosePair> pairs,
                       std::span<const double> lengths = kKittiLengths, size_t step = 10);

}  // namespace infuse::motion

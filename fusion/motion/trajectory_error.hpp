#pragma once

#include <array>
#include <span>
#include <vector>

#include "fusion/geometry/trajectory.hpp"

namespace infuse::motion {

/// Segment lengths of the KITTI odometry benchmark by definition, m.
inline constexpr std::array<double, 8> kKittiLengths{100, 200, 300, 400, 500, 600, 700, 800};

/// Estimated pose and true pose at the same time.
struct PosePair {
  Stamp stamp;                                                 ///< of both
  Eigen::Isometry3d estimate = Eigen::Isometry3d::Identity();  ///< estimated pose
  Eigen::Isometry3d truth = Eigen::Isometry3d::Identity();     ///< true pose
};

/// Root mean square, mean, median, maximum and number of errors.
struct ErrorStatistics {
  size_t count = 0;                               ///< number of errors
  double rms = 0, mean = 0, median = 0, max = 0;  ///< of the errors
};

/// Alignment of the estimated positions before the comparison.
enum class Alignment {
  kNone,        ///< none: both are in the same frame
  kFirstPose,   ///< the first poses coincide
  kRigid,       ///< least squares over all positions (Umeyama 1991), TUM's convention
  kSimilarity,  ///< as `kRigid`, with a scale
};

/// Absolute trajectory error, TUM's convention.
struct AbsoluteError {
  ErrorStatistics translation;                                         ///< m
  ErrorStatistics rotation;                                            ///< rad
  Eigen::Isometry3d T_truth_estimate = Eigen::Isometry3d::Identity();  ///< the alignment
  double scale = 1;                                                    ///< of the alignment
  const char* reason = "";  ///< static text: why there is no result; empty if there is one

  bool usable() const { return *reason == '\0'; }  ///< there is a result
};

/// Relative error over a fixed time span, TUM's convention.
struct RelativeError {
  ErrorStatistics translation;  ///< m
  ErrorStatistics rotation;     ///< rad
  const char* reason = "";      ///< static text; empty if there is a result

  bool usable() const { return *reason == '\0'; }  ///< there is a result
};

/// Mean error over all segments of one length, KITTI's convention.
struct SegmentError {
  double length = 0;       ///< m along the true path
  size_t count = 0;        ///< segments of that length
  double translation = 0;  ///< m per metre
  double rotation = 0;     ///< rad per metre
};

/// KITTI odometry error: segments of 100 … 800 m from every tenth pose.
struct KittiError {
  std::vector<SegmentError> segments;  ///< one per length; `count` 0 if the true path is too short
  double translation = 0;              ///< m per metre, over all segments (times 100: per cent)
  double rotation = 0;                 ///< rad per metre, over all segments
  size_t count = 0;                    ///< number of segments
  const char* reason = "";             ///< static text; empty if there is a result

  bool usable() const { return *reason == '\0'; }  ///< there is a result
};

/// Pairs each estimated pose with the true pose at its time. The truth is interpolated on SE(3)
/// where it has poses on both sides at most `max_gap` apart; other poses are left out. Both in time
/// order.
std::vector<PosePair> pair_by_time(std::span<const geometry::StampedPose> estimate,
                                   std::span<const geometry::StampedPose> truth,
                                   Duration max_gap = Duration(500'000'000));

/// Absolute error after alignment. Rotation errors include the alignment's rotation.
AbsoluteError absolute_error(std::span<const PosePair> pairs,
                             Alignment alignment = Alignment::kRigid);

/// Error of the motion over `span`, from every pose to the one nearest to `span` later, at most
/// half a span away from it.
RelativeError relative_error(std::span<const PosePair> pairs, Duration span);

/// KITTI error over the lengths (m) from every `step`-th pose, as computed by the KITTI development
/// kit.
KittiError kitti_error(std::span<const PosePair> pairs,
                       std::span<const double> lengths = kKittiLengths, size_t step = 10);

}  // namespace infuse::motion

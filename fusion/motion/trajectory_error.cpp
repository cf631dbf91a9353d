#include "fusion/motion/trajectory_error.hpp"

#include <Eigen/SVD>
#include <algorithm>
#include <cmath>

#include "drivers/measurement/median.hpp"

namespace infuse::motion {
namespace {

constexpr const char* kReasonTooFewPairs =
    "fewer than 3 estimated poses have a true pose at their time";

ErrorStatistics compute_statistics(std::vector<double> errors) {
  ErrorStatistics s;
  s.count = errors.size();
  if (errors.empty()) return s;
  for (const double e : errors) {
    s.rms += e * e;
    s.mean += e;
    s.max = std::max(s.max, e);
  }
  s.rms = std::sqrt(s.rms / static_cast<double>(s.count));
  s.mean /= static_cast<double>(s.count);
  s.median = median(errors);
  if (s.count % 2 == 0) {
    const auto middle = errors.begin() + static_cast<std::ptrdiff_t>(s.count / 2);
    s.median = 0.5 * (s.median + *std::max_element(errors.begin(), middle));
  }
  return s;
}

double rotation_angle(const Eigen::Matrix3d& R) { return geometry::rotation_log(R).norm(); }

/// Rotation about `axis` (unit vector) that best aligns the estimated orientations after `R`: the
/// angle a that maximises the sum of tr(exp(-a axis) truth (R estimate)ᵀ).
Eigen::Matrix3d best_rotation_about(const Eigen::Vector3d& axis, const Eigen::Matrix3d& R,
                                    std::span<const PosePair> pairs) {
  Eigen::Matrix3d M = Eigen::Matrix3d::Zero();
  for (const PosePair& pair : pairs) {
    M += pair.truth.linear() * (R * pair.estimate.linear()).transpose();
  }
  const Eigen::Vector3d skew(M(2, 1) - M(1, 2), M(0, 2) - M(2, 0), M(1, 0) - M(0, 1));
  return Eigen::AngleAxisd(std::atan2(axis.dot(skew), M.trace() - axis.dot(M * axis)), axis)
      .toRotationMatrix();
}

/// Least-squares similarity from estimated to true positions, Umeyama (1991).
void align(std::span<const PosePair> pairs, bool with_scale, AbsoluteError& result) {
  Eigen::Vector3d mean_estimate = Eigen::Vector3d::Zero(), mean_truth = Eigen::Vector3d::Zero();
  const double count = static_cast<double>(pairs.size());
  for (const PosePair& pair : pairs) {
    mean_estimate += pair.estimate.translation() / count;
    mean_truth += pair.truth.translation() / count;
  }
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();
  double spread = 0;
  for (const PosePair& pair : pairs) {
    const Eigen::Vector3d e = pair.estimate.translation() - mean_estimate;
    covariance += (pair.truth.translation() - mean_truth) * e.transpose() / count;
    spread += e.squaredNorm() / count;
  }
  const Eigen::JacobiSVD<Eigen::Matrix3d> svd(covariance,
                                              Eigen::ComputeFullU | Eigen::ComputeFullV);
  Eigen::Vector3d sign = Eigen::Vector3d::Ones();
  if (svd.matrixU().determinant() * svd.matrixV().determinant() < 0) sign.z() = -1;
  Eigen::Matrix3d R = svd.matrixU() * sign.asDiagonal() * svd.matrixV().transpose();
  // Positions on a line do not determine the rotation about it (a path 33 m long and 10 cm wide was
  // rolled onto its side): use the orientations there.
  constexpr double kMaxLineVarianceRatio = 1e-3;  // variance across the line
  if (svd.singularValues()[1] < kMaxLineVarianceRatio * svd.singularValues()[0]) {
    R = best_rotation_about(svd.matrixU().col(0), R, pairs) * R;
  }
  if (with_scale && spread > 0) result.scale = svd.singularValues().dot(sign) / spread;
  result.T_truth_estimate.linear() = R;
  result.T_truth_estimate.translation() = mean_truth - result.scale * (R * mean_estimate);
}

/// Error of the motion between two poses, after undoing the true motion.
Eigen::Isometry3d motion_error(const PosePair& from, const PosePair& to) {
  const Eigen::Isometry3d true_motion = from.truth.inverse() * to.truth;
  return true_motion.inverse() * (from.estimate.inverse() * to.estimate);
}

}  // namespace

std::vector<PosePair> pair_by_time(std::span<const geometry::StampedPose> estimate,
                                   std::span<const geometry::StampedPose> truth, Duration max_gap) {
  std::vector<PosePair> pairs;
  size_t after = 0;
  for (const geometry::StampedPose& pose : estimate) {
    while (after < truth.size() && truth[after].stamp < pose.stamp) ++after;
    if (after == truth.size()) break;
    const geometry::StampedPose& b = truth[after];
    if (b.stamp == pose.stamp) {
      pairs.push_back({pose.stamp, pose.T_odom_vehicle, b.T_odom_vehicle});
      continue;
    }
    if (after == 0 || b.stamp - truth[after - 1].stamp > max_gap) continue;
    const geometry::StampedPose& a = truth[after - 1];
    const double u = to_seconds(pose.stamp - a.stamp) / to_seconds(b.stamp - a.stamp);
    pairs.push_back({pose.stamp, pose.T_odom_vehicle,
                     geometry::interpolate(a.T_odom_vehicle, b.T_odom_vehicle, u)});
  }
  return pairs;
}

AbsoluteError absolute_error(std::span<const PosePair> pairs, Alignment alignment) {
  AbsoluteError result;
  if (pairs.size() < 3) {
    result.reason = kReasonTooFewPairs;
    return result;
  }
  if (alignment == Alignment::kFirstPose) {
    result.T_truth_estimate = pairs[0].truth * pairs[0].estimate.inverse();
  } else if (alignment != Alignment::kNone) {
    align(pairs, alignment == Alignment::kSimilarity, result);
  }
  const Eigen::Matrix3d R = result.T_truth_estimate.linear();
  std::vector<double> translation, rotation;
  for (const PosePair& pair : pairs) {
    const Eigen::Vector3d moved =
        result.scale * (R * pair.estimate.translation()) + result.T_truth_estimate.translation();
    translation.push_back((pair.truth.translation() - moved).norm());
    rotation.push_back(
        rotation_angle(pair.truth.linear().transpose() * R * pair.estimate.linear()));
  }
  result.translation = compute_statistics(std::move(translation));
  result.rotation = compute_statistics(std::move(rotation));
  return result;
}

RelativeError relative_error(std::span<const PosePair> pairs, Duration span) {
  RelativeError result;
  std::vector<double> translation, rotation;
  size_t to = 0;
  for (size_t from = 0; from < pairs.size(); ++from) {
    const Stamp wanted = pairs[from].stamp + span;
    while (to < pairs.size() && pairs[to].stamp < wanted) ++to;
    if (to == pairs.size()) break;
    const bool earlier_is_nearer =
        to > from + 1 && wanted - pairs[to - 1].stamp < pairs[to].stamp - wanted;
    const PosePair& nearest = pairs[earlier_is_nearer ? to - 1 : to];
    const Duration off = nearest.stamp > wanted ? nearest.stamp - wanted : wanted - nearest.stamp;
    if (off > span / 2) continue;
    const Eigen::Isometry3d error = motion_error(pairs[from], nearest);
    translation.push_back(error.translation().norm());
    rotation.push_back(rotation_angle(error.linear()));
  }
  if (translation.empty()) {
    result.reason = "no two poses are the requested time span apart";
    return result;
  }
  result.translation = compute_statistics(std::move(translation));
  result.rotation = compute_statistics(std::move(rotation));
  return result;
}

KittiError kitti_error(std::span<const PosePair> pairs, std::span<const double> lengths,
                       size_t step) {
  KittiError result;
  std::vector<double> distance(pairs.size(), 0);
  for (size_t i = 1; i < pairs.size(); ++i) {
    distance[i] =
        distance[i - 1] + (pairs[i].truth.translation() - pairs[i - 1].truth.translation()).norm();
  }
  for (const double length : lengths) {
    SegmentError segment;
    segment.length = length;
    for (size_t from = 0; from < pairs.size(); from += std::max<size_t>(step, 1)) {
      const auto at = std::upper_bound(distance.begin(), distance.end(), distance[from] + length);
      if (at == distance.end()) break;
      const PosePair& to = pairs[static_cast<size_t>(at - distance.begin())];
      const Eigen::Isometry3d error = motion_error(pairs[from], to);
      segment.translation += error.translation().norm() / length;
      segment.rotation += rotation_angle(error.linear()) / length;
      ++segment.count;
    }
    result.translation += segment.translation;
    result.rotation += segment.rotation;
    result.count += segment.count;
    if (segment.count > 0) {
      segment.translation /= static_cast<double>(segment.count);
      segment.rotation /= static_cast<double>(segment.count);
    }
    result.segments.push_back(segment);
  }
  if (result.count == 0) {
    result.reason = "the true path is shorter than the shortest segment";
    return result;
  }
  result.translation /= static_cast<double>(result.count);
  result.rotation /= static_cast<double>(result.count);
  return result;
}

}  // namespace infuse::motion

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <tuple>
#include <utility>

#include "fusion/geometry/symmetric_eigen.hpp"
#include "fusion/motion/odometry_state.hpp"

namespace infuse::motion {
namespace {

using geometry::Matrix6;
using geometry::Vector6;

constexpr double kRotationScale = 10;  // m, at which rotations count as shifts (decision 17)
constexpr double kFreeSigma = 3;       // m: a direction known worse than this is free (decision 17)

/// Independent scalar measurements that have the information of a relative pose: rows of `A`, of
/// unit noise after whitening.
struct Directions {
  Matrix6 A = Matrix6::Zero();
  int count = 0;
};

/// Information of the planar part (rz, tx, ty), the rest being unknown.
Matrix6 planar_part(const Matrix6& information) {
  constexpr int kKept[] = {2, 3, 4}, kUnknown[] = {0, 1, 5};
  Eigen::Matrix3d kept, cross, unknown;
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) {
      kept(i, j) = information(kKept[i], kKept[j]);
      cross(i, j) = information(kKept[i], kUnknown[j]);
      unknown(i, j) = information(kUnknown[i], kUnknown[j]);
    }
  }
  const auto eigen = geometry::symmetric_eigen<3>(unknown);
  const double least = 1e-12 * std::max(eigen.values[2], 0.0);  // what is smaller carries nothing
  const Eigen::Vector3d inverse =
      (eigen.values.array() > least).select(eigen.values.array().inverse(), 0.0);
  const Eigen::Matrix3d across = cross * eigen.vectors;
  const Eigen::Matrix3d rest = kept - across * inverse.asDiagonal() * across.transpose();
  Matrix6 planar = Matrix6::Zero();
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) planar(kKept[i], kKept[j]) = 0.5 * (rest(i, j) + rest(j, i));
  }
  return planar;
}

/// Principal directions of the information, each with the noise that the options add.
Directions directions_of(const Matrix6& information, const OdometryOptions& options) {
  Vector6 scale;
  scale << Eigen::Vector3d::Constant(kRotationScale), Eigen::Vector3d::Ones();
  const Vector6 inverse = scale.cwiseInverse();
  const auto eigen =
      geometry::symmetric_eigen<6>(inverse.asDiagonal() * information * inverse.asDiagonal());
  Vector6 floor;
  floor << Eigen::Vector3d::Constant(kRotationScale * options.lidar_rotation_noise),
      Eigen::Vector3d::Constant(options.lidar_translation_noise);
  Directions directions;
  for (int i = 0; i < 6; ++i) {
    const double value = eigen.values[i];
    if (!(value > 1 / (kFreeSigma * kFreeSigma))) continue;
    const Vector6 direction = eigen.vectors.col(i);
    const double variance = 1 / value + direction.cwiseProduct(floor).squaredNorm();
    directions.A.row(directions.count++) =
        direction.cwiseProduct(scale).transpose() / std::sqrt(variance);
  }
  return directions;
}

/// How well the directions measure the speed, m/s, and whether they measure the rotation about z,
/// where nothing else is known of either.
std::pair<double, bool> measured_motion(const Directions& directions, double seconds,
                                        bool moves_forward) {
  constexpr double kMaxYawRateSigma = 0.1;  // rad/s (decision 17)
  Vector6 unknown;
  unknown << Eigen::Vector3d::Constant(kRotationScale / kFreeSigma),
      Eigen::Vector3d::Constant(1 / kFreeSigma);
  const Matrix6 information =
      directions.A.transpose() * directions.A + Matrix6(unknown.cwiseAbs2().asDiagonal());
  const Vector6 variance = information.llt().solve(Matrix6::Identity()).diagonal();
  const double shift = moves_forward ? variance[3] : std::max(variance[3], variance[4]);
  return {std::sqrt(shift) / seconds, std::sqrt(variance[2]) < kMaxYawRateSigma * seconds};
}

}  // namespace

void OdometryState::clear_clones() {
  clones_ = {};
  P_.bottomRows<kSize - kMotionSize>().setZero();
  P_.rightCols<kSize - kMotionSize>().setZero();
}

size_t OdometryState::find_clone(Stamp stamp) const {
  const auto at = std::find_if(clones_.begin(), clones_.end(),
                               [&](const Clone& clone) { return clone.stamp == stamp; });
  return static_cast<size_t>(at - clones_.begin());
}

void OdometryState::clone_pose(Stamp stamp) {
  const auto oldest =
      std::min_element(clones_.begin(), clones_.end(),
                       [](const Clone& a, const Clone& b) { return a.stamp < b.stamp; });
  *oldest = {stamp, T_odom_vehicle_};
  const int at = kMotionSize + 6 * static_cast<int>(oldest - clones_.begin());
  P_.middleRows<6>(at) = P_.topRows<6>().eval();
  P_.middleCols<6>(at) = P_.leftCols<6>().eval();
}

const Eigen::Isometry3d* OdometryState::cloned_pose(Stamp stamp) const {
  const size_t index = find_clone(stamp);
  return index < kMaxClones ? &clones_[index].T_odom_vehicle : nullptr;
}

Matrix6 OdometryState::cloned_covariance(Stamp stamp) const {
  const int at = kMotionSize + 6 * static_cast<int>(find_clone(stamp));
  return P_.block<6, 6>(at, at);
}

// With ξ the left perturbations of the poses, the measured motion is
// exp(Ad(T_from⁻¹)(ξ_to − ξ_from)) T̂_from_to, and the drift adds in proportion to the distance.
RelativePoseUpdate OdometryState::update_relative_pose(const RelativePose& pose, bool gated) {
  RelativePoseUpdate result;
  const size_t from = find_clone(pose.from), to = find_clone(pose.to);
  result.known = from < kMaxClones && to < kMaxClones && pose.from < pose.to &&
                 pose.T_from_to.matrix().allFinite() && pose.information.allFinite();
  if (!result.known) return result;
  const Eigen::Isometry3d T_from_odom = clones_[from].T_odom_vehicle.inverse();
  const Eigen::Isometry3d predicted = T_from_odom * clones_[to].T_odom_vehicle;
  const double distance = pose.T_from_to.translation().norm();
  result.error = geometry::log(pose.T_from_to * predicted.inverse());
  const Vector6 innovation = result.error - distance * x_.segment<6>(kLidarDrift);

  const Directions directions =
      directions_of(options_.planar ? planar_part(pose.information) : pose.information, options_);
  result.informative = directions.count > 0;
  constexpr double kMaxSpeedSigma = 1;  // m/s (decision 17)
  std::tie(result.speed_sigma, result.rotation_measured) =
      measured_motion(directions, to_seconds(pose.to - pose.from), options_.moves_forward);
  result.speed_measured = result.speed_sigma < kMaxSpeedSigma;
  if (!result.informative) return result;
  const int at_from = kMotionSize + 6 * static_cast<int>(from);
  const int at_to = kMotionSize + 6 * static_cast<int>(to);
  const Matrix6 by_pose = directions.A * geometry::adjoint(T_from_odom);
  Eigen::Matrix<double, 6, kSize> H = Eigen::Matrix<double, 6, kSize>::Zero();
  H.middleCols<6>(at_to) = by_pose;
  H.middleCols<6>(at_from) = -by_pose;
  H.middleCols<6>(kLidarDrift) = distance * directions.A;
  const Vector6 residual = directions.A * innovation;
  // Rows beyond `count` are zero: with unit noise they carry nothing.
  const Eigen::Matrix<double, kSize, 6> PHt = P_ * H.transpose();
  const Matrix6 S = H * PHt + Matrix6::Identity();
  const Eigen::LLT<Matrix6> solver(S);
  const double distance_squared = residual.dot(solver.solve(residual));
  // Four standard deviations.
  result.accepted = std::isfinite(distance_squared) &&
                    (!gated || distance_squared <= 16 + 2.2 * directions.count);
  if (!result.accepted) return result;

  // The gain of the motion since `from`.
  Eigen::Matrix<double, kSize, 6> gain = solver.solve(PHt.transpose()).transpose();
  const Matrix6 before = gain.middleRows<6>(at_from);
  gain.topRows<6>() -= before;
  for (size_t i = 0; i < kMaxClones; ++i) {
    auto rows = gain.middleRows<6>(kMotionSize + 6 * static_cast<int>(i));
    if (clones_[i].stamp > pose.from) {
      rows -= before;
    } else {
      rows.setZero();
    }
  }
  const Vector change = gain * residual;
  apply(change);
  const Matrix lost = gain * PHt.transpose();  // as in `update`, for any gain
  P_ += gain * S * gain.transpose() - lost - lost.transpose();
  P_ = (0.5 * (P_ + P_.transpose())).eval();
  recent_.setZero();
  result.change_at_to = change.segment<6>(at_to);
  result.change_at_now = change.head<6>();
  result.motion_covariance = P_.block<6, 6>(at_from, at_from) + P_.block<6, 6>(at_to, at_to) -
                             P_.block<6, 6>(at_from, at_to) - P_.block<6, 6>(at_to, at_from);
  return result;
}

// The rate, or the motion, was wrong by a constant since then: one direction of the state.
void OdometryState::release(int rate, double sigma, const Vector6& twist, Stamp since, Stamp now) {
  const Eigen::Isometry3d* T_odom_since = cloned_pose(since);
  if (T_odom_since == nullptr) return;
  const Vector6 moved = sigma * geometry::adjoint(*T_odom_since) * twist;
  Vector direction = Vector::Zero();
  if (rate != kPose) direction[rate] = sigma;
  direction.head<6>() = to_seconds(now - since) * moved;
  for (size_t i = 0; i < kMaxClones; ++i) {
    if (clones_[i].stamp <= since) continue;
    direction.segment<6>(kMotionSize + 6 * static_cast<int>(i)) =
        to_seconds(clones_[i].stamp - since) * moved;
  }
  P_ += direction * direction.transpose();
}

void OdometryState::release_speed(Stamp since, Stamp now) {
  constexpr double kSigma = 10;  // m/s (decision 17)
  release(kSpeed, kSigma, Vector6::Unit(3), since, now);
  if (options_.moves_forward) return;
  release(kLateralVelocity, kSigma, Vector6::Unit(4), since, now);
  if (!options_.planar) release(kVerticalVelocity, kSigma, Vector6::Unit(5), since, now);
}

// Where a vehicle pitches or rolls, about whichever of its points, the others move.
void OdometryState::release_rotation(Stamp since, Stamp now) {
  constexpr double kSigma = 0.3;  // rad/s (decision 17)
  for (int i = options_.planar ? 2 : 0; i < 3; ++i) {
    release(kAngularVelocity + i, kSigma, Vector6::Unit(i), since, now);
    if (!options_.planar) {
      release(kPose, kSigma * options_.wheelbase, Vector6::Unit(3 + i), since, now);
    }
  }
}

}  // namespace infuse::motion

#include "fusion/registration/pose_prior.hpp"

#include <Eigen/Cholesky>

namespace infuse::registration {
namespace {

using geometry::Matrix6;
using geometry::Vector6;

// Errors of a measured motion that are not in its covariance, as those of the times of its samples
// (decision 9).
constexpr double kPriorRotationNoise = 3e-4, kPriorTranslationNoise = 2e-2;  // rad, m

}  // namespace

// T_anchor_lidar = T_anchor_from T_from_to T_to_lidar: its left perturbation is Ad(T_anchor_from)
// times that of the motion.
PosePrior anchored_prior(const geometry::MotionBetween& motion,
                         const Eigen::Isometry3d& T_anchor_from,
                         const Eigen::Isometry3d& T_vehicle_lidar, double scale) {
  Matrix6 covariance = motion.covariance;
  covariance.diagonal().head<3>().array() += kPriorRotationNoise * kPriorRotationNoise;
  covariance.diagonal().tail<3>().array() += kPriorTranslationNoise * kPriorTranslationNoise;
  const Matrix6 to_motion = geometry::adjoint(T_anchor_from.inverse());
  return {T_anchor_from * motion.T_from_to * T_vehicle_lidar,
          scale * to_motion.transpose() * covariance.ldlt().solve(to_motion)};
}

Vector6 step_with_prior(const PoseSystem& system, const DeterminedDirections& determined,
                        const Eigen::Isometry3d& T_anchor_lidar, const PosePrior& prior) {
  const Vector6 to_prior = geometry::log(prior.T_anchor_lidar * T_anchor_lidar.inverse());
  const Matrix6 basis = determined.twist_from_scaled * determined.basis;
  Matrix6 seen = basis;
  seen.rightCols(6 - determined.count).setZero();
  const Matrix6 H = seen.transpose() * (system.planes + system.isotropic) * seen +
                    basis.transpose() * prior.information * basis;
  const Vector6 g =
      seen.transpose() * system.gradient + basis.transpose() * (prior.information * to_prior);
  return basis * H.ldlt().solve(g);
}

}  // namespace infuse::registration

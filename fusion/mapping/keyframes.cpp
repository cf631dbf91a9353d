#include "fusion/mapping/keyframes.hpp"

#include "drivers/measurement/rotation.hpp"

namespace infuse::mapping {
namespace {

/// Independent rotation and translation.
geometry::Matrix6 isotropic_covariance(double rotation, double translation) {
  geometry::Vector6 variance;
  variance.head<3>().setConstant(rotation * rotation);
  variance.tail<3>().setConstant(translation * translation);
  return variance.asDiagonal();
}

}  // namespace

std::optional<std::string> KeyframeOptions::invalid() const {
  if (!(distance > 0)) return "distance must be positive";
  if (!(rotation > 0)) return "rotation must be positive";
  if (!(rotation_drift > 0 && translation_drift > 0)) return "the drift must be positive";
  if (!(unmeasured_rotation > 0 && unmeasured_translation > 0)) {
    return "the uncertainty of what is not measured must be positive";
  }
  return std::nullopt;
}

bool KeyframePicker::is_due() const {
  const Eigen::Isometry3d T = last_.T_odom_vehicle.inverse() * T_odom_vehicle_;
  return T.translation().norm() >= options_.distance ||
         Eigen::AngleAxisd(T.linear()).angle() >= options_.rotation;
}

bool KeyframePicker::add(const SweepMotion& motion) {
  if (!started_) {
    if (!motion.measured) return false;
    started_ = true;
    last_ = {motion.stamp, T_odom_vehicle_, 0, geometry::Matrix6::Zero()};
    stamp_ = motion.stamp;
    return true;
  }
  const double seconds = to_seconds(motion.stamp - stamp_);
  const Eigen::Isometry3d T_last_before = last_.T_odom_vehicle.inverse() * T_odom_vehicle_;
  const Eigen::Isometry3d T_step =
      motion.measured ? motion.T_from_to : geometry::exp(velocity_ * seconds);
  T_odom_vehicle_ = T_odom_vehicle_ * T_step;
  T_odom_vehicle_.linear() = orthonormal(T_odom_vehicle_.linear());
  distance_driven_ += T_step.translation().norm();
  stamp_ = motion.stamp;
  since_last_ += geometry::transform_covariance(
      T_last_before, motion.measured
                         ? motion.covariance
                         : isotropic_covariance(options_.unmeasured_rotation * seconds,
                                                options_.unmeasured_translation * seconds));
  unregistered_ += motion.registered ? 0 : 1;
  unmeasured_ += motion.measured ? 0 : 1;
  if (!motion.measured) return false;
  if (seconds > 0) velocity_ = geometry::log(T_step) / seconds;
  if (!is_due()) return false;
  const double root = std::sqrt(distance_driven_ - last_.distance_driven);
  const geometry::Matrix6 drift =
      isotropic_covariance(options_.rotation_drift * root, options_.translation_drift * root);
  last_ = {motion.stamp, T_odom_vehicle_, distance_driven_, since_last_ + drift};
  since_last_.setZero();
  return true;
}

}  // namespace infuse::mapping

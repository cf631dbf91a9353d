#include "fusion/mapping/keyframes.hpp"

namespace infuse::mapping {
namespace {

/// Information of a step in directions that the geometry leaves free: 0.1 rad, 1 m.
geometry::Matrix6 prior_information() {
  geometry::Vector6 information;
  information << 100, 100, 100, 1, 1, 1;
  return information.asDiagonal();
}

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

geometry::Matrix6 KeyframePicker::covariance_since_last(
    const geometry::Matrix6& of_step, const Eigen::Isometry3d& T_last_before) const {
  // Each sweep is registered to the local map by itself, so only the last step's error counts.
  const double root = std::sqrt(way_ - last_.way);
  return bridged_ + geometry::transform_covariance(T_last_before, of_step) +
         isotropic_covariance(options_.rotation_drift * root, options_.translation_drift * root);
}

bool KeyframePicker::add(const registration::LidarOdometryResult& result) {
  if (!started_) {
    if (!result.usable()) return false;
    started_ = true;
    last_ = {result.stamp, T_odom_vehicle_, 0, geometry::Matrix6::Zero()};
    stamp_ = result.stamp;
    return true;
  }
  const double seconds = to_seconds(result.stamp - stamp_);
  const Eigen::Isometry3d T_before = T_odom_vehicle_;
  const Eigen::Isometry3d T_step =
      result.usable() ? result.motion.T_from_to : geometry::exp(velocity_ * seconds);
  T_odom_vehicle_ = T_before * T_step;
  T_odom_vehicle_.linear() =
      Eigen::Quaterniond(T_odom_vehicle_.linear()).normalized().toRotationMatrix();
  way_ += T_step.translation().norm();
  stamp_ = result.stamp;
  const Eigen::Isometry3d T_last_before = last_.T_odom_vehicle.inverse() * T_before;
  if (!result.usable()) {
    ++unmeasured_;
    bridged_ += geometry::transform_covariance(
        T_last_before, isotropic_covariance(options_.unmeasured_rotation * seconds,
                                            options_.unmeasured_translation * seconds));
    return false;
  }
  if (seconds > 0) velocity_ = geometry::log(T_step) / seconds;
  if (!is_due()) return false;
  const geometry::Matrix6 of_step = (result.motion.information + prior_information()).inverse();
  last_ = {result.stamp, T_odom_vehicle_, way_, covariance_since_last(of_step, T_last_before)};
  bridged_.setZero();
  return true;
}

}  // namespace infuse::mapping

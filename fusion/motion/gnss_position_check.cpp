#include "fusion/motion/gnss_position_check.hpp"

#include <Eigen/Geometry>
#include <cmath>

namespace infuse::motion {
namespace {

constexpr double kEarthRadius = 6.371e6;     // m, mean of WGS 84
constexpr double kPositionTolerance = 10;    // m, of good fixes (decision 17)
constexpr double kRelativeTolerance = 0.01;  // of the distance, of odometry (decision 17)
constexpr double kSureHeading = 0.05;        // rad (decision 17)

}  // namespace

std::optional<bool> GnssPositionCheck::check(const GnssFix& fix, const Eigen::Vector3d& position,
                                             const EstimatedParameter& east_heading) {
  if (!std::isfinite(fix.latitude) || !std::isfinite(fix.longitude)) return std::nullopt;
  const Believed here{fix.stamp, fix.latitude, fix.longitude, position.head<2>()};
  if (!believed_ || fix.stamp < believed_->stamp || fix.stamp - believed_->stamp > kMaxGnssDoubt) {
    believed_ = here;
    return std::nullopt;
  }
  const Eigen::Vector2d measured =
      kEarthRadius *
      Eigen::Vector2d(std::cos(fix.latitude) * (fix.longitude - believed_->longitude),
                      fix.latitude - believed_->latitude);
  const Eigen::Vector2d driven = here.position - believed_->position;
  const bool directed = east_heading.sigma < kSureHeading;
  const double error = directed
                           ? (measured - Eigen::Rotation2Dd(east_heading.value) * driven).norm()
                           : std::abs(measured.norm() - driven.norm());
  const double tolerance =
      kPositionTolerance * (fix.hdop > 1 ? fix.hdop : 1.0) +
      (kRelativeTolerance + (directed ? east_heading.sigma : 0.0)) * driven.norm();
  const bool agrees = error <= tolerance;
  if (agrees) believed_ = here;
  return agrees;
}

}  // namespace infuse::motion

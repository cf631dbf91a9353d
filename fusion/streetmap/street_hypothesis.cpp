#include "fusion/streetmap/street_hypothesis.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

namespace infuse::streetmap {
namespace {

constexpr double kStartYawSigma = 0.12;  // rad (decision 17)

using Vector5 = Eigen::Matrix<double, 5, 1>;

}  // namespace

std::optional<std::string> GlobalStartOptions::invalid() const {
  if (!(spacing >= 1 && spacing <= 20 && step > 0.1 && step <= 10 && independent_length >= step)) {
    return "global_start: spacing must be between 1 and 20 m, step at most 10 m and the "
           "independent length";
  }
  if (max_hypotheses < 1000 || max_hypotheses > 1000000) {
    return "global_start: max_hypotheses must be between 1000 and 1000000";
  }
  if (!(max_spacing >= spacing && max_spacing <= 20) || max_seeded < 1000 ||
      max_seeded > 100000000) {
    return "global_start: max_spacing must be between the spacing and 20 m, max_seeded between "
           "1000 and 100000000";
  }
  if (!(street_sigma > 0 && max_misfit > 0 && max_log_odds > 0 && max_sigma > 0)) {
    return "global_start: sigmas and limits must be positive";
  }
  if (!(believed_radius >= 0 && believed_log_odds >= 0 && believed_log_odds < max_log_odds)) {
    return "global_start: believed_radius must be at least 0, believed_log_odds between 0 and "
           "max_log_odds";
  }
  if (!(max_elsewhere > 0 && max_elsewhere < 1 && max_mean_misfit > 0 && min_alone >= 0)) {
    return "global_start: max_elsewhere must be between 0 and 1, max_mean_misfit be positive";
  }
  if (!(turn_worth >= 0 && turn_worth <= 1000) || max_witnessed < 0 || max_witnessed > 1000) {
    return "global_start: turn_worth and max_witnessed must be between 0 and 1000";
  }
  return std::nullopt;
}

StreetHypothesis begin_hypothesis(const PlanarPose& pose, double spacing,
                                  const GlobalStartOptions& options) {
  StreetHypothesis hypothesis;
  hypothesis.pose = pose;
  const double place = spacing * spacing / 2, yaw = kStartYawSigma * kStartYawSigma;
  hypothesis.covariance.diagonal() << place, place, yaw, options.scale_sigma * options.scale_sigma,
      options.yaw_rate_sigma * options.yaw_rate_sigma;
  return hypothesis;
}

void predict(StreetHypothesis& hypothesis, const PlanarPose& motion,
             const Eigen::Matrix3d& covariance, double seconds) {
  PlanarPose& pose = hypothesis.pose;
  Eigen::Matrix3d R = Eigen::Matrix3d::Identity();
  R.topLeftCorner<2, 2>() = Eigen::Rotation2Dd(pose.yaw).toRotationMatrix();
  const Eigen::Vector2d measured = R.topLeftCorner<2, 2>() * Eigen::Vector2d(motion.x, motion.y);
  const Eigen::Vector2d moved = hypothesis.scale * measured;
  StreetHypothesis::Matrix F = StreetHypothesis::Matrix::Identity();
  F(0, 2) = -moved.y();
  F(1, 2) = moved.x();
  F(0, 3) = measured.x();
  F(1, 3) = measured.y();
  F(2, 4) = seconds;
  pose.x += moved.x();
  pose.y += moved.y();
  pose.yaw = wrap_angle(pose.yaw + motion.yaw + hypothesis.yaw_rate_bias * seconds);
  hypothesis.covariance = F * hypothesis.covariance * F.transpose();
  hypothesis.covariance.topLeftCorner<3, 3>() += R * covariance * R.transpose();
}

void compare(StreetHypothesis& hypothesis, const StreetGrid& grid, double novelty,
             const GlobalStartOptions& options) {
  PlanarPose& pose = hypothesis.pose;
  const auto street = grid.across(pose, hypothesis.level);
  if (!street) {
    hypothesis.log_weight -= novelty * options.max_misfit;
    hypothesis.misfit += novelty * options.max_misfit;
    return;
  }
  Vector5 h = Vector5::Zero();  // the position across the heading, by the state
  h[0] = -std::sin(pose.yaw);
  h[1] = std::cos(pose.yaw);
  const Vector5 Ph = hypothesis.covariance * h;
  const double variance = h.dot(Ph), edge = options.street_sigma * options.street_sigma;
  // A position on the street is uniform across it. Its variance is that of independent evidence.
  const double width = street->half_width();
  const double noise = (width * width / 3 + edge) / novelty;
  const double innovation = street->centre(), outside = street->distance();
  hypothesis.misfit +=
      novelty * std::min(options.max_misfit, outside * outside / (edge + variance));
  hypothesis.log_weight -=
      std::min(novelty * options.max_misfit, innovation * innovation / (2 * (variance + noise)));
  const Vector5 gain = Ph / (variance + noise);
  const Vector5 change = gain * innovation;
  pose.x += change[0];
  pose.y += change[1];
  pose.yaw = wrap_angle(pose.yaw + change[2]);
  hypothesis.scale += change[3];
  hypothesis.yaw_rate_bias += change[4];
  hypothesis.covariance -= gain * Ph.transpose();
}

void advance(StreetHypothesis& hypothesis, const StreetGrid& grid, const DriveStretch& stretch,
             const GlobalStartOptions& options) {
  const Eigen::Vector2d before(hypothesis.pose.x, hypothesis.pose.y);
  predict(hypothesis, stretch.motion, stretch.covariance, stretch.seconds);
  hypothesis.level =
      grid.level_after(hypothesis.level, before, {hypothesis.pose.x, hypothesis.pose.y});
  compare(hypothesis, grid, std::min(stretch.length / options.independent_length, 1.0), options);
}

}  // namespace infuse::streetmap

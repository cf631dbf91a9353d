#include "fusion/monitoring/dependence_profile.hpp"

#include "fusion/monitoring/reduced_image.hpp"

namespace infuse::monitoring {

std::optional<std::string> ProfileOptions::invalid() const {
  if (!(rotation > 0 && rotation < 0.5) || !(translation > 0)) {
    return "rotation must be between 0 and 0.5 rad, translation positive";
  }
  return evaluation.invalid();
}

ProfileSampler::ProfileSampler(const CameraIntrinsics& camera, const ProfileOptions& options)
    : options_(options),
      camera_(camera),
      step_(reduction_step(camera, options.evaluation.reduced_focal_length)),
      dependence_(options.evaluation.weights) {}

const char* ProfileSampler::prepare(const CameraFrame& grey, const SweepView& sweep,
                                    const Eigen::Isometry3d& T_camera_lidar) {
  if (!matches_intrinsics(grey, camera_.intrinsics())) {
    return "the image does not match the intrinsics";
  }
  features::find_ring_directions(camera_, T_camera_lidar, step_, rings_);
  image_.build(grey, step_, rings_);
  points_.select(sweep, camera_, T_camera_lidar, options_.evaluation.max_points);
  return points_.size() < options_.evaluation.min_points ? "too few returns in view" : "";
}

DependenceProfile ProfileSampler::sample(const Eigen::Isometry3d& T_camera_lidar) {
  DependenceProfile profile;
  const double middle =
      dependence_.evaluate(T_camera_lidar, image_.compared().fine, points_.compared(), camera_);
  for (size_t axis = 0; axis < DependenceProfile::kAxes; ++axis) {
    const double half_width = axis < 3 ? options_.rotation : options_.translation;
    for (size_t k = 0; k < DependenceProfile::kSamples; ++k) {
      if (k == DependenceProfile::kSamples / 2) {
        profile.nats[axis][k] = middle;
        continue;
      }
      const geometry::Vector6 moved = half_width * DependenceProfile::part_of(k) *
                                      geometry::Vector6::Unit(static_cast<Eigen::Index>(axis));
      profile.nats[axis][k] =
          dependence_.evaluate(geometry::exp(moved) * T_camera_lidar, image_.compared().fine,
                               points_.compared(), camera_);
    }
  }
  return profile;
}

}  // namespace infuse::monitoring

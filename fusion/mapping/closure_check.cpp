#include "fusion/mapping/closure_check.hpp"

#include "fusion/registration/global_guess.hpp"
#include "fusion/registration/refine.hpp"

namespace infuse::mapping {
namespace {

/// Why registration from the other side contradicts, or an empty text.
std::string reverse_contradiction(const PreparedSubmap& target, const PreparedSubmap& source,
                                  const Eigen::Isometry3d& T_target_source,
                                  const ClosureCheckOptions& options) {
  const registration::RegistrationResult back =
      registration::gicp(source.cloud, target.cloud.cloud, T_target_source.inverse());
  if (!back.usable()) return std::string("from the other side: ") + back.reason;
  const Eigen::Isometry3d difference = T_target_source * back.T_target_source;
  if (difference.translation().norm() > options.max_difference ||
      Eigen::AngleAxisd(difference.linear()).angle() > options.max_difference_rotation) {
    return "the registration from the other side finds another pose";
  }
  return "";
}

}  // namespace

std::optional<std::string> ClosureCheckOptions::invalid() const {
  if (!(voxel_size > 0 && voxel_size < 10)) return "voxel_size must be between 0 and 10 m";
  for (const double share : {min_inliers, min_agreement, min_overlap}) {
    if (!(share >= 0 && share < 1)) return "shares must be between 0 and 1";
  }
  if (!(max_difference > 0 && max_difference_rotation > 0)) return "differences must be positive";
  if (!(rotation_noise > 0 && translation_noise > 0)) return "the noise must be positive";
  return std::nullopt;
}

PreparedSubmap::PreparedSubmap(const Submap& submap, const ClosureCheckOptions& options)
    : cloud(registration::prepare_cloud(submap.points(),
                                        registration::sweep_options(options.voxel_size))),
      view(cloud) {}

ClosureCheck check_closure(const PreparedSubmap& target, const PreparedSubmap& source,
                           const std::optional<Eigen::Isometry3d>& T_target_source_guess,
                           const ClosureCheckOptions& options) {
  ClosureCheck check;
  registration::RegistrationResult& result = check.registration;
  const registration::PointCloud& points = source.cloud.cloud;
  result = T_target_source_guess
               ? registration::refine(target.cloud, points, *T_target_source_guess)
               : registration::find_global_guess(target.cloud.cloud.points(), points.points());
  if (result.points > 0) {
    check.inliers = static_cast<double>(result.inliers) / static_cast<double>(result.points);
  }
  if (!result.usable()) {
    check.reason = result.reason;
    return check;
  }
  const registration::ViewAgreement views = registration::agreement(
      target.view, target.cloud.cloud, source.view, points, result.T_target_source);
  check.agreement = views.share();
  check.overlap = views.overlap();
  if (result.free_directions > 0) {
    check.reason = "the geometry leaves free: " + result.free_directions_text();
  } else if (check.inliers < options.min_inliers || check.overlap < options.min_overlap) {
    check.reason = "the places have too little in common";
  } else if (check.agreement < options.min_agreement) {
    check.reason = "the beams of one place pass through what the other shows";
  } else {
    check.reason = reverse_contradiction(target, source, result.T_target_source, options);
  }
  geometry::Vector6 noise;
  noise.head<3>().setConstant(options.rotation_noise * options.rotation_noise);
  noise.tail<3>().setConstant(options.translation_noise * options.translation_noise);
  // Rotations are about the source's place, not the target's.
  Eigen::Isometry3d T_target_place = Eigen::Isometry3d::Identity();
  T_target_place.translation() = result.T_target_source.translation();
  result.covariance += geometry::transform_covariance(T_target_place, noise.asDiagonal());
  return check;
}

}  // namespace infuse::mapping

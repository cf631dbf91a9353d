#include "fusion/registration/registration.hpp"

namespace infuse::registration {
namespace {

constexpr double kIdentical = 1e-5;  // m, single precision at 100 m: clouds are copies

}  // namespace

std::optional<std::string> StepLimits::invalid() const {
  if (max_iterations < 1) return "max_iterations must be at least 1";
  if (!(rotation_tolerance > 0 && translation_tolerance > 0)) return "tolerances must be above 0";
  if (!(min_plane_fraction >= 0 && min_plane_fraction <= 1))
    return "min_plane_fraction must be between 0 and 1";
  return std::nullopt;
}

std::optional<std::string> RegistrationOptions::invalid() const {
  if (!(max_correspondence_distance > 0)) return "max_correspondence_distance must be above 0 m";
  if (!(min_inlier_fraction >= 0 && min_inlier_fraction <= 1))
    return "min_inlier_fraction must be between 0 and 1";
  return steps.invalid();
}

const char* missing(const PreparedCloud& target, const PointCloud& source,
                    const Eigen::Isometry3d& guess, const RegistrationOptions& options) {
  if (target.search.size() == 0) return "the target has no finite points";
  if (source.size() == 0) return "the source has no finite points";
  if (target.search.size() < options.min_inliers) return "the target has too few points";
  if (source.size() < options.min_inliers) return "the source has too few points";
  if (!guess.matrix().allFinite()) return "the guess is not finite";
  return "";
}

const char* doubt(const RegistrationResult& result) {
  if (!result.converged) return "the registration did not converge";
  if (result.free_directions == 6) return "the planes determine no direction";
  if (result.rms < kIdentical) return "the clouds are identical: they do not show the accuracy";
  return "";
}

}  // namespace infuse::registration

#pragma once

#include <optional>
#include <string>

#include "fusion/mapping/submap.hpp"
#include "fusion/registration/view_agreement.hpp"

namespace infuse::mapping {

/// Settings of the verification of a loop closure.
struct ClosureCheckOptions {
  double voxel_size = 0.4;   ///< m, of the clouds that are registered
  double min_inliers = 0.5;  ///< share of the points with a counterpart
  double min_agreement = registration::kMinPlaceAgreement;  ///< share of what each place can judge
                                                            ///< of the other and supports
  double min_overlap = registration::kMinPlaceOverlap;  ///< share of all points that are supported
  double max_difference = 0.15;           ///< m, between both directions of the registration, …
  double max_difference_rotation = 5e-3;  ///< rad
  /// Standard deviations that are added to what the registration states: of the submaps' own shape.
  /// With them the squared error over the covariance is 0.5 to 0.6 a degree of freedom on towns of
  /// seeds 31, 32 and 34 (closures against the truth, 16 and 32 beams; decision 17).
  double rotation_noise = 1e-3;     ///< rad
  double translation_noise = 0.01;  ///< m

  /// What is wrong with the settings, or nothing.
  std::optional<std::string> invalid() const;
};

/// A submap that is prepared for registration. Does not move: `view` refers to `cloud`.
struct PreparedSubmap {
  PreparedSubmap(const Submap& submap, const ClosureCheckOptions& options);
  PreparedSubmap(const PreparedSubmap&) = delete;
  PreparedSubmap& operator=(const PreparedSubmap&) = delete;

  registration::PreparedCloud cloud;
  registration::ViewOfScan view;
};

/// What a verification found.
struct ClosureCheck {
  registration::RegistrationResult registration;  ///< covariance with the noise of the options
  double inliers = 0;                             ///< share of the source's points
  double agreement = 0;                           ///< `ViewAgreement::share`
  double overlap = 0;                             ///< `ViewAgreement::overlap`
  std::string reason;                             ///< why it is not a closure; empty if it is

  bool usable() const { return reason.empty(); }
};

/// Registers two places (P 4.2, generalized ICP) from a guess that is right within 2 m, or from
/// none, and accepts the pose if the registration from the other side finds the same, the geometry
/// leaves no direction free, and nothing lies where a beam of the other place passed.
/// `options.invalid()` must be empty.
ClosureCheck check_closure(const PreparedSubmap& target, const PreparedSubmap& source,
                           const std::optional<Eigen::Isometry3d>& T_target_source_guess,
                           const ClosureCheckOptions& options = {});

}  // namespace infuse::mapping

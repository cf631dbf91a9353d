#pragma once

#include <optional>
#include <string>
#include <vector>

#include "fusion/mapping/closure_search.hpp"

namespace infuse::mapping {

/// Settings of the agreement of closures between two drives.
struct AgreementOptions {
  size_t min_closures = 3;  ///< that must agree, of different places
  double widening = 3;      ///< of the standard deviations: what registration states is narrow
  double max_rival = 0.5;   ///< closures that agree on something else, as a share of those

  /// What is wrong with the settings, or nothing.
  std::optional<std::string> invalid() const;
};

/// Motion between two keyframes of one drive by odometry, and its covariance: left perturbation in
/// the vehicle frame at `from`, which may be the later one.
struct OdometryBetween {
  Eigen::Isometry3d T_from_to = Eigen::Isometry3d::Identity();
  geometry::Matrix6 covariance = geometry::Matrix6::Zero();
};
OdometryBetween odometry_between(const std::vector<Keyframe>& keyframes, size_t from, size_t to);

/// Returns which of the accepted closures from one drive to another agree with each other, by their
/// index, in order of `to`: the cycle of any of them, the one that most agree with, and the
/// odometry of both drives closes but for chance (χ² below its 99.9 % quantile). Empty if too few
/// agree, or if others agree on something else. Every `from` lies before `first`, every `to` does
/// not; `first_keyframes` are those of all drives. `options.invalid()` must be empty.
std::vector<size_t> find_agreeing(const std::vector<Keyframe>& keyframes,
                                  const std::vector<size_t>& first_keyframes,
                                  const std::vector<Closure>& closures,
                                  const AgreementOptions& options = {});

/// By what drive `drive` joins those before it, or nothing: all closures that lead straight to
/// them, or else one that is composed of closures through later drives and of the odometry between.
/// `first_keyframes` are those of all drives, `links` true closures between any of them.
std::optional<DriveJoin> join_by_links(const std::vector<Keyframe>& keyframes,
                                       const std::vector<size_t>& first_keyframes,
                                       const std::vector<Closure>& links, size_t drive);

/// Whether each drive is `drive` or one that `links` connect with it without those before it.
std::vector<bool> find_linked_drives(const std::vector<Keyframe>& keyframes,
                                     const std::vector<size_t>& first_keyframes,
                                     const std::vector<Closure>& links, size_t drive);

}  // namespace infuse::mapping

#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "drivers/measurement/error.hpp"
#include "fusion/mapping/keyframes.hpp"

namespace infuse::mapping {

/// Settings of the search for loop closures.
struct ClosureSearchOptions {
  double min_distance_driven = 40;  ///< m driven between two keyframes of a closure of one drive
  double max_distance = 6;          ///< m between them
  double spacing = 4;               ///< m driven after a closure until the next one is sought
  double sigmas = 3;  ///< of the stated uncertainty, within which a closure is sought: 99.7 % of a
                      ///< Gaussian's errors
  double max_search = 60;  ///< m; limit of what the uncertainty adds
  double max_guess_error =
      1;  ///< m, standard deviation; beyond it the registration begins without a guess …
  double search_spacing = 10;  ///< m driven; … and no more often than this

  /// What is wrong with the settings, or nothing.
  std::optional<std::string> invalid() const;
};

/// A loop closure, accepted or not.
struct Closure {
  size_t from = 0, to = 0;  ///< indices of keyframes, from < to
  bool guessed = true;      ///< where it is sought is certain enough for a registration
  Eigen::Isometry3d T_from_to = Eigen::Isometry3d::Identity();   ///< the motion
  geometry::Matrix6 covariance = geometry::Matrix6::Identity();  ///< left perturbation at `from`
  double agreement = 0, overlap = 0;  ///< shares of supported points, see `ViewAgreement`
  std::string reason;                 ///< why it is rejected; empty if it is accepted

  /// True if it is accepted.
  bool accepted() const { return reason.empty(); }
};

/// Poses that are known from elsewhere, such as GNSS.
struct KnownPoses {
  std::vector<Eigen::Isometry3d> T_map_vehicle;  ///< by keyframe
  double sigma = 0;                              ///< m, of their positions
};

/// A further drive among the keyframes, and where it joins those before it.
struct DriveJoin {
  size_t first = 0;               ///< its first keyframe; the drive before ends there
  std::vector<Closure> closures;  ///< that agree, in order of `to`; from < first <= to; not empty
};

/// Verifies a closure of which `from`, `to`, `guessed` and the guess `T_from_to` are given; fills
/// the rest.
using VerifyClosure = std::function<Result<void>(Closure&)>;

/// Seeks closures along the drives: of every keyframe the nearest one that was passed before, where
/// the uncertainty of the odometry since (or of the known poses) lets them be within
/// `max_distance`. A closure that was found, or by which a drive joins the others, corrects where
/// the next ones are sought, and so do the `earlier` ones, which are in order of `to` and are not
/// returned; none is sought beside them unless their `from` has no cloud. One that was verified and
/// contradicts that uncertainty is rejected.
/// `options.invalid()` must be empty.
Result<std::vector<Closure>> search_closures(const std::vector<Keyframe>& keyframes,
                                             const std::vector<DriveJoin>& joins,
                                             const std::vector<Closure>& earlier,
                                             const std::optional<KnownPoses>& known,
                                             const ClosureSearchOptions& options,
                                             const VerifyClosure& verify);

}  // namespace infuse::mapping

#pragma once

#include <optional>
#include <span>
#include <string>
#include <vector>

#include "fusion/calibration/image_pyramid.hpp"
#include "fusion/calibration/maximize.hpp"
#include "fusion/calibration/objective.hpp"

namespace infuse::calibration {

/// Level of the coarse-to-fine search.
struct Level {
  double sigma = 1.5;  ///< px, blur of the image features, see `ImageBlur`
  size_t points = 0;   ///< maximum number of points; 0: all in view
  int passes = 1;      ///< number of ascents, each with the points in view where the last one ended
  double tolerance = 2e-3;  ///< MaximizeOptions::tolerance
  double prior_weight = 0;  ///< share of the measure that is subtracted at one standard deviation
                            ///< from the prior position; 0: no prior
  int survivors = 1;        ///< of coarse levels: maximum number of different maxima that go on

  /// What is wrong with the settings, or nothing.
  std::optional<std::string> invalid() const;
};

/// Search for a pose through levels of blur; shared by all initial poses.
class CoarseToFine {
 public:
  /// All arguments but the options must outlive this. `prior_position` is the position of the
  /// reference camera in the lidar frame, with a standard deviation of `prior_position_sigma`
  /// metres: levels with a `prior_weight` stay near it.
  CoarseToFine(std::span<const Scene> scenes, std::span<const RigCamera> cameras,
               std::span<const TermOptions> terms, ImagePyramid& images,
               const VisibilityOptions& visibility, const MaximizeOptions& maximize,
               const Eigen::Vector3d& prior_position, double prior_position_sigma);

  /// Ascends through all levels in order; returns early once a stop is requested.
  Maximum ascend(const Eigen::Isometry3d& initial_pose, std::span<const Level> levels);

  /// Returns the points of a level: in view under a pose.
  VisiblePoints visible_points(const Eigen::Isometry3d& T_refcam_lidar, size_t max_points) const;

  /// Returns the objective over `points`, which must outlive it, with images blurred by `sigma` px,
  /// see `ImageBlur`.
  Objective make_objective(const VisiblePoints& points, double sigma);

  /// Number of evaluations of the objective so far.
  int evaluations() const { return evaluations_; }

 private:
  Maximum ascend_once(const Eigen::Isometry3d& initial_pose, const Level& level);

  std::span<const Scene> scenes_;
  std::span<const RigCamera> cameras_;
  std::span<const TermOptions> terms_;
  ImagePyramid& images_;
  VisibilityOptions visibility_;
  MaximizeOptions maximize_;
  Eigen::Vector3d prior_position_;
  double prior_position_sigma_;
  int evaluations_ = 0;
};

}  // namespace infuse::calibration

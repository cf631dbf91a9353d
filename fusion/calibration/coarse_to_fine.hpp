#pragma once

#include <optional>
#include <span>
#include <string>
#include <vector>

#include "fusion/calibration/image_pyramid.hpp"
#include "fusion/calibration/maximize.hpp"
#include "fusion/calibration/objective.hpp"

namespace infuse::calibration {

/// One step of the coarse-to-fine search.
struct Level {
  double sigma = 1.5;  ///< px, blur of the image features
  size_t points = 0;   ///< how many points take part at most; 0: all in view
  int passes = 1;      ///< searches, each with the points chosen anew from where the last ended
  double tolerance = 2e-3;  ///< MaximizeOptions::tolerance
  double prior_weight = 0;  ///< share of the measure that is taken off where the head stands one
                            ///< standard deviation from where it is known to; 0: none
  int survivors = 1;        ///< of coarse levels: how many climbs go on to the next

  /// What is wrong with the settings, or nothing.
  std::optional<std::string> invalid() const;
};

/// The search for a calibration through levels of blur, and what its starts share.
class CoarseToFine {
 public:
  /// All arguments but the options must outlive this. `known` is where the head stands in the lidar
  /// frame, within `known_to` metres (one standard deviation): levels with an anchor stay near it.
  CoarseToFine(std::span<const Scene> scenes, std::span<const RigCamera> cameras,
               std::span<const TermOptions> terms, ImagePyramid& images,
               const VisibilityOptions& visibility, const MaximizeOptions& maximize,
               const Eigen::Vector3d& prior_position, double prior_position_sigma);

  /// Up all levels, in order; no further once a stop is requested.
  Maximum ascend(const Eigen::Isometry3d& start, std::span<const Level> levels);

  /// The points of a level, in view under a pose.
  VisiblePoints visible_points(const Eigen::Isometry3d& T_head_lidar, size_t max_points) const;

  /// The measure over `points`, which must outlive it, with images blurred by `sigma` pixels.
  Objective make_objective(const VisiblePoints& points, double sigma);

  /// Evaluations of the measure so far.
  int evaluations() const { return evaluations_; }

 private:
  Maximum ascend_once(const Eigen::Isometry3d& start, const Level& level);

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

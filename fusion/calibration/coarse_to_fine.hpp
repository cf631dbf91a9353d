#pragma once

#include <map>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "fusion/calibration/maximize.hpp"
#include "fusion/calibration/objective.hpp"

namespace infuse::calibration {

/// One step of the coarse-to-fine search.
struct Level {
  double sigma = 1.5;  ///< px, blur of the image features
  size_t points = 0;   ///< how many points take part at most; 0: all in view
  int passes = 1;      ///< searches, each with the points chosen anew from where the last ended
  double tolerance = 2e-3;  ///< MaximizeOptions::tolerance
  bool anchored = false;    ///< the translation is held near the start's: strong blur hides it

  /// What is wrong with the settings, or nothing.
  std::optional<std::string> invalid() const;
};

/// The search for a calibration through levels, and what its starts share: scenes, cameras and the
/// blurred images of every level.
class CoarseToFine {
 public:
  /// All arguments but `terms` must outlive this. `known` is where the translation is known to be,
  /// within `known_to` metres (one standard deviation): anchored levels stay near it.
  CoarseToFine(std::span<const Scene> scenes, std::span<const RigCamera> cameras,
               std::vector<TermOptions> terms, const VisibilityOptions& visibility,
               const MaximizeOptions& maximize, const Eigen::Vector3d& known, double known_to);

  /// Up all levels, in order.
  Maximum climb(const Eigen::Isometry3d& start, std::span<const Level> levels);

  /// The better of two by the measure, on the points in view under both.
  const Eigen::Isometry3d& better(const Eigen::Isometry3d& a, const Eigen::Isometry3d& b,
                                  const Level& level);

  /// The points of a level, in view under all poses.
  VisiblePoints visible(std::span<const Eigen::Isometry3d> poses, size_t most) const;

  /// The measure over `points`, which must outlive it, with images blurred by `sigma` pixels.
  Objective objective(const VisiblePoints& points, double sigma);

  /// Evaluations of the measure so far.
  int evaluations() const { return evaluations_; }

 private:
  const BlurredImages& images(double sigma);
  Maximum climb_once(const Eigen::Isometry3d& start, const Level& level);

  std::span<const Scene> scenes_;
  std::span<const RigCamera> cameras_;
  std::vector<TermOptions> terms_;
  VisibilityOptions visibility_;
  MaximizeOptions maximize_;
  Eigen::Vector3d known_;
  double known_to_;
  std::map<double, BlurredImages> images_;  ///< by sigma
  int evaluations_ = 0;
};

}  // namespace infuse::calibration

#pragma once

#include <Eigen/Geometry>
#include <optional>
#include <stop_token>
#include <string>

#include "fusion/calibration/ascent.hpp"
#include "fusion/calibration/objective.hpp"

namespace infuse::calibration {

/// Method of local optimisation.
enum class Optimizer {
  kBfgs,     ///< quasi-Newton on analytic gradients, I 4.2.3
  kSimplex,  ///< Nelder–Mead, without gradients
};

/// Prior of the reference camera's position: ½ weight |c − centre|² is subtracted from the measure,
/// c the camera's origin in the lidar frame. For coarse levels, whose blurred images hardly
/// determine the position.
struct PositionPrior {
  Eigen::Vector3d centre = Eigen::Vector3d::Zero();  ///< m, lidar frame
  double weight = 0;                                 ///< the measure's unit per m²; 0: none
};

/// Rotations (rad) and translations (m) that have effects of like size; the maximum steps.
inline constexpr double kRotationScale = 0.01, kTranslationScale = 0.1;

/// Reason of a result that was stopped.
inline constexpr const char* kCancelled = "cancelled";

/// Settings of a local optimisation.
struct MaximizeOptions {
  Optimizer optimizer = Optimizer::kBfgs;
  int max_iterations =
      AscentOptions{}.max_iterations;            ///< of BFGS; the simplex has ten times as many
  double tolerance = AscentOptions{}.tolerance;  ///< in `kRotationScale` and `kTranslationScale`

  PositionPrior position_prior;
  std::stop_token stop;  ///< ends the search early, with the reason `kCancelled`

  /// What is wrong with the settings, or nothing.
  std::optional<std::string> invalid() const;
};

/// Result of a local optimisation.
struct Maximum {
  Eigen::Isometry3d T_refcam_lidar = Eigen::Isometry3d::Identity();
  double value = 0;
  const char* reason = "";  ///< static text: why it is not a maximum; empty if it is

  bool usable() const { return *reason == '\0'; }
};

/// Finds the nearest maximum from an initial pose. The value at the result is never smaller than
/// there.
Maximum maximize(Objective& objective, const Eigen::Isometry3d& initial_pose,
                 const MaximizeOptions& options);

}  // namespace infuse::calibration

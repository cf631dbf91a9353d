#pragma once

#include <Eigen/Geometry>
#include <optional>
#include <stop_token>
#include <string>

#include "fusion/calibration/objective.hpp"

namespace infuse::calibration {

/// How a maximum is looked for.
enum class Optimizer {
  kBfgs,     ///< quasi-Newton on analytic gradients, I 4.2.3
  kSimplex,  ///< Nelder–Mead, without gradients
};

/// Holds the head near where it is known to stand: ½ weight |c − centre|² is taken off the measure,
/// c the head's origin in the lidar frame. For coarse levels, whose blurred images hardly tell
/// where the camera stands.
struct PositionPrior {
  Eigen::Vector3d centre = Eigen::Vector3d::Zero();  ///< m, lidar frame
  double weight = 0;                                 ///< the measure's unit per m²; 0: none
};

/// The reason of what was asked to stop.
inline constexpr const char* kCancelled = "cancelled";

/// Settings of a search.
struct MaximizeOptions {
  Optimizer optimizer = Optimizer::kBfgs;
  int max_iterations = 60;         ///< of BFGS; the simplex has ten times as many
  double rotation_scale = 0.01;    ///< rad; a step of this and
  double translation_scale = 0.1;  ///< m; a step of this are taken to matter alike, and are the
                                   ///< longest; 0: translation stays as it is
  double tolerance = 1e-4;         ///< in these scales: smaller steps end the search

  PositionPrior position_prior;
  std::stop_token stop;  ///< ends the search soon, with `kCancelled` for a reason

  /// What is wrong with the settings, or nothing.
  std::optional<std::string> invalid() const;
};

/// Where a search ended.
struct Maximum {
  Eigen::Isometry3d T_refcam_lidar = Eigen::Isometry3d::Identity();
  double value = 0;
  const char* reason = "";  ///< static text: why it is no maximum; empty when it is

  bool usable() const { return *reason == '\0'; }
};

/// Looks for the next maximum from a start. The value at the result is never below the start's.
Maximum maximize(Objective& objective, const Eigen::Isometry3d& start,
                 const MaximizeOptions& options);

}  // namespace infuse::calibration

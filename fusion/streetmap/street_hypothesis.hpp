#pragma once

#include <Eigen/Core>
#include <optional>
#include <string>

#include "fusion/streetmap/planar_pose.hpp"
#include "fusion/streetmap/street_grid.hpp"

namespace infuse::streetmap {

/// Settings of `GlobalStart`.
struct GlobalStartOptions {
  bool enabled = true;            ///< search all streets while the place is not sure
  double spacing = 4;             ///< m between hypotheses along and across a street (decision 17)
  int max_hypotheses = 60000;     ///< the spacing grows until no more are needed (decision 17)
  int max_compared = 5000;        ///< hypotheses that are compared at each motion: bounds time
  double max_spacing = 10;        ///< m; where more are needed even so, the search waits for turns
  int max_seeded = 500000;        ///< comparisons each second of the drive meanwhile; bounds time
  double step = 2;                ///< m driven between two comparisons with the streets; longer
                                  ///< while the hypotheses are many (decision 17)
  double independent_length = 8;  ///< m driven until the next evidence is independent (decision 17)
  double street_sigma = 1.5;      ///< m, of a street's edge against the drive (decision 17)
  double max_misfit = 4;          ///< log-weight that evidence takes at most: 0.5 % of a Gaussian
  double scale_sigma = 0.01;      ///< of true over measured distance; derived from the particles'
  double yaw_rate_sigma = 0.001;  ///< rad/s, lasting error; derived from the particles'
  double yaw_noise = 0.002;       ///< rad per √m driven (decision 17)
  double believed_radius = 100;   ///< m, of streets that are likelier where a pose is believed
  double believed_log_odds = 3;   ///< of one of them against one beyond: one in twenty is wrong
  double max_log_odds = 16;       ///< a hypothesis worse by more is dropped: right one in 8 900 000
  double same_place = 15;         ///< m within which hypotheses are one place (decision 17)
  double min_alone = 150;         ///< m driven, all else improbable, until it is sure (decision 16)
  double turn_worth = 40;  ///< m of it that a radian turned meanwhile counts for (decision 16)
  int max_witnessed = 48;  ///< hypotheses that sensor data are compared with; 0: never
  double max_mean_misfit = 0.02;  ///< of independent evidence of a place that is sure (decision 16)
  double max_elsewhere = 0.01;    ///< of all else, of a place that is sure: one in a hundred
  double max_sigma = 6;           ///< m, of a place that is sure (decision 17)

  /// Returns what is wrong, or nothing.
  std::optional<std::string> invalid() const;
};

/// Odometry between two comparisons.
struct DriveStretch {
  PlanarPose motion;
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();
  double seconds = 0;
  double length = 0;  ///< m
};

/// Hypothesis of the global start: a normal distribution of x, y (m), yaw (rad), the scale of the
/// odometry and the error of its yaw rate (rad/s).
struct StreetHypothesis {
  using Matrix = Eigen::Matrix<double, 5, 5>;
  PlanarPose pose;
  int level = StreetGrid::kAnyLevel;  ///< of its street
  double scale = 1;                   ///< true over measured distance
  double yaw_rate_bias = 0;           ///< true minus measured
  Matrix covariance = Matrix::Zero();
  double log_weight = 0;
  double misfit = 0;  ///< sum over independent evidence of the squared distance from the street
};

/// A hypothesis on a street, of those that are `spacing` apart, m.
StreetHypothesis begin_hypothesis(const PlanarPose& pose, double spacing,
                                  const GlobalStartOptions& options);

/// Moves a hypothesis by odometry: `motion` in the vehicle frame within `seconds`; `covariance` of
/// its x, y, yaw.
void predict(StreetHypothesis& hypothesis, const PlanarPose& motion,
             const Eigen::Matrix3d& covariance, double seconds);

/// Compares a hypothesis with the street of its level across it: evidence of which the share
/// `novelty` is independent. Outside the street it loses weight, and its position across the street
/// is corrected.
void compare(StreetHypothesis& hypothesis, const StreetGrid& grid, double novelty,
             const GlobalStartOptions& options);

/// Both: by a stretch of the drive, on the level that it leads to.
void advance(StreetHypothesis& hypothesis, const StreetGrid& grid, const DriveStretch& stretch,
             const GlobalStartOptions& options);

}  // namespace infuse::streetmap

#pragma once

#include <Eigen/Core>
#include <array>
#include <optional>
#include <random>
#include <span>
#include <vector>

#include "fusion/dependence/least_squares.hpp"
#include "fusion/streetmap/planar_pose.hpp"
#include "fusion/streetmap/tracker_options.hpp"

namespace infuse::streetmap {

/// Hypothesis of the pose of the vehicle, I(3.5).
struct Particle {
  PlanarPose pose;
  // Persistent errors of the odometry, learned from the map.
  double scale = 1;          ///< true over measured distance
  double yaw_rate_bias = 0;  ///< rad/s, true minus measured yaw rate
  double log_weight = 0;
  bool in_second_mode = false;  ///< belongs to the second mode while two modes are compared
  /// Hyper-parameters that cross-validation chose for it or for the particle it is a copy of.
  std::optional<dependence::HyperParameters> hyper_parameters;
};

/// Mean and covariance (x, y, yaw) of poses.
struct PoseMoments {
  PlanarPose mean;
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();

  /// Standard deviation along the worst direction of the plane, m.
  double spread() const;
};

/// Weighted pose hypotheses. Deterministic: all random numbers come from the seed.
class ParticleSet {
 public:
  ParticleSet(const ParticleOptions& options, uint64_t seed);

  /// Replaces all particles by draws from a normal distribution around `mean`; their number follows
  /// from the spread.
  void scatter(const PlanarPose& mean, const Eigen::Matrix3d& covariance);

  /// Replaces every third particle by a draw from a normal distribution around `mean`, each with
  /// the mean weight: a second mode, half as likely as the first. Of two modes that there are
  /// already, the less likely one is given up for it, with all its particles.
  void add_mode(const PlanarPose& mean, const Eigen::Matrix3d& covariance);

  /// Moves all particles by a motion in the vehicle frame with its covariance (x, y, yaw) and the
  /// process noise of the options, I(3.2), each with its own scale and yaw-rate bias over
  /// `seconds`. The covariance is that of errors that are independent between motions.
  void predict(const PlanarPose& motion, const Eigen::Matrix3d& covariance, double seconds);

  /// Updates the log-weights by the particles' scores: adds `within_gain` times the excess of a
  /// score over the local mean score, and `between_gain` times that local mean. The local mean
  /// covers particles within `radius` (m, positive), weighted by proximity.
  void update_weights(std::span<const double> scores, double within_gain, double between_gain,
                      double radius);

  /// Resamples in proportion to weight (systematic, low variance) if fewer than half of the
  /// particles carry the weight. The new number follows from the spread, and copies are spread by a
  /// kernel. Merges two modes that met or of which one is refuted. True if it resampled.
  bool resample_if_needed();

  std::span<Particle> all() { return particles_; }
  std::span<const Particle> all() const { return particles_; }

  /// Weighted mean and covariance, of the likelier mode if there are two.
  PoseMoments moments() const;

  /// The same of the less likely mode; nothing if there is one mode.
  std::optional<PoseMoments> second_moments() const;

  /// Weight of the less likely mode, 0 … 0.5; 0 if there is one mode.
  double second_mode_weight() const;

  /// Effective number of particles, 1/Σw².
  double effective_count() const;

  /// Entropy of the weights relative to its maximum, 0 … 1.
  double entropy() const;

 private:
  int required_count();
  void draw_odometry_errors(Particle& particle);
  void normalise();
  void merge_modes();
  void smooth_with_kernel();
  /// Sums of the weights of both modes.
  std::array<double, 2> mode_weights() const;
  PoseMoments moments_of_mode(bool second_mode) const;
  double normal() { return normal_(random_); }

  ParticleOptions options_;
  std::mt19937_64 random_;
  std::normal_distribution<double> normal_;
  std::vector<Particle> particles_, resampled_;
  std::vector<double> weights_;
  std::vector<uint64_t> bins_;
};

}  // namespace infuse::streetmap

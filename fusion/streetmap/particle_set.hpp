#pragma once

#include <Eigen/Core>
#include <optional>
#include <random>
#include <span>
#include <vector>

#include "fusion/dependence/least_squares.hpp"
#include "fusion/streetmap/planar_pose.hpp"
#include "fusion/streetmap/tracker_options.hpp"

namespace infuse::streetmap {

/// A hypothesis of the vehicle's pose, I(3.5).
struct Particle {
  PlanarPose pose;
  // Errors of the odometry that last, learned from the map.
  double scale = 1;          ///< true over measured distance
  double yaw_rate_bias = 0;  ///< rad/s, true minus measured yaw rate
  double log_weight = 0;
  bool in_second_mode = false;  ///< of the second place, while two are weighed against each other
  /// What cross-validation chose for it, or for the one that it is a copy of.
  std::optional<dependence::HyperParameters> hyper_parameters;
};

/// Mean and covariance (x, y, yaw) of poses.
struct PoseMoments {
  PlanarPose mean;
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();

  /// Deviation along the worst direction of the plane, m.
  double spread() const;
};

/// Weighted hypotheses. Deterministic: all draws come from the seed.
class ParticleSet {
 public:
  ParticleSet(const ParticleOptions& options, uint64_t seed);

  /// Replaces all by draws from a normal distribution around `mean`, as many as its spread needs.
  void scatter(const PlanarPose& mean, const Eigen::Matrix3d& covariance);

  /// Replaces all by draws from a disc of `radius` (m) around `middle`, heading within ± `yaw`.
  void scatter_disc(const PlanarPose& middle, double radius, double yaw);

  /// Replaces every third particle by a draw from a normal distribution around `mean`, each with
  /// the mean weight: a second place, half as likely as the first.
  void add_mode(const PlanarPose& mean, const Eigen::Matrix3d& covariance);

  /// Moves all by a motion in the vehicle's frame with its covariance (x, y, yaw) and the options'
  /// own noise, I(3.2), each by its own scale and yaw rate over the `seconds` that it took. The
  /// covariance is that of errors which are other ones at the next motion.
  void predict(const PlanarPose& motion, const Eigen::Matrix3d& covariance, double seconds);

  /// Adds to the log-weights: `within` times what each particle's score, one a particle, is above
  /// those of the particles around it, and `between` times what these score. Around it is within
  /// `reach` (m, positive), the near ones counting more.
  void update_weights(std::span<const double> scores, double within_gain, double between_gain,
                      double radius);

  /// Draws a new set with probability proportional to weight (systematic, low variance), as many
  /// as the spread needs, and spreads the copies, if fewer than half of the particles carry the
  /// weight; whether it did. Two places that came together, or one of which is refuted, are one.
  bool resample_if_needed();

  std::span<Particle> all() { return particles_; }
  std::span<const Particle> all() const { return particles_; }

  /// Mean and covariance by weight, of the likelier place where there are two.
  PoseMoments moments() const;

  /// The weight of the less likely place, 0 … 0.5; 0 where there is one place.
  double second_mode_weight() const;

  /// Effective number of particles, 1/Σw².
  double effective_count() const;

  /// Entropy of the weights over their largest possible one, 0 … 1.
  double entropy() const;

 private:
  int required_count();
  void draw_odometry_errors(Particle& particle);
  void normalise();
  void merge_modes();
  void smooth_with_kernel();
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

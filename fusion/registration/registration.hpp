#pragma once

#include <optional>
#include <string>

#include "fusion/registration/gauss_newton.hpp"
#include "fusion/registration/nearest_pairs.hpp"

namespace infuse::registration {

/// Settings of the registration of two clouds.
struct RegistrationOptions {
  double max_correspondence_distance = 1;  ///< m; points without a counterpart so near do not count
  StepLimits steps;
  size_t min_inliers = 50;           ///< fewer give no pose
  double min_inlier_fraction = 0.1;  ///< of the source's points; fewer: the clouds do not overlap

  /// What is wrong with the settings, or nothing.
  std::optional<std::string> invalid() const;
};

/// Why two clouds cannot be registered; empty if they can.
const char* missing(const PreparedCloud& target, const PointCloud& source,
                    const Eigen::Isometry3d& guess, const RegistrationOptions& options);

/// Why the pose at the end of the steps is not usable; empty if it is.
const char* doubt(const RegistrationResult& result);

/// Registers clouds by a factor (`factors.hpp`) of every point and its nearest neighbour. Does not
/// allocate once it has seen a source of that size. Same bytes on every processor.
template <class Factor>
class Registration {
 public:
  /// `options.invalid()` must be empty.
  explicit Registration(const RegistrationOptions& options = {}, const Factor& factor = {})
      : options_(options), factor_(factor) {}

  /// Finds the source's pose in the target's frame near the guess. Quick where neighbours stand
  /// together in `source`, as in the cloud of a `PreparedCloud`; in any order it takes many times
  /// as long.
  RegistrationResult align(const PreparedCloud& target, const PointCloud& source,
                           const Eigen::Isometry3d& T_target_source_guess);

 private:
  struct Method;

  RegistrationOptions options_;
  Factor factor_;
  NearestPairs pairs_;
  ClusterGradients clusters_;
};

/// One registration, as `gauss_newton` takes it.
template <class Factor>
struct Registration<Factor>::Method {
  Registration& owner;
  const PreparedCloud& target;
  const PointCloud& source;
  RegistrationResult& result;
  double last_move = 0;  ///< m, of points at the radius

  Eigen::Vector3d origin() const { return Eigen::Vector3d::Zero(); }
  const Pairs& pairs() const { return owner.pairs_.pairs(); }
  const Factor& factor() const { return owner.factor_; }

  const char* match(const Eigen::Isometry3d& T_target_source) {
    const RegistrationOptions& options = owner.options_;
    result.inliers = owner.pairs_.match(target, source, T_target_source,
                                        options.max_correspondence_distance, last_move);
    const bool overlap = result.inliers >= options.min_inliers &&
                         static_cast<double>(result.inliers) >=
                             options.min_inlier_fraction * static_cast<double>(source.size());
    return overlap ? "" : "the clouds do not overlap";
  }

  std::optional<geometry::Vector6> step(const Linearisation& at, const Eigen::Isometry3d&) const {
    const geometry::Vector6 step = determined_step(at.system, at.determined);
    if (!step.allFinite()) return std::nullopt;
    return step;
  }

  bool settled(const Linearisation& at, const geometry::Vector6& step, bool small) {
    last_move = step.template tail<3>().norm() + at.system.radius * step.template head<3>().norm();
    return small;
  }
};

template <class Factor>
RegistrationResult Registration<Factor>::align(const PreparedCloud& target,
                                               const PointCloud& source,
                                               const Eigen::Isometry3d& T_target_source_guess) {
  RegistrationResult result;
  result.T_target_source = T_target_source_guess;
  result.points = source.size();
  result.reason = missing(target, source, T_target_source_guess, options_);
  if (!result.usable()) return result;
  pairs_.begin(source);
  Method method{*this, target, source, result};
  const std::optional<Linearisation> last = gauss_newton(method, options_.steps, result);
  if (!last) return result;
  clusters_.sum(pairs_.pairs(), factor_);
  set_uncertainty(clusters_, last->system, last->determined, result);
  result.reason = doubt(result);
  return result;
}

}  // namespace infuse::registration

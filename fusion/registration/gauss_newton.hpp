#pragma once

#include <optional>

#include "fusion/registration/linearise.hpp"
#include "fusion/registration/uncertainty.hpp"

namespace infuse::registration {

/// When the steps end.
struct StepLimits {
  int max_iterations = 50;
  double rotation_tolerance = 1.7e-3;   ///< rad; a step smaller than both tolerances is the last
  double translation_tolerance = 1e-3;  ///< m
  double min_plane_fraction = 0.01;     ///< a direction is free if less of the points' (squared)
                                        ///< displacement by it is along the planes' normals
                                        ///< (decision 9)

  /// What is wrong with the settings, or nothing.
  std::optional<std::string> invalid() const;
};

/// Normal equations at the last pose before a step, and the directions that they determine.
struct Linearisation {
  PoseSystem system;
  DeterminedDirections determined;
};

/// The loop of every registration (P 4.2): Gauss–Newton on SE(3) from the pose in `result`, which
/// it moves; sets `iterations` and `converged`. A method says what one registration is made of:
///   origin()                of the pairs' coordinates, m, in the target frame
///   const char* match(T)    pairs at the source's pose about the origin, or why there is none
///   pairs(), factor()       as matched; `factors.hpp`
///   std::optional<Vector6> step(linearisation, T), or nothing if no pose is determined
///   bool settled(linearisation, step, small)   takes note of the step; true if it is the last
/// Returns nothing if the loop ended without a pose, with `result.reason`.
template <class Method>
std::optional<Linearisation> gauss_newton(Method& method, const StepLimits& limits,
                                          RegistrationResult& result) {
  Linearisation at;
  while (result.iterations < limits.max_iterations && !result.converged) {
    Eigen::Isometry3d T = result.T_target_source;
    T.translation() -= method.origin();
    result.reason = method.match(T);
    if (*result.reason != '\0') return std::nullopt;
    at.system = linearise(method.pairs(), method.factor());
    at.determined = determined_directions(method.pairs(), at.system, method.factor().noise,
                                          limits.min_plane_fraction);
    const std::optional<geometry::Vector6> step = method.step(at, T);
    if (!step) {
      result.reason = "the points do not determine a pose";
      return std::nullopt;
    }
    T = geometry::exp(*step) * T;
    T.translation() += method.origin();
    result.T_target_source = T;
    ++result.iterations;
    const bool small = step->template head<3>().norm() <= limits.rotation_tolerance &&
                       step->template tail<3>().norm() <= limits.translation_tolerance;
    result.converged = method.settled(at, *step, small);
  }
  return at;
}

}  // namespace infuse::registration

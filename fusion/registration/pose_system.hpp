#pragma once

#include <vector>

#include "drivers/measurement/sweep.hpp"
#include "fusion/registration/lanes.hpp"
#include "fusion/registration/registration_result.hpp"

namespace infuse::registration {

/// Pairs of points and their local planes as a structure of arrays in the target frame, padded to
/// whole vectors with weight 0.
struct Pairs {
  using Field = FieldVector<float>;
  Field px, py, pz;  ///< m, points of the source at the present pose
  Field sx, sy, sz;  ///< their normals
  Field qx, qy, qz;  ///< m, points of the target
  Field tx, ty, tz;  ///< their normals
  Field weight;      ///< 1, or 0: no pair
  Field tilt;        ///< rad², variance of the target's normals by noise; 0: not known
  size_t size = 0;   ///< number of pairs, with weight or not
  size_t padded() const { return (size + kLanes - 1) / kLanes * kLanes; }
  void resize(size_t pairs);
};

/// Noise model of the pairs.
struct PairNoise {
  double plane_variance = 1e-3;  ///< ε: variance across a plane in units of that along it
  double robust_width = 0;  ///< m, of the Geman–McClure kernel on the distance from the planes;
                            ///< 0: none
};

/// Normal equations of a left perturbation of the source's pose, about `centre`. The rows of planes
/// and the isotropic rest (weight ½ of every pair) are kept apart, since only planes inform.
struct PoseSystem {
  geometry::Matrix6 planes = geometry::Matrix6::Zero();     ///< Σ w Jᵀ (W − ½) J
  geometry::Matrix6 isotropic = geometry::Matrix6::Zero();  ///< Σ w Jᵀ ½ J
  geometry::Vector6 gradient = geometry::Vector6::Zero();   ///< Σ w Jᵀ W r
  double cost = 0;                                          ///< Σ w rᵀ W r
  double weight = 0;                                        ///< Σ w
  Eigen::Vector3d mean{0, 0, 0};                            ///< of the points, weighted, m
  double radius = 0;  ///< m, root mean square distance of the points from the mean
};

/// Sums the normal equations of GICP, P 4.2.2 (Segal et al. 2009), with planes of variance 1 and ε:
/// r = q − p, W = (Cq + R Cp Rᵀ)⁻¹. Same bytes on every processor.
PoseSystem pose_system(const Pairs& pairs, const PairNoise& noise);

}  // namespace infuse::registration

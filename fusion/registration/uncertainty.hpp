#pragma once

#include <vector>

#include "fusion/registration/factors.hpp"
#include "fusion/registration/pose_system.hpp"
#include "fusion/registration/registration_result.hpp"

namespace infuse::registration {

/// Directions in which planes determine a pose, as columns 0 … count − 1 of `basis`: orthogonal
/// twists about the points' middle, in units of the points' displacement by them (root mean square,
/// m). The other columns are the free directions.
struct DeterminedDirections {
  geometry::Matrix6 basis = geometry::Matrix6::Identity();
  int count = 6;
  /// Twist about the origin of a twist in the units of the basis.
  geometry::Matrix6 twist_from_scaled = geometry::Matrix6::Identity();
};

/// Finds the directions that the planes see: the part of the points' displacement that is along the
/// normals is at least `min_plane_fraction` (in squares). Noise tilts the normals of level ground
/// in all directions, and rings of returns on it would seem to show how far the vehicle moved:
/// normals that may be the commonest one count as that.
DeterminedDirections determined_directions(const Pairs& pairs, const PoseSystem& system,
                                           const PairNoise& noise, double min_plane_fraction);

/// Gauss–Newton step in the determined directions.
geometry::Vector6 determined_step(const PoseSystem& system, const DeterminedDirections& determined);

/// What one pair adds to the gradient of a factor, without the isotropic part.
struct PairGradient {
  geometry::Vector6 gradient;  ///< w Jᵀ (W − kIsotropic) r
  geometry::Vector6 normal;    ///< the same per metre of distance from the target's plane
  double weight;
};

/// Gradient of pair i in double precision, as `linearise` sums it.
template <class Factor>
PairGradient pair_gradient(const Pairs& pairs, size_t i, const Factor& factor) {
  const Pair<double> pair{{pairs.px[i], pairs.py[i], pairs.pz[i]},
                          {pairs.sx[i], pairs.sy[i], pairs.sz[i]},
                          {pairs.qx[i], pairs.qy[i], pairs.qz[i]},
                          {pairs.tx[i], pairs.ty[i], pairs.tz[i]}};
  const Eigen::Vector3d r = factor.residual(pair);
  const auto W = factor.information(pair);
  double distance[Factor::kDirections];
  for (int k = 0; k < Factor::kDirections; ++k) distance[k] = W.direction[k].dot(r);
  Eigen::Vector3d Wr = Eigen::Vector3d::Zero();
  for (int k = 0; k < Factor::kDirections; ++k) {
    double along = W.coefficient[k][0] * distance[0];
    for (int l = 1; l < Factor::kDirections; ++l) along += W.coefficient[k][l] * distance[l];
    Wr += along * W.direction[k];
  }
  Wr *= W.scale;
  const double square = r.dot(Wr) + Factor::kIsotropic * r.squaredNorm();
  PairGradient out;
  out.weight = pairs.weight[i] * factor.weight(square);
  out.gradient << pair.p.cross(Wr), Wr;
  out.gradient *= out.weight;
  const Eigen::Vector3d n = out.weight / (2 * factor.noise.plane_variance) * pair.target_normal;
  out.normal << pair.p.cross(n), n;
  return out;
}

/// Sums of gradients over clusters of neighbouring points: those err together (the surface is not
/// the plane, both sweeps saw it from elsewhere), so their residuals are not independent. Does not
/// allocate after the first use.
class ClusterGradients {
 public:
  /// Sums the pairs' gradients of a factor.
  template <class Factor>
  void sum(const Pairs& pairs, const Factor& factor) {
    clear();
    for (size_t i = 0; i < pairs.size; ++i) {
      if (pairs.weight[i] != 0) add(pairs, i, pair_gradient(pairs, i, factor));
    }
  }

  /// Scatter of the clusters' sums.
  geometry::Matrix6 scatter() const;

  /// Weighted sum of the squared distances from the target's planes, m².
  double square() const { return square_; }

 private:
  void clear();
  void add(const Pairs& pairs, size_t i, const PairGradient& at);

  std::vector<geometry::Vector6> sums_;
  double square_ = 0;
};

/// Sets covariance, information and free directions of a result at its optimum. The scatter of the
/// clusters' sums is what the pose's error comes from ("sandwich" covariance, White 1982; Liang and
/// Zeger 1986).
void set_uncertainty(const ClusterGradients& clusters, const PoseSystem& system,
                     const DeterminedDirections& determined, RegistrationResult& result);

}  // namespace infuse::registration

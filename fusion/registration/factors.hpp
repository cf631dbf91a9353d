#pragma once

#include "fusion/registration/pairs.hpp"

namespace infuse::registration {

// A factor is what a pair of points states about the pose. It is a type with
//   kDirections, kIsotropic   the shape of its information
//   noise                     what a plane counts, and the robust kernel
//   residual(pair)            a vector that falls by 1 m where the source's point rises by 1 m
//   information(pair)         of the residual
//   weight(square)            from the residual's weighted square: 1, or less by a robust kernel
// each a template of the numbers, `Floats` or `double`. They are inlined into loops that are
// compiled for several processors.

/// Noise model of the pairs.
struct PairNoise {
  double plane_variance = 1e-3;  ///< ε: variance across a plane in units of that along it; a plane
                                 ///< across a direction informs by 1 / 2ε
  double robust_width = 0;  ///< m, of the Geman–McClure kernel on the distance from the planes;
                            ///< 0: none
};

/// W = scale Σₖₗ coefficient[k][l] direction[k] direction[l]ᵀ + kIsotropic · 1, symmetric.
template <class Number, int directions>
struct Information {
  VectorOf<Number> direction[directions];
  Number coefficient[directions][directions];
  Number scale;
};

/// The kernel of Geman and McClure: weight of a pair with the weighted square rᵀ W r, which is
/// d² / 2ε at the distance d from a plane.
template <class Number>
[[gnu::always_inline]] inline Number robust_weight(const Number& square, const PairNoise& noise) {
  const auto width2 = static_cast<ScalarOf<Number>>(noise.robust_width * noise.robust_width /
                                                    (2 * noise.plane_variance));
  if (!(width2 > 0)) return Number{} + 1;
  const Number kernel = width2 / (width2 + square);
  return kernel * kernel;
}

/// Generalized ICP, P 4.2.2 (Segal et al. 2009): local covariances of planes, 1 along them and ε
/// across, W = (Cq + R Cp Rᵀ)⁻¹. With a = 1 − ε such a covariance is 1 − a n nᵀ, and
/// (2 − a N Nᵀ)⁻¹ = ½ + ½ a N (2 − a NᵀN)⁻¹ Nᵀ with N = (n₁ n₂).
struct GicpFactor {
  static constexpr int kDirections = 2;      // N above, P 4.2.2
  static constexpr double kIsotropic = 0.5;  // ½ above, P 4.2.2
  PairNoise noise;

  template <class Number>
  [[gnu::always_inline]] VectorOf<Number> residual(const Pair<Number>& pair) const {
    return pair.q - pair.p;
  }

  template <class Number>
  [[gnu::always_inline]] Information<Number, kDirections> information(
      const Pair<Number>& pair) const {
    const auto& n1 = pair.target_normal;
    const auto& n2 = pair.source_normal;
    const auto a = static_cast<ScalarOf<Number>>(1 - noise.plane_variance);
    const Number m1 = 2 - a * dot(n1, n1), m2 = 2 - a * dot(n2, n2), m12 = a * dot(n1, n2);
    return {{n1, n2}, {{m2, m12}, {m12, m1}}, ScalarOf<Number>(0.5) * a / (m1 * m2 - m12 * m12)};
  }

  template <class Number>
  [[gnu::always_inline]] Number weight(const Number& square) const {
    return robust_weight(square, noise);
  }
};

/// Factor of the lidar odometry: GICP with the target's plane at both points. Only the map has
/// planes, and a point may slide on them.
struct MapPlaneFactor : GicpFactor {
  template <class Number>
  [[gnu::always_inline]] Information<Number, kDirections> information(
      const Pair<Number>& pair) const {
    Pair<Number> same = pair;
    same.source_normal = pair.target_normal;
    return GicpFactor::information(same);
  }
};

/// Distance of a point from the target's plane (Chen and Medioni 1992): W = n nᵀ.
struct PointToPlaneFactor {
  static constexpr int kDirections = 1;  // n above (Chen and Medioni 1992)
  static constexpr double kIsotropic = 0;
  PairNoise noise{.plane_variance = 0.5};

  template <class Number>
  [[gnu::always_inline]] VectorOf<Number> residual(const Pair<Number>& pair) const {
    return pair.q - pair.p;
  }

  template <class Number>
  [[gnu::always_inline]] Information<Number, kDirections> information(
      const Pair<Number>& pair) const {
    return {{pair.target_normal}, {{Number{} + 1}}, Number{} + 1};
  }

  template <class Number>
  [[gnu::always_inline]] Number weight(const Number& square) const {
    return robust_weight(square, noise);
  }
};

}  // namespace infuse::registration

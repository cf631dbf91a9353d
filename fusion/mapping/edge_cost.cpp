#include "fusion/mapping/edge_cost.hpp"

#include <cmath>

#include "drivers/measurement/rotation.hpp"
#include "fusion/geometry/rigid_motion.hpp"
#include "fusion/geometry/symmetric_eigen.hpp"

namespace infuse::mapping {
namespace {

template <int D>
using Square = Eigen::Matrix<double, D, D>;

/// Harmonic mean of the eigenvalues of an information.
template <int D>
double harmonic_mean(const Square<D>& information) {
  const auto values = geometry::symmetric_eigen<D>(information).values;
  return D / values.cwiseMax(1e-12 * values.maxCoeff()).cwiseInverse().sum();
}

/// Derivative of a rotation by its angle about axis k.
template <int D>
Square<D> generator(int k) {
  if constexpr (D == 2) {
    return Square<2>{{0, -1}, {1, 0}};
  } else {
    return geometry::skew(Eigen::Vector3d::Unit(k));
  }
}

/// Rotation by 2 atan |h| about h.
Square<2> rotation_of_half(double h) {
  const double scale = 1 / (1 + h * h);
  const double c = (1 - h * h) * scale, s = 2 * h * scale;
  return Square<2>{{c, -s}, {s, c}};
}

Square<3> rotation_of_half(const Eigen::Vector3d& h) {
  return Eigen::Quaterniond(1, h.x(), h.y(), h.z()).normalized().toRotationMatrix();
}

/// The nearest rotation, up to the square of a small error.
Square<2> renormalised(const Square<2>& R) {
  const Eigen::Vector2d x = Eigen::Vector2d(R(0, 0) + R(1, 1), R(1, 0) - R(0, 1)).normalized();
  return Square<2>{{x[0], -x[1]}, {x[1], x[0]}};
}

Square<3> renormalised(const Square<3>& R) { return infuse::orthonormal(R); }

/// Residuals, T_from_to⁻¹ T_map_from⁻¹ T_map_to being the error E of an edge.
template <int D>
struct EdgeError {
  Pose<D> E;
  Square<D> R_to_from;            // of the measurement
  Eigen::Matrix<double, D, 1> t;  // from `from` to `to`, in the frame at `from`

  EdgeError(const PoseEdge<D>& edge, const Pose<D>& T_map_from, const Pose<D>& T_map_to) {
    R_to_from = edge.T_from_to.linear().transpose();
    t = T_map_from.linear().transpose() * (T_map_to.translation() - T_map_from.translation());
    E.linear() = R_to_from * (T_map_from.linear().transpose() * T_map_to.linear());
    E.translation() = R_to_from * (t - edge.T_from_to.translation());
  }
};

/// Residual vector of length `kRows`, and its weights as a matrix.
template <int D, Cost kCost>
struct Residual;

template <int D>
struct Residual<D, Cost::kInformation> {
  static constexpr int kRows = kPoseFreedom<D>;
  Eigen::Matrix<double, kRows, 1> value;
  double w = 1;  // of the quaternion

  Residual(const EdgeError<D>& error) {
    value.template head<D>() = error.E.translation();
    if constexpr (D == 2) {
      value[2] = std::atan2(error.E(1, 0), error.E(0, 0));
    } else {
      Eigen::Quaterniond q(error.E.linear());
      if (q.w() < 0) q.coeffs() = -q.coeffs();
      value.template tail<3>() = q.vec();
      w = q.w();
    }
  }

  static PoseMatrix<D> weights(const PoseEdge<D>& edge) { return edge.information; }

  /// Derivatives of the rotation's residual by rotations at `from` and at `to`.
  void rotate(const EdgeError<D>& error, auto&& by_from, auto&& by_to) const {
    if constexpr (D == 2) {
      by_from(0, 0) = -1;
      by_to(0, 0) = 1;
    } else {
      const Square<3> cross = geometry::skew(value.template tail<3>());
      const Square<3> scaled = w * Square<3>::Identity();
      by_from = (cross - scaled) / 2 * error.R_to_from;
      by_to = (cross + scaled) / 2;
    }
  }
};

template <int D>
struct Residual<D, Cost::kChordal> {
  static constexpr int kRows = D + D * D;
  Eigen::Matrix<double, kRows, 1> value;

  Residual(const EdgeError<D>& error) {
    value.template head<D>() = error.E.translation();
    value.template tail<D * D>() = (error.E.linear() - Square<D>::Identity()).reshaped();
  }

  static auto weights(const PoseEdge<D>& edge) {
    const ChordalWeights weights = chordal_weights<D>(edge.information);
    Eigen::Matrix<double, kRows, 1> diagonal;
    diagonal.template head<D>().setConstant(weights.translation);
    diagonal.template tail<D * D>().setConstant(weights.rotation);
    return Eigen::DiagonalMatrix<double, kRows>(diagonal);
  }

  void rotate(const EdgeError<D>& error, auto&& by_from, auto&& by_to) const {
    const auto E = error.E.linear();
    for (int k = 0; k < by_from.cols(); ++k) {
      const Square<D> G = generator<D>(k);
      by_from.col(k) = (-error.R_to_from * G * error.R_to_from.transpose() * E).reshaped();
      by_to.col(k) = (E * G).reshaped();
    }
  }
};

template <int D, Cost kCost>
EdgeSystem<D> linearize(const PoseEdge<D>& edge, const Pose<D>& T_map_from,
                        const Pose<D>& T_map_to) {
  const EdgeError<D> error(edge, T_map_from, T_map_to);
  const Residual<D, kCost> residual(error);
  constexpr int kRows = Residual<D, kCost>::kRows, kFreedom = kPoseFreedom<D>;
  using Jacobian = Eigen::Matrix<double, kRows, kFreedom>;
  Jacobian by_from = Jacobian::Zero(), by_to = Jacobian::Zero();
  by_from.template topLeftCorner<D, D>() = -error.R_to_from;
  for (int k = 0; k < kFreedom - D; ++k) {
    by_from.template block<D, 1>(0, D + k) = -error.R_to_from * (generator<D>(k) * error.t);
  }
  by_to.template topLeftCorner<D, D>() = error.E.linear();
  residual.rotate(error, by_from.template bottomRightCorner<kRows - D, kFreedom - D>(),
                  by_to.template bottomRightCorner<kRows - D, kFreedom - D>());

  const auto weights = Residual<D, kCost>::weights(edge);
  const Eigen::Matrix<double, kRows, 1> weighted = weights * residual.value;
  const Jacobian weighted_from = weights * by_from, weighted_to = weights * by_to;
  EdgeSystem<D> system;
  system.cost = residual.value.dot(weighted);
  system.H_from_from = by_from.transpose() * weighted_from;
  system.H_to_from = by_to.transpose() * weighted_from;
  system.H_to_to = by_to.transpose() * weighted_to;
  system.g_from = by_from.transpose() * weighted;
  system.g_to = by_to.transpose() * weighted;
  return system;
}

template <int D, Cost kCost>
double evaluate(const PoseEdge<D>& edge, const Pose<D>& T_map_from, const Pose<D>& T_map_to) {
  const Residual<D, kCost> residual(EdgeError<D>(edge, T_map_from, T_map_to));
  return residual.value.dot(Residual<D, kCost>::weights(edge) * residual.value);
}

}  // namespace

template <int D>
ChordalWeights chordal_weights(const PoseMatrix<D>& information) {
  constexpr int kAngles = kPoseFreedom<D> - D;
  const double rotation =
      harmonic_mean<kAngles>(information.template bottomRightCorner<kAngles, kAngles>());
  return {D == 2 ? rotation : rotation / 2,
          harmonic_mean<D>(information.template topLeftCorner<D, D>())};
}

template <int D>
double edge_cost(const PoseEdge<D>& edge, const Pose<D>& T_map_from, const Pose<D>& T_map_to,
                 Cost cost) {
  return cost == Cost::kChordal ? evaluate<D, Cost::kChordal>(edge, T_map_from, T_map_to)
                                : evaluate<D, Cost::kInformation>(edge, T_map_from, T_map_to);
}

template <int D>
EdgeSystem<D> linearize_edge(const PoseEdge<D>& edge, const Pose<D>& T_map_from,
                             const Pose<D>& T_map_to, Cost cost) {
  return cost == Cost::kChordal ? linearize<D, Cost::kChordal>(edge, T_map_from, T_map_to)
                                : linearize<D, Cost::kInformation>(edge, T_map_from, T_map_to);
}

template <int D>
Pose<D> perturb(const Pose<D>& T, const Eigen::Matrix<double, kPoseFreedom<D>, 1>& delta) {
  Square<D> R;
  if constexpr (D == 2) {
    R = rotation_of_half(delta[2] / 2);
  } else {
    R = rotation_of_half(Eigen::Vector3d(delta.template tail<3>() / 2));
  }
  Pose<D> moved;
  moved.linear() = renormalised(Square<D>(T.linear() * R));
  moved.translation() = T.translation() + T.linear() * delta.template head<D>();
  return moved;
}

template ChordalWeights chordal_weights<2>(const PoseMatrix<2>&);
template ChordalWeights chordal_weights<3>(const PoseMatrix<3>&);
template double edge_cost(const PoseEdge<2>&, const Pose<2>&, const Pose<2>&, Cost);
template double edge_cost(const PoseEdge<3>&, const Pose<3>&, const Pose<3>&, Cost);
template EdgeSystem<2> linearize_edge(const PoseEdge<2>&, const Pose<2>&, const Pose<2>&, Cost);
template EdgeSystem<3> linearize_edge(const PoseEdge<3>&, const Pose<3>&, const Pose<3>&, Cost);
template Pose<2> perturb(const Pose<2>&, const Eigen::Vector3d&);
template Pose<3> perturb(const Pose<3>&, const Eigen::Matrix<double, 6, 1>&);

}  // namespace infuse::mapping

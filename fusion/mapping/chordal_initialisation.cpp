#include "fusion/mapping/chordal_initialisation.hpp"

#include <Eigen/SVD>

#include "fusion/mapping/block_cholesky.hpp"
#include "fusion/mapping/edge_cost.hpp"
#include "fusion/mapping/free_poses.hpp"

namespace infuse::mapping {
namespace {

template <int D>
using Square = Eigen::Matrix<double, D, D>;

/// The rotation that is nearest to M.
template <int D>
Square<D> nearest_rotation(const Square<D>& M) {
  const Eigen::JacobiSVD<Square<D>> svd(M, Eigen::ComputeFullU | Eigen::ComputeFullV);
  Square<D> sign = Square<D>::Identity();
  sign(D - 1, D - 1) = (svd.matrixU() * svd.matrixV().transpose()).determinant() < 0 ? -1 : 1;
  return svd.matrixU() * sign * svd.matrixV().transpose();
}

/// Least squares of w |y_to − A y_from − b|² over all edges, y being B × D for each pose and
/// `fixed` at pose 0: `term(e)` gives w, A and b of edge e.
template <int D, int B>
struct LinearTerm {
  double weight;
  Square<B> A;
  Eigen::Matrix<double, B, D> b;
};

template <int D, int B, class Term>
bool solve_linear(const PoseGraph<D>& graph, const Eigen::Matrix<double, B, D>& fixed, Term term,
                  Eigen::MatrixXd& y) {
  using Right = Eigen::Matrix<double, B, D>;
  BlockCholesky<B> system(graph.poses.size() - 1, free_pairs(graph));
  Eigen::MatrixXd right =
      Eigen::MatrixXd::Zero(static_cast<Eigen::Index>(graph.poses.size() - 1) * B, D);
  const auto rows = [&](size_t pose) {
    return right.middleRows<B>(static_cast<Eigen::Index>(pose - 1) * B);
  };
  for (size_t e = 0; e < graph.edges.size(); ++e) {
    const size_t from = graph.edges[e].from, to = graph.edges[e].to;
    const LinearTerm<D, B> t = term(e);
    // What is known of the residual: at the free poses' zero.
    Right known = -t.b;
    if (from == 0) known -= t.A * fixed;
    if (to == 0) known += fixed;
    if (from != 0) {
      system.add(from - 1, from - 1, t.weight * t.A.transpose() * t.A);
      rows(from) += t.weight * t.A.transpose() * known;
    }
    if (to != 0) {
      system.add(to - 1, to - 1, t.weight * Square<B>::Identity());
      rows(to) -= t.weight * known;
    }
    if (from != 0 && to != 0) system.add(to - 1, from - 1, -t.weight * t.A);
  }
  if (!system.factorize(0)) return false;
  y = system.solve(right);
  return y.allFinite();
}

}  // namespace

template <int D>
bool initialise_chordal(PoseGraph<D>& graph) {
  if (graph.poses.size() < 2) return true;
  std::vector<ChordalWeights> of_edges;
  of_edges.reserve(graph.edges.size());
  for (const PoseEdge<D>& edge : graph.edges) {
    of_edges.push_back(chordal_weights<D>(edge.information));
  }
  // |R_to − R_from R| = |R_toᵀ − Rᵀ R_fromᵀ|: the columns of the transposes are independent.
  Eigen::MatrixXd transposes;
  const auto rotation_term = [&](size_t e) {
    return LinearTerm<D, D>{of_edges[e].rotation, graph.edges[e].T_from_to.linear().transpose(),
                            Square<D>::Zero()};
  };
  if (!solve_linear<D, D>(graph, graph.poses[0].linear().transpose(), rotation_term, transposes)) {
    return false;
  }
  std::vector<Square<D>> rotations = {graph.poses[0].linear()};
  for (Eigen::Index i = 0; i < transposes.rows(); i += D) {
    rotations.push_back(nearest_rotation<D>(transposes.middleRows<D>(i).transpose()));
  }
  Eigen::MatrixXd positions;
  const auto translation_term = [&](size_t e) {
    const PoseEdge<D>& edge = graph.edges[e];
    return LinearTerm<D, 1>{of_edges[e].translation, Square<1>::Identity(),
                            (rotations[edge.from] * edge.T_from_to.translation()).transpose()};
  };
  if (!solve_linear<D, 1>(graph, graph.poses[0].translation().transpose(), translation_term,
                          positions)) {
    return false;
  }
  for (size_t i = 1; i < graph.poses.size(); ++i) {
    graph.poses[i].linear() = rotations[i];
    graph.poses[i].translation() = positions.row(static_cast<Eigen::Index>(i - 1)).transpose();
  }
  return true;
}

template bool initialise_chordal(PoseGraph<2>&);
template bool initialise_chordal(PoseGraph<3>&);

}  // namespace infuse::mapping

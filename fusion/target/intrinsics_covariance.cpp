#include "fusion/target/intrinsics_covariance.hpp"

#include <Eigen/Cholesky>
#include <Eigen/QR>
#include <algorithm>
#include <cmath>

namespace infuse::target {
namespace {

using Information = Eigen::Matrix<double, 12, 12>;

/// A view with its pose eliminated.
struct EliminatedView {
  Information information;
  SharedVector score;
};

EliminatedView eliminate_pose(const CornerEquations& equations) {
  const Eigen::HouseholderQR<Eigen::MatrixXd> qr(equations.by_pose);
  const Eigen::MatrixXd rotated = qr.householderQ().transpose() * equations.by_shared;
  const Eigen::VectorXd residual = qr.householderQ().transpose() * equations.residual;
  const Eigen::Index rows = rotated.rows() - 6;
  return {rotated.bottomRows(rows).transpose() * rotated.bottomRows(rows),
          rotated.bottomRows(rows).transpose() * residual.tail(rows)};
}

}  // namespace

IntrinsicsCovariance estimate_intrinsics_covariance(const Board& board,
                                                    std::span<const Corners> views,
                                                    const std::vector<bool>& used, double flatness,
                                                    const IntrinsicsSolution& solution) {
  const geometry::CameraModel camera(solution.camera);
  std::vector<EliminatedView> eliminated;
  Information sum = Information::Zero();
  double squares = 0, freedom = 0;
  for (size_t v = 0; v < views.size(); ++v) {
    if (!used[v] || !solution.T_camera_board[v]) continue;
    const auto equations =
        linearize_corners(camera, board, solution.bow, *solution.T_camera_board[v], views[v]);
    if (!equations) continue;
    eliminated.push_back(eliminate_pose(*equations));
    sum += eliminated.back().information;
    squares += equations->residual.squaredNorm();
    freedom += static_cast<double>(equations->residual.size() - 6);
  }
  const int count = intrinsics_count(solution.camera.model);
  IntrinsicsCovariance out;
  freedom -= count;
  if (!(freedom > 0) || eliminated.size() <= 3) return out;
  const double variance = squares / freedom;
  out.corner_noise = std::sqrt(variance);
  sum.bottomRightCorner<3, 3>().diagonal().array() += variance / (flatness * flatness);
  if (count < 9) sum(8, 8) = 1;  // not a number of this model; its row and column are zero

  // In units of each number's own information, so that px and m can be inverted together.
  const SharedVector scale = sum.diagonal().cwiseSqrt().cwiseInverse();
  if (!scale.allFinite()) return out;
  const Information scaled = scale.asDiagonal() * sum * scale.asDiagonal();
  const Eigen::LDLT<Information> ldlt(scaled);
  // double precision: a number that is determined to less than 1e-12 of its information is not
  if (!(ldlt.vectorD().minCoeff() > 1e-12)) return out;
  const Information inverse =
      scale.asDiagonal() * Information(ldlt.solve(Information::Identity())) * scale.asDiagonal();

  double scores = 0, expected = 0;
  for (const EliminatedView& view : eliminated) {
    scores += view.score.dot(inverse * view.score);
    const Information share = inverse * view.information;
    expected += variance * (share.trace() - (share * share).trace());
  }
  out.view_ratio = expected > 0 ? scores / expected : 1;
  // Variance of Student's t with a degree of freedom less than views.
  const auto clusters = static_cast<double>(eliminated.size());
  const double few = (clusters - 1) / (clusters - 3);
  out.covariance =
      variance * std::max(1.0, out.view_ratio) * few * inverse.topLeftCorner(count, count);
  return out;
}

}  // namespace infuse::target

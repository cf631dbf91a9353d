#include "fusion/target/target_model.hpp"

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>

#include "drivers/measurement/median.hpp"

namespace infuse::target {
namespace {

constexpr double kMinSlope = 0.1;  // cosine of the angle between beam and normal: 84°
constexpr double kTail = 0.1;  // share of returns beyond "darkest" and "brightest": the squares'
                               // two clusters, without their tails
constexpr double kMinShift = 1e-6;  // m and rad; exact boards are inverted in double precision

/// Derivative of a point by the distance from the axis (z) of where the beams cross.
Eigen::Vector3d by_origin(const Eigen::Vector3d& point) {
  return {0, 0, -point.z() / std::hypot(point.x(), point.y())};
}

}  // namespace

std::optional<std::string> SharedErrors::invalid() const {
  if (!(range_accuracy > 0)) return "range_accuracy must be positive";
  if (!(beam_origin > 0)) return "beam_origin must be positive";
  if (!(flatness > 0)) return "flatness must be positive";
  if (!(scale > 0)) return "scale must be positive";
  return std::nullopt;
}

ReducedView reduce_view(const ViewEquations& view, const ShiftCovariance& shift_covariance,
                        double noise) {
  const double weight = 1 / (noise * noise);
  const ShiftCovariance own = weight * view.own + shift_covariance.inverse();
  const Eigen::LLT<ShiftCovariance> llt(own);
  const Eigen::Matrix<double, 3, Eigen::Dynamic> solved =
      llt.solve(weight * view.cross.transpose());
  const BoardShift shift = llt.solve(weight * view.own_gradient);
  ReducedView out;
  out.information = weight * (view.shared - view.cross * solved);
  out.gradient = weight * (view.shared_gradient - view.cross * shift);
  out.chi_squared = weight * (view.squares - view.own_gradient.dot(shift));
  out.log_determinant = std::log((own * shift_covariance).determinant());
  return out;
}

TargetModel::TargetModel(std::span<const TargetView> views) : views_(views) {
  std::vector<double> reflectivities;
  for (const TargetView& view : views) {
    for (const BoardReturn& seen : view.returns) {
      reflectivities.push_back(seen.reflectivity);
      if (seen.ring >= beam_of_ring_.size()) beam_of_ring_.resize(seen.ring + size_t{1}, -1);
      Eigen::Index& beam = beam_of_ring_[seen.ring];
      if (beam < 0) beam = beams_++;
    }
  }
  if (reflectivities.empty()) return;
  const auto tail = static_cast<size_t>(kTail * static_cast<double>(reflectivities.size()));
  dark_ = nth_smallest(reflectivities, tail);
  bright_ = nth_smallest(reflectivities, reflectivities.size() - 1 - tail);
}

double TargetModel::contrast(double reflectivity) const {
  if (!(bright_ > dark_)) return 0;
  return std::clamp((reflectivity - dark_) / (bright_ - dark_), 0.0, 1.0) - 0.5;
}

Eigen::MatrixXd TargetModel::prior_information(const SharedErrors& errors) const {
  Eigen::VectorXd sigma = Eigen::VectorXd::Constant(size(), errors.range_accuracy);
  sigma(kScale) = errors.scale;
  sigma.segment<3>(kBow).setConstant(errors.flatness);
  sigma.segment<3>(kShift).setConstant(kMinShift);  // until there is a misfit
  sigma(kOrigin) = errors.beam_origin;
  Eigen::VectorXd information = sigma.cwiseAbs2().cwiseInverse();
  information.head<6>().setZero();
  return information.asDiagonal();
}

ViewEquations TargetModel::linearise(size_t index, const Eigen::Isometry3d& T) const {
  const TargetView& view = views_[index];
  const Eigen::Matrix3d axes = view.T_refcam_board.linear();
  const Eigen::Vector3d normal = axes.col(2);
  const Eigen::Vector3d middle = view.T_refcam_board * view.board.middle();
  const Eigen::Vector2d half = view.board.half_size();
  ViewEquations out;
  out.shared = Eigen::MatrixXd::Zero(size(), size());
  out.cross = Eigen::MatrixXd::Zero(size(), 3);
  out.shared_gradient = Eigen::VectorXd::Zero(size());
  std::array<Eigen::Index, kFirstBeam + 1> at{};  // where a row is not zero
  for (Eigen::Index k = 0; k < kFirstBeam; ++k) at[static_cast<size_t>(k)] = k;
  for (const BoardReturn& seen : view.returns) {
    const Eigen::Vector3d beam = T.linear() * seen.point.normalized();
    const double slope = normal.dot(beam);
    if (std::abs(slope) < kMinSlope) continue;
    const double residual = normal.dot(T * seen.point - middle) / slope;
    // Where the beam meets the board: unlike the return itself it does not move with its noise,
    // which would tilt the board (errors in variables).
    const Eigen::Vector3d point = T * seen.point - residual * beam;
    const Eigen::Vector3d from_middle = point - middle;
    const Eigen::Vector2d on_board(axes.col(0).dot(from_middle), axes.col(1).dot(from_middle));
    Eigen::Matrix<double, kFirstBeam + 1, 1> row;
    row.head<3>() = point.cross(normal);
    row.segment<3>(3) = normal;
    row(kCommon) = -slope;
    row(kContrast) = -slope * contrast(seen.reflectivity);
    row(kScale) = -normal.dot(middle);
    row.segment<3>(kBow) = -view.board.bow_at(on_board.cwiseQuotient(half));
    row(kOrigin) = normal.dot(T.linear() * by_origin(seen.point));
    row.segment<3>(kShift) = BoardShift(-1, -on_board.x(), -on_board.y());
    row(kFirstBeam) = -slope;
    at[kFirstBeam] = kFirstBeam + beam_of_ring_[seen.ring];
    row /= slope;
    const BoardShift own = row.segment<3>(kShift);
    for (Eigen::Index a = 0; a < row.size(); ++a) {
      const Eigen::Index i = at[static_cast<size_t>(a)];
      for (Eigen::Index b = 0; b < row.size(); ++b) {
        out.shared(i, at[static_cast<size_t>(b)]) += row(a) * row(b);
      }
      out.cross.row(i) += row(a) * own.transpose();
      out.shared_gradient(i) -= row(a) * residual;
    }
    out.own += own * own.transpose();
    out.own_gradient -= own * residual;
    out.squares += residual * residual;
    out.returns += 1;
  }
  return out;
}

ShiftCovariance TargetModel::shift_covariance(const TargetView& view) {
  const Eigen::Matrix3d axes = view.T_refcam_board.linear();
  const Eigen::Vector3d normal = axes.col(2);
  const Eigen::Vector3d middle = view.T_refcam_board * view.board.middle();
  Eigen::Matrix<double, 3, 6> by_pose = Eigen::Matrix<double, 3, 6>::Zero();
  by_pose.row(0) << middle.cross(normal).transpose(), normal.transpose();
  by_pose.row(1).head<3>() = -axes.col(1).transpose();
  by_pose.row(2).head<3>() = axes.col(0).transpose();
  return by_pose * view.board_covariance * by_pose.transpose() +
         kMinShift * kMinShift * ShiftCovariance::Identity();
}

}  // namespace infuse::target

#include "fusion/registration/uncertainty.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

#include "fusion/geometry/symmetric_eigen.hpp"
#include "fusion/registration/lengths.hpp"
#include "fusion/registration/voxel_key.hpp"

namespace infuse::registration {
namespace {

using geometry::Matrix6;
using geometry::Vector6;

constexpr size_t kClusterSlots = 4096;  // bounds memory: clusters that share one are one
constexpr double kMinArm = 0.1;         // m; points nearer to an axis do not show the rotation
constexpr double kNoiseFloor =
    0.001;  // m; error of a cluster that its residuals hide (decision 17)

/// What the noise of normals adds to Σ w (Jn)(Jn)ᵀ: of pairs whose normal is the commonest one but
/// for its noise, the difference from that of the commonest one.
Matrix6 tilt_by_noise(const Pairs& pairs, const PoseSystem& system, const PairNoise& noise) {
  constexpr float kSigmas = 3;  // 99.7 % of a Gaussian
  const Eigen::Vector3f common =
      geometry::symmetric_eigen<3>(system.planes.bottomRightCorner<3, 3>())
          .vectors.col(2)
          .cast<float>();
  const auto width2 = static_cast<float>(noise.robust_width * noise.robust_width);
  Matrix6 sum = Matrix6::Zero();
  for (size_t i = 0; i < pairs.size; ++i) {
    if (!(pairs.weight[i] > 0) || !(pairs.tilt[i] > 0)) continue;
    const float nx = pairs.tx[i], ny = pairs.ty[i], nz = pairs.tz[i];
    const float cosine = nx * common.x() + ny * common.y() + nz * common.z();
    if (1 - cosine * cosine > kSigmas * kSigmas * pairs.tilt[i]) continue;
    double weight = static_cast<double>(pairs.weight[i]);
    if (width2 > 0) {
      const float d = nx * (pairs.qx[i] - pairs.px[i]) + ny * (pairs.qy[i] - pairs.py[i]) +
                      nz * (pairs.qz[i] - pairs.pz[i]);
      const float kernel = width2 / (width2 + d * d);
      weight *= static_cast<double>(kernel * kernel);
    }
    const Eigen::Vector3d p(pairs.px[i], pairs.py[i], pairs.pz[i]), n(nx, ny, nz);
    Vector6 own, other;
    own << p.cross(n), n;
    other << p.cross(common.cast<double>()), common.cast<double>();
    sum += weight * (own * own.transpose() - other * other.transpose());
  }
  return sum;
}

/// Twists about the points' middle that move the points by 1 m in the root mean square: M^−½ with
/// M the mean square displacement of the points by a twist. A rotation so counts by the points'
/// distances from its axis, however far they reach along it.
Matrix6 unit_displacements(const PoseSystem& system) {
  const Eigen::Matrix3d to_middle = geometry::skew(system.mean);
  const Eigen::Matrix3d arms = system.arms / system.weight + to_middle * to_middle;
  const auto eigen = geometry::symmetric_eigen<3>(arms);
  Matrix6 unit = Matrix6::Identity();
  unit.topLeftCorner<3, 3>() =
      eigen.vectors *
      eigen.values.cwiseMax(kMinArm * kMinArm).cwiseSqrt().cwiseInverse().asDiagonal() *
      eigen.vectors.transpose();
  return unit;
}

}  // namespace

DeterminedDirections determined_directions(const Pairs& pairs, const PoseSystem& system,
                                           const PairNoise& noise, double min_plane_fraction) {
  DeterminedDirections out;
  if (!(system.weight > 0)) {
    out.count = 0;
    return out;
  }
  // exp(twist about the origin) = middle · exp(scaled twist) · middle⁻¹
  Eigen::Isometry3d middle = Eigen::Isometry3d::Identity();
  middle.translation() = system.mean;
  out.twist_from_scaled = geometry::adjoint(middle) * unit_displacements(system);
  // A plane whose normal is the direction counts 1 / 2ε.
  const Matrix6 planes =
      2 * noise.plane_variance * system.planes - tilt_by_noise(pairs, system, noise);
  const Matrix6 scaled =
      out.twist_from_scaled.transpose() * planes * out.twist_from_scaled / system.weight;
  const auto eigen = geometry::symmetric_eigen<6>(scaled);
  out.basis = eigen.vectors.rowwise().reverse();
  out.count = static_cast<int>((eigen.values.array() >= min_plane_fraction).count());
  return out;
}

Vector6 determined_step(const PoseSystem& system, const DeterminedDirections& determined) {
  if (determined.count == 0) return Vector6::Zero();
  Matrix6 directions = determined.twist_from_scaled * determined.basis;
  directions.rightCols(6 - determined.count).setZero();
  Matrix6 H = directions.transpose() * (system.planes + system.isotropic) * directions;
  for (int i = determined.count; i < 6; ++i) H(i, i) = 1;
  const Vector6 g = directions.transpose() * system.gradient;
  return directions * H.llt().solve(g);
}

void ClusterGradients::clear() {
  sums_.assign(2 * kClusterSlots, Vector6::Zero());
  square_ = 0;
}

void ClusterGradients::add(const Pairs& pairs, size_t i, const PairGradient& at) {
  const auto cell = [](float c) { return floor_to_int(std::clamp(c / kClusterSize, -1e5, 1e5)); };
  const uint64_t key = voxel_key(cell(pairs.px[i]), cell(pairs.py[i]), cell(pairs.pz[i]));
  const size_t slot = voxel_hash(key) % kClusterSlots;
  sums_[2 * slot] += at.gradient;
  sums_[2 * slot + 1] += kNoiseFloor * at.normal;
  const double distance = (pairs.qx[i] - pairs.px[i]) * pairs.tx[i] +
                          (pairs.qy[i] - pairs.py[i]) * pairs.ty[i] +
                          (pairs.qz[i] - pairs.pz[i]) * pairs.tz[i];
  square_ += at.weight * distance * distance;
}

Matrix6 ClusterGradients::scatter() const {
  Matrix6 scatter = Matrix6::Zero();
  for (const Vector6& sum : sums_) scatter += sum * sum.transpose();
  return scatter;
}

void set_uncertainty(const ClusterGradients& clusters, const PoseSystem& system,
                     const DeterminedDirections& determined, RegistrationResult& result) {
  const int count = determined.count;
  result.free_directions = 6 - count;
  for (int i = count; i < 6; ++i) {
    result.free[static_cast<size_t>(i - count)] = determined.basis.col(i);
  }
  result.rms = std::sqrt(clusters.square() / std::max(system.weight, 1e-12));
  const Matrix6 scatter = clusters.scatter();
  const Matrix6 to_scaled = determined.twist_from_scaled;
  const Eigen::Matrix<double, 6, Eigen::Dynamic, 0, 6, 6> directions =
      to_scaled * determined.basis.leftCols(count);
  Matrix6 variance = Matrix6::Zero(), information = Matrix6::Zero();  // in the units of the basis
  if (count > 0) {
    using Small = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, 6, 6>;
    const Small H = directions.transpose() * system.planes * directions;
    const Small inverse = H.llt().solve(Small::Identity(count, count));
    const Small spread = inverse * (directions.transpose() * scatter * directions) * inverse;
    variance.topLeftCorner(count, count) = spread;
    information.topLeftCorner(count, count) = spread.llt().solve(Small::Identity(count, count));
  }
  for (int i = count; i < 6; ++i) variance(i, i) = RegistrationResult::kFreeVariance;
  const Matrix6 to_twist = to_scaled * determined.basis;
  const Matrix6 from_twist = to_twist.inverse();
  result.covariance = to_twist * variance * to_twist.transpose();
  result.information = from_twist.transpose() * information * from_twist;
}

}  // namespace infuse::registration

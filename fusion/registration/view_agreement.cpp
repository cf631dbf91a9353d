#include "fusion/registration/view_agreement.hpp"

#include <Eigen/Eigenvalues>
#include <cmath>

namespace infuse::registration {
namespace {

constexpr float kSupport = 0.6F;         // m, distance of a point that supports another
constexpr float kAlongCommonest = 0.8F;  // cosine between a normal and the commonest one

/// Direction of which most normals have a large part.
Eigen::Vector3f commonest_normal(const PointCloud& cloud) {
  Eigen::Matrix3d spread = Eigen::Matrix3d::Zero();
  for (size_t i = 0; i < cloud.size(); ++i) {
    const Eigen::Vector3d n(cloud.nx[i], cloud.ny[i], cloud.nz[i]);
    spread += n * n.transpose();
  }
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(spread);
  return solver.eigenvectors().col(2).cast<float>();
}

}  // namespace

double ViewAgreement::share() const {
  const size_t judged = supported + refuted;
  return judged == 0 ? 0 : static_cast<double>(supported) / static_cast<double>(judged);
}

double ViewAgreement::overlap() const {
  const size_t all = supported + refuted + unseen;
  return all == 0 ? 0 : static_cast<double>(supported) / static_cast<double>(all);
}

ViewAgreement ViewAgreement::operator+(const ViewAgreement& other) const {
  return {supported + other.supported, refuted + other.refuted, unseen + other.unseen};
}

ViewAgreement ViewOfScan::judge(const PointCloud& other,
                                const Eigen::Isometry3d& T_this_other) const {
  const Eigen::Vector3f ground = commonest_normal(other);
  const Eigen::Isometry3f T = T_this_other.cast<float>();
  ViewAgreement out;
  for (size_t i = 0; i < other.size(); ++i) {
    const Eigen::Vector3f normal(other.nx[i], other.ny[i], other.nz[i]);
    if (normal.squaredNorm() == 0 || std::abs(normal.dot(ground)) > kAlongCommonest) continue;
    const Eigen::Vector3f p = T * Eigen::Vector3f(other.x[i], other.y[i], other.z[i]);
    if (scan_.search.nearest(p.data(), kSupport, 0).index >= 0) {
      ++out.supported;
      continue;
    }
    const float range = p.norm(), seen = ranges_.range_towards(p);
    ++(seen > range + static_cast<float>(kClearance) ? out.refuted : out.unseen);
  }
  return out;
}

ViewAgreement agreement(const ViewOfScan& target, const PointCloud& target_cloud,
                        const ViewOfScan& source, const PointCloud& source_cloud,
                        const Eigen::Isometry3d& T_target_source) {
  return target.judge(source_cloud, T_target_source) +
         source.judge(target_cloud, T_target_source.inverse());
}

}  // namespace infuse::registration

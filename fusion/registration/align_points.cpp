#include "fusion/registration/align_points.hpp"

#include "fusion/registration/gicp.hpp"

namespace infuse::registration {
namespace {

PreparedCloud prepare(std::span<const Eigen::Vector3f> points) {
  FieldVector<float> x, y, z;
  for (auto* field : {&x, &y, &z}) field->reserve(points.size());
  for (const Eigen::Vector3f& point : points) {
    x.push_back(point.x()), y.push_back(point.y()), z.push_back(point.z());
  }
  return prepare_cloud({x, y, z});
}

}  // namespace

RegistrationResult align_points(std::span<const Eigen::Vector3f> target,
                                std::span<const Eigen::Vector3f> source,
                                const Eigen::Isometry3d& T_target_source_guess) {
  return gicp(prepare(target), prepare(source).cloud, T_target_source_guess);
}

}  // namespace infuse::registration

#include "drivers/ros/messages.hpp"

namespace infuse::ros {

Eigen::Isometry3d to_isometry(const Transform& transform) {
  const auto& [x, y, z] = transform.translation;
  const Quaternion& q = transform.rotation;
  Eigen::Isometry3d motion = Eigen::Isometry3d::Identity();
  motion.linear() = Eigen::Quaterniond(q.w, q.x, q.y, q.z).normalized().toRotationMatrix();
  motion.translation() = Eigen::Vector3d(x, y, z);
  return motion;
}

Transform to_transform(const Eigen::Isometry3d& motion) {
  const Eigen::Quaterniond q(motion.linear());
  const Eigen::Vector3d t = motion.translation();
  return {{t.x(), t.y(), t.z()}, {q.x(), q.y(), q.z(), q.w()}};
}

}  // namespace infuse::ros

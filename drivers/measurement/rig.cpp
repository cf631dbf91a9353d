#include "drivers/measurement/rig.hpp"

#include <algorithm>
#include <cmath>

namespace infuse {
namespace {

bool is_rigid(const Eigen::Isometry3d& T) {
  constexpr double kTolerance = 1e-6;
  const Eigen::Matrix3d R = T.linear();
  return T.matrix().allFinite() && (R * R.transpose()).isIdentity(kTolerance) &&
         R.determinant() > 0;
}

template <class Mount>
const Mount* find_by_name(const std::vector<Mount>& mounts, const std::string& name) {
  const auto at =
      std::find_if(mounts.begin(), mounts.end(), [&](const Mount& m) { return m.name == name; });
  return at == mounts.end() ? nullptr : &*at;
}

template <class Mount>
std::optional<std::string> find_name_error(const std::vector<Mount>& mounts) {
  for (const Mount& mount : mounts) {
    if (mount.name.empty()) return "a sensor has no name";
    if (find_by_name(mounts, mount.name) != &mount)
      return "two sensors are named '" + mount.name + "'";
  }
  return std::nullopt;
}

}  // namespace

std::optional<std::string> CameraIntrinsics::invalid() const {
  if (width <= 0 || height <= 0) return "width and height must be positive";
  if (!(fx > 0) || !(fy > 0) || !std::isfinite(fx) || !std::isfinite(fy))
    return "fx and fy must be positive";
  if (!std::isfinite(cx) || !std::isfinite(cy)) return "cx and cy must be finite";
  for (const double k : distortion) {
    if (!std::isfinite(k)) return "distortion must be finite";
  }
  return std::nullopt;
}

std::optional<std::string> Rig::invalid() const {
  if (auto wrong = find_name_error(lidars)) return wrong;
  if (auto wrong = find_name_error(cameras)) return wrong;
  for (const LidarMount& lidar : lidars) {
    if (!is_rigid(lidar.T_vehicle_lidar))
      return "T_vehicle_lidar of '" + lidar.name + "' is not a rigid motion";
  }
  for (const CameraMount& camera : cameras) {
    if (auto wrong = camera.intrinsics.invalid()) return "camera '" + camera.name + "': " + *wrong;
    if (find_lidar(camera.lidar) == nullptr) {
      return "camera '" + camera.name + "' refers to lidar '" + camera.lidar +
             "', which does not exist";
    }
    if (!is_rigid(camera.T_camera_lidar))
      return "T_camera_lidar of '" + camera.name + "' is not a rigid motion";
  }
  return std::nullopt;
}

const LidarMount* Rig::find_lidar(const std::string& name) const {
  return find_by_name(lidars, name);
}
const CameraMount* Rig::find_camera(const std::string& name) const {
  return find_by_name(cameras, name);
}

}  // namespace infuse

#include "drivers/recording/rig_checks.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <numbers>
#include <tuple>

#include "drivers/measurement/angles.hpp"

namespace infuse::recording {
namespace {

// The longest road trains of Australia's national scheme are 53.5 m.
constexpr double kMaxOffset = 53.5;  // m
// A lens of 2000 mm sees 1.03° of a full-frame sensor; no rectilinear lens reaches 170°.
constexpr double kMinView = 1 * kDegree, kMaxRectilinearView = 170 * kDegree;
constexpr double kMaxPixelRatio = 2;  // an anamorphic lens squeezes by two

/// Distance from the axis at which a direction is imaged, over the focal length. `r`: tangent of
/// the angle to the axis, or the angle itself of a fisheye lens.
double distorted(const CameraIntrinsics& intrinsics, double r) {
  const auto& k = intrinsics.distortion;
  const double s = r * r;
  if (intrinsics.model == CameraIntrinsics::Model::kFisheye) {
    return r * (1 + s * (k[0] + s * (k[1] + s * (k[2] + s * k[3]))));
  }
  return r * (1 + s * (k[0] + s * (k[1] + s * k[4])));
}

/// True if directions farther from the axis are imaged nearer to it, within the image: up to the
/// farthest of its edges, but not into the corners.
bool folds(const CameraIntrinsics& intrinsics) {
  constexpr double kStep = 0.005, kMaxRadius = 20;
  const double edge =
      std::max(std::max(intrinsics.cx, intrinsics.width - 1 - intrinsics.cx) / intrinsics.fx,
               std::max(intrinsics.cy, intrinsics.height - 1 - intrinsics.cy) / intrinsics.fy);
  const bool fisheye = intrinsics.model == CameraIntrinsics::Model::kFisheye;
  double before = 0;
  for (double r = kStep; r < (fisheye ? std::numbers::pi : kMaxRadius); r += kStep) {
    const double now = distorted(intrinsics, r);
    if (now <= before) return true;
    if (now >= edge) return false;
    before = now;
  }
  return !fisheye;
}

template <class... Values>
std::string print(const char* format, Values... values) {
  std::array<char, 200> text{};
  std::snprintf(text.data(), text.size(), format, values...);
  return text.data();
}

std::optional<std::string> find_far(const char* transform, const Eigen::Isometry3d& T) {
  const double distance = T.translation().norm();
  if (distance <= kMaxOffset) return std::nullopt;
  return print("%s moves by %.0f m: its unit is the metre", transform, distance);
}

}  // namespace

std::optional<std::string> find_impossible(const CameraIntrinsics& intrinsics) {
  const auto view = [](int pixels, double f) { return 2 * std::atan(pixels / (2 * f)); };
  const bool fisheye = intrinsics.model == CameraIntrinsics::Model::kFisheye;
  for (const auto& [name, f, pixels] : {std::tuple{"fx", intrinsics.fx, intrinsics.width},
                                        std::tuple{"fy", intrinsics.fy, intrinsics.height}}) {
    const double angle = view(pixels, f);
    if (angle >= kMinView && (fisheye || angle <= kMaxRectilinearView)) continue;
    return print("%s = %g pixels lets the camera see %.3g°", name, f, angle / kDegree);
  }
  const double ratio = intrinsics.fx / intrinsics.fy;
  if (std::max(ratio, 1 / ratio) > kMaxPixelRatio) {
    return print("fx is %.3g times fy", ratio);
  }
  if (!(intrinsics.cx >= -0.5 && intrinsics.cx <= intrinsics.width - 0.5 && intrinsics.cy >= -0.5 &&
        intrinsics.cy <= intrinsics.height - 0.5)) {
    return print("cx, cy = %g, %g lies outside the image", intrinsics.cx, intrinsics.cy);
  }
  if (folds(intrinsics)) return "distortion folds the image onto itself";
  return std::nullopt;
}

std::optional<std::string> find_impossible(const CameraMount& mount) {
  if (auto wrong = find_impossible(mount.intrinsics)) return wrong;
  if (mount.T_camera_lidar.matrix() == Eigen::Matrix4d::Identity()) {
    return "T_camera_lidar is the identity: a camera's z axis points forward, a lidar's up";
  }
  return find_far("T_camera_lidar", mount.T_camera_lidar);
}

std::optional<std::string> find_impossible(const LidarMount& mount) {
  return find_far("T_vehicle_lidar", mount.T_vehicle_lidar);
}

}  // namespace infuse::recording

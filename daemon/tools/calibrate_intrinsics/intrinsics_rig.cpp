#include "daemon/tools/calibrate_intrinsics/intrinsics_rig.hpp"

#include "daemon/playback/list_images.hpp"
#include "drivers/recording/drive_toml.hpp"

namespace infuse::daemon {
namespace {

/// Lidar coordinates (x forward, y left, z up) to those of a camera beside it that looks forward.
Eigen::Isometry3d looking_forward() {
  Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
  T.linear() << 0, -1, 0, 0, 0, -1, 1, 0, 0;
  return T;
}

}  // namespace

Result<Rig> with_intrinsics(Rig rig, const std::string& name, const CameraIntrinsics& intrinsics,
                            const IntrinsicsSigma& sigma) {
  const bool known = name.empty() ? !rig.cameras.empty() : rig.find_camera(name) != nullptr;
  if (!known) {
    if (rig.lidars.empty()) rig.lidars.push_back({.name = "lidar", .model = ""});
    rig.cameras.push_back({.name = name.empty() ? "camera" : name,
                           .intrinsics = intrinsics,
                           .lidar = rig.lidars.front().name,
                           .T_camera_lidar = looking_forward(),
                           .intrinsics_sigma = sigma});
    return rig;
  }
  const auto camera = find_camera(rig, name, "the rig");
  if (!camera) return tl::unexpected(camera.error());
  rig.cameras[*camera].intrinsics = intrinsics;
  rig.cameras[*camera].intrinsics_sigma = sigma;
  return rig;
}

Result<bool> write_intrinsics(const std::filesystem::path& path, const Rig& rig,
                              const std::string& name, const CameraIntrinsics& intrinsics,
                              const IntrinsicsSigma& sigma) {
  std::error_code error;
  const Result<Rig> before =
      std::filesystem::exists(path, error) ? recording::read_rig(path) : Result<Rig>(rig);
  if (!before) return tl::unexpected(before.error());
  const auto after = with_intrinsics(*before, name, intrinsics, sigma);
  if (!after) return tl::unexpected(after.error());
  if (const auto written = recording::write_rig(path, *after); !written) {
    return tl::unexpected(written.error());
  }
  return !before->cameras.empty() && after->cameras.size() > before->cameras.size();
}

}  // namespace infuse::daemon

#include "drivers/import/bag_mounts.hpp"

#include <algorithm>

namespace infuse::importers {

Result<CameraIntrinsics> intrinsics_of(const BagCamera& camera) {
  const ros::CameraInfo& info = camera.info;
  CameraIntrinsics intrinsics;
  intrinsics.width = static_cast<int>(std::min<uint32_t>(info.width, 1 << 20));
  intrinsics.height = static_cast<int>(std::min<uint32_t>(info.height, 1 << 20));
  intrinsics.fx = camera.rectified ? info.p[0] : info.k[0];
  intrinsics.fy = camera.rectified ? info.p[5] : info.k[4];
  intrinsics.cx = camera.rectified ? info.p[2] : info.k[2];
  intrinsics.cy = camera.rectified ? info.p[6] : info.k[5];
  if (info.binning_x > 1 || info.binning_y > 1 || info.roi.x_offset != 0 || info.roi.y_offset != 0)
    return fail("has a camera_info with binning or a region of interest, which is not taken");
  const bool fisheye = info.distortion_model == "equidistant" || info.distortion_model == "fisheye";
  if (camera.rectified) return intrinsics;
  if (fisheye) intrinsics.model = CameraIntrinsics::Model::kFisheye;
  const size_t terms = fisheye ? 4 : intrinsics.distortion.size();
  for (size_t k = 0; k < info.d.size(); ++k) {
    if (k < terms) {
      intrinsics.distortion[k] = info.d[k];
    } else if (info.d[k] != 0) {
      return fail("has the distortion '" + info.distortion_model + "' of " +
                  std::to_string(info.d.size()) + " terms, which is not taken");
    }
  }
  return intrinsics;
}

LidarMount mount_of(const BagLidar& lidar, const std::string& vehicle_frame,
                    BagImportSummary& summary) {
  LidarMount mount;
  mount.name = lidar.name;
  if (const auto T = summary.survey.frames.find(vehicle_frame, lidar.frame)) {
    mount.T_vehicle_lidar = *T;
  } else {
    summary.notes.push_back({"no transform between '" + vehicle_frame + "' and '" + lidar.frame +
                                 "': the mounting is unknown",
                             lidar.topic, "set T_vehicle_lidar in drive.toml"});
  }
  return mount;
}

void relate_to_lidar(const BagCamera& camera, CameraMount& mount, BagImportSummary& summary) {
  const FrameTree& frames = summary.survey.frames;
  const auto& lidars = summary.selection.lidars;
  const auto direct = std::ranges::find(lidars, frames.parent_of(camera.frame), &BagLidar::frame);
  if (direct != lidars.end()) {
    if (const auto T = frames.find(camera.frame, direct->frame)) {
      mount.lidar = direct->name;
      mount.T_camera_lidar = *T;
      return;
    }
  }
  for (const BagLidar& lidar : lidars) {
    const auto T = frames.find(camera.frame, lidar.frame);
    if (!T) continue;
    mount.lidar = lidar.name;
    mount.T_camera_lidar = *T;
    return;
  }
  mount.lidar = lidars.front().name;
  mount.T_camera_lidar.linear() << 0, -1, 0, 0, 0, -1, 1, 0, 0;
  summary.notes.push_back({"no transform between '" + camera.frame +
                               "' and a lidar: the pose of "
                               "the camera is not known, it is set to look along the lidar's x",
                           camera.topic, "set T_camera_lidar in drive.toml"});
}

Eigen::Matrix3d rotation_of(const std::string& name, const char* what,
                            const std::string& vehicle_frame, BagImportSummary& summary) {
  const BagTopic* topic = name.empty() ? nullptr : summary.survey.find(name);
  if (topic == nullptr || topic->frame.empty()) return Eigen::Matrix3d::Identity();
  if (const auto T = summary.survey.frames.find(vehicle_frame, topic->frame)) return T->linear();
  summary.notes.push_back({"no transform between '" + vehicle_frame + "' and '" + topic->frame +
                               "': " + what + " are taken as along the vehicle's axes",
                           name, ""});
  return Eigen::Matrix3d::Identity();
}

}  // namespace infuse::importers

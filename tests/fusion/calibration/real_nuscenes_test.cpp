#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <nlohmann/json.hpp>

#include "drivers/measurement/angles.hpp"
#include "fusion/calibration/calibrate.hpp"
#include "tests/fusion/calibration/kitti_pairs.hpp"
#include "tests/real_data.hpp"

namespace infuse::calibration {
namespace {

using nlohmann::json;

/// An HDL-32E's sweep as nuScenes stores it: x, y, z, intensity 0 … 255, ring, all float32, in
/// order of firing. A firing ends where the ring falls.
Sweep read_sweep(const std::filesystem::path& path) {
  const std::vector<uint8_t> bytes = kitti::read_bytes(path);
  Sweep sweep;
  sweep.resize(bytes.size() / 20);
  sweep.rings = 32;
  uint32_t column = 0;
  float last = -1;
  for (size_t i = 0; i < sweep.size(); ++i) {
    float v[5];
    std::memcpy(v, &bytes[20 * i], sizeof v);
    if (v[4] <= last) ++column;
    last = v[4];
    sweep.x[i] = v[0];
    sweep.y[i] = v[1];
    sweep.z[i] = v[2];
    sweep.range[i] = std::hypot(v[0], v[1], v[2]);
    sweep.reflectivity[i] = v[3] / 255;
    sweep.ring[i] = static_cast<uint16_t>(v[4]);
    sweep.column[i] = static_cast<uint16_t>(column);
  }
  return sweep;
}

struct NuscenesRig {
  std::vector<Scene> scenes;  ///< one per camera
  std::vector<RigCamera> cameras;
  Eigen::Isometry3d T_refcam_lidar = Eigen::Isometry3d::Identity();  ///< as published
};

Eigen::Isometry3d matrix(const json& rows) {
  Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
  for (int r = 0; r < 3; ++r) {
    for (int c = 0; c < 4; ++c) {
      T.matrix()(r, c) = rows.at(static_cast<size_t>(r)).at(static_cast<size_t>(c)).get<double>();
    }
  }
  return T;
}

NuscenesRig read_rig(const std::filesystem::path& folder) {
  const auto text = kitti::read_bytes(folder / "calib.json");
  const json calib = json::parse(text.begin(), text.end());
  NuscenesRig rig;
  Sweep sweep;
  for (const auto& entry : std::filesystem::directory_iterator(folder)) {
    if (entry.path().extension() == ".bin") sweep = read_sweep(entry.path());
  }
  for (const auto& [name, entry] : calib.at("images").items()) {
    CameraFrame frame;
    const auto image = kitti::read_bytes(folder / entry.at("img_path").get<std::string>());
    EXPECT_TRUE(camera::decode_image(image, {}, frame)) << name;
    const json& K = entry.at("cam2img");
    const CameraIntrinsics intrinsics{.width = frame.width,
                                      .height = frame.height,
                                      .fx = K[0][0].get<double>(),
                                      .fy = K[1][1].get<double>(),
                                      .cx = K[0][2].get<double>(),
                                      .cy = K[1][2].get<double>()};
    const Eigen::Isometry3d T_camera_lidar = matrix(entry.at("lidar2cam"));
    if (rig.cameras.empty()) rig.T_refcam_lidar = T_camera_lidar;
    const geometry::CameraModel model(intrinsics);
    auto scene =
        make_scene(sweep, frame, {.rings = features::ring_directions(model, T_camera_lidar)});
    EXPECT_TRUE(scene) << name;
    if (!scene) continue;
    scene->camera = rig.cameras.size();
    scene->name = name;
    rig.cameras.push_back({model, T_camera_lidar * rig.T_refcam_lidar.inverse()});
    rig.scenes.push_back(std::move(*scene));
  }
  return rig;
}

/// Within a degree of the published extrinsics, or refused.
void expect_never_confidently_wrong(const CalibrationResult& result, const NuscenesRig& rig) {
  if (!result.usable()) return;
  const geometry::Vector6 off = geometry::log(result.T_refcam_lidar * rig.T_refcam_lidar.inverse());
  EXPECT_LT(off.head<3>().norm(), 1 * kDegree);
  EXPECT_LT(off.tail<3>().norm(), 0.2);
}

TEST(RealNuscenes, SixCamerasAndOneSweepTogether) {
  INFUSE_REAL_DATA_OR_SKIP(folder, "calibration/nuscenes");
  const NuscenesRig rig = read_rig(folder);
  ASSERT_EQ(rig.cameras.size(), 6U);
  for (const auto& start : kitti::draw_initial_poses(rig.T_refcam_lidar, 1 * kDegree, 0.05, 2, 3)) {
    expect_never_confidently_wrong(calibrate(rig.scenes, rig.cameras, start, {}), rig);
  }
  expect_never_confidently_wrong(calibrate(rig.scenes, rig.cameras, rig.T_refcam_lidar, {}), rig);
}

TEST(RealNuscenes, OneCameraAndOneSweepAreRefused) {
  INFUSE_REAL_DATA_OR_SKIP(folder, "calibration/nuscenes");
  NuscenesRig rig = read_rig(folder);
  rig.scenes.resize(1);
  const CalibrationResult result = calibrate(rig.scenes, rig.cameras, rig.T_refcam_lidar, {});
  EXPECT_FALSE(result.usable());
  EXPECT_THAT(result.reason, testing::HasSubstr("at least 3"));
}

}  // namespace
}  // namespace infuse::calibration

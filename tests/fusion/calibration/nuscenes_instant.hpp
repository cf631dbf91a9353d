#pragma once

#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "drivers/camera/image_decoder.hpp"
#include "drivers/measurement/rig.hpp"
#include "drivers/measurement/sweep.hpp"
#include "tests/fusion/calibration/kitti_pairs.hpp"

/// One sweep of nuScenes, and the images of six cameras with it.
namespace infuse::nuscenes {

/// A camera's image, its intrinsics and its published place.
struct Shot {
  std::string name;
  CameraFrame frame;
  CameraIntrinsics intrinsics;
  Eigen::Isometry3d T_camera_lidar;
};

struct Instant {
  Sweep sweep;
  std::vector<Shot> shots;
};

/// An HDL-32E's sweep as nuScenes stores it: x, y, z, intensity 0 … 255, ring, all float32, in
/// order of firing. A firing ends where the ring falls.
inline Sweep read_sweep(const std::filesystem::path& path) {
  const std::vector<uint8_t> bytes = calibration::kitti::read_bytes(path);
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

inline Eigen::Isometry3d matrix(const nlohmann::json& rows) {
  Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
  for (int r = 0; r < 3; ++r) {
    for (int c = 0; c < 4; ++c) {
      T.matrix()(r, c) = rows.at(static_cast<size_t>(r)).at(static_cast<size_t>(c)).get<double>();
    }
  }
  return T;
}

/// Reads `folder` (data/calibration/nuscenes).
inline Instant read_instant(const std::filesystem::path& folder) {
  const auto text = calibration::kitti::read_bytes(folder / "calib.json");
  const auto calib = nlohmann::json::parse(text.begin(), text.end());
  Instant instant;
  for (const auto& entry : std::filesystem::directory_iterator(folder)) {
    if (entry.path().extension() == ".bin") instant.sweep = read_sweep(entry.path());
  }
  for (const auto& [name, entry] : calib.at("images").items()) {
    Shot& shot = instant.shots.emplace_back();
    shot.name = name;
    const auto image =
        calibration::kitti::read_bytes(folder / entry.at("img_path").get<std::string>());
    EXPECT_TRUE(camera::decode_image(image, {}, shot.frame)) << name;
    const nlohmann::json& K = entry.at("cam2img");
    shot.intrinsics = {.width = shot.frame.width,
                       .height = shot.frame.height,
                       .fx = K[0][0].get<double>(),
                       .fy = K[1][1].get<double>(),
                       .cx = K[0][2].get<double>(),
                       .cy = K[1][2].get<double>()};
    shot.T_camera_lidar = matrix(entry.at("lidar2cam"));
  }
  return instant;
}

}  // namespace infuse::nuscenes

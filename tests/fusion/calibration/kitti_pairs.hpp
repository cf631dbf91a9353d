#pragma once

#include <Eigen/Geometry>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <random>
#include <string>
#include <vector>

#include "drivers/camera/image_decoder.hpp"
#include "drivers/import/kitti_calibration.hpp"
#include "drivers/import/kitti_files.hpp"
#include "drivers/measurement/error.hpp"
#include "drivers/recording/sweep_files.hpp"
#include "fusion/calibration/scene.hpp"
#include "fusion/calibration/visible_points.hpp"
#include "fusion/geometry/rigid_motion.hpp"

/// Recorded pairs of a sweep and an image in KITTI's object layout, with the published extrinsics.
namespace infuse::calibration::kitti {

struct Pairs {
  std::vector<Scene> scenes;
  std::vector<RigCamera> cameras;                                    ///< one
  Eigen::Isometry3d T_camera_lidar = Eigen::Isometry3d::Identity();  ///< as published
};

inline std::vector<uint8_t> read_bytes(const std::filesystem::path& path) {
  std::ifstream stream(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(stream), {}};
}

/// All pairs of camera 2 in `folder` (data/calibration/kitti).
inline Result<Pairs> read_pairs(const std::filesystem::path& folder, SceneOptions options) {
  Pairs pairs;
  for (const auto& [number, path] : importers::list_files(folder / "velodyne", ".bin")) {
    const std::string stem = path.stem().string();
    const auto calibration = importers::read_kitti_calibration(folder / "calib" / (stem + ".txt"));
    if (!calibration) return tl::unexpected(calibration.error());
    Sweep sweep;
    if (auto read = recording::read_sweep_file(path, sweep); !read)
      return tl::unexpected(read.error());
    CameraFrame frame;
    const auto image = read_bytes(folder / "image_2" / (stem + ".png"));
    if (auto decoded = camera::decode_image(image, {}, frame); !decoded)
      return tl::unexpected(decoded.error());
    if (pairs.cameras.empty()) {
      pairs.T_camera_lidar = calibration->T_camera_lidar(2);
      pairs.cameras.push_back(
          {geometry::CameraModel(calibration->intrinsics(2, frame.width, frame.height))});
      options.rings = features::ring_directions(pairs.cameras.front().model, pairs.T_camera_lidar);
    }
    auto scene = make_scene(sweep, frame, options);
    if (!scene) return tl::unexpected(scene.error());
    scene->name = stem;
    pairs.scenes.push_back(std::move(*scene));
  }
  return pairs;
}

/// Draws poses uniformly within ± `radians` about each axis and ± `metres` along each.
inline std::vector<Eigen::Isometry3d> draw_initial_poses(const Eigen::Isometry3d& T, double radians,
                                                         double metres, int count, uint64_t seed) {
  std::mt19937_64 random(seed);
  const auto even = [&] { return static_cast<double>(random() >> 11) * 0x1p-52 - 1.0; };
  std::vector<Eigen::Isometry3d> starts;
  for (int i = 0; i < count; ++i) {
    geometry::Vector6 xi;
    for (int k = 0; k < 6; ++k) xi(k) = even() * (k < 3 ? radians : metres);
    starts.push_back(geometry::exp(xi) * T);
  }
  return starts;
}

}  // namespace infuse::calibration::kitti

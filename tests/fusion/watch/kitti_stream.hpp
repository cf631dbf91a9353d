#pragma once

#include <fstream>
#include <iterator>
#include <vector>

#include "drivers/camera/colour.hpp"
#include "drivers/camera/picture.hpp"
#include "drivers/recording/kitti_calibration.hpp"
#include "drivers/recording/kitti_files.hpp"
#include "drivers/recording/sweep_files.hpp"
#include "fusion/watch/reestimate.hpp"
#include "fusion/watch/watch.hpp"

/// KITTI's pairs of a sweep and a picture, one after the other as if they were one drive.
namespace infuse::watch::kitti {

/// The pairs of camera 2, and the published extrinsics.
struct Stream {
  std::vector<CameraFrame> pictures;
  std::vector<Sweep> sweeps;
  CameraIntrinsics camera;
  Eigen::Isometry3d T_camera_lidar;
};

/// Reads `folder` (data/calibration/kitti); empty where something is missing.
inline Stream read_stream(const std::filesystem::path& folder) {
  Stream stream;
  for (const auto& [number, path] : recording::list_numbered(folder / "velodyne", ".bin")) {
    const std::string stem = path.stem().string();
    const auto calibration = recording::read_kitti_calibration(folder / "calib" / (stem + ".txt"));
    Sweep sweep;
    if (!calibration || !recording::read_sweep_bin(path, sweep)) return {};
    std::ifstream file(folder / "image_2" / (stem + ".png"), std::ios::binary);
    const std::vector<char> bytes{std::istreambuf_iterator<char>(file), {}};
    CameraFrame frame, grey;
    if (!camera::decode_picture({reinterpret_cast<const uint8_t*>(bytes.data()), bytes.size()}, {},
                                frame)) {
      return {};
    }
    camera::to_grey(frame, grey);
    stream.camera = calibration->intrinsics(2, grey.width, grey.height);  // all are of one camera
    stream.T_camera_lidar = calibration->T_camera_lidar(2);
    stream.pictures.push_back(std::move(grey));
    stream.sweeps.push_back(std::move(sweep));
  }
  return stream;
}

/// Drives past all pairs again and again, twice a second, until a drift is certain or `rounds` are
/// over.
inline WatchReport drive(Watch& watch, const Stream& stream, int rounds) {
  WatchReport report;
  int next = 0;
  for (int round = 0; round < rounds; ++round) {
    for (size_t i = 0; i < stream.pictures.size(); ++i) {
      CameraFrame grey = stream.pictures[i];
      grey.stamp = Stamp::from_ns(500'000'000LL * ++next);
      report = watch.take(grey, view_of(stream.sweeps[i]),
                          {.velocity = Eigen::Vector3d(0, 0, 16 + next % 3)});
      if (report.drift == Drift::kDrifted) return report;
    }
  }
  return report;
}

/// Estimates anew from every pair, as kept under a wrong calibration.
inline Reestimate estimate(const Stream& stream, const Eigen::Isometry3d& wrong) {
  WatchOptions options;
  options.store.capacity = stream.pictures.size();
  Watch watch(stream.camera, wrong, options);
  drive(watch, stream, 1);
  std::vector<StoredScene> scenes;
  watch.scenes().copy(Stamp::earliest(), scenes);
  return reestimate(scenes, stream.camera, wrong, {});
}

}  // namespace infuse::watch::kitti

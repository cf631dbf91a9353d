#pragma once

#include <fstream>
#include <iterator>
#include <vector>

#include "drivers/camera/colour.hpp"
#include "drivers/camera/image_decoder.hpp"
#include "drivers/import/kitti_calibration.hpp"
#include "drivers/import/kitti_files.hpp"
#include "drivers/recording/sweep_files.hpp"
#include "fusion/monitoring/calibration_monitor.hpp"
#include "fusion/monitoring/reestimate.hpp"

/// KITTI's pairs of a sweep and an image, one after the other as if they were one drive.
namespace infuse::monitoring::kitti {

/// The pairs of camera 2, and the published extrinsics.
struct Stream {
  std::vector<CameraFrame> images;
  std::vector<Sweep> sweeps;
  CameraIntrinsics camera;
  Eigen::Isometry3d T_camera_lidar;
};

/// Reads `folder` (data/calibration/kitti); empty where something is missing.
inline Stream read_stream(const std::filesystem::path& folder) {
  Stream stream;
  for (const auto& [number, path] : importers::list_files(folder / "velodyne", ".bin")) {
    const std::string stem = path.stem().string();
    const auto calibration = importers::read_kitti_calibration(folder / "calib" / (stem + ".txt"));
    Sweep sweep;
    if (!calibration || !recording::read_sweep_file(path, sweep)) return {};
    std::ifstream file(folder / "image_2" / (stem + ".png"), std::ios::binary);
    const std::vector<char> bytes{std::istreambuf_iterator<char>(file), {}};
    CameraFrame frame, grey;
    if (!camera::decode_image({reinterpret_cast<const uint8_t*>(bytes.data()), bytes.size()}, {},
                              frame)) {
      return {};
    }
    camera::to_grey(frame, grey);
    stream.camera = calibration->intrinsics(2, grey.width, grey.height);  // one camera for all
    stream.T_camera_lidar = calibration->T_camera_lidar(2);
    stream.images.push_back(std::move(grey));
    stream.sweeps.push_back(std::move(sweep));
  }
  return stream;
}

/// Processes all pairs `rounds` times, two a second; stops at a confirmed drift.
inline MonitorReport drive(CalibrationMonitor& monitor, const Stream& stream, int rounds) {
  MonitorReport report;
  int next = 0;
  for (int round = 0; round < rounds; ++round) {
    for (size_t i = 0; i < stream.images.size(); ++i) {
      CameraFrame grey = stream.images[i];
      grey.stamp = Stamp::from_ns(500'000'000LL * ++next);
      report = monitor.process(grey, make_sweep_view(stream.sweeps[i]),
                               {.velocity = Eigen::Vector3d(0, 0, 16 + next % 3)});
      if (report.verdict.drift == Drift::kConfirmed) return report;
    }
  }
  return report;
}

/// Re-estimates from every pair, as stored under a wrong calibration.
inline Reestimate estimate(const Stream& stream, const Eigen::Isometry3d& wrong) {
  MonitorOptions options;
  options.scene_store.capacity = stream.images.size();
  CalibrationMonitor monitor(stream.camera, wrong, options);
  drive(monitor, stream, 1);
  const auto scenes = monitor.scenes().lend(Stamp::earliest());
  return reestimate(scenes, stream.camera, wrong, {});
}

}  // namespace infuse::monitoring::kitti

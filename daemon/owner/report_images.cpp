#include "daemon/owner/report_images.hpp"

#include <algorithm>
#include <cmath>

#include "daemon/drawing/calibration_images.hpp"
#include "daemon/drawing/sweep_image.hpp"
#include "daemon/pipeline/odometry_plan.hpp"
#include "daemon/playback/calibration_scenes.hpp"
#include "daemon/playback/deskewed_sweeps.hpp"
#include "daemon/playback/play_lidar.hpp"
#include "daemon/setup/drive_setup.hpp"
#include "fusion/streetmap/draw_map.hpp"

namespace infuse::daemon {
namespace {

constexpr int kScenesRead = 12;       // of each camera, spread over the drive
constexpr size_t kScenesDrawn = 2;    // of each camera
constexpr uint64_t kDrawnSweep = 30;  // the vehicle moves and the clock has settled
constexpr int kMaxMapPixels = 6000;   // pixels of the whole map
constexpr double kMapMargin = 25;     // m around the path

/// The scenes to draw: spread over those since the drift began, if there are any.
std::vector<const ScenePair*> choose_scenes(const ScenePairs& pairs,
                                            const ReportedCalibration& calibration) {
  std::vector<const ScenePair*> since_drift, all;
  for (const ScenePair& pair : pairs.pairs) {
    all.push_back(&pair);
    if (calibration.drift_since && pair.stamp >= *calibration.drift_since) {
      since_drift.push_back(&pair);
    }
  }
  const auto& from = since_drift.empty() ? all : since_drift;
  const size_t count = std::min(kScenesDrawn, from.size());
  std::vector<const ScenePair*> chosen;
  for (size_t k = 0; k < count; ++k) {
    chosen.push_back(from[(2 * k + 1) * from.size() / (2 * count)]);
  }
  return chosen;
}

/// A rectangle of an image in kBgr8.
CameraFrame cut(const CameraFrame& image, int left, int top, int width, int height) {
  CameraFrame part;
  part.width = width;
  part.height = height;
  part.format = image.format;
  for (int row = top; row < top + height; ++row) {
    const auto* begin = image.pixels.data() + static_cast<size_t>(row) * image.row_bytes() +
                        static_cast<size_t>(left) * 3;
    part.pixels.insert(part.pixels.end(), begin, begin + static_cast<size_t>(width) * 3);
  }
  return part;
}

}  // namespace

Json overlay_images(const std::filesystem::path& drive, const ReportData& reports, Json& notes) {
  Json images = Json::array();
  for (const auto& [camera, calibration] : reports.calibrations()) {
    const auto pairs = read_scene_pairs(
        {.drives = {drive.string()}, .cameras = {camera}, .max_scenes = kScenesRead},
        [](double) {});
    if (!pairs) {
      notes.push_back("No lidar over the images of " + camera + ": " + pairs.error().message());
      continue;
    }
    const CameraIntrinsics& intrinsics = pairs->cameras.front().intrinsics;
    for (const ScenePair* pair : choose_scenes(*pairs, calibration)) {
      Json image = {{"device", camera},
                    {"t", to_seconds(pair->stamp - *reports.start())},
                    {"before", data_url(draw_overlay(*pair, intrinsics, calibration.T_first))}};
      if (!calibration.T_last.isApprox(calibration.T_first, 1e-9)) {
        image["after"] = data_url(draw_overlay(*pair, intrinsics, calibration.T_last));
      }
      images.push_back(std::move(image));
    }
  }
  return images;
}

std::string sweep_image_url(const std::filesystem::path& path) {
  auto setup = open_drive(path, {}, {});
  if (!setup || setup->lidars.empty()) return {};
  DeskewedSweeps sweeps(plan_odometry({}, *setup), setup->rig.lidars.front().T_vehicle_lidar);
  std::string url;
  uint64_t count = 0;
  const auto draw = [&](const Sweep& sweep, const motion::DeskewedSweep& deskewed) {
    if (count++ <= kDrawnSweep) url = data_url(draw_sweep(sweep, deskewed));
  };
  play_lidar(
      *setup, 0, [&](Sweep& sweep) { sweeps.add_sweep(sweep); },
      [&](const VehicleSample& sample) { sweeps.add_sample(sample); },
      [&](const recording::DriveEvent& event) {
        sweeps.process_due(event.stamp, draw);
        return count <= kDrawnSweep;
      });
  if (count <= kDrawnSweep) sweeps.finish(draw);
  return url;
}

Json map_image(const streetmap::SegmentMap& map, const Eigen::AlignedBox2d& path) {
  if (map.empty() || path.isEmpty()) return nullptr;
  const CameraFrame image = streetmap::draw_map(map, kMaxMapPixels);
  const double cells_per_m = image.width / (map.columns() * map.frame().cell_size);
  const Eigen::Vector2d corner = map.frame().min_corner;
  const auto cell = [&](double m, int limit) {
    return static_cast<int>(std::clamp(m * cells_per_m, 0.0, static_cast<double>(limit)));
  };
  const Eigen::Vector2d low = path.min().array() - kMapMargin - corner.array();
  const Eigen::Vector2d high = path.max().array() + kMapMargin - corner.array();
  const int left = cell(low.x(), image.width), right = cell(high.x(), image.width);
  const int bottom = cell(low.y(), image.height), top = cell(high.y(), image.height);
  if (right <= left || top <= bottom) return nullptr;
  const CameraFrame part = cut(image, left, image.height - top, right - left, top - bottom);
  return {{"url", data_url(part)},
          {"x", corner.x() + left / cells_per_m},
          {"y", corner.y() + bottom / cells_per_m},
          {"width", part.width / cells_per_m},
          {"height", part.height / cells_per_m}};
}

}  // namespace infuse::daemon

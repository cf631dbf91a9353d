#include "daemon/owner/report_images.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "daemon/drawing/calibration_images.hpp"
#include "daemon/drawing/sweep_image.hpp"
#include "daemon/drawing/view_from_above.hpp"
#include "daemon/pipeline/odometry_plan.hpp"
#include "daemon/playback/calibration_scenes.hpp"
#include "daemon/playback/deskewed_sweeps.hpp"
#include "daemon/playback/play_lidar.hpp"
#include "daemon/setup/drive_setup.hpp"

namespace infuse::daemon {
namespace {

constexpr int kScenesRead = 12;      // of each camera, spread over the drive
constexpr size_t kScenesDrawn = 2;   // of each camera
constexpr int kMaxMapPixels = 2000;  // of the longer edge
constexpr double kMapMargin = 25;    // m around the path

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

/// Colours of the kinds of segments in their order (blue, green, red): muted, so that a track
/// stands out; as daemon/view/page/plan.js has them.
constexpr std::array<Colour, streetmap::kSegmentKindCount> kMutedKinds{{{238, 242, 243},
                                                                        {219, 215, 214},
                                                                        {184, 178, 176},
                                                                        {219, 228, 232},
                                                                        {210, 226, 236},
                                                                        {186, 222, 230},
                                                                        {216, 234, 222},
                                                                        {238, 224, 208},
                                                                        {238, 230, 234},
                                                                        {206, 212, 222},
                                                                        {158, 164, 178},
                                                                        {230, 230, 230},
                                                                        {150, 150, 150}}};

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

Json sweep_image_json(const std::filesystem::path& path, Stamp stamp) {
  auto setup = open_drive(path, {}, {});
  if (!setup || setup->lidars.empty()) return nullptr;
  DeskewedSweeps sweeps(plan_odometry({}, *setup), setup->rig.lidars.front().T_vehicle_lidar);
  Json drawn;
  const auto draw = [&](const Sweep& sweep, const motion::DeskewedSweep& deskewed) {
    if (!drawn.is_null() || sweep.stamp < stamp || sweep.size() == 0) return;
    drawn = {{"url", data_url(draw_sweep(sweep, deskewed))},
             {"stamp_ns", std::to_string(sweep.stamp.ns())},
             {"seam", std::atan2(sweep.y[0], sweep.x[0])},
             {"metres", kSweepViewMetres}};
  };
  play_lidar(
      *setup, 0, [&](Sweep& sweep) { sweeps.add_sweep(sweep); },
      [&](const VehicleSample& sample) { sweeps.add_sample(sample); },
      [&](const recording::DriveEvent& event) {
        sweeps.process_due(event.stamp, draw);
        return drawn.is_null();
      });
  if (drawn.is_null()) sweeps.finish(draw);
  return drawn;
}

Json map_image(const streetmap::SegmentMap& map, const Eigen::AlignedBox2d& path) {
  if (map.empty() || path.isEmpty()) return nullptr;
  const Eigen::Vector2d low = path.min().array() - kMapMargin;
  const Eigen::Vector2d size = path.max() - path.min() + Eigen::Vector2d::Constant(2 * kMapMargin);
  const double pixel = std::max(map.frame().cell_size, size.maxCoeff() / kMaxMapPixels);
  CameraFrame image;
  image.format = PixelFormat::kBgr8;
  image.width = static_cast<int>(std::ceil(size.x() / pixel));
  image.height = static_cast<int>(std::ceil(size.y() / pixel));
  image.pixels.reserve(image.row_bytes() * static_cast<size_t>(image.height));
  for (int row = image.height - 1; row >= 0; --row) {
    for (int column = 0; column < image.width; ++column) {
      const uint32_t id =
          map.id_at(low.x() + (column + 0.5) * pixel, low.y() + (row + 0.5) * pixel);
      const Colour& colour = kMutedKinds.at(static_cast<size_t>(map.segment(id).kind));
      image.pixels.insert(image.pixels.end(), colour.begin(), colour.end());
    }
  }
  return {{"url", data_url(image)},
          {"x", low.x()},
          {"y", low.y()},
          {"width", image.width * pixel},
          {"height", image.height * pixel}};
}

}  // namespace infuse::daemon

#include "daemon/tools/align/align_scan.hpp"

#include <optional>

#include "daemon/pipeline/odometry_plan.hpp"
#include "daemon/playback/camera_images.hpp"
#include "daemon/playback/deskewed_sweeps.hpp"
#include "daemon/playback/find_lidar.hpp"
#include "daemon/playback/play_lidar.hpp"
#include "daemon/setup/drive_setup.hpp"
#include "drivers/recording/sweep_export.hpp"
#include "drivers/recording/sweep_files.hpp"
#include "drivers/text/numbers.hpp"

namespace infuse::daemon {
namespace {

Result<AlignScan> read_from_drive(const std::string& path, uint64_t index, const std::string& name,
                                  bool with_images) {
  auto setup = open_drive(path, {}, {});
  if (!setup) return tl::unexpected(setup.error());
  const auto lidar = find_lidar(*setup, name);
  if (!lidar) return tl::unexpected(lidar.error());
  std::vector<CameraImages> images;
  if (with_images) {
    auto listed = list_camera_images(path, setup->rig.lidars[*lidar].name);
    if (!listed) return tl::unexpected(listed.error());
    images = std::move(*listed);
  }
  constexpr uint64_t kRunIn = 10;  // sweeps before it, from which the lidar knows its motion
  std::optional<AlignScan> found;
  Stamp reference;
  const auto choose_reference = [&](const Sweep& sweep) {
    reference = sweep.stamp + sweep.span / 2;
    if (!images.empty()) {
      const Stamp exposure = images.front().nearest(reference).stamp;
      if (distance_between(exposure, reference) <= kMaxImageGap) reference = exposure;
    }
    return reference;
  };
  DeskewedSweeps sweeps(plan_odometry({}, *setup, *lidar),
                        setup->rig.lidars[*lidar].T_vehicle_lidar, choose_reference);
  const auto on_deskewed = [&](const Sweep& sweep, const motion::DeskewedSweep& deskewed) {
    if (sweep.sequence != index) return;
    found.emplace();
    found->sweep = sweep;
    found->sweep.x = deskewed.x;
    found->sweep.y = deskewed.y;
    found->sweep.z = deskewed.z;
    found->deskew_reason = deskewed.reason;
  };
  play_lidar(
      *setup, *lidar,
      [&](Sweep& sweep) {
        if (sweep.sequence <= index && sweep.sequence + kRunIn >= index) sweeps.add_sweep(sweep);
      },
      [&](const VehicleSample& sample) { sweeps.add_sample(sample); },
      [&](const recording::DriveEvent& event) {
        sweeps.process_due(event.stamp, on_deskewed);
        return !found.has_value();
      });
  if (!found) sweeps.finish(on_deskewed);
  if (!found) {
    return fail("has no sweep " + std::to_string(index), path, "infuse inspect lists them");
  }
  auto read = read_nearest_images(images, *setup, reference);
  if (!read) return tl::unexpected(read.error());
  found->cameras = std::move(read->cameras);
  found->images = std::move(read->images);
  return std::move(*found);
}

}  // namespace

Result<AlignScan> read_align_scan(const std::string& path, const std::string& lidar, bool images) {
  const size_t colon = path.rfind(':');
  if (colon != std::string::npos) {
    if (const auto index = text::parse_as<uint64_t>(path.substr(colon + 1))) {
      return read_from_drive(path.substr(0, colon), *index, lidar, images);
    }
  }
  const auto format = recording::detect_sweep_format(path);
  if (!format || *format == recording::SweepFormat::kCsv) {
    return fail("is neither PATH:INDEX nor a .pcd, .ply or .bin file", path);
  }
  if (images) {
    return fail("has no images", path, "vb-gicp and mi need sweeps of a drive: PATH:INDEX");
  }
  AlignScan scan;
  scan.deskew_reason = "the file has no times";
  if (auto read = recording::read_sweep_file(path, scan.sweep); !read) {
    return tl::unexpected(read.error());
  }
  return scan;
}

}  // namespace infuse::daemon

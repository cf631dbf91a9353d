#include "daemon/tools/align/align_scan.hpp"

#include <algorithm>
#include <optional>

#include "daemon/pipeline/odometry_plan.hpp"
#include "daemon/playback/deskewed_sweeps.hpp"
#include "daemon/playback/find_lidar.hpp"
#include "daemon/playback/play_lidar.hpp"
#include "daemon/playback/read_image.hpp"
#include "daemon/setup/drive_setup.hpp"
#include "drivers/recording/sweep_export.hpp"
#include "drivers/recording/sweep_files.hpp"
#include "drivers/recording/times_csv.hpp"
#include "drivers/text/numbers.hpp"

namespace infuse::daemon {
namespace {

constexpr Duration kMaxGap{50'000'000};  // from a sweep's middle to an exposure

/// Images of one camera.
struct CameraImages {
  size_t camera;  // index in the rig
  std::vector<recording::SequenceEntry> entries;

  /// The image whose exposure is nearest.
  const recording::SequenceEntry& nearest(Stamp time) const {
    return *std::min_element(entries.begin(), entries.end(), [&](const auto& a, const auto& b) {
      return distance_between(a.stamp, time) < distance_between(b.stamp, time);
    });
  }
};

/// Lists the images of the cameras of a lidar; at least one of each.
Result<std::vector<CameraImages>> list_images(const std::string& path, const std::string& lidar) {
  const auto drive = recording::Drive::open(path);
  if (!drive) return tl::unexpected(drive.error());
  const recording::DriveDescription& description = drive->description;
  std::vector<CameraImages> out;
  for (size_t camera = 0; camera < description.rig.cameras.size(); ++camera) {
    const CameraMount& mount = description.rig.cameras[camera];
    if (mount.lidar != lidar) continue;
    auto files = recording::index_images(drive->resolve(description.cameras[camera].images),
                                         mount.stamp_delay);
    if (!files) return tl::unexpected(files.error());
    if (files->entries.empty()) return fail("camera '" + mount.name + "' has no images", path);
    out.push_back({camera, std::move(files->entries)});
  }
  if (out.empty()) {
    return fail("there is no camera for lidar '" + lidar + "'", path,
                "choose a method that needs no images");
  }
  return out;
}

/// Adds the image of each camera that is nearest to the time.
Result<void> read_images(const std::vector<CameraImages>& cameras, const SensorSetup& setup,
                         Stamp time, AlignScan& out) {
  for (const CameraImages& images : cameras) {
    const CameraMount& mount = setup.rig.cameras[images.camera];
    const recording::SequenceEntry& image = images.nearest(time);
    if (distance_between(image.stamp, time) > kMaxGap) {
      return fail("camera '" + mount.name + "' has no image within 50 ms of the sweep",
                  setup.path.string(), "choose another sweep");
    }
    auto frame = read_scene_image(image.path, setup.cameras[images.camera].image);
    if (!frame) return tl::unexpected(frame.error());
    out.cameras.push_back(mount);
    out.images.push_back(std::move(*frame));
  }
  return {};
}

Result<AlignScan> read_from_drive(const std::string& path, uint64_t index, const std::string& name,
                                  bool with_images) {
  auto setup = open_drive(path, {}, {});
  if (!setup) return tl::unexpected(setup.error());
  const auto lidar = find_lidar(*setup, name);
  if (!lidar) return tl::unexpected(lidar.error());
  std::vector<CameraImages> images;
  if (with_images) {
    auto listed = list_images(path, setup->rig.lidars[*lidar].name);
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
      if (distance_between(exposure, reference) <= kMaxGap) reference = exposure;
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
  if (auto read = read_images(images, *setup, reference, *found); !read) {
    return tl::unexpected(read.error());
  }
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

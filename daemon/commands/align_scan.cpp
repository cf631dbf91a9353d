#include "daemon/commands/align_scan.hpp"

#include <algorithm>
#include <optional>

#include "daemon/commands/deskewed_sweeps.hpp"
#include "daemon/commands/play_lidar.hpp"
#include "daemon/commands/read_image.hpp"
#include "drivers/recording/sweep_export.hpp"
#include "drivers/recording/sweep_files.hpp"
#include "drivers/recording/times_csv.hpp"
#include "drivers/text/numbers.hpp"

namespace infuse::daemon {
namespace {

constexpr Duration kMaxGap{75'000'000};  // between the middle of the sweep and an exposure

/// Adds the image of each of the lidar's cameras that is nearest to the time.
Result<void> read_images(const recording::Drive& drive, const DriveSetup& setup,
                         const std::string& lidar, Stamp time, AlignScan& out) {
  const Rig& rig = drive.description.rig;
  for (size_t camera = 0; camera < rig.cameras.size(); ++camera) {
    const CameraMount& mount = rig.cameras[camera];
    if (mount.lidar != lidar) continue;
    const auto files =
        recording::index_images(drive.resolve(drive.description.cameras[camera].images));
    if (!files) return tl::unexpected(files.error());
    const auto gap = [&](const recording::SequenceEntry& image) {
      const Duration d = image.stamp - mount.stamp_delay - time;
      return d.count() < 0 ? -d : d;
    };
    const auto nearest =
        std::min_element(files->entries.begin(), files->entries.end(),
                         [&](const auto& a, const auto& b) { return gap(a) < gap(b); });
    if (nearest == files->entries.end() || gap(*nearest) > kMaxGap) {
      return fail("camera '" + mount.name + "' has no image within 75 ms of the sweep",
                  drive.folder.string(), "choose another sweep");
    }
    auto frame = read_image(nearest->path, setup.cameras[camera]);
    if (!frame) return tl::unexpected(frame.error());
    out.cameras.push_back(mount);
    out.images.push_back(std::move(*frame));
  }
  if (out.images.empty()) {
    return fail("there is no camera for lidar '" + lidar + "'", drive.folder.string(),
                "choose a method that needs no images");
  }
  return {};
}

Result<AlignScan> read_from_drive(const std::string& path, uint64_t index, const std::string& name,
                                  bool images) {
  auto setup = open_drive(path, {}, {});
  if (!setup) return tl::unexpected(setup.error());
  const auto lidar = find_lidar(*setup, name);
  if (!lidar) return tl::unexpected(lidar.error());
  std::optional<AlignScan> found;
  Stamp middle;
  DeskewedSweeps sweeps(setup->rig.lidars[*lidar].T_vehicle_lidar, {}, 0.5);
  const auto on_deskewed = [&](const Sweep& sweep, const motion::DeskewedSweep& deskewed) {
    found.emplace();
    found->sweep = sweep;
    found->sweep.x = deskewed.x;
    found->sweep.y = deskewed.y;
    found->sweep.z = deskewed.z;
    found->deskew_reason = deskewed.reason;
    middle = deskewed.reference;
  };
  play_lidar(
      *setup, *lidar,
      [&](Sweep& sweep) {
        if (sweep.sequence == index) sweeps.add_sweep(sweep);
      },
      [&](const VehicleSample& sample) { sweeps.add_sample(sample); },
      [&](const recording::DriveEvent& event) {
        sweeps.process_due(event.stamp, on_deskewed);
        return !found.has_value();
      });
  if (!found) sweeps.finish(on_deskewed);
  if (!found)
    return fail("has no sweep " + std::to_string(index), path, "infuse inspect lists them");
  if (!images) return std::move(*found);
  const auto drive = recording::Drive::open(path);
  if (!drive) return tl::unexpected(drive.error());
  if (auto read = read_images(*drive, *setup, setup->rig.lidars[*lidar].name, middle, *found);
      !read) {
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

#include "daemon/playback/calibration_scenes.hpp"

#include <spdlog/fmt/fmt.h>

#include <algorithm>
#include <map>

#include "daemon/pipeline/odometry_plan.hpp"
#include "daemon/playback/play_lidar.hpp"
#include "daemon/playback/read_image.hpp"
#include "daemon/playback/sweep_pairing.hpp"
#include "daemon/setup/drive_setup.hpp"
#include "drivers/recording/drive_toml.hpp"
#include "drivers/recording/times_csv.hpp"
#include "fusion/geometry/rolling_shutter.hpp"

namespace infuse::daemon {
namespace {

namespace fs = std::filesystem;

/// An open drive and the indices of the two sensors in it.
struct OpenDrive {
  recording::Drive drive;
  SensorSetup setup;
  size_t camera = 0;
  size_t lidar = 0;
  std::vector<recording::SequenceEntry> images;  ///< stamps are those of the exposures
};

template <class Mounts>
Result<size_t> find_by_name(const Mounts& mounts, const std::string& name, const char* kind,
                            const std::string& drive) {
  std::string names;
  for (size_t i = 0; i < mounts.size(); ++i) {
    if (mounts[i].name == name || (name.empty() && mounts.size() == 1)) return i;
    names += (i == 0 ? "" : ", ") + mounts[i].name;
  }
  if (mounts.empty()) return fail(fmt::format("the drive has no {}", kind), drive);
  return fail(name.empty() ? fmt::format("the drive has several {}s", kind)
                           : fmt::format("the drive has no {} '{}'", kind, name),
              drive, fmt::format("choose one with --{}: {}", kind, names));
}

Result<OpenDrive> open_sensors(const std::string& path, const std::string& name,
                               const std::string& lidar_name) {
  auto drive = recording::Drive::open(path);
  if (!drive) return tl::unexpected(drive.error());
  const Rig& rig = drive->description.rig;
  const auto camera = find_by_name(rig.cameras, name, "camera", path);
  if (!camera) return tl::unexpected(camera.error());
  const CameraMount& mount = rig.cameras[*camera];
  const auto lidar =
      find_by_name(rig.lidars, lidar_name.empty() ? mount.lidar : lidar_name, "lidar", path);
  if (!lidar) return tl::unexpected(lidar.error());
  if (mount.lidar != rig.lidars[*lidar].name) {
    return fail(
        fmt::format("the extrinsics of camera '{}' refer to lidar '{}'", mount.name, mount.lidar),
        path, "choose that lidar");
  }
  auto images = recording::index_images(drive->resolve(drive->description.cameras[*camera].images),
                                        mount.stamp_delay);
  if (!images) return tl::unexpected(images.error());
  auto setup = open_drive(path, {}, {});
  if (!setup) return tl::unexpected(setup.error());
  return OpenDrive{std::move(*drive), std::move(*setup), *camera, *lidar,
                   std::move(images->entries)};
}

/// `count` of the entries, spread evenly.
std::vector<recording::SequenceEntry> select_evenly(
    const std::vector<recording::SequenceEntry>& all, size_t count) {
  if (all.size() <= count) return all;
  std::vector<recording::SequenceEntry> selected;
  for (size_t k = 0; k < count; ++k)
    selected.push_back(all[(2 * k + 1) * all.size() / (2 * count)]);
  return selected;
}

/// Receives the sweep of each image, in order.
using SweepConsumer = std::function<Result<void>(size_t image, PairedSweep&& sweep)>;

/// Plays the drive and finds the sweep of each image.
Result<void> pair_sweeps(OpenDrive& drive, const std::vector<recording::SequenceEntry>& images,
                         Duration max_gap, const std::function<void(double)>& progress,
                         const SweepConsumer& consume) {
  const Rig& rig = drive.drive.description.rig;
  const OdometrySettings odometry = plan_odometry({}, drive.setup, drive.lidar);
  SweepPairing pairing(odometry, rig.lidars[drive.lidar].T_vehicle_lidar,
                       *odometry.use_lidar || drive.setup.vehicle.has_odometry(), max_gap);
  for (const recording::SequenceEntry& image : images) pairing.add_exposure(image.stamp);
  const auto on_sweep = [&](Sweep& sweep) { pairing.add_sweep(sweep); };
  const auto on_sample = [&](const VehicleSample& sample) { pairing.add_sample(sample); };
  const double span = images.empty() ? 1 : to_seconds(images.back().stamp - images.front().stamp);
  Result<void> consumed;
  size_t taken = 0;
  play_lidar(
      drive.setup, drive.lidar, on_sweep, on_sample, [&](const recording::DriveEvent& event) {
        pairing.advance(event.stamp);
        for (; consumed && taken < pairing.settled(); ++taken) {
          consumed = consume(taken, pairing.take(taken));
        }
        if (!images.empty() && span > 0) {
          progress(std::clamp(to_seconds(event.stamp - images.front().stamp) / span, 0.0, 1.0));
        }
        return consumed && !pairing.done();
      });
  std::vector<PairedSweep> rest = pairing.finish();
  for (; consumed && taken < rest.size(); ++taken) {
    consumed = consume(taken, std::move(rest[taken]));
  }
  return consumed;
}

/// Moves the returns to the exposures of their rows, if the shutter is rolling. By the rig's
/// extrinsics: those that are sought differ by a few rows.
void move_to_rows(const CameraMount& mount, PairedSweep& pair) {
  if (mount.readout == Duration::zero() || !pair.twist || !pair.deskew_reason.empty()) return;
  Sweep& sweep = pair.sweep;
  std::vector<float> u(sweep.size()), v(sweep.size()), depth(sweep.size());
  const geometry::CameraModel camera(mount.intrinsics);
  geometry::RollingShutter{camera, mount.readout, *pair.twist}.move(
      mount.T_camera_lidar, sweep.x, sweep.y, sweep.z, {u, v, depth});
}

/// Adds a drive's pairs of one camera; notes what is left out.
Result<void> add_pairs(OpenDrive& drive, size_t camera, size_t count, const SceneRequest& request,
                       const std::function<void(double)>& progress, const PairConsumer& consume,
                       ScenePairs& out) {
  const auto images = select_evenly(drive.images, count);
  const CameraMount& mount = out.cameras[camera];
  std::string label = fs::path(drive.drive.folder).lexically_normal().filename().string();
  if (request.cameras.size() > 1) label += "/" + mount.name;
  size_t unpaired = 0;
  std::map<std::string, size_t> not_deskewed;
  const auto add = [&](size_t k, PairedSweep&& sweep) -> Result<void> {
    if (!sweep.found) {
      ++unpaired;
      return {};
    }
    auto frame = read_scene_image(images[k].path, drive.setup.cameras[drive.camera].image);
    if (!frame) return tl::unexpected(frame.error());
    const CameraIntrinsics& intrinsics = mount.intrinsics;
    if (frame->width != intrinsics.width || frame->height != intrinsics.height) {
      return fail(fmt::format("the image has {} x {} pixels, the rig states {} x {}", frame->width,
                              frame->height, intrinsics.width, intrinsics.height),
                  images[k].path.string(),
                  "intrinsics are valid for one image size only: infuse calibrate-intrinsics "
                  "estimates those of another");
    }
    frame->stamp = images[k].stamp;
    if (!sweep.deskew_reason.empty()) ++not_deskewed[sweep.deskew_reason];
    move_to_rows(mount, sweep);
    ScenePair pair{.name = fmt::format("{}/{:06}", label, images[k].number),
                   .camera = camera,
                   .stamp = images[k].stamp,
                   .gap = sweep.gap,
                   .frame = std::move(*frame),
                   .sweep = std::move(sweep.sweep),
                   .deskew_reason = sweep.deskew_reason,
                   .uncompensated = sweep.uncompensated,
                   .twist = sweep.twist,
                   .scenes = {}};
    if (consume) {
      if (auto consumed = consume(out, pair); !consumed) return consumed;
    }
    out.pairs.push_back(std::move(pair));
    return {};
  };
  if (auto paired = pair_sweeps(drive, images, request.max_gap, progress, add); !paired)
    return paired;
  if (unpaired > 0) {
    out.notes.push_back(fmt::format(
        "{}: {} of {} images have no sweep within {:.0f} ms; check that camera and lidar are "
        "stamped by one clock",
        label, unpaired, images.size(), 1e3 * to_seconds(request.max_gap)));
  }
  for (const auto& [reason, times] : not_deskewed) {
    out.notes.push_back(fmt::format("{}: {} sweeps not deskewed: {}", label, times, reason));
  }
  return {};
}

std::optional<Eigen::Isometry3d> true_extrinsics(const OpenDrive& drive,
                                                 const std::string& camera) {
  if (drive.drive.description.truth_rig.empty()) return std::nullopt;
  const auto rig = recording::read_rig(drive.drive.resolve(drive.drive.description.truth_rig));
  const CameraMount* mount = rig ? rig->find_camera(camera) : nullptr;
  if (mount == nullptr) return std::nullopt;
  return mount->T_camera_lidar;
}

bool same_intrinsics(const CameraIntrinsics& a, const CameraIntrinsics& b) {
  return a.model == b.model && a.width == b.width && a.height == b.height && a.fx == b.fx &&
         a.fy == b.fy && a.cx == b.cx && a.cy == b.cy && a.distortion == b.distortion;
}

}  // namespace

Eigen::Isometry3d T_camera_refcam(const ScenePairs& pairs, size_t camera) {
  return pairs.cameras[camera].T_camera_lidar * pairs.cameras.front().T_camera_lidar.inverse();
}

std::string camera_names(const ScenePairs& pairs) {
  std::string names;
  for (size_t c = 0; c < pairs.cameras.size(); ++c) {
    names += (c == 0 ? "" : c + 1 == pairs.cameras.size() ? " and " : ", ") + pairs.cameras[c].name;
  }
  return names;
}

Result<ScenePairs> read_scene_pairs(const SceneRequest& request,
                                    const std::function<void(double)>& progress,
                                    const PairConsumer& consume) {
  ScenePairs out;
  std::vector<std::string> cameras = request.cameras;
  if (cameras.empty()) cameras.emplace_back();
  const size_t drives = request.drives.size();
  for (size_t c = 0; c < cameras.size(); ++c) {
    const size_t before = out.pairs.size();
    for (size_t d = 0; d < drives; ++d) {
      const std::string lidar = request.lidar.empty() ? out.lidar : request.lidar;
      auto opened = open_sensors(request.drives[d], cameras[c], lidar);
      if (!opened) return tl::unexpected(opened.error());
      const Rig& rig = opened->drive.description.rig;
      const CameraMount& camera = rig.cameras[opened->camera];
      if (d == 0) {
        out.cameras.push_back(camera);
        if (c == 0) {
          out.lidar = rig.lidars[opened->lidar].name;
          out.rig = rig;
          out.truth = true_extrinsics(*opened, camera.name);
        }
      } else if (!same_intrinsics(camera.intrinsics, out.cameras[c].intrinsics)) {
        return fail("the camera's intrinsics differ from the first drive's", request.drives[d],
                    "calibrate drives of one rig together");
      }
      // Images that earlier drives lack are taken from the following drives.
      const size_t missing = static_cast<size_t>(request.max_scenes) - (out.pairs.size() - before);
      const auto part = [&](double share) {
        progress((static_cast<double>(c * drives + d) + share) /
                 static_cast<double>(cameras.size() * drives));
      };
      if (auto added = add_pairs(*opened, c, missing / (drives - d), request, part, consume, out);
          !added) {
        return tl::unexpected(added.error());
      }
    }
  }
  return out;
}

}  // namespace infuse::daemon

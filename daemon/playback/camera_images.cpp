#include "daemon/playback/camera_images.hpp"

#include <algorithm>

#include "daemon/playback/read_image.hpp"
#include "daemon/setup/drive_setup.hpp"
#include "drivers/recording/drive_toml.hpp"

namespace infuse::daemon {

const recording::SequenceEntry& CameraImages::nearest(Stamp time) const {
  return *std::min_element(entries.begin(), entries.end(), [&](const auto& a, const auto& b) {
    return distance_between(a.stamp, time) < distance_between(b.stamp, time);
  });
}

Result<std::vector<CameraImages>> list_camera_images(const std::string& path,
                                                     const std::string& lidar) {
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

Result<ImageSet> read_nearest_images(const std::vector<CameraImages>& cameras,
                                     const SensorSetup& setup, Stamp time) {
  ImageSet out;
  for (const CameraImages& images : cameras) {
    const CameraMount& mount = setup.rig.cameras[images.camera];
    const recording::SequenceEntry& image = images.nearest(time);
    if (distance_between(image.stamp, time) > kMaxImageGap) {
      return fail("camera '" + mount.name + "' has no image within 50 ms of the sweep",
                  setup.path.string(), "choose another sweep");
    }
    auto frame = read_scene_image(image.path, setup.cameras[images.camera].image);
    if (!frame) return tl::unexpected(frame.error());
    out.cameras.push_back(mount);
    out.images.push_back(std::move(*frame));
  }
  return out;
}

}  // namespace infuse::daemon

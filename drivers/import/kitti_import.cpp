#include "drivers/import/kitti_import.hpp"

#include "drivers/gnss/gnss_csv.hpp"
#include "drivers/import/image_size.hpp"
#include "drivers/import/import_files.hpp"
#include "drivers/import/kitti_layouts.hpp"
#include "drivers/recording/drive.hpp"
#include "drivers/recording/drive_toml.hpp"
#include "drivers/recording/imu_csv.hpp"
#include "drivers/recording/speed_csv.hpp"
#include "drivers/recording/trajectory_file.hpp"
#include "drivers/text/text_file.hpp"

namespace infuse::importers {
namespace {

namespace fs = std::filesystem;

Result<KittiRecording> read_layout(KittiLayout layout, const fs::path& folder) {
  switch (layout) {
    case KittiLayout::kRaw:
      return read_kitti_raw(folder);
    case KittiLayout::kOdometry:
      return read_kitti_odometry(folder);
    case KittiLayout::kObject:
      return read_kitti_object(folder);
  }
  return fail("unknown layout", folder.string());
}

// Removes the images whose size differs from that of the first.
ImageSize keep_same_size(std::vector<StampedFile>& images, std::vector<Error>& notes) {
  ImageSize size;
  std::erase_if(images, [&](const StampedFile& image) {
    const auto this_size = read_image_size(image.path);
    if (this_size && size.width == 0) size = *this_size;
    if (this_size && *this_size == size) return false;
    notes.push_back(
        {this_size ? "has a different size from the first image" : "is not a PNG or JPEG image",
         image.path.string(), "this image is skipped"});
    return true;
  });
  return size;
}

void add_lidar(const KittiRecording& recording, recording::DriveDescription& description) {
  LidarMount mount;
  mount.name = "velodyne";
  mount.T_vehicle_lidar = recording.calibration.T_vehicle_lidar();
  description.rig.lidars.push_back(mount);
  description.lidars.push_back(
      {.sweeps = "sweeps", .turn = recording.turn, .deskewed = recording.deskewed});
}

void add_camera(const KittiRecording& recording, size_t camera, const ImageSize& size,
                recording::DriveDescription& description) {
  const KittiCalibration& calibration = recording.calibration;
  CameraMount mount;
  mount.name = "image_" + std::to_string(camera);
  mount.lidar = "velodyne";
  mount.intrinsics = calibration.intrinsics(camera, size.width, size.height);
  mount.T_camera_lidar = calibration.T_camera_lidar(camera);
  mount.stamp_delay = recording.stamp_delay[camera];
  mount.stamp_delay_sigma = recording.stamp_delay_sigma[camera];
  description.rig.cameras.push_back(mount);
  description.cameras.emplace_back().images = mount.name;
}

Result<void> write_truth(const KittiRecording& recording, const fs::path& drive,
                         recording::DriveDescription& description) {
  std::error_code failed;
  fs::create_directories(drive / "truth", failed);
  description.truth_rig = "truth/rig.toml";
  if (auto written = recording::write_rig(drive / description.truth_rig, description.rig); !written)
    return written;
  if (recording.poses.empty()) return {};
  description.truth_poses = "truth/poses.tum";
  return text::write_text(drive / description.truth_poses, recording::format_tum(recording.poses));
}

Result<void> write_samples(const KittiRecording& recording, const fs::path& drive,
                           recording::DriveDescription& description) {
  if (!recording.speed.empty()) {
    description.speed = "speed.csv";
    if (auto written = recording::write_speed_csv(drive / "speed.csv", recording.speed); !written)
      return written;
  }
  if (!recording.imu.empty()) {
    description.imu = "imu.csv";
    if (auto written = recording::write_imu_csv(drive / "imu.csv", recording.imu); !written)
      return written;
  }
  if (!recording.gnss.empty()) {
    description.gnss = "gnss.csv";
    if (auto written = gnss::write_gnss_csv(drive / "gnss.csv", recording.gnss); !written)
      return written;
  }
  return {};
}

/// A recording in a folder below, at most three levels down; nothing if there is none.
std::optional<fs::path> recording_below(const fs::path& folder) {
  constexpr int kMaxDepth = 2, kMaxEntries = 100'000;  // bounds time
  std::error_code error;
  fs::recursive_directory_iterator at(folder, error);
  for (int seen = 0; !error && at != fs::end(at) && seen < kMaxEntries; ++seen) {
    const fs::path name = at->path().filename();
    if (name == "velodyne_points" || name == "velodyne") return at->path().parent_path();
    if (at.depth() >= kMaxDepth) at.disable_recursion_pending();
    at.increment(error);
  }
  return std::nullopt;
}

}  // namespace

const char* name_of(KittiLayout layout) {
  switch (layout) {
    case KittiLayout::kRaw:
      return "raw";
    case KittiLayout::kOdometry:
      return "odometry";
    case KittiLayout::kObject:
      return "object";
  }
  return "unknown";
}

Result<KittiLayout> detect_kitti_layout(const fs::path& folder) {
  std::error_code ignored;
  if (!fs::is_directory(folder, ignored)) return fail("is not a folder", folder.string());
  if (fs::is_directory(folder / "velodyne_points", ignored)) return KittiLayout::kRaw;
  if (fs::is_directory(folder / "velodyne", ignored)) {
    if (fs::is_directory(folder / "calib", ignored)) return KittiLayout::kObject;
    if (fs::exists(folder / "times.txt", ignored) || fs::exists(folder / "calib.txt", ignored))
      return KittiLayout::kOdometry;
  }
  if (const auto below = recording_below(folder)) {
    return fail("has none of KITTI's layouts", folder.string(),
                "a recording is in " + below->string());
  }
  return fail(
      "has none of KITTI's layouts", folder.string(),
      "raw has velodyne_points/, object has velodyne/ and calib/, odometry has velodyne/ and "
      "times.txt");
}

Result<KittiImportSummary> import_kitti(const fs::path& folder, const fs::path& drive) {
  const auto layout = detect_kitti_layout(folder);
  if (!layout) return tl::unexpected(layout.error());
  auto recording = read_layout(*layout, folder);
  if (!recording) return tl::unexpected(recording.error());
  if (recording->sweeps.empty()) return fail("contains no usable sweep", folder.string());
  if (auto made = make_empty_folder(drive); !made) return tl::unexpected(made.error());

  KittiImportSummary result;
  result.layout = *layout;
  result.sweeps = recording->sweeps.size();
  result.poses = recording->poses.size();
  result.times_trusted = recording->times_trusted;
  recording::DriveDescription description;
  description.name = "KITTI, " + std::string(name_of(*layout)) + " layout";
  description.times_trusted = recording->times_trusted;

  add_lidar(*recording, description);
  if (auto linked = link_sequence(recording->sweeps, drive / "sweeps"); !linked)
    return tl::unexpected(linked.error());
  for (size_t camera = 0; camera < recording->images.size(); ++camera) {
    std::vector<StampedFile>& images = recording->images[camera];
    if (images.empty()) continue;
    if (!recording->calibration.projection[camera]) {
      recording->notes.push_back({"the calibration has no P" + std::to_string(camera),
                                  images.front().path.parent_path().string(),
                                  "this camera is skipped"});
      continue;
    }
    const ImageSize size = keep_same_size(images, recording->notes);
    if (images.empty()) continue;
    add_camera(*recording, camera, size, description);
    if (auto linked = link_sequence(images, drive / description.cameras.back().images); !linked)
      return tl::unexpected(linked.error());
    result.images += images.size();
  }
  if (auto written = write_truth(*recording, drive, description); !written)
    return tl::unexpected(written.error());
  if (auto written = write_samples(*recording, drive, description); !written)
    return tl::unexpected(written.error());
  if (auto written = recording::write_drive_toml(drive, description); !written)
    return tl::unexpected(written.error());
  result.notes = std::move(recording->notes);
  return result;
}

}  // namespace infuse::importers

#include "drivers/import/opencalib_import.hpp"

#include <algorithm>
#include <string>
#include <string_view>

#include "drivers/import/calibration_text.hpp"
#include "drivers/import/image_size.hpp"
#include "drivers/import/import_files.hpp"
#include "drivers/recording/drive.hpp"
#include "drivers/recording/drive_toml.hpp"

namespace infuse::importers {
namespace {

namespace fs = std::filesystem;

constexpr std::string_view kCalibrationSuffix = ".calib.txt";

// Files of a scene; empty paths for missing files.
struct SceneFiles {
  std::string name;
  fs::path sweep, image;
};

SceneFiles find_scene_files(const fs::path& calibration) {
  std::error_code ignored;
  std::string name = calibration.filename().string();
  if (name.ends_with(kCalibrationSuffix)) name.resize(name.size() - kCalibrationSuffix.size());
  SceneFiles files{.name = name, .sweep = {}, .image = {}};
  const auto in_same_folder = [&](const char* extension) {
    return calibration.parent_path() / (name + extension);
  };
  if (fs::is_regular_file(in_same_folder(".pcd"), ignored)) files.sweep = in_same_folder(".pcd");
  for (const char* extension : {".jpg", ".png"}) {
    if (fs::is_regular_file(in_same_folder(extension), ignored))
      files.image = in_same_folder(extension);
  }
  return files;
}

Result<CameraIntrinsics> read_intrinsics(const CalibrationText& text, const ImageSize& size) {
  const auto K = text.matrix({"K"}, 3, 3);
  if (!K) return tl::unexpected(K.error());
  CameraIntrinsics intrinsics{.width = size.width,
                              .height = size.height,
                              .fx = (*K)(0, 0),
                              .fy = (*K)(1, 1),
                              .cx = (*K)(0, 2),
                              .cy = (*K)(1, 2)};
  if (const std::vector<double>* distortion = text.find({"D"})) {
    if (distortion->size() > intrinsics.distortion.size()) {
      return fail("D must be at most 5 numbers", text.name(), "expected k1 k2 p1 p2 k3");
    }
    std::copy(distortion->begin(), distortion->end(), intrinsics.distortion.begin());
  }
  if (const auto wrong = intrinsics.invalid()) return fail(*wrong, text.name());
  return intrinsics;
}

Result<recording::DriveDescription> make_description(const CalibrationText& text,
                                                     const SceneFiles& files) {
  const auto size = read_image_size(files.image);
  if (!size) return fail("is not a PNG or JPEG image", files.image.string());
  const auto intrinsics = read_intrinsics(text, *size);
  if (!intrinsics) return tl::unexpected(intrinsics.error());
  const auto T_camera_lidar = text.rigid({"T"}, 4);
  if (!T_camera_lidar) return tl::unexpected(T_camera_lidar.error());
  recording::DriveDescription description;
  description.name = "OpenCalib, " + files.name;
  description.times_trusted = false;
  description.rig.lidars.emplace_back().name = "lidar";
  description.lidars.emplace_back().sweeps = "sweeps";
  description.rig.cameras.push_back({.name = "camera",
                                     .intrinsics = *intrinsics,
                                     .lidar = "lidar",
                                     .T_camera_lidar = *T_camera_lidar});
  description.cameras.emplace_back().images = "camera";
  description.truth_rig = "truth/rig.toml";
  return description;
}

}  // namespace

Result<void> import_opencalib(const fs::path& calibration, const fs::path& drive) {
  const auto text = CalibrationText::read(calibration);
  if (!text) return tl::unexpected(text.error());
  const SceneFiles files = find_scene_files(calibration);
  if (files.sweep.empty() || files.image.empty()) {
    return fail(
        files.sweep.empty() ? "has no sweep in the same folder" : "has no image in the same folder",
        calibration.string(), "expected " + files.name + ".pcd and .png or .jpg");
  }
  const auto description = make_description(*text, files);
  if (!description) return tl::unexpected(description.error());
  if (auto made = make_empty_folder(drive); !made) return made;
  if (auto linked = link_sequence({{.path = files.sweep}}, drive / "sweeps"); !linked)
    return linked;
  if (auto linked = link_sequence({{.path = files.image}}, drive / "camera"); !linked)
    return linked;
  std::error_code failed;
  fs::create_directories(drive / "truth", failed);
  if (auto written = recording::write_rig(drive / description->truth_rig, description->rig);
      !written)
    return written;
  return recording::write_drive_toml(drive, *description);
}

}  // namespace infuse::importers

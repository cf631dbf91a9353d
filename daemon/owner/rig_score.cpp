#include <spdlog/fmt/fmt.h>

#include "daemon/owner/evaluation.hpp"
#include "daemon/protocol/number_json.hpp"
#include "drivers/measurement/angles.hpp"
#include "drivers/recording/drive.hpp"
#include "drivers/recording/drive_toml.hpp"
#include "drivers/recording/rigid_matrix.hpp"
#include "drivers/text/text_file.hpp"

namespace infuse::daemon {
namespace {

constexpr size_t kMaxJsonBytes = 64 << 20;

bool is_folder(const std::filesystem::path& path) {
  std::error_code ignored;
  return std::filesystem::is_directory(path, ignored);
}

Result<Rig> true_rig(const std::filesystem::path& truth) {
  if (!is_folder(truth)) return recording::read_rig(truth);
  const auto drive = recording::Drive::open(truth);
  if (!drive) return tl::unexpected(drive.error());
  if (drive->description.truth_rig.empty()) {
    return fail("the drive has no ground-truth rig", truth.string(),
                "add rig to [truth] in drive.toml");
  }
  return recording::read_rig(drive->resolve(drive->description.truth_rig));
}

/// Extrinsics of one camera.
struct Extrinsics {
  std::string camera;  ///< empty: the truth's only camera
  Eigen::Isometry3d T_camera_lidar = Eigen::Isometry3d::Identity();
};

Result<std::vector<Extrinsics>> read_json(const std::filesystem::path& path) {
  const auto text = text::read_text(path, kMaxJsonBytes);
  if (!text) return tl::unexpected(text.error());
  const Json json = Json::parse(*text, nullptr, false);
  const auto numbers =
      numbers_of(json.is_object() ? json.value("T_camera_lidar", Json()) : Json(), 16);
  if (!numbers) {
    return fail("no T_camera_lidar of 16 numbers", path.string(),
                "give the output of infuse calibrate --json, or a rig.toml");
  }
  const auto rigid = recording::to_rigid(*numbers);
  if (!rigid) return fail("T_camera_lidar is not a rigid transform", path.string());
  const bool named = json.contains("camera") && json["camera"].is_string();
  return std::vector<Extrinsics>{
      {named ? json["camera"].get<std::string>() : std::string(), *rigid}};
}

Result<std::vector<Extrinsics>> read_result(const std::filesystem::path& result) {
  if (result.extension() == ".json") return read_json(result);
  Rig rig;
  if (is_folder(result)) {
    const auto drive = recording::Drive::open(result);
    if (!drive) return tl::unexpected(drive.error());
    rig = drive->description.rig;
  } else {
    const auto read = recording::read_rig(result);
    if (!read) return tl::unexpected(read.error());
    rig = *read;
  }
  std::vector<Extrinsics> extrinsics;
  for (const CameraMount& camera : rig.cameras) {
    extrinsics.push_back({camera.name, camera.T_camera_lidar});
  }
  return extrinsics;
}

const CameraMount* find_camera(const Rig& truth, const std::string& name) {
  if (name.empty() && truth.cameras.size() == 1) return &truth.cameras.front();
  return truth.find_camera(name);
}

}  // namespace

Result<std::vector<CameraScore>> score_rig(const std::filesystem::path& result,
                                           const std::filesystem::path& truth) {
  const auto extrinsics = read_result(result);
  if (!extrinsics) return tl::unexpected(extrinsics.error());
  const auto rig = true_rig(truth);
  if (!rig) return tl::unexpected(rig.error());
  std::vector<CameraScore> scores;
  for (const Extrinsics& estimate : *extrinsics) {
    const CameraMount* camera = find_camera(*rig, estimate.camera);
    if (camera == nullptr) continue;
    scores.push_back(
        {camera->name, geometry::extrinsic_error(estimate.T_camera_lidar, camera->T_camera_lidar,
                                                 geometry::CameraModel(camera->intrinsics))});
  }
  if (scores.empty()) {
    return fail("the result and the truth have no camera in common", result.string(),
                "cameras are compared by their names");
  }
  return scores;
}

Json to_json(const std::vector<CameraScore>& scores) {
  Json json = {{"kind", "calibration"}, {"cameras", Json::array()}};
  for (const CameraScore& score : scores) {
    const geometry::ExtrinsicError& e = score.error;
    Json axes;
    for (int i = 0; i < 3; ++i) axes["rotation_deg"].push_back(e.by_axis[i] / kDegree);
    for (int i = 3; i < 6; ++i) axes["translation_m"].push_back(e.by_axis[i]);
    json["cameras"].push_back({{"camera", score.camera},
                               {"rotation_deg", e.rotation / kDegree},
                               {"translation_m", e.translation},
                               {"mean_px", e.pixels},
                               {"by_axis", axes}});
  }
  return json;
}

std::string to_text(const std::vector<CameraScore>& scores) {
  std::string text;
  for (const CameraScore& score : scores) {
    const geometry::ExtrinsicError& e = score.error;
    text += fmt::format("{}: {:.3f}°, {:.2f} cm, {:.2f} pixels on average\n", score.camera,
                        e.rotation / kDegree, e.translation * 100, e.pixels);
    text += fmt::format(
        "  about the camera's axes ({:+.3f}, {:+.3f}, {:+.3f})°, along them ({:+.2f}, {:+.2f}, "
        "{:+.2f}) cm\n",
        e.by_axis[0] / kDegree, e.by_axis[1] / kDegree, e.by_axis[2] / kDegree, e.by_axis[3] * 100,
        e.by_axis[4] * 100, e.by_axis[5] * 100);
  }
  return text;
}

}  // namespace infuse::daemon

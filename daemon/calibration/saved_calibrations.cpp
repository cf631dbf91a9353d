#include "daemon/calibration/saved_calibrations.hpp"

#include <algorithm>

#include "daemon/protocol/number_json.hpp"
#include "drivers/recording/atomic_file.hpp"
#include "drivers/recording/rigid_matrix.hpp"
#include "drivers/text/text_file.hpp"

namespace infuse::daemon {
namespace {

constexpr size_t kMaxBytes = 1 << 20;
constexpr size_t kMaxCameras = 64;

std::optional<Eigen::Isometry3d> read_rigid(const Json& object, const char* key) {
  const auto found = object.find(key);
  if (found == object.end()) return std::nullopt;
  const auto numbers = numbers_of(*found, 16);
  return numbers ? recording::to_rigid(*numbers) : std::nullopt;
}

std::optional<SavedCalibration> read_calibration(const Json& object) {
  if (!object.is_object()) return std::nullopt;
  const auto camera = object.find("camera");
  const auto since = object.find("since_ns");
  const auto configured = read_rigid(object, "T_camera_lidar_configured");
  const auto used = read_rigid(object, "T_camera_lidar");
  if (camera == object.end() || !camera->is_string() || since == object.end() ||
      !since->is_number_integer() || !configured || !used) {
    return std::nullopt;
  }
  const auto frozen = object.find("frozen");  // absent in older files
  if (frozen != object.end() && !frozen->is_boolean()) return std::nullopt;
  return SavedCalibration{camera->get<std::string>(), Stamp::from_ns(since->get<int64_t>()),
                          frozen != object.end() && frozen->get<bool>(), *configured, *used};
}

/// Returns whether the two differ by no more than printing and parsing can cause.
bool nearly_equal(const Eigen::Isometry3d& a, const Eigen::Isometry3d& b) {
  return (a.matrix() - b.matrix()).cwiseAbs().maxCoeff() < 1e-9;
}

}  // namespace

std::string format_calibrations(const std::vector<SavedCalibration>& calibrations) {
  Json json = {{"form", kCalibrationsForm}, {"cameras", Json::array()}};
  for (const SavedCalibration& calibration : calibrations) {
    json["cameras"].push_back(
        {{"camera", calibration.camera},
         {"since_ns", calibration.since.ns()},
         {"frozen", calibration.frozen},
         {"T_camera_lidar_configured", by_row(calibration.T_camera_lidar_configured.matrix())},
         {"T_camera_lidar", by_row(calibration.T_camera_lidar.matrix())}});
  }
  return json.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
}

Result<std::vector<SavedCalibration>> parse_calibrations(std::string_view text) {
  const Json json = Json::parse(text, nullptr, false);
  if (!json.is_object() || !json.contains("form") || json["form"] != kCalibrationsForm ||
      !json.contains("cameras") || !json["cameras"].is_array() ||
      json["cameras"].size() > kMaxCameras) {
    return fail("not a calibration file of this release");
  }
  std::vector<SavedCalibration> calibrations;
  for (const Json& object : json["cameras"]) {
    const auto calibration = read_calibration(object);
    if (!calibration) return fail("damaged calibration file");
    calibrations.push_back(*calibration);
  }
  return calibrations;
}

std::vector<std::string> SavedCalibrations::restore(Rig& rig) {
  std::vector<std::string> lines;
  std::error_code ignored;
  std::vector<SavedCalibration> saved;
  if (!path_.empty() && std::filesystem::exists(path_, ignored)) {
    const auto text = text::read_text(path_, kMaxBytes);
    const auto read = text ? parse_calibrations(*text)
                           : Result<std::vector<SavedCalibration>>(tl::unexpected(text.error()));
    if (read) {
      saved = *read;
    } else {
      damage_ = path_.string() + ": " + read.error().what + "; using the configured calibrations";
      lines.push_back(*damage_);
      std::filesystem::rename(path_, path_.string() + ".unreadable", ignored);
    }
  }
  calibrations_.clear();
  for (CameraMount& camera : rig.cameras) {
    calibrations_.push_back({camera.name, {}, false, camera.T_camera_lidar, camera.T_camera_lidar});
    const auto found = std::find_if(saved.begin(), saved.end(), [&](const SavedCalibration& one) {
      return one.camera == camera.name;
    });
    if (found == saved.end()) continue;
    calibrations_.back().frozen = found->frozen;
    if (found->frozen) lines.push_back(camera.name + ": calibration frozen");
    if (nearly_equal(found->T_camera_lidar, camera.T_camera_lidar)) continue;
    if (!nearly_equal(found->T_camera_lidar_configured, camera.T_camera_lidar)) {
      lines.push_back(camera.name + ": using the configured calibration, which has changed");
      continue;
    }
    camera.T_camera_lidar = found->T_camera_lidar;
    calibrations_.back() = *found;
    lines.push_back(camera.name + ": using the saved calibration");
  }
  return lines;
}

std::vector<std::string> SavedCalibrations::frozen_cameras() const {
  std::vector<std::string> cameras;
  for (const SavedCalibration& calibration : calibrations_) {
    if (calibration.frozen) cameras.push_back(calibration.camera);
  }
  return cameras;
}

Result<void> SavedCalibrations::save(const CalibrationReport& report) {
  for (SavedCalibration& calibration : calibrations_) {
    if (calibration.camera != report.camera ||
        nearly_equal(calibration.T_camera_lidar, report.T_camera_lidar)) {
      continue;
    }
    calibration.T_camera_lidar = report.T_camera_lidar;
    calibration.since = report.stamp;
    unsaved_ = true;
  }
  return unsaved_ ? write() : Result<void>();
}

Result<void> SavedCalibrations::save_frozen(const std::string& camera, bool frozen) {
  for (SavedCalibration& calibration : calibrations_) {
    if (!camera.empty() && calibration.camera != camera) continue;
    unsaved_ |= std::exchange(calibration.frozen, frozen) != frozen;
  }
  return unsaved_ ? write() : Result<void>();
}

Result<void> SavedCalibrations::write() {
  if (path_.empty()) return {};
  std::error_code ignored;  // write_file_atomically reports the error
  std::filesystem::create_directories(path_.parent_path(), ignored);
  const std::string text = format_calibrations(calibrations_);
  auto written = recording::write_file_atomically(path_, std::as_bytes(std::span(text)), 0640);
  unsaved_ = !written;
  return written;
}

}  // namespace infuse::daemon

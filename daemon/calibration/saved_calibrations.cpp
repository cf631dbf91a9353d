#include "daemon/calibration/saved_calibrations.hpp"

#include <algorithm>
#include <set>

#include "daemon/protocol/names.hpp"
#include "daemon/protocol/number_json.hpp"
#include "drivers/recording/rigid_matrix.hpp"

namespace infuse::daemon {
namespace {

constexpr size_t kMaxCameras = 64;
constexpr size_t kMaxKnown = 1000;  // of a camera; the ledger keeps fewer

/// Members of a JSON object, read with their types. `damaged` if one is missing or of another type.
class ObjectReader {
 public:
  explicit ObjectReader(const Json& object) : object_(object), damaged_(!object.is_object()) {}

  template <class T>
  T read(const char* key) {
    const auto value = read_if<T>(key);
    damaged_ = damaged_ || !value;
    return value.value_or(T{});
  }
  /// Nothing if there is no such member.
  template <class T>
  std::optional<T> read_if(const char* key) {
    if (!object_.is_object()) return std::nullopt;
    const auto found = object_.find(key);
    if (found == object_.end()) return std::nullopt;
    const std::optional<T> value = convert<T>(*found);
    damaged_ = damaged_ || !value;
    return value;
  }
  bool damaged() const { return damaged_; }

 private:
  template <class T>
  static std::optional<T> convert(const Json& value) {
    if constexpr (std::is_same_v<T, std::string>) {
      return value.is_string() ? std::optional(value.get<std::string>()) : std::nullopt;
    } else if constexpr (std::is_same_v<T, bool>) {
      return value.is_boolean() ? std::optional(value.get<bool>()) : std::nullopt;
    } else if constexpr (std::is_same_v<T, uint64_t>) {
      return value.is_number_unsigned() ? std::optional(value.get<uint64_t>()) : std::nullopt;
    } else if constexpr (std::is_same_v<T, int64_t>) {
      return value.is_number_integer() ? std::optional(value.get<int64_t>()) : std::nullopt;
    } else if constexpr (std::is_same_v<T, Eigen::Isometry3d>) {
      const auto numbers = numbers_of(value, 16);
      return numbers ? recording::to_rigid(*numbers) : std::nullopt;
    } else {
      const auto numbers = numbers_of(value, 36);
      if (!numbers) return std::nullopt;
      return T(Eigen::Map<const Eigen::Matrix<double, 6, 6, Eigen::RowMajor>>(numbers->data()));
    }
  }

  const Json& object_;
  bool damaged_;
};

std::optional<CalibrationOrigin> origin_of(const std::string& name) {
  for (const CalibrationOrigin origin :
       {CalibrationOrigin::kConfigured, CalibrationOrigin::kEstimated, CalibrationOrigin::kGiven}) {
    if (name == name_of(origin)) return origin;
  }
  return std::nullopt;
}

Json known_json(const KnownCalibration& known) {
  Json json = {{"number", known.number},
               {"since_ns", known.stamp.ns()},
               {"origin", name_of(known.origin)},
               {"T_camera_lidar", by_row(known.T_camera_lidar.matrix())}};
  if (known.covariance) json["covariance"] = by_row(*known.covariance);
  if (known.estimated_from) json["estimated_from"] = *known.estimated_from;
  return json;
}

std::optional<KnownCalibration> read_known(const Json& json) {
  ObjectReader object(json);
  KnownCalibration known;
  known.number = object.read<uint64_t>("number");
  known.stamp = Stamp::from_ns(object.read<int64_t>("since_ns"));
  const auto origin = origin_of(object.read<std::string>("origin"));
  known.T_camera_lidar = object.read<Eigen::Isometry3d>("T_camera_lidar");
  known.covariance = object.read_if<Eigen::Matrix<double, 6, 6>>("covariance");
  known.estimated_from = object.read_if<uint64_t>("estimated_from");
  if (object.damaged() || !origin || known.number == 0) return std::nullopt;
  known.origin = *origin;
  return known;
}

std::optional<CameraCalibrations> read_camera(const Json& json) {
  ObjectReader object(json);
  CameraCalibrations camera;
  camera.camera = object.read<std::string>("camera");
  camera.frozen = object.read<bool>("frozen");
  camera.T_camera_lidar_configured = object.read<Eigen::Isometry3d>("T_camera_lidar_configured");
  camera.in_use = object.read<uint64_t>("in_use");
  camera.previous = object.read_if<uint64_t>("previous");
  if (object.damaged()) return std::nullopt;
  const auto known = json.find("calibrations");
  if (known == json.end() || !known->is_array() || known->size() > kMaxKnown) return std::nullopt;
  for (const Json& one : *known) {
    const auto read = read_known(one);
    if (!read) return std::nullopt;
    camera.known.push_back(*read);
  }
  if (camera.find(camera.in_use) == nullptr) return std::nullopt;
  if (camera.previous && camera.find(*camera.previous) == nullptr) return std::nullopt;
  return camera;
}

/// A camera of form 1: the configured calibration and the one in use.
std::optional<CameraCalibrations> read_form_1(const Json& json, uint64_t& next_number) {
  ObjectReader object(json);
  CameraCalibrations camera;
  camera.camera = object.read<std::string>("camera");
  const Stamp since = Stamp::from_ns(object.read<int64_t>("since_ns"));
  camera.frozen = object.read_if<bool>("frozen").value_or(false);
  camera.T_camera_lidar_configured = object.read<Eigen::Isometry3d>("T_camera_lidar_configured");
  const auto used = object.read<Eigen::Isometry3d>("T_camera_lidar");
  if (object.damaged()) return std::nullopt;
  camera.in_use = next_number++;
  camera.known.push_back(
      {.number = camera.in_use, .T_camera_lidar = camera.T_camera_lidar_configured});
  if (used.matrix() == camera.T_camera_lidar_configured.matrix()) return camera;
  camera.previous = camera.in_use;
  camera.in_use = next_number++;
  camera.known.push_back({.number = camera.in_use,
                          .stamp = since,
                          .origin = CalibrationOrigin::kEstimated,
                          .T_camera_lidar = used});
  return camera;
}

/// True if no number names two calibrations and none is still to be given.
bool numbers_are_unique(const SavedCalibrations& calibrations) {
  std::set<uint64_t> numbers;
  for (const CameraCalibrations& camera : calibrations.cameras) {
    for (const KnownCalibration& known : camera.known) {
      if (known.number >= calibrations.next_number) return false;
      if (!numbers.insert(known.number).second) return false;
    }
  }
  return true;
}

}  // namespace

const KnownCalibration* CameraCalibrations::find(uint64_t number) const {
  const auto found = std::find_if(known.begin(), known.end(), [&](const KnownCalibration& one) {
    return one.number == number;
  });
  return found == known.end() ? nullptr : &*found;
}

CameraCalibrations* SavedCalibrations::find(const std::string& camera) {
  const auto found =
      std::find_if(cameras.begin(), cameras.end(),
                   [&](const CameraCalibrations& one) { return one.camera == camera; });
  return found == cameras.end() ? nullptr : &*found;
}

std::string format_calibrations(const SavedCalibrations& calibrations) {
  Json json = {{"form", kCalibrationsForm},
               {"next_number", calibrations.next_number},
               {"cameras", Json::array()}};
  for (const CameraCalibrations& camera : calibrations.cameras) {
    Json object = {{"camera", camera.camera},
                   {"frozen", camera.frozen},
                   {"T_camera_lidar_configured", by_row(camera.T_camera_lidar_configured.matrix())},
                   {"in_use", camera.in_use}};
    if (camera.previous) object["previous"] = *camera.previous;
    object["calibrations"] = Json::array();
    for (const KnownCalibration& known : camera.known) {
      object["calibrations"].push_back(known_json(known));
    }
    json["cameras"].push_back(object);
  }
  return json.dump(1, ' ', false, Json::error_handler_t::replace) + "\n";
}

Result<SavedCalibrations> parse_calibrations(std::string_view text) {
  const Json json = Json::parse(text, nullptr, false);
  ObjectReader object(json);
  const auto form = object.read<uint64_t>("form");
  if (object.damaged() || form < 1 || form > kCalibrationsForm || !json.contains("cameras") ||
      !json["cameras"].is_array() || json["cameras"].size() > kMaxCameras) {
    return fail("not a calibration file of this release");
  }
  SavedCalibrations calibrations;
  if (form > 1) calibrations.next_number = object.read<uint64_t>("next_number");
  for (const Json& one : json["cameras"]) {
    const auto camera = form > 1 ? read_camera(one) : read_form_1(one, calibrations.next_number);
    if (!camera) return fail("damaged calibration file");
    calibrations.cameras.push_back(*camera);
  }
  if (object.damaged() || !numbers_are_unique(calibrations)) {
    return fail("damaged calibration file");
  }
  return calibrations;
}

}  // namespace infuse::daemon

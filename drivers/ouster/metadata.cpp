#include "drivers/ouster/metadata.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>
#include <optional>
#include <utility>

#include "drivers/measurement/angles.hpp"
#include "drivers/text/text_file.hpp"

namespace infuse::ouster {
namespace {

using Json = nlohmann::json;

constexpr size_t kMaxFileBytes = 1 << 20;
constexpr int kMaxDepth = 16;
constexpr size_t kMaxNameBytes = 100;
constexpr double kMaxMillimetres = 1e5;
constexpr const char* kExpected =
    "expected the JSON that the sensor gives at /api/v1/sensor/metadata";

/// Millimetres of an OS0's, OS1's … axis to the origin of its beams, where the metadata does not
/// say (firmware before 2.0).
constexpr std::array<std::pair<std::string_view, double>, 3> kBeamOriginRadii{
    {{"OS-0-", 27.67}, {"OS-1-", 15.806}, {"OS-2-", 13.762}}};
constexpr double kFirstGenerationRadius = 12.163;

bool is_shallow(std::string_view text) {
  int depth = 0;
  bool quoted = false;
  for (size_t i = 0; i < text.size(); ++i) {
    const char c = text[i];
    if (quoted) {
      if (c == '\\') ++i;
      quoted = c != '"';
    } else if (c == '"') {
      quoted = true;
    } else if (c == '[' || c == '{') {
      if (++depth > kMaxDepth) return false;
    } else if (c == ']' || c == '}') {
      --depth;
    }
  }
  return true;
}

/// Finds keys wherever a layout has them, and keeps the first problem.
class MetadataReader {
 public:
  MetadataReader(const Json& root, const std::string& where) : root_(root), where_(where) {}

  /// The value of `key` in `section`, or on the top level; null if there is none.
  const Json* find(const char* section, const char* key) const {
    const auto in = [key](const Json& object) -> const Json* {
      const auto found = object.is_object() ? object.find(key) : object.end();
      return object.is_object() && found != object.end() ? &*found : nullptr;
    };
    const auto found = root_.find(section);
    const Json* nested = found != root_.end() ? in(*found) : nullptr;
    return nested != nullptr ? nested : in(root_);
  }

  std::string text(const char* section, const char* key) const {
    const Json* value = find(section, key);
    return value != nullptr && value->is_string()
               ? value->get<std::string>().substr(0, kMaxNameBytes)
               : std::string();
  }

  /// An integer in [low, high], or `otherwise` if there is none.
  uint16_t integer(const char* section, const char* key, uint32_t low, uint32_t high,
                   uint16_t otherwise) {
    const Json* value = find(section, key);
    if (value == nullptr || value->is_null()) return otherwise;
    return integer(*value, key, low, high);
  }

  uint16_t integer(const Json& value, const char* key, uint32_t low, uint32_t high) {
    const double number = value.is_number() ? value.get<double>() : -1;
    if (!(number >= low && number <= high) || number != std::floor(number)) {
      reject(std::string(key) + " must be an integer in " + std::to_string(low) + " ... " +
             std::to_string(high));
      return static_cast<uint16_t>(low);
    }
    return static_cast<uint16_t>(number);
  }

  /// Numbers of at most `limit`; empty if there are none.
  std::vector<double> numbers(const char* section, const char* key, size_t max_count,
                              double limit) {
    const Json* value = find(section, key);
    if (value == nullptr || value->is_null()) return {};
    if (!value->is_array() || value->size() > max_count) {
      reject(std::string(key) + " must be a list of at most " + std::to_string(max_count) +
             " numbers");
      return {};
    }
    std::vector<double> result;
    for (const Json& entry : *value) {
      const double number =
          entry.is_number() ? entry.get<double>() : std::numeric_limits<double>::quiet_NaN();
      if (!(std::abs(number) <= limit)) {
        reject(std::string(key) + " has an entry that is no number, or impossible");
        return {};
      }
      result.push_back(number);
    }
    return result;
  }

  /// A rigid motion in metres from a matrix of 4 × 4 by row in millimetres, or nothing if there is
  /// none.
  std::optional<Eigen::Isometry3d> transform(const char* section, const char* key) {
    const std::vector<double> entries = numbers(section, key, 16, kMaxMillimetres);
    if (entries.empty()) return std::nullopt;
    if (entries.size() != 16) {
      reject(std::string(key) + " must have 16 numbers");
      return std::nullopt;
    }
    const Eigen::Map<const Eigen::Matrix<double, 4, 4, Eigen::RowMajor>> matrix(entries.data());
    const Eigen::Matrix3d rotation = matrix.topLeftCorner<3, 3>();
    const bool rigid =
        (rotation * rotation.transpose()).isApprox(Eigen::Matrix3d::Identity(), 1e-3) &&
        rotation.determinant() > 0 && matrix.row(3) == Eigen::RowVector4d(0, 0, 0, 1);
    if (!rigid) {
      reject(std::string(key) + " is no rigid motion");
      return std::nullopt;
    }
    Eigen::Isometry3d result = Eigen::Isometry3d::Identity();
    result.linear() = rotation;
    result.translation() = matrix.topRightCorner<3, 1>() * 1e-3;
    return result;
  }

  /// States what is wrong. The first problem counts.
  void reject(std::string what, std::string hint = kExpected) {
    if (!error_) error_ = Error{std::move(what), where_, std::move(hint)};
  }

  const std::optional<Error>& error() const { return error_; }

 private:
  const Json& root_;
  const std::string& where_;
  std::optional<Error> error_;
};

/// Reads "1024x10": columns a turn and turns a second.
void read_mode(std::string_view mode, Metadata& metadata) {
  constexpr std::array<std::string_view, 4> kColumns{"512x", "1024x", "2048x", "4096x"};
  constexpr std::array<std::pair<std::string_view, double>, 3> kRates{
      {{"5", 5.0}, {"10", 10.0}, {"20", 20.0}}};
  for (size_t i = 0; i < kColumns.size(); ++i) {
    if (!mode.starts_with(kColumns[i])) continue;
    metadata.columns_per_turn = static_cast<uint16_t>(512u << i);
    for (const auto& [name, rate] : kRates) {
      if (mode.substr(kColumns[i].size()) == name) metadata.turns_per_second = rate;
    }
  }
}

void read_format(MetadataReader& reader, const char* section, Metadata& metadata) {
  read_mode(reader.text("config_params", "lidar_mode"), metadata);
  metadata.columns_per_turn = reader.integer(section, "columns_per_frame", 16, kMaxColumnsPerTurn,
                                             metadata.columns_per_turn);
  if (metadata.columns_per_turn == 0) reader.reject("neither columns_per_frame nor lidar_mode");
  metadata.columns_per_packet =
      reader.integer(section, "columns_per_packet", 1, kMaxColumnsPerPacket, 16);
  metadata.window = {0, static_cast<uint16_t>(metadata.columns_per_turn - 1)};
  const Json* window = reader.find(section, "column_window");
  if (window != nullptr && window->is_array() && window->size() == 2) {
    const uint32_t last = metadata.columns_per_turn - 1u;
    metadata.window = {reader.integer((*window)[0], "column_window", 0, last),
                       reader.integer((*window)[1], "column_window", 0, last)};
  } else if (window != nullptr && !window->is_null()) {
    reader.reject("column_window must have two numbers");
  }
  const std::string inertial = reader.text(section, "udp_profile_imu");
  metadata.has_other_imu = !inertial.empty() && inertial != "LEGACY" && inertial != "OFF";
  const std::string profile = reader.text(section, "udp_profile_lidar");
  if (profile.empty()) return;
  if (const ProfileInfo* info = find_profile(profile)) {
    metadata.profile = info->profile;
    const std::string header = reader.text(section, "header_type");  // from firmware 3.2 on
    metadata.fusa_header = header.empty() ? info->profile == Profile::kFusaDual
                                          : header == "FUSA" && info->profile != Profile::kLegacy;
  } else {
    reader.reject("udp_profile_lidar \"" + profile + "\" is not supported",
                  "supported: " + profile_names());
  }
}

void read_beams(MetadataReader& reader, const char* format_section, Metadata& metadata) {
  metadata.elevation = reader.numbers("beam_intrinsics", "beam_altitude_angles", kMaxBeams, 90);
  metadata.azimuth = reader.numbers("beam_intrinsics", "beam_azimuth_angles", kMaxBeams, 180);
  for (double& angle : metadata.elevation) angle *= kDegree;
  for (double& angle : metadata.azimuth) angle *= kDegree;
  const size_t beams = metadata.beams();
  if (beams == 0 || beams % 8 != 0 || metadata.azimuth.size() != beams) {
    reader.reject("beam_altitude_angles and beam_azimuth_angles must have 8, 16 ... 128 numbers");
    return;
  }
  if (metadata.beams_from_below().empty()) reader.reject("the beams have no angles");
  if (reader.integer(format_section, "pixels_per_column", 8, kMaxBeams,
                     static_cast<uint16_t>(beams)) != beams) {
    reader.reject("pixels_per_column is not the number of beam_altitude_angles");
  }
}

void read_transforms(MetadataReader& reader, Metadata& metadata) {
  // Firmware before 2.0 may leave these out; they are the same for all units of that time.
  Eigen::Isometry3d turned = Eigen::Isometry3d::Identity();
  turned.linear() = Eigen::Vector3d(-1, -1, 1).asDiagonal();
  turned.translation() = Eigen::Vector3d(0, 0, 0.03618);
  Eigen::Isometry3d imu = Eigen::Isometry3d::Identity();
  imu.translation() = Eigen::Vector3d(0.006253, -0.011775, 0.007645);
  metadata.T_sensor_lidar =
      reader.transform("lidar_intrinsics", "lidar_to_sensor_transform").value_or(turned);
  metadata.T_sensor_imu =
      reader.transform("imu_intrinsics", "imu_to_sensor_transform").value_or(imu);

  double radius = kFirstGenerationRadius;
  for (const auto& [line, value] : kBeamOriginRadii) {
    if (metadata.product_line.starts_with(line)) radius = value;
  }
  const Json* stated = reader.find("beam_intrinsics", "lidar_origin_to_beam_origin_mm");
  if (stated != nullptr && !stated->is_null()) {
    radius = stated->is_number() ? stated->get<double>() : -1;
    if (!(radius >= 0 && radius <= 1000)) {
      reader.reject("lidar_origin_to_beam_origin_mm must be in 0 ... 1000");
    }
  }
  Eigen::Isometry3d origin = Eigen::Isometry3d::Identity();
  origin.translation().x() = radius * 1e-3;
  metadata.T_lidar_beam =
      reader.transform("beam_intrinsics", "beam_to_lidar_transform").value_or(origin);
}

void read_config(const MetadataReader& reader, Metadata& metadata) {
  const std::string mode = reader.text("config_params", "timestamp_mode");
  if (mode == "TIME_FROM_INTERNAL_OSC") metadata.time_mode = TimeMode::kInternal;
  if (mode == "TIME_FROM_SYNC_PULSE_IN") metadata.time_mode = TimeMode::kPps;
  if (mode == "TIME_FROM_PTP_1588") metadata.time_mode = TimeMode::kPtp;
  const std::string order = reader.text("config_params", "return_order");
  if (order == "FARTHEST_TO_NEAREST" || order == "LAST_RETURN_FIRST") {
    metadata.first_return = FirstReturn::kFarthest;
  }
  if (order == "NEAREST_TO_FARTHEST") metadata.first_return = FirstReturn::kNearest;
}

}  // namespace

const char* describe(TimeMode mode) {
  switch (mode) {
    case TimeMode::kUnknown:
      break;
    case TimeMode::kInternal:
      return "internal oscillator";
    case TimeMode::kPps:
      return "pulse per second";
    case TimeMode::kPtp:
      return "PTP";
  }
  return "not stated";
}

std::vector<size_t> Metadata::beams_from_below() const {
  std::vector<size_t> order;
  for (size_t beam = 0; beam < beams(); ++beam) {
    if (elevation[beam] != 0 || azimuth[beam] != 0) order.push_back(beam);
  }
  std::ranges::stable_sort(order, {}, [this](size_t beam) { return elevation[beam]; });
  return order;
}

double Metadata::begin_azimuth() const {
  const auto& rotation = T_sensor_lidar.linear();
  return std::atan2(rotation(1, 0), rotation(0, 0));
}

std::string Metadata::model() const {
  const std::string_view line = product_line;
  const std::string count = std::to_string(beams_from_below().size());
  if (line.starts_with("OS-DOME")) return "OSDome-" + count;
  if (line.size() > 4 && line.starts_with("OS-") && line[3] >= '0' && line[3] <= '2') {
    return "OS" + product_line.substr(3, 1) + "-" + count;
  }
  // Nobody states less than the first product did.
  return product_line.empty() ? "OS1-" + count : product_line;
}

Result<Metadata> parse_metadata(std::string_view text, const std::string& where) {
  if (text.size() > kMaxFileBytes) return fail("is larger than 1 MiB", where, kExpected);
  if (!is_shallow(text)) return fail("is nested too deeply", where, kExpected);
  const Json root = Json::parse(text, nullptr, false);
  if (!root.is_object()) return fail("is no JSON object", where, kExpected);
  MetadataReader reader(root, where);
  Metadata metadata;
  metadata.text = text;
  metadata.product_line = reader.text("sensor_info", "prod_line");
  metadata.serial_number = reader.text("sensor_info", "prod_sn");
  metadata.firmware = reader.text("sensor_info", "build_rev");
  const char* format = root.contains("lidar_data_format") ? "lidar_data_format" : "data_format";
  read_format(reader, format, metadata);
  read_beams(reader, format, metadata);
  read_transforms(reader, metadata);
  read_config(reader, metadata);
  metadata.lidar_port = reader.integer("config_params", "udp_port_lidar", 0, 65535, 7502);
  metadata.imu_port = reader.integer("config_params", "udp_port_imu", 0, 65535, 7503);
  if (reader.error()) return tl::unexpected(*reader.error());
  return metadata;
}

Result<Metadata> load_metadata(const std::filesystem::path& path) {
  const auto text = text::read_text(path, kMaxFileBytes);
  if (!text) return tl::unexpected(text.error());
  return parse_metadata(*text, path.string());
}

}  // namespace infuse::ouster

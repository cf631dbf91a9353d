#include "daemon/pages/report_data.hpp"

#include <cmath>
#include <fstream>

#include "daemon/protocol/number_json.hpp"
#include "daemon/protocol/report_class.hpp"
#include "drivers/measurement/angles.hpp"
#include "drivers/recording/rigid_matrix.hpp"
#include "drivers/text/text_file.hpp"
#include "fusion/geometry/rigid_motion.hpp"

namespace infuse::daemon {
namespace {

constexpr size_t kMaxLine = size_t{4} << 20;  // bytes
constexpr size_t kMaxText = 1000;             // bytes of a text that is shown

/// The member, or null.
const Json& member(const Json& object, const char* key) {
  static const Json kNothing;
  const auto found = object.find(key);
  return found == object.end() ? kNothing : *found;
}

/// The text of a member, empty if it has none.
std::string text(const Json& object, const char* key) {
  const Json& found = member(object, key);
  return found.is_string() ? found.get_ref<const std::string&>().substr(0, kMaxText)
                           : std::string();
}

/// The numbers of a member of `count`; nothing if it is anything else.
std::optional<std::vector<double>> numbers(const Json& object, const char* key, size_t count) {
  return numbers_of(member(object, key), count);
}

void copy_numbers(const Json& from, std::initializer_list<const char*> keys, Json& to) {
  for (const char* key : keys) {
    if (const Json& number = member(from, key); number.is_number()) to[key] = number;
  }
}

std::optional<Stamp> stamp_of(const Json& object, const char* key) {
  const Json& found = member(object, key);
  if (!found.is_number_integer()) return std::nullopt;
  return Stamp::from_ns(found.get<int64_t>());
}

std::optional<Eigen::Isometry3d> pose_of(const Json& object, const char* key) {
  const auto values = numbers(object, key, 16);
  if (!values) return std::nullopt;
  return recording::to_rigid(*values);
}

Json poses_json(const std::vector<ReportedPose>& poses, Stamp start) {
  Json columns = {{"t", Json::array()},  {"x", Json::array()},  {"y", Json::array()},
                  {"xx", Json::array()}, {"xy", Json::array()}, {"yy", Json::array()}};
  Json states = Json::array();
  for (const ReportedPose& pose : poses) {
    const Eigen::Vector3d p = pose.T_frame_vehicle.translation();
    columns["t"].push_back(to_seconds(pose.stamp - start));
    columns["x"].push_back(p.x());
    columns["y"].push_back(p.y());
    columns["xx"].push_back(pose.covariance[0]);
    columns["xy"].push_back(pose.covariance[1]);
    columns["yy"].push_back(pose.covariance[2]);
    if (states.empty() || states.back()["state"] != pose.state) {
      states.push_back({{"t", columns["t"].back()}, {"state", pose.state}});
    }
  }
  columns["states"] = std::move(states);
  return columns;
}

}  // namespace

CalibrationMove move_between(const Eigen::Isometry3d& T_from, const Eigen::Isometry3d& T_to) {
  const Eigen::AngleAxisd rotation(Eigen::Matrix3d(T_to.linear() * T_from.linear().transpose()));
  return {rotation.angle(), (T_to.inverse().translation() - T_from.inverse().translation()).norm()};
}

Json to_json(const CalibrationMove& move) {
  return {{"rotation_deg", move.rotation / kDegree}, {"translation_cm", 100 * move.translation}};
}

void ReportData::add_line(std::string_view line) {
  if (line.empty()) return;
  const Json report = line.size() > kMaxLine ? Json() : Json::parse(line, nullptr, false);
  if (!report.is_object() || text(report, "class").empty() || !stamp_of(report, "stamp")) {
    ++unreadable_;
    return;
  }
  ++reports_;
  add(report);
}

void ReportData::add(const Json& report) {
  const Stamp stamp = *stamp_of(report, "stamp");
  const std::string kind = text(report, "class");
  if (kind == "DEVICES") {  // before the drive begins
    devices_ = member(report, "devices");
    return;
  }
  if (!start_) start_ = end_ = stamp;
  end_ = std::max(end_, stamp);
  if (kind == "SWEEP") add_sweep(report, stamp);
  if (kind == "POSE") add_pose(report, stamp);
  if (kind == "CALIBRATION") add_calibration(report, stamp);
  if (kind == "HEALTH") add_health(report, stamp);
  if (kind == "ALERT") add_alert(report, stamp);
}

void ReportData::add_sweep(const Json& report, Stamp stamp) {
  const Json& turned = member(report, "turned_deg");
  const Json& travelled = member(report, "travelled");
  if (!turned.is_number() || !travelled.is_number() || member(report, "deskewed") != Json(true))
    return;
  // At the seam of a sweep, returns at this distance are apart by that much if it is not deskewed.
  constexpr double kSeamDistance = 20;  // m, a street's width
  const double apart =
      std::abs(travelled.get<double>()) + std::abs(turned.get<double>()) * kDegree * kSeamDistance;
  if (moved_sweep_ && apart <= moved_sweep_apart_) return;
  moved_sweep_ = stamp;
  moved_sweep_apart_ = apart;
}

void ReportData::add_pose(const Json& report, Stamp stamp) {
  const auto T = pose_of(report, "T_frame_vehicle");
  const auto covariance = numbers(report, "covariance", 36);
  if (!T || !covariance || member(report, "usable") != Json(true)) return;
  const bool on_map = text(report, "frame") == "map";
  ReportedPose pose{stamp, *T, {(*covariance)[21], (*covariance)[22], (*covariance)[28]}, {}};
  if (on_map) pose.state = text(report, "state");
  (on_map ? map_ : odom_).add(std::move(pose));
}

void ReportData::add_calibration(const Json& report, Stamp stamp) {
  const auto T = pose_of(report, "T_camera_lidar");
  const std::string camera = text(report, "device");
  if (!T || (calibrations_.size() >= kMaxCameras && !calibrations_.contains(camera))) {
    ++left_out_;
    return;
  }
  const auto [at, is_first] = calibrations_.try_emplace(camera);
  ReportedCalibration& calibration = at->second;
  if (is_first) calibration.T_first = *T;
  calibration.T_last = *T;
  const std::string state = text(report, "state");
  if (!calibration.drift_since && (state == "SUSPECTED" || state == "CONFIRMED")) {
    calibration.drift_since = stamp;
  }
  if (calibration.points.size() < kMaxPoints) {
    const Json& evidence = member(report, "evidence");
    Json point = {{"t", seconds(stamp)}, {"state", state}};
    if (evidence.is_object()) {
      point["axis"] = text(evidence, "axis");
      copy_numbers(evidence, {"nats", "threshold_nats"}, point);
    }
    if (const auto offset = numbers(report, "offset", 6)) point["offset"] = *offset;
    if (const auto sigma = numbers(report, "offset_sigma", 6)) point["sigma"] = *sigma;
    calibration.points.push_back(std::move(point));
  } else {
    ++left_out_;
  }
  const Json& changes = member(report, "history");
  if (!changes.is_array() || changes.empty()) return;
  calibration.history = Json::array();
  Eigen::Isometry3d T_before = calibration.T_first;
  for (const Json& change : changes) {
    const auto when = stamp_of(change, "stamp");
    const auto T_after = pose_of(change, "T_camera_lidar");
    if (!when || !T_after) continue;
    calibration.history.push_back({{"t", seconds(*when)},
                                   {"state", text(change, "state")},
                                   {"what", text(change, "what")},
                                   {"moved", daemon::to_json(move_between(T_before, *T_after))}});
    T_before = *T_after;
  }
}

void ReportData::add_health(const Json& report, Stamp stamp) {
  const std::string level = text(report, "level");
  if (levels_.size() < kMaxPoints && (levels_.empty() || levels_.back()["level"] != level)) {
    levels_.push_back({{"t", seconds(stamp)}, {"level", level}});
  }
  const Json& odometry = member(report, "odometry");
  if (odometry.is_object()) {
    Json point = {{"t", seconds(stamp)}};
    copy_numbers(odometry,
                 {"speed", "wheel_scale", "wheel_scale_sigma", "yaw_rate_bias",
                  "yaw_rate_bias_sigma", "gyro_bias", "gyro_bias_sigma"},
                 point);
    odometry_.add(std::move(point));
  }
  health_ = report;
}

void ReportData::add_alert(const Json& report, Stamp stamp) {
  if (alerts_.size() >= kMaxAlerts) {
    ++left_out_;
    return;
  }
  Json alert = {{"t", seconds(stamp)}};
  for (const char* key : {"id", "device", "severity", "state", "what", "advice"}) {
    alert[key] = text(report, key);
  }
  if (const auto since = stamp_of(report, "since")) alert["since"] = seconds(*since);
  alerts_.push_back(std::move(alert));
}

Json ReportData::to_json() const {
  Json cameras = Json::array();
  for (const auto& [name, calibration] : calibrations_) {
    cameras.push_back(
        {{"device", name},
         {"points", calibration.points},
         {"history", calibration.history},
         {"changed", daemon::to_json(move_between(calibration.T_first, calibration.T_last))}});
  }
  const Stamp start = start_.value_or(end_);
  return {{"begin_ns", std::to_string(start.ns())},  // beyond the integers of JavaScript
          {"duration", start_ ? seconds(end_) : 0},
          {"reports", reports_},
          {"unreadable", unreadable_},
          {"left_out", left_out_},
          {"devices", devices_},
          {"odom", poses_json(odom_.kept(), start)},
          {"map", poses_json(map_.kept(), start)},
          {"cameras", std::move(cameras)},
          {"levels", levels_},
          {"alerts", alerts_},
          {"odometry", odometry_.kept()},
          {"health", health_}};
}

Result<ReportData> read_reports(const std::string& path) {
  if (const auto regular = text::open_regular_file(path); !regular) {
    return fail(regular.error().what, path, "write it with infused --replay DRIVE --reports");
  }
  std::ifstream file(path, std::ios::binary);
  ReportData data;
  std::string line;
  // Read in pieces, so that a file without line feeds does not fill the memory.
  std::vector<char> piece(size_t{64} << 10);
  while (file) {
    file.getline(piece.data(), static_cast<std::streamsize>(piece.size()));
    if (line.size() <= kMaxLine) line += piece.data();
    const bool continues = file.fail() && !file.bad() && file.gcount() > 0;
    if (continues) {
      file.clear(file.rdstate() & ~std::ios::failbit);
      continue;
    }
    data.add_line(line);
    line.clear();
  }
  if (data.reports() == 0) {
    return fail("contains no reports", path, "write it with infused --replay DRIVE --reports");
  }
  return data;
}

}  // namespace infuse::daemon

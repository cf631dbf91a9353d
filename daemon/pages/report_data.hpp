#pragma once

#include <Eigen/Geometry>
#include <iosfwd>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "daemon/pages/thinned.hpp"
#include "daemon/protocol/json.hpp"
#include "drivers/measurement/error.hpp"
#include "drivers/measurement/stamp.hpp"

namespace infuse::daemon {

/// A pose of a POSE report.
struct ReportedPose {
  Stamp stamp;
  Eigen::Isometry3d T_frame_vehicle = Eigen::Isometry3d::Identity();
  /// m², of x and y: xx, xy, yy.
  Eigen::Vector3d covariance = Eigen::Vector3d::Zero();
  std::string state;  ///< of the tracker, frame map: "TRACKING"; empty in frame odom
};

/// Difference of two calibrations T_camera_lidar.
struct CalibrationMove {
  double rotation = 0;     ///< rad
  double translation = 0;  ///< m, of the camera's centre in the lidar's frame
};

CalibrationMove move_between(const Eigen::Isometry3d& T_from, const Eigen::Isometry3d& T_to);

/// rotation_deg, translation_cm.
Json to_json(const CalibrationMove& move);

/// The calibration of a camera over the time of the reports.
struct ReportedCalibration {
  Eigen::Isometry3d T_first = Eigen::Isometry3d::Identity();  ///< T_camera_lidar, in use at first
  Eigen::Isometry3d T_last = Eigen::Isometry3d::Identity();   ///< in use at the end
  std::optional<Stamp> drift_since;  ///< first report that is SUSPECTED or CONFIRMED
  Json points = Json::array();       ///< as drawn: state, evidence, offsets with sigma
  Json history = Json::array();      ///< as drawn: changes
};

/// What the lines of a reports file (infused --reports) say, reduced to what a page draws. Bounded:
/// long files are thinned. Lines that are not reports are counted.
class ReportData {
 public:
  /// Adds one line of the file.
  void add_line(std::string_view line);

  const std::vector<ReportedPose>& odom_poses() const { return odom_.kept(); }
  const std::vector<ReportedPose>& map_poses() const { return map_.kept(); }
  const std::map<std::string, ReportedCalibration>& calibrations() const { return calibrations_; }
  std::optional<Stamp> start() const { return start_; }

  /// Stamp of the deskewed sweep in which the vehicle moved most; nothing without one.
  std::optional<Stamp> moved_sweep() const { return moved_sweep_; }

  size_t reports() const { return reports_; }
  size_t unreadable() const { return unreadable_; }

  /// The data of the page; times in s after the start.
  Json to_json() const;

 private:
  void add(const Json& report);
  void add_sweep(const Json& report, Stamp stamp);
  void add_pose(const Json& report, Stamp stamp);
  void add_calibration(const Json& report, Stamp stamp);
  void add_health(const Json& report, Stamp stamp);
  void add_alert(const Json& report, Stamp stamp);
  double seconds(Stamp stamp) const { return to_seconds(stamp - *start_); }

  static constexpr size_t kMaxCameras = 64;
  static constexpr size_t kMaxPoints = 2000;  // of a camera
  static constexpr size_t kMaxAlerts = 500;

  std::optional<Stamp> start_, moved_sweep_;
  double moved_sweep_apart_ = 0;  // m, of what it was chosen by
  Stamp end_;
  size_t reports_ = 0, unreadable_ = 0, left_out_ = 0;
  Thinned<ReportedPose> odom_, map_;
  Thinned<Json> odometry_;
  std::map<std::string, ReportedCalibration> calibrations_;
  Json alerts_ = Json::array(), levels_ = Json::array(), devices_ = Json::array(), health_;
};

/// Reads a reports file. Lines longer than 4 MiB are counted as unreadable.
Result<ReportData> read_reports(const std::string& path);

}  // namespace infuse::daemon

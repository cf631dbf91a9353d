#pragma once

#include <Eigen/Geometry>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "daemon/health/host_alerts.hpp"
#include "daemon/health/latency_histogram.hpp"
#include "daemon/health/lidar_health.hpp"
#include "daemon/health/map_health.hpp"
#include "daemon/health/odometry_health.hpp"
#include "daemon/health/stream_health.hpp"
#include "daemon/health/streetmap_health.hpp"
#include "daemon/protocol/report_class.hpp"
#include "drivers/measurement/stamp.hpp"
#include "fusion/monitoring/calibration_states.hpp"
#include "fusion/monitoring/drift_verdict.hpp"

namespace infuse::daemon {

// The reports as values in SI units. `descriptions.hpp` states the name, meaning and unit of each
// field on the wire.

/// A sensor of the daemon.
struct Device {
  std::string name;
  std::string kind;                ///< one of kDeviceKinds
  std::string model;               ///< "HDL-32E"
  std::string model_reason;        ///< source of the model: "configured", or the evidence for it
  std::string endpoint;            ///< where its data is received: "port 2368 of lidar.pcap"
  std::optional<Stamp> activated;  ///< stamp of its first packet; nothing while there was none
};

/// The sensors of the daemon.
struct DevicesReport {
  static constexpr ReportClass kClass = ReportClass::kDevices;
  Stamp stamp;
  std::vector<Device> devices;
};

/// Summary of one sweep. Plain data of fixed size, copied between threads.
struct SweepReport {
  static constexpr ReportClass kClass = ReportClass::kSweep;
  std::string_view device;  ///< name in the rig, which outlives the report
  Stamp stamp;              ///< first firing
  Duration span{0};         ///< first firing to last
  uint64_t sequence = 0;
  uint64_t returns = 0;
  uint32_t columns = 0;
  uint32_t rings = 0;
  uint32_t lost_packets = 0;
  uint32_t gaps = 0;
  double gap_angle = 0;          ///< rad
  double mean_range = 0;         ///< m; NaN without returns
  double max_range = 0;          ///< m; NaN without returns
  double mean_reflectivity = 0;  ///< 0 … 1; NaN without returns
  bool has_times = true;
  bool clock_trusted = false;
  const char* deskew_reason = "";  ///< static text: why it is not deskewed; empty if it is
  double travelled = 0;            ///< m
  double turned = 0;               ///< rad
};

/// Frames of poses.
enum class PoseFrame : uint8_t { kOdom, kMap };

/// Confidence of a pose on a map.
struct MapConfidence {
  streetmap::TrackState state = streetmap::TrackState::kLost;
  /// Of the tracker on a street map: probability of a match as good by chance, and normalised
  /// entropy of the particle weights, 0 … 1.
  std::optional<double> p_value = 1, entropy = 1;
  const char* reason = "";  ///< static text: why it is not TRACKING; empty if it is
};

/// Pose of the vehicle. Plain data of fixed size.
struct PoseReport {
  static constexpr ReportClass kClass = ReportClass::kPose;
  Stamp stamp;
  PoseFrame frame = PoseFrame::kOdom;
  Eigen::Isometry3d T_frame_vehicle = Eigen::Isometry3d::Identity();
  Eigen::Matrix<double, 6, 6> covariance = Eigen::Matrix<double, 6, 6>::Zero();
  double speed = 0;                  ///< m/s along x
  double yaw_rate = 0;               ///< rad/s
  std::optional<MapConfidence> map;  ///< with kMap
  const char* reason = "";           ///< static text: why it is not usable; empty if it is

  bool usable() const { return *reason == '\0'; }
};

/// An image and the sweep during which it was exposed. Plain data of fixed size.
struct FrameReport {
  static constexpr ReportClass kClass = ReportClass::kFrame;
  std::string_view device;  ///< name in the rig, which outlives the report
  Stamp stamp;              ///< middle of the exposure
  uint64_t sequence = 0;
  uint32_t width = 0;   ///< pixels
  uint32_t height = 0;  ///< pixels
  double mean_brightness = 0;
  double dark = 0;
  double bright = 0;
  uint64_t sweep = 0;
  Duration sweep_offset{0};
  uint32_t points_in_view = 0;
  const char* deskew_reason = "";  ///< static text: why it is not deskewed; empty if it is
  const char* reason = "";         ///< static text: why image and sweep do not match
};

/// Latency of one stage of the pipeline, in host time.
struct StageStats {
  const char* name = "";
  LatencyStats latency;
  uint64_t deadline_misses = 0;
};

/// Fill level of one queue.
struct QueueStats {
  const char* name = "";
  uint32_t depth = 0;
  uint32_t capacity = 0;
  uint64_t lost = 0;
};

/// Figures that depend on the speed of the host.
struct HostStats {
  double cpu_s = 0;
  std::vector<StageStats> stages;
  std::vector<QueueStats> queues;
  std::vector<StoreStatus> stores;   ///< live
  std::optional<SystemClock> clock;  ///< live; nothing if it cannot be asked
  std::vector<MapInUse> maps;        ///< live
  std::vector<PtpClock> ptp_clocks;  ///< live
};

/// Health of one device.
template <class Status>
struct DeviceHealth {
  std::string device;
  std::string kind;  ///< one of kDeviceKinds
  Status status;
};

/// Health of one task.
template <class Status>
struct TaskHealth {
  Status status;
  Level level = Level::kOk;
  std::vector<Finding> findings;
};

/// Health of the calibration of one camera.
struct CalibrationHealth {
  std::string camera;
  std::vector<Finding> findings;
};

/// Health of the daemon, once a second of drive time.
struct HealthReport {
  static constexpr ReportClass kClass = ReportClass::kHealth;
  Stamp stamp;
  Duration drive{0};  ///< since the start of the drive
  std::vector<DeviceHealth<LidarStatus>> sensors;
  std::vector<DeviceHealth<StreamStatus>> streams;
  std::optional<TaskHealth<OdometryStatus>> odometry;
  std::optional<TaskHealth<StreetMapStatus>> streetmap;
  std::optional<TaskHealth<MapStatus>> map;
  std::vector<CalibrationHealth> calibrations;  ///< of the monitored cameras
  std::vector<Finding> findings;                ///< about the daemon itself
  std::optional<HostStats> host;

  /// Returns the worst level of all findings: the one level of the daemon, which everything shows.
  Level level() const;
};

/// Device of alerts about the daemon itself.
inline constexpr const char* kDaemonDevice = "infused";

/// A finding that was raised or cleared.
struct AlertReport {
  static constexpr ReportClass kClass = ReportClass::kAlert;
  Stamp stamp;
  std::string device;
  bool raised = false;
  Finding finding;

  std::string id() const { return device + "." + finding.id; }
};

/// State of a recording.
struct RecordReport {
  static constexpr ReportClass kClass = ReportClass::kRecord;
  Stamp stamp;
  std::string name;
  std::string folder;
  std::string cause;
  Stamp since;
  Duration duration{0};
  uint64_t bytes = 0;
  uint32_t drives = 0;
  uint64_t datagrams = 0;
  uint64_t frames = 0;
  uint64_t images = 0;
  uint64_t fixes = 0;
  uint64_t lost = 0;
  bool ended = false;
  bool failed = false;  ///< it ended early
  std::string reason;   ///< why it ended; empty: as requested
};

/// A change of a calibration.
struct CalibrationChange {
  Stamp stamp;
  monitoring::CalibrationState state = monitoring::CalibrationState::kOk;  ///< after it
  std::string what;                                                        ///< "applied", ...
  Eigen::Isometry3d T_camera_lidar = Eigen::Isometry3d::Identity();        ///< in use after it
};

/// Result of a re-estimation.
struct CalibrationEstimate {
  Eigen::Isometry3d T_camera_lidar = Eigen::Isometry3d::Identity();
  Eigen::Matrix<double, 6, 6> covariance = Eigen::Matrix<double, 6, 6>::Zero();
  double mahalanobis_distance = 0;
  uint64_t scenes = 0;
  std::string reason;  ///< why it is not usable; empty if it is
  Eigen::Isometry3d T_estimated_from = Eigen::Isometry3d::Identity();  ///< in use when it began
};

/// Where a calibration comes from.
enum class CalibrationOrigin : uint8_t {
  kConfigured,  ///< rig.toml
  kEstimated,   ///< a re-estimation
  kGiven,       ///< the owner, from a file
};

/// What is done with a calibration.
enum class CalibrationUse : uint8_t {
  kEarlier,   ///< nothing
  kInUse,     ///< it is in use
  kPrevious,  ///< it was in use before: a rollback returns to it
  kProposed,  ///< it waits for the owner
};

/// A calibration of a camera that was in use or proposed, with the number that it keeps.
struct KnownCalibration {
  uint64_t number = 0;
  Stamp stamp;  ///< since when it is known
  CalibrationOrigin origin = CalibrationOrigin::kConfigured;
  CalibrationUse use = CalibrationUse::kEarlier;
  Eigen::Isometry3d T_camera_lidar = Eigen::Isometry3d::Identity();
  std::optional<Eigen::Matrix<double, 6, 6>> covariance;  ///< of an estimate
  std::optional<uint64_t> estimated_from;  ///< number of the calibration that was in use then
};

/// State of the calibration of one camera to its lidar.
struct CalibrationReport {
  static constexpr ReportClass kClass = ReportClass::kCalibration;
  std::string camera;
  Stamp stamp;
  monitoring::CalibrationState state = monitoring::CalibrationState::kMonitoring;
  Stamp since;  ///< begin of the state
  monitoring::UpdatePolicy policy = monitoring::UpdatePolicy::kAlertOnly;
  bool frozen = false;
  std::optional<CalibrationEstimate> proposal;  ///< a new calibration that waits for the owner
  bool recalibration_requested = false;         ///< by the owner; it waits for scenes
  uint64_t decision = 0;       ///< the last of the owner's that is carried out; not on the wire
  uint64_t needed_scenes = 0;  ///< that the next re-estimation needs
  std::vector<KnownCalibration> known;  ///< oldest first; numbered by the daemon's main thread
  Eigen::Isometry3d T_camera_lidar = Eigen::Isometry3d::Identity();  ///< in use
  uint64_t evaluations = 0;
  uint64_t scenes = 0;
  monitoring::DriftVerdict verdict;  ///< known after the first evaluation, its fault before it
  double dependence = 0;             ///< nats, of the last evaluated image
  std::optional<CalibrationEstimate> estimate;  ///< the last one
  std::vector<CalibrationChange> history;       ///< oldest first
};

/// Greeting of the server.
struct VersionReport {
  std::string release;
  std::string session;         ///< differs from one start of the daemon to the next
  std::string config_digest;   ///< of the configuration in use; empty: not known
  std::string config_version;  ///< its owner's name of it; empty: none
};

/// Loss of reports of a slow client.
struct LostReport {
  Stamp stamp;  ///< of the report sent next
  uint64_t reports = 0;
};

/// Reply to a request that was carried out.
struct AckReply {
  std::string op;
  std::string note;  ///< what follows from it; empty: nothing more to say
};

/// Reply to a request, or a connection, that was refused.
struct ErrorReply {
  std::string op;  ///< empty: not known
  std::string what;
  std::string hint;  ///< empty: none
};

}  // namespace infuse::daemon

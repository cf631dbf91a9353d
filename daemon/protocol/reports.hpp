#pragma once

#include <Eigen/Geometry>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "daemon/health/latency_histogram.hpp"
#include "daemon/health/odometry_health.hpp"
#include "daemon/health/sensor_health.hpp"
#include "daemon/health/stream_health.hpp"
#include "daemon/health/streetmap_health.hpp"
#include "drivers/measurement/stamp.hpp"

namespace infuse::daemon {

/// A sensor that the daemon listens to.
struct Device {
  std::string name;
  std::string kind;                ///< "lidar", "camera", "can", "imu", "gps"
  std::string model;               ///< "HDL-32E"
  std::string model_reason;        ///< why that model: "configured", or what it was inferred from
  std::string endpoint;            ///< where it is listened to: "port 2368 of lidar.pcap"
  std::optional<Stamp> activated;  ///< its first packet; absent while there was none
};

/// What is told of one sweep. Plain data of fixed size: it crosses threads by copy.
struct SweepReport {
  uint32_t device = 0;  ///< index in the list of devices
  Stamp stamp;          ///< first firing
  Duration span{0};     ///< first firing to last
  uint64_t sequence = 0;
  uint64_t returns = 0;
  uint32_t columns = 0;
  uint32_t rings = 0;
  uint32_t lost_packets = 0;
  uint32_t gaps = 0;             ///< stretches of the turn without data
  double gap_angle = 0;          ///< their sum, rad
  double mean_range = 0;         ///< m; NaN where there is no return
  double max_range = 0;          ///< m; NaN where there is no return
  double mean_reflectivity = 0;  ///< 0 … 1; NaN where there is no return
  bool has_times = true;         ///< each return has its own time
  bool clock_trusted = false;
  const char* deskew_reason = "";  ///< static text: why the returns were not corrected for
                                   ///< motion; empty where they were
  double travelled = 0;            ///< m, by the vehicle from the first return to the last
  double turned = 0;               ///< rad, the same
};

/// Where the vehicle is. Plain data of fixed size.
struct PoseReport {
  Stamp stamp;
  /// "odom": begins where the drive does, x ahead, and drifts; "map": the street map's
  const char* frame = "";
  Eigen::Isometry3d T_frame_vehicle = Eigen::Isometry3d::Identity();
  Eigen::Matrix<double, 6, 6> covariance = Eigen::Matrix<double, 6, 6>::Zero();
  double speed = 0;         ///< m/s along x
  double yaw_rate = 0;      ///< rad/s
  const char* state = "";   ///< on the map: "TRACKING", "UNSURE" or "LOST"; empty otherwise
  double p_value = 1;       ///< on the map: chance that what is seen fits it by chance
  double entropy = 1;       ///< on the map: of the particles' weights, 0 … 1
  const char* reason = "";  ///< static text: why it cannot be used; empty where it can

  bool usable() const { return *reason == '\0'; }
};

/// What is told of one picture and the sweep during which it was exposed. Plain data of fixed size.
struct FrameReport {
  uint32_t camera = 0;  ///< index in the rig
  Stamp stamp;          ///< middle of the exposure
  uint64_t sequence = 0;
  int width = 0;               ///< pixels
  int height = 0;              ///< pixels
  double mean_brightness = 0;  ///< 0 … 1
  double dark = 0;             ///< fraction of pixels that are black
  double bright = 0;           ///< fraction of pixels that are white
  uint64_t sweep = 0;          ///< sequence of the sweep
  Duration sweep_offset{0};    ///< exposure after the sweep's first firing
  uint32_t points_in_view = 0;
  const char* deskew_reason = "";  ///< static text: why the returns are not as of the exposure
  const char* reason = "";         ///< static text: why the two were not brought together
};

/// How one stage of the pipeline keeps up, in host time.
struct StageStats {
  const char* name = "";
  LatencyStats latency;
  uint64_t deadline_misses = 0;
};

/// How full one queue is.
struct QueueStats {
  const char* name = "";
  uint32_t depth = 0;
  uint32_t capacity = 0;
  uint64_t lost = 0;  ///< overwritten before they were read; live only
};

/// What depends on this machine's speed and not on the data alone.
struct HostStats {
  double cpu_s = 0;  ///< processor time of the process
  std::vector<StageStats> stages;
  std::vector<QueueStats> queues;
};

/// How the daemon is, once a second of drive time.
struct HealthReport {
  Stamp stamp;
  Duration drive{0};                         ///< since the start of the drive
  std::vector<const SensorStatus*> sensors;  ///< lidars, by device; valid while the report is used
  std::vector<const StreamStatus*> streams;  ///< the devices that follow; the same
  const OdometryStatus* odometry = nullptr;  ///< null where nothing says how the vehicle moves
  const Conditions* odometry_conditions = nullptr;   ///< with `odometry`
  const StreetMapStatus* streetmap = nullptr;        ///< null where there is no street map
  const Conditions* streetmap_conditions = nullptr;  ///< with `streetmap`
};

/// A finding that was raised or cleared.
struct AlertReport {
  Stamp stamp;
  std::string device;
  bool raised = false;
  Finding finding;
};

/// How a recording of what the sensors say stands.
struct RecordReport {
  Stamp stamp;
  std::string name;    ///< of the drive
  std::string folder;  ///< of the first drive
  std::string cause;   ///< "requested", or the alert
  Stamp since;
  Duration duration{0};  ///< of what was recorded
  uint64_t bytes = 0;
  uint32_t drives = 0;     ///< it was split into so many
  uint64_t datagrams = 0;  ///< of lidars
  uint64_t frames = 0;     ///< of buses
  uint64_t images = 0;
  uint64_t fixes = 0;
  uint64_t lost = 0;  ///< of all these, for want of time or of a faster disk
  bool ended = false;
  bool failed = false;  ///< it ended before it should have
  std::string reason;   ///< why it ended; empty: as it was requested
};

/// One thing that happened to a calibration.
struct CalibrationChange {
  Stamp stamp;
  const char* state = "";                                            ///< after it
  std::string what;                                                  ///< "applied", ...
  Eigen::Isometry3d T_camera_lidar = Eigen::Isometry3d::Identity();  ///< in use after it
};

/// How the calibration of one camera to its lidar stands. Plain data of fixed size, but for the
/// words.
struct CalibrationReport {
  std::string camera;
  Stamp stamp;
  const char* state = "";   ///< "OK", "MONITORING", "SUSPECTED", "CONFIRMED", "RECALIBRATING",
                            ///< "RECALIBRATED", "UNUSABLE"
  Stamp since;              ///< of the state
  const char* policy = "";  ///< "alert-only", "apply", "apply-within"
  bool frozen = false;      ///< the owner wants nothing changed
  Eigen::Isometry3d T_camera_lidar = Eigen::Isometry3d::Identity();  ///< in use
  uint64_t evaluations = 0;  ///< pictures that were put to the test
  uint64_t scenes = 0;       ///< kept for a re-estimation
  const char* axis = "";     ///< along which there is most evidence for a drift; empty: none yet
  double evidence = 0;       ///< nats, along it
  double evidence_threshold = 0;  ///< nats, to call it a drift
  Eigen::Matrix<double, 6, 1> offset = Eigen::Matrix<double, 6, 1>::Zero();  ///< rad and m: how far
                                                                             ///< it seems to be off
  Eigen::Matrix<double, 6, 1> offset_sigma = Eigen::Matrix<double, 6, 1>::Zero();  ///< of that
  double delay = 0;  ///< s, of the camera's stamps after its exposures, as it seems
  const char* delay_ambiguous_axis =
      "";                  ///< axis along which that cannot be told from a moved camera
  double dependence = 0;   ///< nats, of the last picture looked at
  const char* fault = "";  ///< of the camera itself; empty: none
  bool has_estimate = false;
  Eigen::Isometry3d T_camera_lidar_estimate = Eigen::Isometry3d::Identity();     ///< the last one
  Eigen::Matrix<double, 6, 6> covariance = Eigen::Matrix<double, 6, 6>::Zero();  ///< its
  double mahalanobis_distance = 0;  ///< Mahalanobis distance of the estimate from what was in use
  uint64_t estimate_scenes = 0;
  std::string estimate_reason;             ///< why the estimate cannot be used; empty where it can
  std::vector<CalibrationChange> history;  ///< the last changes, oldest first
};

}  // namespace infuse::daemon

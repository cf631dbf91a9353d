#pragma once

#include "daemon/protocol/description_parts.hpp"
#include "daemon/protocol/sensor_health_descriptions.hpp"

namespace infuse::daemon {

// HEALTH: the tasks, the host, and the message itself.

template <class Visitor>
void describe(Visitor& v, const OdometrySourceStatus& source) {
  v.field("name", source.name);
  v.field("carries", source.carries, "the odometry uses it now");
  v.field("accepted", source.accepted, "samples used");
  v.field("rejected", source.rejected, "samples that contradict the others");
}

template <class Visitor>
void describe(Visitor& v, const TaskHealth<OdometryStatus>& odometry) {
  const OdometryStatus& status = odometry.status;
  v.field("level", odometry.level);
  v.field("usable", status.usable(), "True if odometry can be used.",
          gauge("infuse_odometry_usable"));
  v.field("speed", when(status.usable(), rounded(status.speed)),
          "Forward speed, m/s; absent, as the next three, where odometry is not usable.",
          gauge("infuse_odometry_speed_meters_per_second"));
  v.field("speed_sigma", when(status.usable(), non_negative(rounded(status.speed_sigma))),
          "Its standard deviation.", gauge("infuse_odometry_speed_sigma_meters_per_second"));
  v.field("yaw_rate", when(status.usable(), rounded(status.yaw_rate)), "Yaw rate, rad/s.",
          gauge("infuse_odometry_yaw_rate_radians_per_second"));
  v.field("yaw_rate_sigma", when(status.usable(), non_negative(status.yaw_rate_sigma)),
          "Its standard deviation.", gauge("infuse_odometry_yaw_rate_sigma_radians_per_second"));
  v.field("sources", status.sources, "which measurements there are, and which carry the odometry");
  v.field("standing", status.standing, "True if the vehicle stands still.",
          gauge("infuse_odometry_standing"));
  v.field("wheel_scale", status.wheel_scale, "Estimated ratio of true to measured speed.",
          gauge("infuse_odometry_wheel_scale"));
  v.field("wheel_scale_sigma", non_negative(status.wheel_scale_sigma),
          "Its standard deviation; 0 until there are wheels.",
          gauge("infuse_odometry_wheel_scale_sigma"));
  v.field("yaw_rate_bias", status.yaw_rate_bias,
          "Estimated bias of the vehicle's yaw rate sensor, rad/s.",
          gauge("infuse_odometry_yaw_rate_bias_radians_per_second"));
  v.field("yaw_rate_bias_sigma", non_negative(status.yaw_rate_bias_sigma),
          "Its standard deviation.",
          gauge("infuse_odometry_yaw_rate_bias_sigma_radians_per_second"));
  v.field("gyro_bias", status.gyro_bias, "Estimated bias of the inertial unit about z, rad/s.",
          gauge("infuse_odometry_gyro_bias_radians_per_second"));
  v.field("gyro_bias_sigma", non_negative(status.gyro_bias_sigma), "Its standard deviation.",
          gauge("infuse_odometry_gyro_bias_sigma_radians_per_second"));
  v.field("yaw_rate_delay", when(status.yaw_rate_delay_sigma > 0, rounded(status.yaw_rate_delay)),
          "Estimated delay of the yaw rate, s; absent without it.",
          gauge("infuse_odometry_yaw_rate_delay_seconds"));
  v.field("yaw_rate_delay_sigma",
          when(status.yaw_rate_delay_sigma > 0, non_negative(rounded(status.yaw_rate_delay_sigma))),
          "Its standard deviation.", gauge("infuse_odometry_yaw_rate_delay_sigma_seconds"));
  v.field("imu_delay", when(status.imu_delay_sigma > 0, rounded(status.imu_delay)),
          "Estimated delay of the inertial unit, s; absent without it.",
          gauge("infuse_odometry_imu_delay_seconds"));
  v.field("imu_delay_sigma",
          when(status.imu_delay_sigma > 0, non_negative(rounded(status.imu_delay_sigma))),
          "Its standard deviation.", gauge("infuse_odometry_imu_delay_sigma_seconds"));
  v.field("gnss_delay", when(status.gnss_delay_sigma > 0, rounded(status.gnss_delay)),
          "Estimated delay of the GNSS receiver, s; absent without it.",
          gauge("infuse_odometry_gnss_delay_seconds"));
  v.field("gnss_delay_sigma",
          when(status.gnss_delay_sigma > 0, non_negative(rounded(status.gnss_delay_sigma))),
          "Its standard deviation.", gauge("infuse_odometry_gnss_delay_sigma_seconds"));
  v.field("steering_ratio", rounded(status.steering_ratio),
          "Estimated angle of the steering wheel over that of the road wheels.",
          gauge("infuse_odometry_steering_ratio"));
  v.field("wanted", unless_empty(status.wanted),
          "the source that would bound the largest uncertainty");
  v.field("late", status.late, "Samples that arrived too late.",
          counter("infuse_odometry_late_total"));
  v.field("outliers", status.outliers, "Samples rejected as inconsistent with the motion.",
          counter("infuse_odometry_outliers_total"));
  v.field("invalid_samples", status.invalid_samples,
          "Samples without a finite quantity, or with an implausible time.",
          counter("infuse_odometry_invalid_samples_total"));
  v.field("sweeps_not_deskewed", status.not_deskewed, "Sweeps passed on as measured.",
          counter("infuse_odometry_sweeps_not_deskewed_total"));
  v.field("reason", unless_empty(status.reason), "why it is not usable");
  v.field("findings", odometry.findings, "raised at present");
}

template <class Visitor>
void describe(Visitor& v, const streetmap::PossiblePlace& place) {
  v.field("x", rounded(place.pose.x), "m, map frame");
  v.field("y", rounded(place.pose.y), "m, map frame");
  v.field("yaw", rounded(place.pose.yaw), "rad, counter-clockwise from the map's x axis");
  v.field("covariance", place.covariance, "by row; x, y (m), yaw (rad)");
  v.field("probability", fraction(rounded(place.probability)));
}

template <class Visitor>
void describe(Visitor& v, const TaskHealth<StreetMapStatus>& streetmap) {
  const StreetMapStatus& status = streetmap.status;
  v.field("level", streetmap.level);
  v.field("state", status.state);
  v.field("p_value", fraction(rounded(status.p_value)),
          "Probability of a match with the map as good by chance.",
          gauge("infuse_streetmap_p_value"));
  v.field("entropy", fraction(rounded(status.entropy)),
          "Normalised entropy of the particle weights.", gauge("infuse_streetmap_entropy_ratio"));
  v.field("sigma", rounded(std::min(status.sigma, 1e6)),
          "Standard deviation of the position along its worst direction, m.",
          gauge("infuse_streetmap_sigma_metres"));
  v.field("elsewhere", fraction(rounded(status.elsewhere)),
          "Probability that the true place is another one that was checked.",
          gauge("infuse_streetmap_elsewhere_probability"));
  const std::span<const streetmap::PossiblePlace> places = status.places.all();
  v.field("places", when(places.size() > 1, places),
          "the places that look alike, of 5 % or more, at most four; absent where there is one");
  const bool fixes = status.gnss_offset.has_value();
  const Eigen::Vector2d offset = status.gnss_offset.value_or(Eigen::Vector2d::Zero());
  v.field("gnss_offset_east", when(fixes, rounded(offset.x())),
          "GNSS fixes minus the pose on the map, m to the east.",
          gauge("infuse_streetmap_gnss_offset_east_metres"));
  v.field("gnss_offset_north", when(fixes, rounded(offset.y())),
          "GNSS fixes minus the pose on the map, m to the north.",
          gauge("infuse_streetmap_gnss_offset_north_metres"));
  v.field("gnss_offset_sigma", when(fixes, rounded(status.gnss_offset_sigma)),
          "Standard deviation of this offset, m.",
          gauge("infuse_streetmap_gnss_offset_sigma_metres"));
  v.field("particles", status.particles, "Number of particles.",
          gauge("infuse_streetmap_particles"));
  v.field("hypotheses", when(status.hypotheses > 0, status.hypotheses),
          "Places of the search on all streets that explain the drive; absent without a search.",
          gauge("infuse_streetmap_hypotheses"));
  v.field("updates", status.updates, "Updates of the particle weights.",
          counter("infuse_streetmap_updates_total"));
  v.field("reason", unless_empty(status.reason), "why it is not TRACKING");
  v.field("findings", streetmap.findings, "raised at present");
}

template <class Visitor>
void describe(Visitor& v, const TaskHealth<MapStatus>& map) {
  const MapStatus& status = map.status;
  v.field("level", map.level);
  v.field("state", status.state);
  v.field("sigma", rounded(std::min(status.sigma, 1e6)),
          "Standard deviation of the position along its worst direction, m.",
          gauge("infuse_map_sigma_metres"));
  v.field("place_probability", rounded(status.place.best),
          "Probability of the place that fitted best at the last search.",
          gauge("infuse_map_place_probability"));
  v.field("runner_up_probability", rounded(status.place.runner_up),
          "Probability of the next best place.", gauge("infuse_map_runner_up_probability"));
  v.field("nowhere_probability", rounded(status.place.nowhere),
          "Probability that the vehicle was nowhere on the map at the last search.",
          gauge("infuse_map_nowhere_probability"));
  v.field("verified", status.verified, "Places of the map that confirmed the pose.",
          counter("infuse_map_verified_total"));
  v.field("found", status.found, "Times that the vehicle was found on the map.",
          counter("infuse_map_found_total"));
  v.field("dropped", status.dropped, "Sweeps that came while the background thread was behind.",
          counter("infuse_map_dropped_sweeps_total"));
  v.field("reason", unless_empty(status.reason), "why it is not TRACKING");
  v.field("findings", map.findings, "raised at present");
}

template <class Visitor>
void describe(Visitor& v, const CalibrationHealth& calibration) {
  v.field("device", calibration.camera, "the camera");
  v.field("level", worst_level(calibration.findings));
  v.field("findings", calibration.findings, "raised at present");
}

template <class Visitor>
void describe(Visitor& v, const LatencyStats& latency) {
  const auto statistic = [&](const char* name, Duration value, const char* label) {
    v.field(name, non_negative(rounded(to_seconds(value) * 1e3)), "ms",
            Metric{"infuse_stage_latency_seconds", "gauge", 1e-3, label,
                   "Latency of a stage since the start."});
  };
  statistic("p50", latency.p50, "statistic=\"p50\"");
  statistic("p99", latency.p99, "statistic=\"p99\"");
  statistic("max", latency.max, "statistic=\"max\"");
}

template <class Visitor>
void describe(Visitor& v, const StageStats& stage) {
  v.field("stage", stage.name);
  v.field("count", stage.latency.count, "Runs of a stage.", counter("infuse_stage_runs_total"));
  v.field("latency_ms", stage.latency);
  v.field("deadline_misses", stage.deadline_misses,
          "Runs that exceeded the stage's deadline, or were left out because of it.",
          counter("infuse_stage_deadline_misses_total"));
}

template <class Visitor>
void describe(Visitor& v, const QueueStats& queue) {
  v.field("queue", queue.name);
  v.field("depth", queue.depth, "Entries waiting.", gauge("infuse_queue_depth"));
  v.field("capacity", queue.capacity, "Maximum number of entries.", gauge("infuse_queue_capacity"));
  v.field("lost", queue.lost, "Entries overwritten before they were read; live only.",
          counter("infuse_queue_lost_total"));
}

template <class Visitor>
void describe(Visitor& v, const StoreStatus& store) {
  v.field("store", store.name, "what the daemon keeps on a disk");
  v.field("free_bytes", store.free_bytes, "Free space on the disk of a store.",
          gauge("infuse_store_free_bytes"));
  v.field("writable", store.problem.empty(), "Whether a store can be written.",
          gauge("infuse_store_writable"));
  v.field("problem", unless_empty(store.problem), "why it cannot");
}

template <class Visitor>
void describe(Visitor& v, const SystemClock& clock) {
  v.field("synchronised", clock.synchronised, "Whether the host's clock is kept by NTP or PTP.",
          gauge("infuse_system_clock_synchronised"));
  v.field("max_error_s", non_negative(rounded(clock.max_error_s)),
          "Bound of the error of the host's clock.",
          gauge("infuse_system_clock_max_error_seconds"));
  v.field("error_s", non_negative(rounded(clock.error_s)), "Estimated error of the host's clock.",
          gauge("infuse_system_clock_error_seconds"));
}

template <class Visitor>
void describe(Visitor& v, const PtpClock& clock) {
  v.field("device", clock.device, "PTP hardware clock of a network interface");
  v.field("offset_s", rounded(clock.offset_s),
          "PTP clock minus the host's; without the whole seconds between TAI and UTC.",
          gauge("infuse_ptp_clock_offset_seconds"));
  v.field("agrees", clock.agrees(), "Whether a PTP clock and the host's agree within 1 ms.",
          gauge("infuse_ptp_clock_agrees"));
}

template <class Visitor>
void describe(Visitor& v, const MapInUse& map) {
  v.field("map", map.name, "section of the configuration that names it");
  v.field("digest", map.digest, "of the map in use");
  v.field("current", map.problem.empty(),
          "Whether a map in use is what lies in its place; a new one may be refused.",
          gauge("infuse_map_current"));
  v.field("problem", unless_empty(map.problem), "why it is not");
}

template <class Visitor>
void describe(Visitor& v, const HostStats& host) {
  v.field("cpu_s", non_negative(rounded(host.cpu_s)), "Processor time of the daemon.",
          counter("process_cpu_seconds_total"));
  v.field("stages", host.stages);
  v.field("queues", host.queues);
  v.field("stores", when(!host.stores.empty(), host.stores), "live: what is kept on disks");
  v.field("clock", host.clock, "live: the host's clock; absent if the kernel does not say");
  v.field("ptp_clocks", when(!host.ptp_clocks.empty(), host.ptp_clocks),
          "live: the PTP clocks that may be read");
  v.field("maps", when(!host.maps.empty(), host.maps), "live: the maps in use");
}

template <class Visitor>
void describe(Visitor& v, const HealthReport& health) {
  v.message(name_of(health.kClass), "Health of the daemon, every second of drive time.");
  v.field("stamp", health.stamp, "Drive time of the figures.",
          stamp_gauge("infuse_health_timestamp_seconds"));
  v.field("drive_s", non_negative(rounded(to_seconds(health.drive))), "Since the start.",
          gauge("infuse_uptime_seconds"));
  v.field("level", health.level(), "the worst of all below");
  v.field("sensors", health.sensors, "lidars");
  v.field("streams", health.streams, "cameras and vehicle sensors");
  v.field("odometry", health.odometry, "dead reckoning; absent without it");
  v.field("streetmap", health.streetmap, "tracking on the street map; absent without one");
  v.field("map", health.map, "localisation on a map of keyframes; absent without one");
  v.field("calibrations", when(!health.calibrations.empty(), health.calibrations),
          "of the monitored cameras; absent without any");
  v.field("findings", health.findings, "about the daemon itself, raised at present");
  v.field("host", health.host, "figures that depend on the host; not in a replay's reports file");
}

}  // namespace infuse::daemon

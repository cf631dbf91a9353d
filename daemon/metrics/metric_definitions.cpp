#include "daemon/metrics/metric_definitions.hpp"

namespace infuse::daemon {
namespace {

constexpr const char* kCounter = "counter";
constexpr const char* kGauge = "gauge";
constexpr double kNano = 1e-9;
constexpr double kMilli = 1e-3;

constexpr const char* kLost = "infuse_lidar_packets_lost_total";
constexpr const char* kLostHelp = "Packets lost or refused, by cause.";

constexpr MetricDefinition kLidar[] = {
    {"/packets", "infuse_lidar_packets_total", "", kCounter, "Data packets decoded."},
    {"/position_packets", "infuse_lidar_position_packets_total", "", kCounter,
     "Position packets read."},
    {"/sweeps", "infuse_lidar_sweeps_total", "", kCounter, "Sweeps completed."},
    {"/returns", "infuse_lidar_returns_total", "", kCounter, "Returns decoded."},
    {"/losses/network", kLost, "cause=\"network\"", kCounter, kLostHelp},
    {"/losses/kernel", kLost, "cause=\"kernel\"", kCounter, kLostHelp},
    {"/losses/malformed", kLost, "cause=\"malformed\"", kCounter, kLostHelp},
    {"/losses/wrong_sender", kLost, "cause=\"wrong_sender\"", kCounter, kLostHelp},
    {"/losses/duplicate", kLost, "cause=\"duplicate\"", kCounter, kLostHelp},
    {"/losses/too_late", kLost, "cause=\"too_late\"", kCounter, kLostHelp},
    {"/wrong_model", "infuse_lidar_packets_wrong_model_total", "", kCounter,
     "Packets that name another model than the configured one."},
    {"/out_of_order", "infuse_lidar_packets_out_of_order_total", "", kCounter,
     "Packets that came late and were put back in order."},
    {"/clock_jumps", "infuse_lidar_clock_jumps_total", "", kCounter,
     "Times that the device's counter jumped."},
    {"/packets_hz", "infuse_lidar_packets_hz", "", kGauge, "Packets a second, of the last 10 s."},
    {"/sweeps_hz", "infuse_lidar_sweeps_hz", "", kGauge, "Sweeps a second, of the last 10 s."},
    {"/returns_hz", "infuse_lidar_returns_hz", "", kGauge, "Returns a second, of the last 10 s."},
    {"/last_packet", "infuse_lidar_last_packet_timestamp_seconds", "", kGauge,
     "Stamp of the last packet.", kNano},
    {"/clock/trusted", "infuse_lidar_clock_trusted", "", kGauge,
     "Whether the device's clock is trusted."},
    {"/clock/offset_ns", "infuse_lidar_clock_offset_seconds", "", kGauge,
     "Host time minus device time.", kNano},
    {"/clock/jitter_ns", "infuse_lidar_clock_jitter_seconds", "", kGauge,
     "Spread of the transport delay.", kNano},
    {"/clock/skew_ppm", "infuse_lidar_clock_skew_ratio", "", kGauge,
     "Rate of the device's clock against the host's, minus one.", 1e-6},
};

constexpr MetricDefinition kStream[] = {
    {"/received", "infuse_stream_received_total", "", kCounter,
     "Pictures, frames, samples or fixes received."},
    {"/used", "infuse_stream_used_total", "", kCounter, "Of these, what fusion was given."},
    {"/refused", "infuse_stream_refused_total", "", kCounter, "Of these, what cannot be read."},
    {"/lost", "infuse_stream_lost_total", "", kCounter,
     "Missing by their number, or dropped by the kernel."},
    {"/out_of_order", "infuse_stream_out_of_order_total", "", kCounter,
     "Stamps that lay before the one above."},
    {"/received_hz", "infuse_stream_received_hz", "", kGauge,
     "Received a second, of the last 10 s."},
    {"/last", "infuse_stream_last_timestamp_seconds", "", kGauge, "Stamp of the last.", kNano},
};

constexpr MetricDefinition kOdometry[] = {
    {"/usable", "infuse_odometry_usable", "", kGauge, "Whether odometry can be trusted."},
    {"/speed", "infuse_odometry_speed_meters_per_second", "", kGauge, "Forward speed."},
    {"/yaw_rate", "infuse_odometry_yaw_rate_radians_per_second", "", kGauge, "Yaw rate."},
    {"/standing", "infuse_odometry_standing", "", kGauge, "Whether the vehicle stands."},
    {"/wheel_scale", "infuse_odometry_wheel_scale", "", kGauge,
     "True over measured speed, as learned."},
    {"/wheel_scale_sigma", "infuse_odometry_wheel_scale_sigma", "", kGauge, "Its deviation."},
    {"/yaw_rate_bias", "infuse_odometry_yaw_rate_bias_radians_per_second", "", kGauge,
     "Bias of the vehicle's yaw-rate sensor, as learned."},
    {"/yaw_rate_bias_sigma", "infuse_odometry_yaw_rate_bias_sigma_radians_per_second", "", kGauge,
     "Its deviation."},
    {"/gyro_bias", "infuse_odometry_gyro_bias_radians_per_second", "", kGauge,
     "Bias of the inertial unit about z, as learned."},
    {"/gyro_bias_sigma", "infuse_odometry_gyro_bias_sigma_radians_per_second", "", kGauge,
     "Its deviation."},
    {"/late", "infuse_odometry_late_total", "", kCounter, "Samples that came too late."},
    {"/outliers", "infuse_odometry_outliers_total", "", kCounter,
     "Samples that did not agree with the motion."},
    {"/senseless", "infuse_odometry_invalid_samples_total", "", kCounter,
     "Samples without a finite quantity, or of a time of their own."},
    {"/sweeps_not_deskewed", "infuse_odometry_sweeps_not_deskewed_total", "", kCounter,
     "Sweeps that were passed on as they were measured."},
};

constexpr MetricDefinition kStreetMap[] = {
    {"/p_value", "infuse_streetmap_p_value", "", kGauge,
     "Chance that what is seen fits the map by chance."},
    {"/entropy", "infuse_streetmap_entropy_ratio", "", kGauge, "Of the particles' weights."},
    {"/particles", "infuse_streetmap_particles", "", kGauge, "Particles in use."},
    {"/updates", "infuse_streetmap_updates_total", "", kCounter, "Looks at the map."},
};

constexpr const char* kLatency = "infuse_stage_latency_seconds";
constexpr const char* kLatencyHelp = "Latency of a stage since the start.";

constexpr MetricDefinition kStage[] = {
    {"/count", "infuse_stage_runs_total", "", kCounter, "What a stage has done."},
    {"/latency_ms/p50", kLatency, "statistic=\"p50\"", kGauge, kLatencyHelp, kMilli},
    {"/latency_ms/p99", kLatency, "statistic=\"p99\"", kGauge, kLatencyHelp, kMilli},
    {"/latency_ms/max", kLatency, "statistic=\"max\"", kGauge, kLatencyHelp, kMilli},
    {"/deadline_misses", "infuse_stage_deadline_misses_total", "", kCounter,
     "Times that a stage was later than its deadline."},
};

constexpr MetricDefinition kQueue[] = {
    {"/depth", "infuse_queue_depth", "", kGauge, "Entries that wait."},
    {"/capacity", "infuse_queue_capacity", "", kGauge, "Entries that it holds."},
    {"/lost", "infuse_queue_lost_total", "", kCounter,
     "Entries overwritten before they were read."},
};

constexpr MetricDefinition kReport[] = {
    {"/stamp", "infuse_health_timestamp_seconds", "", kGauge,
     "When the figures were taken; older than a few seconds: the pipeline stands.", kNano},
    {"/drive_s", "infuse_uptime_seconds", "", kGauge, "Since the start."},
    {"/host/cpu_s", "process_cpu_seconds_total", "", kCounter, "Processor time of the daemon."},
};

}  // namespace

std::span<const MetricDefinition> lidar_metrics() { return kLidar; }
std::span<const MetricDefinition> stream_metrics() { return kStream; }
std::span<const MetricDefinition> odometry_metrics() { return kOdometry; }
std::span<const MetricDefinition> streetmap_metrics() { return kStreetMap; }
std::span<const MetricDefinition> stage_metrics() { return kStage; }
std::span<const MetricDefinition> queue_metrics() { return kQueue; }
std::span<const MetricDefinition> report_metrics() { return kReport; }

}  // namespace infuse::daemon

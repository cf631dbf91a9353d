#include "daemon/pipeline/publisher.hpp"

#include <array>
#include <ctime>

#include "daemon/protocol/messages.hpp"
#include "drivers/measurement/angles.hpp"

namespace infuse::daemon {
namespace {

constexpr size_t kMaxFirstAlerts = 20;

/// What is to be said of a drift, along the axis that has most evidence.
CalibrationStatus calibration_status(const CalibrationReport& report) {
  CalibrationStatus status;
  status.state = report.state;
  status.axis = report.axis;
  status.evidence = report.evidence;
  status.evidence_threshold = report.evidence_threshold;
  status.fault = report.fault;
  status.reason = report.estimate_reason;
  constexpr std::array kAxes = {"rotation about x",    "rotation about y",
                                "rotation about z",    "translation along x",
                                "translation along y", "translation along z"};
  for (size_t i = 0; i < kAxes.size(); ++i) {
    if (status.axis != kAxes[i]) continue;
    const auto axis = static_cast<Eigen::Index>(i);
    const double factor = i < 3 ? 1 / kDegree : 100;
    status.offset = report.offset[axis] * factor;
    status.offset_sigma = report.offset_sigma[axis] * factor;
    status.unit = i < 3 ? "°" : "cm";
  }
  return status;
}

}  // namespace

double process_cpu_s() {
  timespec time{};
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &time);
  return static_cast<double>(time.tv_sec) + static_cast<double>(time.tv_nsec) * 1e-9;
}

Publisher::Publisher(SlotRing<ReportItem>& in, const PipelineSetup& setup,
                     const HealthOptions& health, Server& server, ReportsFile* file)
    : ring_(in),
      in_(in.make_reader()),
      devices_(setup.devices),
      lidar_count_(setup.lidars.size()),
      has_odometry_(setup.vehicle.has_odometry()),
      health_options_(health),
      odometry_health_(health),
      streetmap_health_(health),
      server_(server),
      file_(file) {}

bool Publisher::drain() {
  constexpr int kMaxItemsPerDrain = 64;  // then the clients have their turn
  for (int items = 0; items < kMaxItemsPerDrain; ++items) {
    const Pin<ReportItem> item = in_.next();
    if (!item) return false;
    process(*item);
  }
  return true;
}

void Publisher::process(const ReportItem& item) {
  switch (item.kind) {
    case ReportItem::Kind::kStart:
      start(item.stamp);
      return on_progress_();
    case ReportItem::Kind::kSweep:
      return publish_sweep(item);
    case ReportItem::Kind::kPose:
      return publish_pose(item);
    case ReportItem::Kind::kFrame:
      return publish_frame(item);
    case ReportItem::Kind::kCalibration:
      return publish_calibration(item.calibration);
    case ReportItem::Kind::kTick:
      publish_health(item);
      return on_progress_();
    case ReportItem::Kind::kEnd:
      totals_.ended = true;
      return;
  }
}

void Publisher::start(Stamp stamp) {
  totals_.started = true;
  totals_.start = totals_.now = stamp;
  totals_.counters.resize(lidar_count_);
  totals_.streams.resize(devices_.size() - lidar_count_);
  totals_.levels.resize(devices_.size());
  for (size_t i = 0; i < devices_.size(); ++i) {
    if (i < lidar_count_) {
      lidar_health_.emplace_back(devices_[i].endpoint, health_options_, stamp);
    } else {
      stream_health_.emplace_back(devices_[i].endpoint, health_options_, stamp);
    }
  }
  publish_devices(stamp);
}

void Publisher::publish_sweep(const ReportItem& item) {
  publish(ReportClass::kSweep, devices_[item.sweep.device].name, item.stamp,
          sweep_message(item.sweep, devices_));
}

void Publisher::publish_frame(const ReportItem& item) {
  const std::span<const Device> cameras = std::span(devices_).subspan(lidar_count_);
  publish(ReportClass::kFrame, cameras[item.frame.camera].name, item.stamp,
          frame_message(item.frame, cameras));
}

void Publisher::publish_pose(const ReportItem& item) {
  on_pose_(item.pose);
  publish(ReportClass::kPose, item.pose.frame, item.stamp, pose_message(item.pose));
}

void Publisher::publish_calibration(const CalibrationReport& report) {
  totals_.calibrations[report.camera] = report;
  on_calibration_(report);
  publish(ReportClass::kCalibration, report.camera, report.stamp, calibration_message(report));
  const Conditions& conditions =
      calibration_health_[report.camera].update(report.stamp, calibration_status(report));
  publish_transitions(report.stamp, report.camera, conditions.transitions());
}

void Publisher::publish_health(const ReportItem& item) {
  totals_.now = item.stamp;
  totals_.counters = item.counters;
  totals_.streams = item.streams;
  totals_.odometry = item.odometry;
  totals_.host = host_stats(item);
  HealthReport report{.stamp = item.stamp, .drive = item.stamp - totals_.start};
  update_lidar_health(item, report);
  update_stream_health(item, report);
  if (has_odometry_) {
    report.odometry = &item.odometry;
    report.odometry_conditions = &odometry_health_.update(item.stamp, item.odometry);
  }
  if (item.streetmap.present()) {
    report.streetmap = &item.streetmap;
    report.streetmap_conditions = &streetmap_health_.update(item.stamp, item.streetmap);
  }
  if (mark_activated_devices(item)) publish_devices(item.stamp);
  for (size_t i = 0; i < report.sensors.size(); ++i) {
    publish_transitions(item.stamp, devices_[i].name, report.sensors[i]->transitions);
  }
  for (size_t i = 0; i < report.streams.size(); ++i) {
    publish_transitions(item.stamp, devices_[lidar_count_ + i].name,
                        report.streams[i]->transitions);
  }
  if (has_odometry_) {
    publish_transitions(item.stamp, "odom", report.odometry_conditions->transitions());
  }
  if (report.streetmap != nullptr) {
    publish_transitions(item.stamp, "streetmap", report.streetmap_conditions->transitions());
  }
  if (file_ != nullptr) file_->write(health_message(report, devices_, nullptr));
  std::string message = health_message(report, devices_, &totals_.host);
  on_health_(message);
  server_.publish(ReportClass::kHealth, "", item.stamp, std::move(message));
}

void Publisher::update_lidar_health(const ReportItem& item, HealthReport& report) {
  for (size_t i = 0; i < lidar_count_; ++i) {
    const SensorCounters& counters = item.counters[i];
    report.sensors.push_back(&lidar_health_[i].update(item.stamp, counters));
    totals_.levels[i] = report.sensors[i]->level;
  }
}

void Publisher::update_stream_health(const ReportItem& item, HealthReport& report) {
  for (size_t i = 0; i < stream_health_.size(); ++i) {
    report.streams.push_back(&stream_health_[i].update(item.stamp, item.streams[i]));
    totals_.levels[lidar_count_ + i] = report.streams[i]->level;
  }
}

bool Publisher::mark_activated_devices(const ReportItem& item) {
  bool any = false;
  for (size_t i = 0; i < devices_.size(); ++i) {
    if (devices_[i].activated) continue;
    const bool lidar = i < lidar_count_;
    if ((lidar ? item.counters[i].packets : item.streams[i - lidar_count_].received) == 0) continue;
    devices_[i].activated =
        lidar ? item.counters[i].first_packet : item.streams[i - lidar_count_].first;
    any = true;
  }
  return any;
}

void Publisher::publish_devices(Stamp stamp) {
  publish(ReportClass::kDevices, "", stamp, devices_message(stamp, devices_));
}

void Publisher::publish_transitions(Stamp stamp, const std::string& device,
                                    std::span<const Transition> transitions) {
  for (const Transition& transition : transitions) {
    publish_alert({stamp, device, transition.raised, transition.finding});
  }
}

void Publisher::publish_alert(const AlertReport& alert) {
  publish(ReportClass::kAlert, alert.device + "." + alert.finding.id, alert.stamp,
          alert_message(alert));
  on_alert_(alert);
  if (!alert.raised) return;
  ++totals_.alerts;
  if (totals_.first_alerts.size() < kMaxFirstAlerts) totals_.first_alerts.push_back(alert);
}

void Publisher::set_health_options(const HealthOptions& health) {
  health_options_ = health;
  for (SensorHealth& lidar : lidar_health_) lidar.set_options(health);
  for (StreamHealth& stream : stream_health_) stream.set_options(health);
}

void Publisher::publish_record(const RecordReport& report) {
  publish(ReportClass::kRecord, "", report.stamp, record_message(report));
}

void Publisher::publish(ReportClass report_class, const std::string& device, Stamp stamp,
                        std::string message) {
  if (file_ != nullptr) file_->write(message);
  server_.publish(report_class, device, stamp, std::move(message));
}

HostStats Publisher::host_stats(const ReportItem& item) const {
  HostStats host;
  host.cpu_s = process_cpu_s();
  for (size_t i = 0; i < item.stages.size(); ++i) {
    const bool total = i == static_cast<size_t>(Stage::kTotal);
    host.stages.push_back({kStageNames[i], item.stages[i], total ? item.deadline_misses : 0});
  }
  host.queues = {item.items_waiting,
                 {"reports", static_cast<uint32_t>(in_.backlog()),
                  static_cast<uint32_t>(ring_.capacity()), in_.lost()}};
  return host;
}

}  // namespace infuse::daemon

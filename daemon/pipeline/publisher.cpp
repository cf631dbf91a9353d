#include "daemon/pipeline/publisher.hpp"

#include <ctime>

#include "daemon/protocol/messages.hpp"
#include "daemon/protocol/names.hpp"

namespace infuse::daemon {
namespace {

constexpr size_t kMaxFirstAlerts = 20;

/// Returns what the health check needs of a report.
CalibrationStatus calibration_status(const CalibrationReport& report) {
  const DriftEvidence evidence = report.evidence.value_or(DriftEvidence{});
  CalibrationStatus status{.state = report.state,
                           .axis = evidence.axis,
                           .evidence = evidence.nats,
                           .evidence_threshold = evidence.threshold_nats,
                           .fault = report.fault,
                           .reason = report.estimate ? report.estimate->reason : ""};
  const auto axis = static_cast<Eigen::Index>(monitoring::base_axis(evidence.axis));
  if (axis < report.offset.size()) {
    status.offset = report.offset[axis];
    status.offset_sigma = report.offset_sigma[axis];
  }
  return status;
}

/// Returns the health of a task after `conditions` were updated.
template <class Status>
TaskHealth<Status> task_health(const Status& status, const Conditions& conditions) {
  return {status, conditions.level(), conditions.findings()};
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
      health_options_(health),
      odometry_health_(health),
      streetmap_health_(health),
      map_health_(health),
      server_(server),
      file_(file) {}

template <class Report>
void Publisher::publish(const Report& report, const std::string& device) {
  std::string line = message(report);
  if (file_ != nullptr) file_->write(line);
  serve(Report::kClass, device, report.stamp, std::move(line));
}

void Publisher::serve(ReportClass report_class, const std::string& device, Stamp stamp,
                      std::string line) {
  if (on_line_) on_line_(report_class, device, line);
  server_.publish(report_class, device, stamp, std::move(line));
}

void Publisher::publish_record(const RecordReport& report) { publish(report, ""); }

bool Publisher::drain() {
  constexpr int kMaxItemsPerDrain = 64;  // then the server handles its clients
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
      count(item.sweep);
      return publish(item.sweep, std::string(item.sweep.device));
    case ReportItem::Kind::kPose:
      on_pose_(item.pose);
      return publish(item.pose, name_of(item.pose.frame));
    case ReportItem::Kind::kFrame:
      count(item.frame);
      return publish(item.frame, std::string(item.frame.device));
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

void Publisher::count(const SweepReport& report) {
  ++totals_.sweeps;
  if (*report.deskew_reason == '\0') {
    ++totals_.deskewed_sweeps;
  } else {
    totals_.deskew_reason = report.deskew_reason;
  }
}

void Publisher::count(const FrameReport& report) {
  ++totals_.frames;
  totals_.matched_frames += *report.reason == '\0' ? 1 : 0;
}

void Publisher::start(Stamp stamp) {
  totals_.started = true;
  totals_.start = totals_.now = stamp;
  totals_.counters.resize(lidar_count_);
  totals_.streams.resize(devices_.size() - lidar_count_);
  totals_.levels.resize(devices_.size());
  for (const Device& device : devices_) device_names_.push_back(device.name);
  for (size_t i = 0; i < devices_.size(); ++i) {
    if (i < lidar_count_) {
      lidar_health_.emplace_back(devices_[i].endpoint, health_options_, stamp);
    } else {
      stream_health_.emplace_back(devices_[i].endpoint, health_options_, stamp);
    }
  }
  publish(DevicesReport{stamp, devices_}, "");
}

void Publisher::publish_calibration(const CalibrationReport& report) {
  totals_.calibrations[report.camera] = report;
  for (const auto& listener : on_calibration_) listener(report);
  publish(report, report.camera);
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
  if (mark_activated_devices(item)) publish(DevicesReport{item.stamp, devices_}, "");
  HealthReport report{.stamp = item.stamp, .drive = item.stamp - totals_.start};
  update_devices(item, report);
  if (item.odometry.present) {
    const Conditions& conditions = odometry_health_.update(item.stamp, item.odometry);
    report.odometry = task_health(item.odometry, conditions);
    publish_transitions(item.stamp, "odometry", conditions.transitions());
  }
  if (item.streetmap) {
    const Conditions& conditions = streetmap_health_.update(item.stamp, *item.streetmap);
    report.streetmap = task_health(*item.streetmap, conditions);
    publish_transitions(item.stamp, "streetmap", conditions.transitions());
  }
  if (item.map) {
    const Conditions& conditions = map_health_.update(item.stamp, *item.map);
    report.map = task_health(*item.map, conditions);
    publish_transitions(item.stamp, "map", conditions.transitions());
  }
  const Conditions& conditions = rig_health_.update(item.stamp, device_names_, health_options_);
  report.findings = conditions.findings();
  publish_transitions(item.stamp, kDaemonDevice, conditions.transitions());
  if (file_ != nullptr) file_->write(message(report));  // without host figures
  report.host = totals_.host;
  for (const auto& listener : on_health_) listener(report);
  serve(ReportClass::kHealth, "", item.stamp, message(report));
}

void Publisher::update_devices(const ReportItem& item, HealthReport& report) {
  for (size_t i = 0; i < devices_.size(); ++i) {
    const Device& device = devices_[i];
    if (i < lidar_count_) {
      const SensorStatus& status = lidar_health_[i].update(item.stamp, item.counters[i]);
      report.sensors.push_back({device.name, device.kind, status});
      totals_.levels[i] = status.level;
      publish_transitions(item.stamp, device.name, status.transitions);
    } else {
      const size_t stream = i - lidar_count_;
      const StreamStatus& status = stream_health_[stream].update(item.stamp, item.streams[stream]);
      report.streams.push_back({device.name, device.kind, status});
      totals_.levels[i] = status.level;
      publish_transitions(item.stamp, device.name, status.transitions);
    }
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

void Publisher::publish_transitions(Stamp stamp, const std::string& device,
                                    std::span<const Transition> transitions) {
  for (const Transition& transition : transitions) {
    publish_alert({stamp, device, transition.raised, transition.finding});
  }
}

void Publisher::publish_alert(const AlertReport& alert) {
  publish(alert, alert.id());
  for (const auto& listener : on_alert_) listener(alert);
  if (!alert.raised) return;
  ++totals_.alerts;
  if (totals_.first_alerts.size() < kMaxFirstAlerts) totals_.first_alerts.push_back(alert);
}

void Publisher::set_health_options(const HealthOptions& health) {
  health_options_ = health;
  for (SensorHealth& lidar : lidar_health_) lidar.set_options(health);
  for (StreamHealth& stream : stream_health_) stream.set_options(health);
}

HostStats Publisher::host_stats(const ReportItem& item) const {
  HostStats host;
  host.cpu_s = process_cpu_s();
  for (size_t i = 0; i < item.stages.size(); ++i) {
    const auto stage = static_cast<Stage>(i);
    const uint64_t misses = stage == Stage::kTotal      ? item.deadline_misses
                            : stage == Stage::kRegister ? item.skipped_registrations
                                                        : 0;
    host.stages.push_back({kStageNames[i], item.stages[i], misses});
  }
  host.queues = {item.items_waiting,
                 {"reports", static_cast<uint32_t>(in_.backlog()),
                  static_cast<uint32_t>(ring_.capacity()), in_.lost()}};
  for (const auto& stats : queues_) host.queues.push_back(stats());
  return host;
}

}  // namespace infuse::daemon

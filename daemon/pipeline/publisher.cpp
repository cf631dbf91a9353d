#include "daemon/pipeline/publisher.hpp"

#include <array>
#include <ctime>
#include <numbers>

#include "daemon/protocol/messages.hpp"

namespace infuse::daemon {
namespace {

constexpr size_t kAlertsKept = 20;

/// What is to be said of a drift, along the axis that has most evidence.
CalibrationFigures calibration_figures(const CalibrationReport& report) {
  CalibrationFigures figures;
  figures.state = report.state;
  figures.axis = report.axis;
  figures.evidence = report.evidence;
  figures.evidence_needed = report.evidence_needed;
  figures.fault = report.fault;
  figures.reason = report.estimate_reason;
  constexpr std::array kAxes = {"rotation about x",    "rotation about y",
                                "rotation about z",    "translation along x",
                                "translation along y", "translation along z"};
  for (size_t i = 0; i < kAxes.size(); ++i) {
    if (figures.axis != kAxes[i]) continue;
    const auto axis = static_cast<Eigen::Index>(i);
    const double factor = i < 3 ? 180 / std::numbers::pi : 100;
    figures.offset = report.offset[axis] * factor;
    figures.deviation = report.deviation[axis] * factor;
    figures.unit = i < 3 ? "°" : "cm";
  }
  return figures;
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
      in_(in.reader()),
      devices_(setup.devices),
      lidars_(setup.lidars.size()),
      has_odometry_(setup.vehicle.has_odometry()),
      health_options_(health),
      odometry_health_(health),
      streetmap_health_(health),
      server_(server),
      file_(file) {}

bool Publisher::drain() {
  constexpr int kItemsAtOnce = 64;  // then the clients have their turn
  for (int items = 0; items < kItemsAtOnce; ++items) {
    const Pin<ReportItem> item = in_.next();
    if (!item) return false;
    take(*item);
  }
  return true;
}

void Publisher::take(const ReportItem& item) {
  switch (item.kind) {
    case ReportItem::Kind::kStart:
      start(item.stamp);
      return on_progress_();
    case ReportItem::Kind::kSweep:
      return tell_sweep(item);
    case ReportItem::Kind::kPose:
      return tell_pose(item);
    case ReportItem::Kind::kFrame:
      return tell_frame(item);
    case ReportItem::Kind::kCalibration:
      return tell_calibration(item.calibration);
    case ReportItem::Kind::kTick:
      tell_health(item);
      return on_progress_();
    case ReportItem::Kind::kEnd:
      totals_.ended = true;
      return;
  }
}

void Publisher::start(Stamp stamp) {
  totals_.started = true;
  totals_.start = totals_.now = stamp;
  totals_.counters.resize(lidars_);
  totals_.streams.resize(devices_.size() - lidars_);
  totals_.levels.resize(devices_.size());
  for (size_t i = 0; i < devices_.size(); ++i) {
    if (i < lidars_) {
      health_.emplace_back(devices_[i].endpoint, health_options_, stamp);
    } else {
      stream_health_.emplace_back(devices_[i].endpoint, health_options_, stamp);
    }
  }
  tell_devices(stamp);
}

void Publisher::tell_sweep(const ReportItem& item) {
  tell(ReportClass::kSweep, devices_[item.sweep.device].name, item.stamp,
       sweep_message(item.sweep, devices_));
}

void Publisher::tell_frame(const ReportItem& item) {
  const std::span<const Device> cameras = std::span(devices_).subspan(lidars_);
  tell(ReportClass::kFrame, cameras[item.frame.camera].name, item.stamp,
       frame_message(item.frame, cameras));
}

void Publisher::tell_pose(const ReportItem& item) {
  on_pose_(item.pose);
  tell(ReportClass::kPose, item.pose.frame, item.stamp, pose_message(item.pose));
}

void Publisher::tell_calibration(const CalibrationReport& report) {
  totals_.calibrations[report.camera] = report;
  on_calibration_(report);
  tell(ReportClass::kCalibration, report.camera, report.stamp, calibration_message(report));
  const Conditions& conditions =
      calibration_health_[report.camera].update(report.stamp, calibration_figures(report));
  tell_transitions(report.stamp, report.camera, conditions.transitions());
}

void Publisher::tell_health(const ReportItem& item) {
  totals_.now = item.stamp;
  totals_.counters = item.counters;
  totals_.streams = item.streams;
  totals_.odometry = item.odometry;
  totals_.host = host_figures(item);
  HealthReport report{.stamp = item.stamp, .drive = item.stamp - totals_.start};
  judge_lidars(item, report);
  judge_streams(item, report);
  if (has_odometry_) {
    report.odometry = &item.odometry;
    report.odometry_conditions = &odometry_health_.update(item.stamp, item.odometry);
  }
  if (item.streetmap.present()) {
    report.streetmap = &item.streetmap;
    report.streetmap_conditions = &streetmap_health_.update(item.stamp, item.streetmap);
  }
  if (activate_devices(item)) tell_devices(item.stamp);
  for (size_t i = 0; i < report.sensors.size(); ++i) {
    tell_transitions(item.stamp, devices_[i].name, report.sensors[i]->transitions);
  }
  for (size_t i = 0; i < report.streams.size(); ++i) {
    tell_transitions(item.stamp, devices_[lidars_ + i].name, report.streams[i]->transitions);
  }
  if (has_odometry_) {
    tell_transitions(item.stamp, "odometry", report.odometry_conditions->transitions());
  }
  if (report.streetmap != nullptr) {
    tell_transitions(item.stamp, "streetmap", report.streetmap_conditions->transitions());
  }
  if (file_ != nullptr) file_->write(health_message(report, devices_, nullptr));
  std::string message = health_message(report, devices_, &totals_.host);
  on_health_(message);
  server_.publish(ReportClass::kHealth, "", item.stamp, std::move(message));
}

void Publisher::judge_lidars(const ReportItem& item, HealthReport& report) {
  for (size_t i = 0; i < lidars_; ++i) {
    const SensorCounters& counters = item.counters[i];
    report.sensors.push_back(&health_[i].update(item.stamp, counters));
    totals_.levels[i] = report.sensors[i]->level;
  }
}

void Publisher::judge_streams(const ReportItem& item, HealthReport& report) {
  for (size_t i = 0; i < stream_health_.size(); ++i) {
    report.streams.push_back(&stream_health_[i].update(item.stamp, item.streams[i]));
    totals_.levels[lidars_ + i] = report.streams[i]->level;
  }
}

bool Publisher::activate_devices(const ReportItem& item) {
  bool any = false;
  for (size_t i = 0; i < devices_.size(); ++i) {
    if (devices_[i].activated) continue;
    const bool lidar = i < lidars_;
    if ((lidar ? item.counters[i].packets : item.streams[i - lidars_].received) == 0) continue;
    devices_[i].activated = lidar ? item.counters[i].first_packet : item.streams[i - lidars_].first;
    any = true;
  }
  return any;
}

void Publisher::tell_devices(Stamp stamp) {
  tell(ReportClass::kDevices, "", stamp, devices_message(stamp, devices_));
}

void Publisher::tell_transitions(Stamp stamp, const std::string& device,
                                 std::span<const Transition> transitions) {
  for (const Transition& transition : transitions) {
    tell_alert({stamp, device, transition.raised, transition.finding});
  }
}

void Publisher::tell_alert(const AlertReport& alert) {
  tell(ReportClass::kAlert, alert.device + "." + alert.finding.id, alert.stamp,
       alert_message(alert));
  on_alert_(alert);
  if (!alert.raised) return;
  ++totals_.alerts;
  if (totals_.first_alerts.size() < kAlertsKept) totals_.first_alerts.push_back(alert);
}

void Publisher::set(const HealthOptions& health) {
  health_options_ = health;
  for (SensorHealth& lidar : health_) lidar.set(health);
  for (StreamHealth& stream : stream_health_) stream.set(health);
}

void Publisher::tell_record(const RecordReport& report) {
  tell(ReportClass::kRecord, "", report.stamp, record_message(report));
}

void Publisher::tell(ReportClass report_class, const std::string& device, Stamp stamp,
                     std::string message) {
  if (file_ != nullptr) file_->write(message);
  server_.publish(report_class, device, stamp, std::move(message));
}

HostFigures Publisher::host_figures(const ReportItem& item) const {
  HostFigures host;
  host.cpu_s = process_cpu_s();
  for (size_t i = 0; i < item.stages.size(); ++i) {
    const bool whole = i == static_cast<size_t>(Stage::kWhole);
    host.stages.push_back({kStageNames[i], item.stages[i], whole ? item.deadline_misses : 0});
  }
  host.queues = {item.items_waiting,
                 {"reports", static_cast<uint32_t>(in_.behind()),
                  static_cast<uint32_t>(ring_.capacity()), in_.lost()}};
  return host;
}

}  // namespace infuse::daemon

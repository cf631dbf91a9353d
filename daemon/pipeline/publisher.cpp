#include "daemon/pipeline/publisher.hpp"

#include <ctime>

#include "daemon/protocol/messages.hpp"

namespace infuse::daemon {
namespace {

constexpr size_t kAlertsKept = 20;

}  // namespace

double process_cpu_s() {
  timespec time{};
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &time);
  return static_cast<double>(time.tv_sec) + static_cast<double>(time.tv_nsec) * 1e-9;
}

Publisher::Publisher(SlotRing<ReportItem>& in, std::vector<Device> devices,
                     const HealthOptions& health, Server& server, ReportsFile* file)
    : ring_(in),
      in_(in.reader()),
      devices_(std::move(devices)),
      health_options_(health),
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
    case StreamItem::Kind::kStart:
      return start(item.stamp);
    case StreamItem::Kind::kSweep:
      return tell_sweep(item);
    case StreamItem::Kind::kTick:
      return tell_health(item);
    case StreamItem::Kind::kEnd:
      totals_.ended = true;
      return;
  }
}

void Publisher::start(Stamp stamp) {
  totals_.started = true;
  totals_.start = totals_.now = stamp;
  totals_.counters.resize(devices_.size());
  totals_.levels.resize(devices_.size());
  for (const Device& device : devices_) {
    health_.emplace_back(device.endpoint, health_options_, stamp);
  }
  tell_devices(stamp);
}

void Publisher::tell_sweep(const ReportItem& item) {
  tell(ReportClass::kSweep, devices_[item.sweep.device].name, item.stamp,
       sweep_message(item.sweep, devices_));
}

void Publisher::tell_health(const ReportItem& item) {
  totals_.now = item.stamp;
  totals_.counters = item.counters;
  totals_.host = host_figures(item);
  bool activated = false;
  HealthReport report{item.stamp, item.stamp - totals_.start, {}};
  for (size_t i = 0; i < devices_.size(); ++i) {
    const SensorCounters& counters = item.counters[i];
    const SensorStatus& status = health_[i].update(item.stamp, counters);
    report.sensors.push_back(&status);
    totals_.levels[i] = status.level;
    if (counters.packets > 0 && !devices_[i].activated) {
      devices_[i].activated = counters.first_packet;
      activated = true;
    }
  }
  if (activated) tell_devices(item.stamp);
  for (size_t i = 0; i < devices_.size(); ++i) {
    tell_transitions(item.stamp, i, *report.sensors[i]);
  }
  if (file_ != nullptr) file_->write(health_message(report, devices_, nullptr));
  server_.publish(ReportClass::kHealth, "", item.stamp,
                  health_message(report, devices_, &totals_.host));
}

void Publisher::tell_devices(Stamp stamp) {
  tell(ReportClass::kDevices, "", stamp, devices_message(stamp, devices_));
}

void Publisher::tell_transitions(Stamp stamp, size_t device, const SensorStatus& status) {
  for (const Transition& transition : status.transitions) {
    const std::string& name = devices_[device].name;
    const AlertReport alert{stamp, name, transition.raised, transition.finding};
    tell(ReportClass::kAlert, name + "." + transition.finding.id, stamp, alert_message(alert));
    if (!transition.raised) continue;
    ++totals_.alerts;
    if (totals_.first_alerts.size() < kAlertsKept) totals_.first_alerts.push_back(alert);
  }
}

void Publisher::tell(ReportClass report_class, const std::string& device, Stamp stamp,
                     std::string message) {
  if (file_ != nullptr) file_->write(message);
  server_.publish(report_class, device, stamp, std::move(message));
}

HostFigures Publisher::host_figures(const ReportItem& item) const {
  return {
      process_cpu_s(),
      {{"intake", item.intake, 0},
       {"fusion", item.fusion, 0},
       {"whole", item.whole, item.deadline_misses}},
      {item.sweeps_waiting,
       {"reports", static_cast<uint32_t>(in_.behind()), static_cast<uint32_t>(ring_.capacity())}}};
}

}  // namespace infuse::daemon

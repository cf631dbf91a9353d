#include "daemon/metrics/metrics_text.hpp"

#include <spdlog/fmt/fmt.h>
#include <unistd.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <optional>
#include <vector>

#include "daemon/protocol/descriptions.hpp"

namespace infuse::daemon {
namespace {

/// Collects samples by metric: the format requires those of one metric in one block.
class Families {
 public:
  void add(const char* name, const char* type, const char* help, const std::string& labels,
           double value) {
    auto family = std::find_if(families_.begin(), families_.end(),
                               [&](const Family& f) { return f.name == name; });
    if (family == families_.end()) {
      families_.push_back(
          {name, fmt::format("# HELP {0} {1}\n# TYPE {0} {2}\n", name, help, type)});
      family = std::prev(families_.end());
    }
    family->text += labels.empty() ? fmt::format("{} {}\n", name, value)
                                   : fmt::format("{}{{{}}} {}\n", name, labels, value);
  }

  std::string text() const {
    std::string text;
    for (const Family& family : families_) text += family.text;
    return text;
  }

 private:
  struct Family {
    std::string name;
    std::string text;
  };
  std::vector<Family> families_;  // a few dozen
};

/// Returns `key="value"`, escaped.
std::string label(const char* key, std::string_view value) {
  std::string escaped;
  for (const char c : value) {
    if (c == '\n') {
      escaped += "\\n";
    } else {
      if (c == '\\' || c == '"') escaped += '\\';
      escaped += c;
    }
  }
  return fmt::format("{}=\"{}\"", key, escaped);
}

/// Visitor of a description that adds the fields with a metric, and those of nested objects.
class MetricCollector {
 public:
  MetricCollector(Families& families, std::string labels)
      : families_(families), labels_(std::move(labels)) {}

  void message(const char*, const char*) {}

  template <class T>
  void field(const char*, const std::optional<T>& value, const char* text = "",
             const Metric& metric = {}) {
    if (value) field("", *value, text, metric);
  }

  template <class T>
  void field(const char*, const T& value, const char* text = "", const Metric& metric = {}) {
    if constexpr (std::is_same_v<T, Stamp>) {
      add(static_cast<double>(value.ns()), text, metric);
    } else if constexpr (std::is_arithmetic_v<T>) {
      add(static_cast<double>(value), text, metric);
    } else if constexpr (requires { static_cast<double>(value.value); }) {
      add(static_cast<double>(value.value), text, metric);
    } else if constexpr (kIsObject<T>) {
      describe(*this, value);
    }
  }

 private:
  /// Objects that belong to the one that has them; others have labels of their own.
  template <class T>
  static constexpr bool kIsObject =
      std::is_same_v<T, PacketLosses> || std::is_same_v<T, ClockState> ||
      std::is_same_v<T, LatencyStats>;

  void add(double value, const char* text, const Metric& metric) {
    if (metric.name == nullptr) return;
    const bool both = !labels_.empty() && *metric.label != '\0';
    families_.add(metric.name, metric.type, metric.help != nullptr ? metric.help : text,
                  labels_ + (both ? "," : "") + metric.label, value * metric.scale);
  }

  Families& families_;
  std::string labels_;
};

template <class Report>
void add_metrics(const Report& report, const std::string& labels, Families& families) {
  MetricCollector collector(families, labels);
  describe(collector, report);
}

/// Adds the level of a device or task, and its findings.
void add_level(Level level, const std::vector<Finding>& findings, const std::string& labels,
               Families& families) {
  families.add("infuse_level", "gauge", "0 OK, 1 WARN, 2 ERROR, 3 STALE.", labels,
               static_cast<double>(level));
  for (const Finding& finding : findings) {
    families.add(
        "infuse_finding", "gauge", "1 while a problem exists.",
        labels + "," + label("id", finding.id) + "," + label("severity", name_of(finding.level)),
        1);
  }
}

void add_devices(const HealthReport& health, Families& families) {
  for (const auto& lidar : health.sensors) {
    const std::string device = label("device", lidar.device);
    add_level(lidar.status.level, lidar.status.findings, device + ",kind=\"lidar\"", families);
    add_metrics(lidar, device, families);
  }
  for (const auto& stream : health.streams) {
    const std::string labels = label("device", stream.device) + "," + label("kind", stream.kind);
    add_level(stream.status.level, stream.status.findings, labels, families);
    add_metrics(stream, labels, families);
  }
}

template <class Status>
void add_task(const std::optional<TaskHealth<Status>>& task, const char* name, Families& families) {
  if (!task) return;
  add_level(task->level, task->findings, label("device", name) + "," + label("kind", name),
            families);
  add_metrics(*task, "", families);
}

void add_host(const HostStats& host, Families& families) {
  add_metrics(host, "", families);
  for (const StageStats& stage : host.stages) {
    add_metrics(stage, label("stage", stage.name), families);
  }
  for (const QueueStats& queue : host.queues) {
    add_metrics(queue, label("queue", queue.name), families);
  }
  if (host.clock) add_metrics(*host.clock, "", families);
  for (const PtpClock& clock : host.ptp_clocks) {
    add_metrics(clock, label("clock", clock.device), families);
  }
  for (const MapInUse& map : host.maps) {
    add_metrics(map, label("map", map.name) + "," + label("digest", map.digest), families);
  }
  for (const StoreStatus& store : host.stores) {
    add_metrics(store, label("store", store.name), families);
  }
}

}  // namespace

void measure_process(ProcessStats& process) {
  std::ifstream pages("/proc/self/statm");
  uint64_t all = 0, resident = 0;
  if (pages >> all >> resident) {
    process.resident_bytes = resident * static_cast<uint64_t>(::sysconf(_SC_PAGESIZE));
  }
  std::error_code error;
  std::filesystem::directory_iterator entry("/proc/self/fd", error), end;
  process.descriptors = 0;
  for (; !error && entry != end; entry.increment(error)) ++process.descriptors;
}

std::string metrics_text(const HealthReport& health, const ProcessStats& process) {
  Families families;
  families.add("infuse_build_info", "gauge", "Release of the program.",
               label("release", process.release), 1);
  families.add(
      "infuse_config_info", "gauge", "Configuration at the start.",
      label("digest", process.config_digest) + "," + label("version", process.config_version), 1);
  add_metrics(health, "", families);
  families.add("infuse_alerts_total", "counter", "Alerts raised since the start.", "",
               static_cast<double>(process.alerts));
  if (process.resident_bytes != 0) {
    families.add("process_resident_memory_bytes", "gauge", "Resident memory of the daemon.", "",
                 static_cast<double>(process.resident_bytes));
  }
  if (process.descriptors != 0) {
    families.add("process_open_fds", "gauge", "Open file descriptors of the daemon.", "",
                 static_cast<double>(process.descriptors));
  }
  add_devices(health, families);
  add_task(health.odometry, "odometry", families);
  add_task(health.streetmap, "streetmap", families);
  add_task(health.map, "map", families);
  for (const CalibrationHealth& calibration : health.calibrations) {
    add_level(worst_level(calibration.findings), calibration.findings,
              label("device", calibration.camera) + ",kind=\"calibration\"", families);
  }
  if (health.host) add_host(*health.host, families);
  return families.text();
}

}  // namespace infuse::daemon

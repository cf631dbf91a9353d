#include "daemon/metrics/metrics_text.hpp"

#include <spdlog/fmt/fmt.h>
#include <unistd.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <optional>
#include <vector>

#include "daemon/metrics/metric_definitions.hpp"

namespace infuse::daemon {
namespace {

/// Collects samples, so that those of one metric stand together as the format wants.
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

/// `key="value"`, escaped.
std::string label(const char* key, const std::string& value) {
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

std::string text_of(const Json& table, const char* key) {
  const auto at = table.find(key);
  return at != table.end() && at->is_string() ? at->get<std::string>() : "";
}

std::optional<double> number_at(const Json& table, const char* path) {
  const Json::json_pointer pointer(path);
  if (!table.contains(pointer)) return std::nullopt;
  const Json& value = table[pointer];
  if (value.is_boolean()) return value.get<bool>() ? 1 : 0;
  if (!value.is_number()) return std::nullopt;
  return value.get<double>();
}

void add_metrics(const Json& table, std::span<const MetricDefinition> metrics,
                 const std::string& labels, Families& families) {
  for (const MetricDefinition& metric : metrics) {
    const auto value = number_at(table, metric.path);
    if (!value) continue;
    const bool both = !labels.empty() && *metric.label != '\0';
    families.add(metric.name, metric.type, metric.help, labels + (both ? "," : "") + metric.label,
                 *value * metric.scale);
  }
}

/// How something is, and what is wrong with it.
void add_level(const Json& table, const std::string& labels, Families& families) {
  constexpr std::array kLevels = {"OK", "WARN", "ERROR", "STALE"};
  const auto level = std::find(kLevels.begin(), kLevels.end(), text_of(table, "level"));
  families.add("infuse_level", "gauge", "0 OK, 1 WARN, 2 ERROR, 3 STALE.", labels,
               static_cast<double>(level - kLevels.begin()));
  for (const Json& finding : table.value("findings", Json::array())) {
    families.add("infuse_finding", "gauge", "1 while something is wrong.",
                 labels + "," + label("id", text_of(finding, "id")) + "," +
                     label("severity", text_of(finding, "level")),
                 1);
  }
}

void add_devices(const Json& health, Families& families) {
  for (const Json& lidar : health.value("sensors", Json::array())) {
    const std::string device = label("device", text_of(lidar, "device"));
    add_level(lidar, device + ",kind=\"lidar\"", families);
    add_metrics(lidar, lidar_metrics(), device, families);
  }
  for (const Json& stream : health.value("streams", Json::array())) {
    const std::string labels =
        label("device", text_of(stream, "device")) + "," + label("kind", text_of(stream, "kind"));
    add_level(stream, labels, families);
    add_metrics(stream, stream_metrics(), labels, families);
  }
}

void add_stages(const Json& health, Families& families) {
  const Json host = health.value("host", Json::object());
  for (const Json& stage : host.value("stages", Json::array())) {
    add_metrics(stage, stage_metrics(), label("stage", text_of(stage, "stage")), families);
  }
  for (const Json& queue : host.value("queues", Json::array())) {
    add_metrics(queue, queue_metrics(), label("queue", text_of(queue, "queue")), families);
  }
}

}  // namespace

void measure_process(ProcessStats& metrics) {
  std::ifstream pages("/proc/self/statm");
  uint64_t all = 0, resident = 0;
  if (pages >> all >> resident) {
    metrics.resident_bytes = resident * static_cast<uint64_t>(::sysconf(_SC_PAGESIZE));
  }
  std::error_code error;
  std::filesystem::directory_iterator entry("/proc/self/fd", error), end;
  metrics.descriptors = 0;
  for (; !error && entry != end; entry.increment(error)) ++metrics.descriptors;
}

std::string metrics_text(const Json& health, const ProcessStats& process) {
  Families families;
  families.add("infuse_build_info", "gauge", "The release that runs.",
               label("release", process.release), 1);
  add_metrics(health, report_metrics(), "", families);
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
  if (const auto odometry = health.find("odometry"); odometry != health.end()) {
    add_level(*odometry, "device=\"odometry\",kind=\"odometry\"", families);
    add_metrics(*odometry, odometry_metrics(), "", families);
  }
  if (const auto map = health.find("streetmap"); map != health.end()) {
    add_level(*map, "device=\"streetmap\",kind=\"streetmap\"", families);
    add_metrics(*map, streetmap_metrics(), "", families);
  }
  add_stages(health, families);
  return families.text();
}

}  // namespace infuse::daemon

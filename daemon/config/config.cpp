#include "daemon/config/config.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <sstream>

#include "daemon/config/read_sensors.hpp"
#include "drivers/measurement/angles.hpp"
#include "drivers/recording/toml_table.hpp"
#include "drivers/text/checksum.hpp"
#include "drivers/text/printable.hpp"
#include "drivers/text/text_file.hpp"

namespace infuse::daemon {
namespace {

using recording::TomlTable;

constexpr size_t kMaxConfigBytes = 1 << 20;
constexpr size_t kMaxDropIns = 256;
constexpr size_t kMaxExpectedSensors = 64;
constexpr size_t kMaxOrigins = 16;
constexpr std::array kTables = {"socket", "health",  "odometry", "streetmap", "map", "calibration",
                                "record", "metrics", "mqtt",     "view",      "lcm", "gnss"};
constexpr std::array kLogLevels = {"trace", "debug", "info", "warning", "error", "off"};

void read_seconds(TomlTable& table, std::string_view key, Duration& value) {
  constexpr double kMaxSeconds = 366 * 86'400;
  std::optional<double> seconds;
  table.read(key, seconds);
  if (!seconds) return;
  if (!(std::abs(*seconds) <= kMaxSeconds)) {
    table.report_error(key, std::string(key) + " is longer than a year");
  }
  value = from_seconds(*seconds);
}

void read_milliseconds(TomlTable& table, std::string_view key, Duration& value) {
  constexpr double kMaxMilliseconds = 10'000;  // as the delays of a rig
  std::optional<double> milliseconds;
  table.read(key, milliseconds);
  if (!milliseconds) return;
  if (!(std::abs(*milliseconds) <= kMaxMilliseconds)) {
    table.report_error(key, std::string(key) + " must be between -10000 and 10000");
  }
  value = from_seconds(*milliseconds / 1e3);
}

void read_socket(TomlTable& table, ServerOptions& options) {
  table.read("path", options.path);
  read_integer(table, "tcp_port", options.tcp_port);
  read_integer(table, "max_clients", options.max_clients);
  read_integer(table, "max_clients_per_user", options.max_clients_per_user);
  read_seconds(table, "idle_timeout_s", options.idle_timeout);
  read_integer(table, "queue_reports", options.queue_reports);
  table.read("max_requests_hz", options.max_requests_hz);
}

void read_health(TomlTable& table, HealthOptions& options) {
  read_seconds(table, "stale_after_s", options.stale_after);
  read_seconds(table, "raise_after_s", options.raise_after);
  read_seconds(table, "clear_after_s", options.clear_after);
  read_seconds(table, "clock_grace_s", options.clock_grace);
  table.read("warn_loss", options.warn_loss);
  table.read("error_loss", options.error_loss);
  table.read("expected_sensors", kMaxExpectedSensors, options.expected_sensors);
}

void read_radians(TomlTable& table, std::string_view key, double& value) {
  std::optional<double> degrees;
  table.read(key, degrees);
  if (degrees) value = *degrees * kDegree;
}

void read_odometry(TomlTable& table, OdometrySettings& settings) {
  table.read("planar", settings.planar);
  table.read("wheelbase", settings.filter.wheelbase);
  table.read("track", settings.filter.track);
  table.read("steering_ratio", settings.filter.steering_ratio);
  read_milliseconds(table, "reorder_ms", settings.filter.reorder);
  read_milliseconds(table, "wheel_delay_ms", settings.filter.wheel_delay);
  read_milliseconds(table, "imu_delay_ms", settings.filter.imu_delay);
  read_milliseconds(table, "gnss_delay_ms", settings.filter.gnss_delay);
  table.read("use_gnss_speed", settings.use_gnss_speed);
  table.read("use_lidar", settings.use_lidar);
  read_radians(table, "max_heading_sigma_deg", settings.max_heading_sigma);
  read_milliseconds(table, "max_wait_ms", settings.max_wait);
}

void read_streetmap(TomlTable& table, StreetMapSettings& settings) {
  table.read("map", settings.map);
  const auto read_pair = [&](const char* first, const char* second) {
    std::optional<double> a, b;
    table.read(first, a);
    table.read(second, b);
    if (a.has_value() != b.has_value())
      table.report_table_error(std::string(first) + " and " + second + " must be given together");
    return a && b ? std::optional(Eigen::Vector2d(*a, *b)) : std::nullopt;
  };
  const auto read_angle = [&](const char* key) {
    std::optional<double> degrees;
    table.read(key, degrees);
    return degrees ? std::optional(*degrees * kDegree) : std::nullopt;
  };
  const auto yaw = read_angle("yaw_deg"), heading = read_angle("heading_deg");
  if (const auto place = read_pair("x", "y"))
    settings.initial_pose = InitialPose{place->x(), place->y(), yaw};
  if (const auto place = read_pair("lat", "lon")) {
    settings.initial_location =
        InitialLocation{place->x() * kDegree, place->y() * kDegree, heading};
  }
  table.read("require_tracking", settings.require_tracking);
  table.read("sigma", settings.initial_sigma);
  read_radians(table, "yaw_sigma_deg", settings.initial_yaw_sigma);
  table.read("update_hz", settings.update_hz);
  table.read("global_start", settings.tracker.global_start.enabled);
  read_integer(table, "seed", settings.tracker.seed);
}

void read_map(TomlTable& table, MapLocationSettings& settings) {
  table.read("directory", settings.directory);
  table.read("lidar", settings.lidar);
}

void read_calibration(TomlTable& table, CalibrationSettings& settings) {
  table.read("monitor", settings.monitored);
  std::string policy;
  table.read("policy", policy);
  if (policy == "alert-only") settings.supervisor.policy = monitoring::UpdatePolicy::kAlertOnly;
  if (policy == "apply") settings.supervisor.policy = monitoring::UpdatePolicy::kApply;
  if (policy == "apply-within") settings.supervisor.policy = monitoring::UpdatePolicy::kApplyWithin;
  if (!policy.empty() && policy != "alert-only" && policy != "apply" && policy != "apply-within") {
    table.report_error("policy", "policy is none of alert-only, apply, apply-within");
  }
  std::optional<double> degrees;
  table.read("limit_rotation_deg", degrees);
  if (degrees) settings.supervisor.limit_rotation = *degrees * kDegree;
  table.read("limit_translation", settings.supervisor.limit_translation);
  table.read("false_alarm_hours", settings.monitor.detector.false_alarm_hours);
}

void read_megabytes(TomlTable& table, std::string_view key, uint64_t& bytes) {
  constexpr int64_t kMaxMegabytes = int64_t{1} << 40;  // MiB; so that bytes fit
  constexpr uint64_t kMiB = 1 << 20;
  int64_t megabytes = static_cast<int64_t>(bytes / kMiB);
  table.read(key, 0, kMaxMegabytes, megabytes);
  bytes = static_cast<uint64_t>(megabytes) * kMiB;
}

void read_record(TomlTable& table, RecordSettings& settings) {
  table.read("directory", settings.directory);
  read_megabytes(table, "memory_mb", settings.memory);
  read_seconds(table, "flight_recorder_s", settings.flight_recorder);
  read_seconds(table, "after_alert_s", settings.after_alert);
  read_integer(table, "keep_alerts", settings.keep_alerts);
  read_seconds(table, "alert_pause_s", settings.alert_pause);
  read_megabytes(table, "budget_mb", settings.budget);
  read_seconds(table, "max_duration_s", settings.max_duration);
  read_megabytes(table, "max_size_mb", settings.max_bytes);
  read_seconds(table, "split_s", settings.split);
  read_megabytes(table, "split_mb", settings.split_bytes);
  read_megabytes(table, "min_free_mb", settings.min_free);
}

void read_metrics(TomlTable& table, MetricsSettings& settings) {
  table.read("path", settings.path);
  read_integer(table, "port", settings.port);
}

void read_view(TomlTable& table, ViewSettings& settings) {
  read_integer(table, "port", settings.port);
  table.read("path", settings.path);
  table.read("bind", settings.bind);
  table.read("token", settings.token);
  table.read("allowed_origins", kMaxOrigins, settings.allowed_origins);
  read_integer(table, "max_clients", settings.max_clients);
}

void read_mqtt(TomlTable& table, MqttSettings& settings) {
  table.read("host", settings.host);
  read_integer(table, "port", settings.port);
  table.read("vehicle", settings.vehicle);
  table.read("topic", settings.topic);
  table.read("ca_file", settings.ca_file);
  table.read("certificate_file", settings.certificate_file);
  table.read("key_file", settings.key_file);
  table.read("user", settings.user);
  table.read("password_file", settings.password_file);
  read_seconds(table, "pose_interval_s", settings.pose_interval);
  read_seconds(table, "health_interval_s", settings.health_interval);
  read_megabytes(table, "queue_mb", settings.queue);
  if (settings.host.empty()) table.report_table_error("mqtt: host must name the broker");
}

void read_lcm(TomlTable& table, LcmSettings& settings) {
  settings.enabled = true;
  table.read("group", settings.to.group);
  read_integer(table, "port", settings.to.port);
  read_integer(table, "ttl", settings.to.ttl);
  table.read("interface", settings.to.interface);
  table.read("prefix", settings.prefix);
  table.read("sweeps", settings.sweeps);
  read_integer(table, "max_points", settings.max_points);
}

/// Reads one table into options and validates them.
template <class Options>
std::optional<Error> read_table(const toml::table* toml, const std::string& file,
                                const std::string& name, void (*read)(TomlTable&, Options&),
                                Options& options) {
  if (toml == nullptr) return std::nullopt;
  TomlTable table(*toml, file, name);
  read(table, options);
  if (const auto wrong = options.invalid()) table.report_table_error(name + ": " + *wrong);
  return table.finish();
}

std::optional<Error> read_all(TomlTable& root, const std::string& file, Config& config) {
  root.read("log_level", config.log_level);
  if (std::find(kLogLevels.begin(), kLogLevels.end(), config.log_level) == kLogLevels.end()) {
    root.report_error("log_level", "log_level is none of trace, debug, info, warning, error, off");
  }
  root.read("version", config.version);
  if (!config.version.empty() && !text::is_name(config.version)) {
    root.report_error("version", "version must have at most 64 bytes and no control characters");
  }
  root.read("rig", config.rig);
  for (const char* name : kTables) {
    const toml::node* table = root.node(name);
    if (table == nullptr) continue;
    config.where[name] = file + ":" + std::to_string(table->source().begin.line);
  }
  const toml::table* socket = root.table("socket");
  const toml::table* health = root.table("health");
  const toml::table* odometry = root.table("odometry");
  const toml::table* streetmap = root.table("streetmap");
  const toml::table* map = root.table("map");
  const toml::table* calibration = root.table("calibration");
  const toml::table* record = root.table("record");
  const toml::table* metrics = root.table("metrics");
  const toml::table* mqtt = root.table("mqtt");
  const toml::table* view = root.table("view");
  const toml::table* lcm = root.table("lcm");
  if (auto error = read_sensors(root, file, config)) return error;
  if (auto error = root.finish()) return error;
  if (auto error = read_table(socket, file, "socket", read_socket, config.socket)) return error;
  if (auto error = read_table(health, file, "health", read_health, config.health)) return error;
  if (auto error = read_table(odometry, file, "odometry", read_odometry, config.odometry)) {
    return error;
  }
  if (auto error = read_table(streetmap, file, "streetmap", read_streetmap, config.streetmap)) {
    return error;
  }
  if (auto error = read_table(map, file, "map", read_map, config.map)) return error;
  if (!config.map.directory.empty() && !config.streetmap.map.empty()) {
    return Error{"[map] and [streetmap] both give the pose in the frame map", file,
                 "choose one of them"};
  }
  if (auto error = read_table(record, file, "record", read_record, config.record)) return error;
  if (auto error = read_table(metrics, file, "metrics", read_metrics, config.metrics)) return error;
  if (auto error = read_table(view, file, "view", read_view, config.view)) return error;
  if (auto error = read_table(mqtt, file, "mqtt", read_mqtt, config.mqtt)) return error;
  if (auto error = read_table(lcm, file, "lcm", read_lcm, config.lcm)) return error;
  return read_table(calibration, file, "calibration", read_calibration, config.calibration);
}

/// Reads another file into a configuration.
std::optional<Error> add_text(std::string_view text, const std::string& file, Config& config) {
  const auto table = recording::parse_toml(text, file);
  if (!table) return table.error();
  for (const auto& [key, node] : *table) {
    std::ostringstream source_text;
    node.visit([&](const auto& value) { source_text << value << '\n'; });
    config.source_text[std::string(key.str())] += source_text.str();
  }
  TomlTable root(*table, file, "the configuration");
  return read_all(root, file, config);
}

/// `all`: the bytes of all files.
std::optional<Error> add_file(const std::filesystem::path& path, Config& config, std::string& all) {
  const auto text = text::read_text(path, kMaxConfigBytes);
  if (!text) return text.error();
  all += path.filename().string() + '\0' + *text + '\0';
  return add_text(*text, path.string(), config);
}

/// Returns the files `path`.d/*.toml in order of their names; none without that folder.
Result<std::vector<std::filesystem::path>> drop_ins(const std::filesystem::path& path) {
  const std::string folder = path.string() + ".d";
  std::vector<std::filesystem::path> files;
  std::error_code error;
  for (std::filesystem::directory_iterator entry(folder, error), end; !error && entry != end;
       entry.increment(error)) {
    if (entry->path().extension() == ".toml") files.push_back(entry->path());
  }
  if (error && error != std::errc::no_such_file_or_directory) {
    return fail("cannot be listed: " + error.message(), folder, "the user infuse must read it");
  }
  if (files.size() > kMaxDropIns) return fail("has more than 256 files", folder);
  std::sort(files.begin(), files.end());
  return files;
}

}  // namespace

std::vector<std::string> changed_keys(const Config& a, const Config& b) {
  std::map<std::string, std::string> all = a.source_text;
  all.insert(b.source_text.begin(), b.source_text.end());
  const auto source_text = [](const Config& config, const std::string& key) {
    const auto at = config.source_text.find(key);
    return at == config.source_text.end() ? std::string() : at->second;
  };
  std::vector<std::string> changed;
  for (const auto& [key, text] : all) {
    if (source_text(a, key) != source_text(b, key)) changed.push_back(key);
  }
  return changed;
}

Result<Config> parse_config(std::string_view text, const std::string& file) {
  Config config;
  if (auto error = add_text(text, file, config)) return tl::unexpected(*std::move(error));
  return config;
}

Result<Config> load_config(const std::filesystem::path& path) {
  Config config;
  config.folder = path.parent_path();
  std::string all;
  if (auto error = add_file(path, config, all)) return tl::unexpected(*std::move(error));
  const auto files = drop_ins(path);
  if (!files) return tl::unexpected(files.error());
  for (const std::filesystem::path& file : *files) {
    if (auto error = add_file(file, config, all)) return tl::unexpected(*std::move(error));
  }
  if (!config.rig.empty()) {
    all += text::read_text(config.resolve(config.rig), recording::kMaxTomlBytes).value_or("");
  }
  config.digest = text::checksum(all);
  return config;
}

}  // namespace infuse::daemon

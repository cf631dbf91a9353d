#include "daemon/config/config.hpp"

#include <algorithm>
#include <array>
#include <limits>

#include "daemon/survey/capture_survey.hpp"
#include "drivers/recording/text_file.hpp"
#include "drivers/recording/toml_table.hpp"
#include "drivers/velodyne/model.hpp"

namespace infuse::daemon {
namespace {

using recording::TomlTable;

constexpr size_t kMaxConfigBytes = 1 << 20;
constexpr size_t kMaxLidars = 16;
constexpr std::array kLogLevels = {"trace", "debug", "info", "warning", "error", "off"};

/// An integer that `Integer` can hold.
template <class Integer>
void read_integer(TomlTable& table, std::string_view key, Integer& value) {
  int64_t wide = value;
  table.read(key, 0, std::numeric_limits<Integer>::max(), wide);
  value = static_cast<Integer>(wide);
}

void read_seconds(TomlTable& table, std::string_view key, Duration& value) {
  std::optional<double> seconds;
  table.read(key, seconds);
  if (seconds) value = from_seconds(*seconds);
}

void read_milliseconds(TomlTable& table, std::string_view key, Duration& value) {
  std::optional<double> milliseconds;
  table.read(key, milliseconds);
  if (milliseconds) value = from_seconds(*milliseconds / 1e3);
}

void read_socket(TomlTable& table, ServerOptions& options) {
  table.read("path", options.path);
  read_integer(table, "tcp_port", options.tcp_port);
  read_integer(table, "max_clients", options.max_clients);
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
}

void read_odometry(TomlTable& table, OdometrySettings& settings) {
  table.read("planar", settings.filter.planar);
  table.read("wheelbase", settings.filter.wheelbase);
  table.read("track", settings.filter.track);
  table.read("steering_ratio", settings.filter.steering_ratio);
  read_milliseconds(table, "wheel_delay_ms", settings.filter.wheel_delay);
  read_milliseconds(table, "imu_delay_ms", settings.filter.imu_delay);
  read_milliseconds(table, "gps_delay_ms", settings.filter.gps_delay);
  table.read("use_gps_speed", settings.use_gps_speed);
  read_milliseconds(table, "max_wait_ms", settings.max_wait);
}

void read_lidar(TomlTable& table, LidarOptions& options) {
  table.read("name", options.name);
  table.read("model", options.model);
  read_integer(table, "port", options.port);
  table.read("sender", options.sender);
  table.read("calibration", options.calibration);
  table.read("cut_azimuth_deg", options.cut_azimuth_deg);
}

/// Reads one table into options and checks them as a whole.
template <class Options>
std::optional<Error> read_table(const toml::table* toml, const std::string& file,
                                const std::string& name, void (*read)(TomlTable&, Options&),
                                Options& options) {
  if (toml == nullptr) return std::nullopt;
  TomlTable table(*toml, file, name);
  read(table, options);
  if (const auto wrong = options.invalid()) table.complain_of_table(name + ": " + *wrong);
  return table.finish();
}

bool has_lidar(const Config& config, const std::string& name) {
  return std::any_of(config.lidars.begin(), config.lidars.end(),
                     [&](const LidarOptions& lidar) { return lidar.name == name; });
}

std::optional<Error> read_all(TomlTable& root, const std::string& file, Config& config) {
  root.read("log_level", config.log_level);
  if (std::find(kLogLevels.begin(), kLogLevels.end(), config.log_level) == kLogLevels.end()) {
    root.complain("log_level", "log_level is none of trace, debug, info, warning, error, off");
  }
  const toml::table* socket = root.table("socket");
  const toml::table* health = root.table("health");
  const toml::table* odometry = root.table("odometry");
  const auto lidars = root.tables("lidar", kMaxLidars);
  if (auto error = root.finish()) return error;
  if (auto error = read_table(socket, file, "socket", read_socket, config.socket)) return error;
  if (auto error = read_table(health, file, "health", read_health, config.health)) return error;
  if (auto error = read_table(odometry, file, "odometry", read_odometry, config.odometry)) {
    return error;
  }
  for (const toml::table* lidar : lidars) {
    LidarOptions options;
    if (auto error = read_table(lidar, file, "lidar", read_lidar, options)) return error;
    if (has_lidar(config, options.name)) {
      return Error{"two lidars are named '" + options.name + "'",
                   file + ":" + std::to_string(lidar->source().begin.line),
                   "give each a name of its own"};
    }
    config.lidars.push_back(std::move(options));
  }
  return std::nullopt;
}

}  // namespace

std::optional<std::string> LidarOptions::invalid() const {
  if (name.empty()) return "name is empty";
  if (port == 0) return "port must lie in 1 ... 65535";
  if (!model.empty() && !velodyne::find_model(model)) return "unknown model '" + model + "'";
  if (!sender.empty() && !parse_address(sender)) return "'" + sender + "' is no IPv4 address";
  if (!(cut_azimuth_deg >= 0 && cut_azimuth_deg < 360)) {
    return "cut_azimuth_deg must lie in 0 ... 360";
  }
  return std::nullopt;
}

Result<Config> parse_config(std::string_view text, const std::string& file) {
  const auto table = recording::parse_toml(text, file);
  if (!table) return tl::unexpected(table.error());
  Config config;
  TomlTable root(*table, file, "the configuration");
  if (auto error = read_all(root, file, config)) return tl::unexpected(*std::move(error));
  return config;
}

Result<Config> load_config(const std::filesystem::path& path) {
  const auto text = recording::read_text(path, kMaxConfigBytes);
  if (!text) return tl::unexpected(text.error());
  return parse_config(*text, path.string());
}

}  // namespace infuse::daemon

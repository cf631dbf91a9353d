#include "daemon/setup/live_checks.hpp"

#include <spdlog/fmt/fmt.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <filesystem>
#include <map>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

namespace infuse::daemon {
namespace {

namespace fs = std::filesystem;

Result<void> check_ports(const Config& config) {
  const std::vector<std::tuple<std::string, std::string, uint16_t>> listeners = {
      {"socket", "[socket] tcp_port", config.socket.tcp_port},
      {"metrics", "[metrics] port", config.metrics.port},
      {"view", "[view] port", config.view.port}};
  for (size_t i = 0; i < listeners.size(); ++i) {
    const auto& [table, key, port] = listeners[i];
    for (size_t j = 0; j < i && port != 0; ++j) {
      if (std::get<2>(listeners[j]) != port) continue;
      return fail(fmt::format("{} and {} are both {}", std::get<1>(listeners[j]), key, port),
                  config.where_is(table), "choose another port");
    }
  }
  return {};
}

/// Sockets are created in a folder that is there, or below one that can be written.
Result<void> check_socket(const Config& config, const char* table, const std::string& path) {
  if (path.empty()) return {};
  fs::path folder = fs::absolute(path).parent_path();
  std::error_code failed;
  while (!fs::exists(folder, failed) && folder.has_relative_path()) folder = folder.parent_path();
  if (::access(folder.c_str(), W_OK | X_OK) == 0 && fs::is_directory(folder, failed)) return {};
  return fail(fmt::format("a socket cannot be created at {}: {} is not a writable folder", path,
                          folder.string()),
              config.where_is(table), "the service may write to /run/infuse");
}

Result<void> check_broker_files(const Config& config) {
  const MqttSettings& mqtt = config.mqtt;
  for (const auto& [key, file] :
       {std::pair{"ca_file", mqtt.ca_file}, std::pair{"certificate_file", mqtt.certificate_file},
        std::pair{"key_file", mqtt.key_file}, std::pair{"password_file", mqtt.password_file}}) {
    if (file.empty()) continue;
    const fs::path path = config.resolve(file);
    std::error_code failed;
    if (::access(path.c_str(), R_OK) != 0) {
      return fail(fmt::format("{} {} cannot be read: {}", key, path.string(), std::strerror(errno)),
                  config.where_is("mqtt"), "the user infuse must read it");
    }
    if (!fs::is_regular_file(path, failed)) {
      return fail(fmt::format("{} {} is not a regular file", key, path.string()),
                  config.where_is("mqtt"));
    }
  }
  return {};
}

Result<void> check_record_folder(const Config& config) {
  if (config.record.directory.empty()) return {};
  const fs::path folder = config.resolve(config.record.directory);
  std::error_code error;
  if (!fs::exists(folder, error) || fs::is_directory(folder, error)) return {};
  return fail("record.directory " + folder.string() + " is not a folder",
              config.where_is("record"));
}

/// Two sensors that open one device: the second would find it busy.
template <class Sensors, class DeviceOf>
Result<void> check_devices(const char* kind, const Sensors& sensors, DeviceOf device_of) {
  std::map<std::string, std::string> users;
  for (const auto& sensor : sensors) {
    std::error_code failed;
    const std::string& device = device_of(sensor);
    const fs::path target = fs::canonical(device, failed);  // two names of one device
    const auto [user, first] = users.emplace(failed ? device : target.string(), sensor.name);
    if (first) continue;
    return fail(
        fmt::format("{}s '{}' and '{}' are both {}", kind, user->second, sensor.name, device),
        sensor.source, "give each its own");
  }
  return {};
}

bool is_configured(const Config& config, const std::string& name) {
  const auto has = [&](const auto& sensors) {
    return std::any_of(sensors.begin(), sensors.end(),
                       [&](const auto& sensor) { return sensor.name == name; });
  };
  const bool gnss = !config.gnss.device.empty() || !config.gnss.lidar.empty();
  return has(config.lidars) || has(config.cameras) || has(config.buses) || (gnss && name == "gnss");
}

}  // namespace

Result<void> check_services(const Config& config) {
  if (auto ports = check_ports(config); !ports) return ports;
  for (const auto& [table, path] :
       {std::pair{"socket", config.socket.path}, std::pair{"metrics", config.metrics.path},
        std::pair{"view", config.view.path}}) {
    if (auto socket = check_socket(config, table, path); !socket) return socket;
  }
  if (auto files = check_broker_files(config); !files) return files;
  return check_record_folder(config);
}

Result<void> check_sensors(const Config& config) {
  auto apart = check_devices("camera", config.cameras,
                             [](const CameraOptions& c) { return c.stream.device; });
  if (!apart) return apart;
  apart = check_devices("can bus", config.buses, [](const BusOptions& b) { return b.interface; });
  if (!apart) return apart;
  if (config.odometry.use_lidar.value_or(false) && config.lidars.empty()) {
    return fail("use_lidar needs a lidar, and none is configured", config.where_is("odometry"),
                "add a [[lidar]], or leave use_lidar out");
  }
  return {};
}

/// Valid settings that are probably mistakes.
std::vector<Error> find_doubts(const Config& config, const Rig& rig) {
  std::vector<Error> doubts;
  for (const CameraOptions& camera : config.cameras) {
    if (rig.find_camera(camera.name) != nullptr) continue;
    doubts.push_back({"camera '" + camera.name + "' is not in the rig: its images are counted only",
                      camera.source,
                      "add it to rig.toml, see infused(8); infuse calibrate-intrinsics writes its "
                      "section"});
  }
  for (const LidarOptions& lidar : config.lidars) {
    if (config.rig.empty() || rig.find_lidar(lidar.name) != nullptr) continue;
    doubts.push_back({"lidar '" + lidar.name + "' is not in the rig: taken as the vehicle's origin",
                      lidar.source, "add it to rig.toml, see infused(8)"});
  }
  for (const BusOptions& bus : config.buses) {
    if (!bus.signals.empty()) continue;
    doubts.push_back({"can '" + bus.name + "' has no signals: its frames are counted only",
                      bus.source, "name them in [can.signals]"});
  }
  for (const std::string& expected : config.health.expected_sensors) {
    if (is_configured(config, expected)) continue;
    doubts.push_back({"expected_sensors names '" + expected + "', which is not configured",
                      config.where_is("health"), "check the configuration and its drop-ins"});
  }
  if (auto doubt = find_broker_doubt(config.mqtt)) doubts.push_back(*std::move(doubt));
  if (auto doubt = find_lcm_doubt(config.lcm)) doubts.push_back(*std::move(doubt));
  const StreetMapSettings& map = config.streetmap;
  const bool has_gnss = !config.gnss.device.empty() || !config.gnss.lidar.empty();
  if (!map.map.empty() && !map.initial_pose && !map.initial_location && !has_gnss &&
      !map.tracker.global_start.enabled) {
    doubts.push_back(
        {"the initial pose on the street map is not known", "[streetmap]",
         "give x, y and yaw_deg, or lat, lon and heading_deg, or [gnss], or global_start"});
  }
  return doubts;
}

}  // namespace infuse::daemon

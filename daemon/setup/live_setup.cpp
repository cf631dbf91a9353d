#include "daemon/setup/live_setup.hpp"

#include <spdlog/fmt/fmt.h>

#include <algorithm>

#include "daemon/setup/live_checks.hpp"
#include "drivers/makers/makers.hpp"
#include "drivers/measurement/ipv4_address.hpp"
#include "drivers/recording/drive_toml.hpp"

namespace infuse::daemon {
namespace {

Result<Rig> read_configured_rig(const Config& config) {
  if (config.rig.empty()) return Rig{};
  return recording::read_vehicle_rig(config.resolve(config.rig));
}

std::string endpoint_of(const LidarOptions& lidar) {
  const std::string local = lidar.tap               ? "tap of " + lidar.interface
                            : lidar.address.empty() ? "0.0.0.0"
                                                    : lidar.address;
  return fmt::format("{}:{}{}", local, lidar.port,
                     lidar.sender.empty() ? "" : ", from " + lidar.sender);
}

Result<void> set_up_lidar(const Config& config, const LidarOptions& options, const Rig& rig,
                          SensorSetup& setup) {
  const lidar::LidarModel* model = makers::find_model(options.model);
  if (model == nullptr) {
    return fail("lidar '" + options.name + "' has no model", options.source,
                "give it one: model = \"HDL-32E\"");
  }
  const LidarMount* mount = rig.find_lidar(options.name);
  LidarSetup lidar{
      {options.name, "lidar", model->name, "configured", endpoint_of(options), std::nullopt},
      true,
      {}};
  if (mount != nullptr) lidar.T_vehicle_lidar = mount->T_vehicle_lidar;
  lidar.decoder.model = model;
  lidar.decoder.cut_azimuth = options.cut_azimuth_deg;
  lidar.decoder.sender = parse_address(options.sender).value_or(0);
  if (!options.calibration.empty()) {
    auto loaded = model->maker->load_calibration(*model, config.resolve(options.calibration));
    if (!loaded) return tl::unexpected(loaded.error());
    lidar.decoder.calibration = *loaded;
  }
  if (const auto made = lidar::make_decoder(lidar.decoder); !made) {
    return fail("lidar '" + options.name + "': " + made.error().what, options.source,
                made.error().hint);
  }
  setup.rig.lidars.push_back(mount != nullptr ? *mount : LidarMount{options.name, options.model});
  setup.lidars.push_back(std::move(lidar));
  return {};
}

Result<void> add_camera(const CameraOptions& options, const CameraMount* mount,
                        SensorSetup& setup) {
  camera::V4l2Options stream = options.stream;
  if (mount != nullptr) {
    const CameraIntrinsics& intrinsics = mount->intrinsics;
    if (stream.width == 0) {
      stream.width = intrinsics.width;
      stream.height = intrinsics.height;
    } else if (stream.width != intrinsics.width || stream.height != intrinsics.height) {
      return fail(
          fmt::format("camera '{}' is configured as {}x{}, but the rig states {}x{}", options.name,
                      stream.width, stream.height, intrinsics.width, intrinsics.height),
          options.source);
    }
    stream.stamp_delay += mount->stamp_delay;
    setup.rig.cameras.push_back(*mount);
  }
  const auto has_name = [&](const auto& sensor) { return sensor.device.name == options.name; };
  const bool name_in_use = std::any_of(setup.lidars.begin(), setup.lidars.end(), has_name) ||
                           std::any_of(setup.cameras.begin(), setup.cameras.end(), has_name);
  setup.cameras.push_back({{(name_in_use ? "camera " : "") + options.name, "camera",
                            stream.format ? camera::name_of(*stream.format) : "any format",
                            "configured", stream.device, std::nullopt},
                           {},
                           std::move(stream)});
  return {};
}

/// Cameras of the rig come first: the pipeline uses their indices.
Result<void> set_up_cameras(const Config& config, const Rig& rig, SensorSetup& setup) {
  for (const bool mounted : {true, false}) {
    for (const CameraOptions& options : config.cameras) {
      const CameraMount* mount = rig.find_camera(options.name);
      if ((mount != nullptr) != mounted) continue;
      if (mount != nullptr && setup.rig.find_lidar(mount->lidar) == nullptr) {
        return fail("camera '" + options.name + "' refers to lidar '" + mount->lidar +
                        "', which is not configured",
                    options.source);
      }
      if (auto added = add_camera(options, mount, setup); !added) return added;
    }
  }
  return {};
}

Result<void> set_up_buses(const Config& config, SensorSetup& setup) {
  for (const BusOptions& options : config.buses) {
    recording::CanFiles files;
    files.dbc = options.dbc;
    files.reverse_gear = options.reverse_gear;
    files.signals = options.signals;
    auto decoder = make_decoder(files, config.folder, options.source, setup.vehicle.notes);
    if (!decoder) return tl::unexpected(decoder.error());
    vehicle::SocketCanOptions socket{.interface = options.interface, .identifiers = {}};
    if (*decoder) socket.identifiers = (*decoder)->identifiers();
    setup.vehicle.buses.push_back(
        {{options.name, "can", options.interface, "configured", options.interface, std::nullopt},
         *std::move(decoder),
         std::move(socket)});
  }
  return {};
}

Result<void> set_up_gnss(const Config& config, SensorSetup& setup) {
  const GnssOptions& gnss = config.gnss;
  if (gnss.device.empty() && gnss.lidar.empty()) return {};
  std::string endpoint = gnss.device;
  if (gnss.device.empty()) {
    const auto lidar = std::find_if(config.lidars.begin(), config.lidars.end(),
                                    [&](const LidarOptions& l) { return l.name == gnss.lidar; });
    if (lidar == config.lidars.end()) {
      return fail("[gnss] refers to lidar '" + gnss.lidar + "', which is not configured");
    }
    setup.gnss_lidar = LidarIndex(static_cast<size_t>(lidar - config.lidars.begin()));
    endpoint = "position packets of " + gnss.lidar;
  } else {
    setup.gnss_serial = vehicle::SerialOptions{gnss.device, gnss.baud};
  }
  setup.vehicle.gnss = Device{"gnss", "gnss", "NMEA", "configured", endpoint, std::nullopt};
  return {};
}

}  // namespace

Result<SensorSetup> set_up_live(const Config& config) {
  if (auto possible = check_services(config); !possible) return tl::unexpected(possible.error());
  if (auto possible = check_sensors(config); !possible) return tl::unexpected(possible.error());
  const auto rig = read_configured_rig(config);
  if (!rig) return tl::unexpected(rig.error());
  SensorSetup setup;
  setup.live = true;
  auto ports = set_up_ports(config.lidars);
  if (!ports) return tl::unexpected(ports.error());
  setup.ports = *std::move(ports);
  for (const LidarOptions& lidar : config.lidars) {
    if (auto done = set_up_lidar(config, lidar, *rig, setup); !done) {
      return tl::unexpected(done.error());
    }
  }
  if (auto done = set_up_cameras(config, *rig, setup); !done) return tl::unexpected(done.error());
  if (auto done = set_up_buses(config, setup); !done) return tl::unexpected(done.error());
  if (auto done = set_up_gnss(config, setup); !done) return tl::unexpected(done.error());
  setup.doubts = find_doubts(config, *rig);
  return setup;
}

}  // namespace infuse::daemon

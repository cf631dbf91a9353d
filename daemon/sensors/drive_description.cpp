#include "daemon/sensors/drive_description.hpp"

#include <algorithm>

#include "drivers/measurement/ipv4_address.hpp"

namespace infuse::daemon {
namespace {

constexpr const char* kPacketsFile = "lidar.pcap";
constexpr const char* kDbcFile = "vehicle.dbc";

void describe_lidar(const Config& config, const LidarOptions& options, DescribedDrive& drive) {
  recording::LidarFiles files;
  files.packets = kPacketsFile;
  files.port = options.port;
  files.position_port = options.position_port;
  files.sender = parse_address(options.sender);
  if (!options.calibration.empty()) {
    files.calibration = "lidar_" + std::to_string(drive.description.lidars.size()) + ".xml";
    drive.copies.push_back({config.resolve(options.calibration), files.calibration});
  }
  drive.description.lidars.push_back(std::move(files));
}

/// A port that no lidar has; nothing was recorded from it.
uint16_t unused_port(const std::vector<recording::LidarFiles>& lidars) {
  uint16_t port = 65535;
  const auto used = [&](const recording::LidarFiles& lidar) {
    return lidar.port == port || lidar.position_port == port;
  };
  while (std::any_of(lidars.begin(), lidars.end(), used)) --port;
  return port;
}

/// Lidars on different ports may share the port of their position packets, by default 8308. Where
/// no senders tell them apart, a drive holds those of the first only, or of the one that carries
/// GNSS.
void separate_position_ports(const SensorSetup& setup, DescribedDrive& drive) {
  std::vector<recording::LidarFiles>& lidars = drive.description.lidars;
  for (size_t i = 0; i < lidars.size(); ++i) {
    for (size_t j = 0; j < i; ++j) {
      const bool apart = lidars[i].sender && lidars[j].sender;
      if (apart || lidars[i].port == lidars[j].port ||
          lidars[i].position_port != lidars[j].position_port) {
        continue;
      }
      const size_t other = setup.gnss_lidar && *setup.gnss_lidar == i ? j : i;
      lidars[other].position_port = unused_port(lidars);
      drive.not_recorded.push_back("position packets of lidar '" + setup.rig.lidars[other].name +
                                   "': give each lidar its sender, or another position_port");
    }
  }
}

void describe_cameras(const SensorSetup& setup, DescribedDrive& drive) {
  for (size_t i = 0; i < setup.rig.cameras.size(); ++i) {
    recording::CameraFiles files;
    files.images = "camera_" + std::to_string(i);
    drive.description.cameras.push_back(std::move(files));
  }
  for (size_t i = setup.rig.cameras.size(); i < setup.cameras.size(); ++i) {
    drive.not_recorded.push_back("camera " + setup.cameras[i].stream.device +
                                 ": it is not in the rig");
  }
}

void describe_buses(const Config& config, DescribedDrive& drive) {
  for (const BusOptions& options : config.buses) {
    if (options.dbc.empty() || drive.description.can) {
      drive.not_recorded.push_back("signals of CAN bus " + options.interface +
                                   (options.dbc.empty() ? ": no DBC file is configured"
                                                        : ": a drive holds the "
                                                          "signals of one bus only") +
                                   (drive.description.can ? "; its frames are in can.log" : ""));
      continue;
    }
    recording::CanFiles& can = drive.description.can.emplace();
    can.log = "can.log";
    can.dbc = kDbcFile;
    can.interface = options.interface;
    can.reverse_gear = options.reverse_gear;
    can.signals = options.signals;
    drive.copies.push_back({config.resolve(options.dbc), can.dbc});
  }
}

}  // namespace

DescribedDrive describe_drive(const Config& config, const SensorSetup& setup) {
  DescribedDrive drive;
  drive.description.rig = setup.rig;
  for (size_t i = 0; i < setup.rig.lidars.size(); ++i) {
    LidarMount& mount = drive.description.rig.lidars[i];
    mount.model = setup.lidars[i].device.model;
    describe_lidar(config, config.lidars[i], drive);
  }
  separate_position_ports(setup, drive);
  describe_cameras(setup, drive);
  describe_buses(config, drive);
  if (setup.gnss_lidar) {
    drive.description.gnss_lidar = setup.rig.lidars[*setup.gnss_lidar].name;
  } else if (setup.vehicle.gnss) {
    drive.description.gnss = "gnss.csv";
  }
  return drive;
}

}  // namespace infuse::daemon

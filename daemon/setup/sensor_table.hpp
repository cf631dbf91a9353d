#pragma once

#include <stdexcept>
#include <vector>

#include "daemon/health/level.hpp"
#include "daemon/health/lidar_counters.hpp"
#include "daemon/health/stream_counters.hpp"
#include "daemon/setup/sensor_setup.hpp"

namespace infuse::daemon {

/// One value for each sensor of a setup. Tables of one setup are copied without allocation.
template <class Lidar, class Stream>
struct SensorTable {
  std::vector<Lidar> lidars;    ///< by LidarIndex
  std::vector<Stream> cameras;  ///< by CameraIndex
  std::vector<Stream> buses;    ///< by BusIndex
  Stream speed{}, imu{}, gnss{};

  SensorTable() = default;
  explicit SensorTable(const SensorSetup& setup)
      : lidars(setup.lidars.size()),
        cameras(setup.cameras.size()),
        buses(setup.vehicle.buses.size()) {}

  /// The value of a sensor that is not a lidar.
  const Stream& stream(const SensorId& id) const {
    switch (id.kind) {
      case SensorKind::kLidar:
        break;
      case SensorKind::kCamera:
        return cameras.at(id.index);
      case SensorKind::kBus:
        return buses.at(id.index);
      case SensorKind::kSpeed:
        return speed;
      case SensorKind::kImu:
        return imu;
      case SensorKind::kGnss:
        return gnss;
    }
    throw std::invalid_argument("a lidar is no stream");
  }
  Stream& stream(const SensorId& id) {
    return const_cast<Stream&>(std::as_const(*this).stream(id));
  }
};

/// What each sensor has counted.
using SensorCounters = SensorTable<LidarCounters, StreamCounters>;
/// The level of each sensor.
using SensorLevels = SensorTable<Level, Level>;

/// The level of one of them.
inline Level level_of(const SensorId& id, const SensorLevels& levels) {
  return id.kind == SensorKind::kLidar ? levels.lidars.at(id.index) : levels.stream(id);
}

}  // namespace infuse::daemon

#include "daemon/setup/sensor_setup.hpp"

namespace infuse::daemon {

std::vector<Sensor> SensorSetup::sensors() const {
  std::vector<Sensor> sensors;
  const auto add_all = [&](SensorKind kind, const auto& setups) {
    for (size_t i = 0; i < setups.size(); ++i) sensors.push_back({{kind, i}, setups[i].device});
  };
  const auto add = [&](SensorKind kind, const std::optional<Device>& device) {
    if (device) sensors.push_back({{kind, 0}, *device});
  };
  add_all(SensorKind::kLidar, lidars);
  add_all(SensorKind::kCamera, cameras);
  add_all(SensorKind::kBus, vehicle.buses);
  add(SensorKind::kSpeed, vehicle.speed);
  add(SensorKind::kImu, vehicle.imu);
  add(SensorKind::kGnss, vehicle.gnss);
  return sensors;
}

}  // namespace infuse::daemon

#include "daemon/playback/find_lidar.hpp"

namespace infuse::daemon {

Result<size_t> find_lidar(const SensorSetup& setup, const std::string& name) {
  std::string names;
  for (size_t i = 0; i < setup.lidars.size(); ++i) {
    if (setup.lidars[i].device.name == name || (name.empty() && setup.lidars.size() == 1)) return i;
    names += (i == 0 ? "" : ", ") + setup.lidars[i].device.name;
  }
  if (setup.lidars.empty()) return fail("there is no lidar", setup.path.string());
  return fail(name.empty() ? "there are several lidars" : "there is no lidar '" + name + "'",
              setup.path.string(), "choose one with --lidar: " + names);
}

}  // namespace infuse::daemon

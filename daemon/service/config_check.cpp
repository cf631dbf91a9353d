#include "daemon/service/config_check.hpp"

#include <net/if.h>
#include <unistd.h>

#include <ostream>

#include "daemon/service/daemon_host.hpp"
#include "daemon/setup/live_setup.hpp"

namespace infuse::daemon {
namespace {

void print_notes(const SensorSetup& setup, std::ostream& out) {
  for (const auto* notes : {&setup.vehicle.notes, &setup.doubts}) {
    for (const Error& each : *notes) out << "note: " << each.message() << "\n";
  }
  const auto note = [&](const std::string& what) {
    out << "note: " << what << " does not exist at present\n";
  };
  for (const BusSetup& bus : setup.vehicle.buses) {
    const std::string& interface = bus.interface.interface;
    if (::if_nametoindex(interface.c_str()) == 0) note("interface " + interface);
  }
  for (const CameraSetup& camera : setup.cameras) {
    const std::string& device = camera.stream.device;
    if (::access(device.c_str(), F_OK) != 0) note(device);
  }
  if (!setup.gnss_serial) return;
  const std::string& device = setup.gnss_serial->device;
  if (::access(device.c_str(), F_OK) != 0) note(device);
}

}  // namespace

Result<void> check_config(const Config& config, std::ostream& out) {
  const auto setup = set_up_live(config);
  if (!setup) return tl::unexpected(setup.error());
  if (const auto map = open_place_map(config); !map) return tl::unexpected(map.error());
  if (const auto map = open_street_map(config); !map) return tl::unexpected(map.error());
  print_notes(*setup, out);
  return {};
}

}  // namespace infuse::daemon

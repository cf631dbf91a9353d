#include "daemon/service/config_check.hpp"

#include <net/if.h>
#include <unistd.h>

#include "daemon/mapping/place_map.hpp"
#include "daemon/service/daemon_host.hpp"
#include "daemon/setup/live_setup.hpp"

namespace infuse::daemon {
namespace {

std::vector<Error> notes_about(const SensorSetup& setup) {
  std::vector<Error> notes = setup.vehicle.notes;
  notes.insert(notes.end(), setup.doubts.begin(), setup.doubts.end());
  const auto note = [&](const std::string& what) {
    notes.push_back({what + " does not exist at present", "", ""});
  };
  for (const BusSetup& bus : setup.vehicle.buses) {
    const std::string& interface = bus.interface.interface;
    if (::if_nametoindex(interface.c_str()) == 0) note("interface " + interface);
  }
  for (const CameraSetup& camera : setup.cameras) {
    const std::string& device = camera.stream.device;
    if (::access(device.c_str(), F_OK) != 0) note(device);
  }
  if (setup.gnss_serial && ::access(setup.gnss_serial->device.c_str(), F_OK) != 0) {
    note(setup.gnss_serial->device);
  }
  return notes;
}

Json json_of(const Error& error) {
  Json json = {{"what", error.what}};
  if (!error.where.empty()) json["where"] = error.where;
  if (!error.hint.empty()) json["hint"] = error.hint;
  return json;
}

}  // namespace

Result<void> check_maps(const Config& config) {
  if (const auto map = open_street_map(config); !map) return tl::unexpected(map.error());
  const auto map = open_place_map(config);
  if (!map) return tl::unexpected(map.error());
  return *map ? check_clouds((*map)->map) : Result<void>();
}

ConfigCheck check_config(const std::filesystem::path& file) {
  ConfigCheck check{.file = file.string()};
  const auto config = load_config(file);
  if (!config) {
    check.wrong = config.error();
    return check;
  }
  check.digest = config->digest;
  check.version = config->version;
  const auto setup = set_up_live(*config);
  if (setup) check.notes = notes_about(*setup);
  if (!setup) {
    check.wrong = setup.error();
  } else if (const auto maps = check_maps(*config); !maps) {
    check.wrong = maps.error();
  }
  return check;
}

Json to_json(const ConfigCheck& check) {
  Json json = {{"file", check.file}, {"valid", !check.wrong}};
  if (!check.digest.empty()) json["config_digest"] = check.digest;
  if (!check.version.empty()) json["config_version"] = check.version;
  if (check.wrong) json["error"] = json_of(*check.wrong);
  json["notes"] = Json::array();
  for (const Error& note : check.notes) json["notes"].push_back(json_of(note));
  return json;
}

}  // namespace infuse::daemon

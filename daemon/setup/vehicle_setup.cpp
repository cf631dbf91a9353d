#include "daemon/setup/vehicle_setup.hpp"

#include <string_view>
#include <utility>

namespace infuse::daemon {
namespace {

using vehicle::SignalMap;
using vehicle::SignalSource;

/// The entry of a quantity of `recording::can_quantities()`; null if it is unknown.
SignalSource* find_source(SignalMap& map, std::string_view quantity) {
  const std::pair<std::string_view, SignalSource*> sources[] = {
      {"wheel_speed_front_left", &map.wheel_speed[0]},
      {"wheel_speed_front_right", &map.wheel_speed[1]},
      {"wheel_speed_rear_left", &map.wheel_speed[2]},
      {"wheel_speed_rear_right", &map.wheel_speed[3]},
      {"speed", &map.speed},
      {"yaw_rate", &map.yaw_rate},
      {"steering_angle", &map.steering_angle},
      {"steering_fraction", &map.steering_fraction},
      {"acceleration_forward", &map.acceleration[0]},
      {"acceleration_left", &map.acceleration[1]},
      {"acceleration_up", &map.acceleration[2]},
      {"angular_velocity_forward", &map.angular_velocity[0]},
      {"angular_velocity_left", &map.angular_velocity[1]},
      {"angular_velocity_up", &map.angular_velocity[2]},
      {"gear", &map.gear}};
  for (const auto& [name, source] : sources) {
    if (name == quantity) return source;
  }
  return nullptr;
}

Result<SignalMap> signal_map(const recording::CanFiles& can, const std::string& where) {
  SignalMap map;
  map.interface = can.interface;
  if (can.reverse_gear) map.reverse_gear = *can.reverse_gear;
  for (const recording::CanSignal& signal : can.signals) {
    SignalSource* source = find_source(map, signal.quantity);
    if (source == nullptr) return fail("unknown quantity '" + signal.quantity + "'", where);
    *source = {signal.signal, signal.scale, signal.unit};
  }
  if (const auto wrong = map.invalid()) return fail(*wrong, where, "see [can.signals]");
  return map;
}

}  // namespace

Result<std::optional<vehicle::VehicleDecoder>> make_decoder(const recording::CanFiles& can,
                                                            const std::filesystem::path& folder,
                                                            const std::string& where,
                                                            std::vector<Error>& notes) {
  if (can.signals.empty()) return std::nullopt;
  const auto map = signal_map(can, where);
  if (!map) return tl::unexpected(map.error());
  const auto reading = vehicle::read_dbc(folder / can.dbc);
  if (!reading) return tl::unexpected(reading.error());
  auto decoder = vehicle::VehicleDecoder::create(reading->dbc, *map);
  if (!decoder) return fail(decoder.error().what, where, decoder.error().hint);
  for (const Error& problem : reading->problems.first()) notes.push_back(problem);
  return std::optional(*std::move(decoder));
}

Result<VehicleSetup> set_up_vehicle(const recording::Drive& drive) {
  const recording::DriveDescription& description = drive.description;
  VehicleSetup setup;
  const auto device = [](const char* kind, const std::string& file) -> std::optional<Device> {
    if (file.empty()) return std::nullopt;
    return Device{kind, kind, file, "configured", file, std::nullopt};
  };
  setup.speed = device("speed", description.speed);
  setup.imu = device("imu", description.imu);
  setup.imu_delay_sigma = to_seconds(description.imu_delay_sigma);
  setup.gnss = device("gnss", description.gnss);
  if (!description.can) return setup;
  auto decoder = make_decoder(*description.can, drive.folder,
                              (drive.folder / "drive.toml").string(), setup.notes);
  if (!decoder) return tl::unexpected(decoder.error());
  const std::string& log = description.can->log;
  setup.buses.push_back(
      {{"can", "can", log, "configured", log, std::nullopt}, *std::move(decoder)});
  return setup;
}

}  // namespace infuse::daemon

#include "daemon/config/sensor_options.hpp"

#include "drivers/makers/makers.hpp"
#include "drivers/measurement/ipv4_address.hpp"
#include "drivers/text/printable.hpp"
#include "drivers/vehicle/serial_line_source.hpp"
#include "drivers/vehicle/socket_can_source.hpp"

namespace infuse::daemon {

std::optional<std::string> LidarOptions::invalid() const {
  if (!text::is_name(name)) return text::kNameRule;
  if (port == 0) return "port must be between 1 and 65535";
  if (position_port == 0) return "position_port must be between 1 and 65535";
  if (!model.empty() && makers::find_model(model) == nullptr)
    return "unknown model '" + model + "' (" + makers::known_models() + ")";
  if (!sender.empty() && !parse_address(sender)) return "'" + sender + "' is not an IPv4 address";
  if (!(cut_azimuth_deg >= -360 && cut_azimuth_deg <= 360)) {
    return "cut_azimuth_deg must be between -360 and 360";
  }
  return udp(port).invalid();
}

std::optional<std::string> CameraOptions::invalid() const {
  if (!text::is_name(name)) return text::kNameRule;
  return stream.invalid();
}

std::optional<std::string> BusOptions::invalid() const {
  if (!text::is_name(name)) return text::kNameRule;
  if (!signals.empty() && dbc.empty()) return "signals need a dbc";
  return vehicle::SocketCanOptions{.interface = interface, .identifiers = {}}.invalid();
}

std::optional<std::string> GnssOptions::invalid() const {
  if (device.empty()) return std::nullopt;
  if (!lidar.empty()) return "device and lidar exclude each other";
  return vehicle::SerialOptions{device, baud}.invalid();
}

}  // namespace infuse::daemon

#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "drivers/measurement/error.hpp"
#include "drivers/measurement/stamp.hpp"

namespace infuse::daemon {

/// Broker of the fleet: the `[mqtt]` table of the configuration.
struct MqttSettings {
  std::string host;              ///< name or address of the broker; empty: none
  uint16_t port = 0;             ///< 0: 8883 with TLS, else 1883
  std::string vehicle;           ///< name of the vehicle in the topics, and client identifier
  std::string topic = "infuse";  ///< beginning of the topics

  std::string ca_file;           ///< PEM; the broker's certificate must be signed by one of these
  std::string certificate_file;  ///< PEM, of this client; with `key_file`
  std::string key_file;
  std::string user;
  std::string password_file;  ///< its first line is the password

  Duration pose_interval{1'000'000'000};     ///< between published poses of a frame; 0: none
  Duration health_interval{10'000'000'000};  ///< between published HEALTH reports
  uint64_t queue = uint64_t{64} << 20;       ///< bytes of reports kept while there is no broker

  std::string config_digest;  ///< stated by the status; set by the daemon
  std::string config_version;

  bool enabled() const { return !host.empty(); }
  bool tls() const { return !ca_file.empty(); }
  uint16_t port_or_default() const { return port != 0 ? port : tls() ? 8883 : 1883; }

  /// Returns what is wrong with the settings, or nothing.
  std::optional<std::string> invalid() const;
};

/// A valid setting that is probably a mistake: a password that is sent in the clear, a broker whose
/// addresses the systemd unit may deny. Nothing if there is no broker.
std::optional<Error> find_broker_doubt(const MqttSettings& settings);

}  // namespace infuse::daemon

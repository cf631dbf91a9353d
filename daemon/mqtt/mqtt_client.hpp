#pragma once

#include <chrono>
#include <functional>
#include <memory>
#include <optional>
#include <string>

#include "daemon/config/mqtt_settings.hpp"
#include "drivers/measurement/error.hpp"

struct mosquitto;

namespace infuse::daemon {

/// One connection to a broker, by MQTT 3.1.1 (libmosquitto), for one thread. It ends when it is
/// lost; another one is made then.
class MqttClient {
 public:
  struct Will {
    std::string topic, payload;  ///< what the broker publishes, retained, when this client is lost
  };
  /// `password`: empty if none is configured. `on_acknowledged` gets the numbers of `publish`.
  MqttClient(const MqttSettings& settings, const std::string& password, const Will& will,
             std::function<void(int)> on_acknowledged);
  ~MqttClient();
  MqttClient(const MqttClient&) = delete;
  MqttClient& operator=(const MqttClient&) = delete;

  /// Connects; waits for names and for the network, a silent host takes minutes. The broker's
  /// answer comes by `run`.
  Result<void> connect();

  /// Sends and receives for at most `wait`. Fails when the connection is lost or refused.
  Result<void> run(std::chrono::milliseconds wait);

  /// The broker has accepted the connection.
  bool connected() const { return connected_; }

  /// Publishes with "at least once" and returns the message's number, or nothing if it cannot.
  std::optional<int> publish(const std::string& topic, const std::string& payload, bool retain);

  /// Ends the connection in order: the will is not published.
  void disconnect();

 private:
  struct Destroy {
    void operator()(mosquitto* client) const;
  };

  Result<void> set_up();
  Error lost(int status) const;

  const MqttSettings& settings_;
  const std::string& password_;
  Will will_;
  std::function<void(int)> on_acknowledged_;
  std::unique_ptr<mosquitto, Destroy> client_;
  bool connected_ = false;
  std::string refusal_;    // of the broker
  std::string tls_error_;  // the last one
};

}  // namespace infuse::daemon

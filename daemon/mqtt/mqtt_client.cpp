#include "daemon/mqtt/mqtt_client.hpp"

#include <mosquitto.h>

#include <cerrno>
#include <cstring>
#include <system_error>

namespace infuse::daemon {
namespace {

constexpr int kAtLeastOnce = 1;  // quality of service
constexpr int kKeepAlive = 30;   // s; after 1.5 times that the broker publishes the will
constexpr int kVerifyPeer = 1;   // SSL_VERIFY_PEER

/// The library's state, once in a process.
void initialise_library() {
  static const int done = mosquitto_lib_init();
  static_cast<void>(done);
}

MqttClient* client_of(void* object) { return static_cast<MqttClient*>(object); }

}  // namespace

void MqttClient::Destroy::operator()(mosquitto* client) const { mosquitto_destroy(client); }

MqttClient::MqttClient(const MqttSettings& settings, const std::string& password, const Will& will,
                       std::function<void(int)> on_acknowledged)
    : settings_(settings),
      password_(password),
      will_(will),
      on_acknowledged_(std::move(on_acknowledged)) {
  initialise_library();
}

MqttClient::~MqttClient() = default;

Result<void> MqttClient::set_up() {
  client_.reset(mosquitto_new(settings_.vehicle.c_str(), true, this));
  if (!client_) return fail(std::string("no client: ") + std::strerror(errno));
  mosquitto* client = client_.get();
  mosquitto_connect_callback_set(client, [](mosquitto*, void* object, int refused) {
    MqttClient* self = client_of(object);
    self->connected_ = refused == 0;
    if (refused != 0) self->refusal_ = mosquitto_connack_string(refused);
  });
  mosquitto_publish_callback_set(client, [](mosquitto*, void* object, int number) {
    client_of(object)->on_acknowledged_(number);
  });
  mosquitto_log_callback_set(client, [](mosquitto*, void* object, int level, const char* text) {
    if (level == MOSQ_LOG_ERR) client_of(object)->tls_error_ = text;
  });
  int status =
      mosquitto_will_set(client, will_.topic.c_str(), static_cast<int>(will_.payload.size()),
                         will_.payload.data(), kAtLeastOnce, true);
  if (status == MOSQ_ERR_SUCCESS && !settings_.user.empty()) {
    status = mosquitto_username_pw_set(client, settings_.user.c_str(),
                                       password_.empty() ? nullptr : password_.c_str());
  }
  if (status == MOSQ_ERR_SUCCESS && settings_.tls()) {
    const auto file = [](const std::string& name) { return name.empty() ? nullptr : name.c_str(); };
    status = mosquitto_tls_set(client, settings_.ca_file.c_str(), nullptr,
                               file(settings_.certificate_file), file(settings_.key_file), nullptr);
    if (status == MOSQ_ERR_SUCCESS) {
      status = mosquitto_tls_opts_set(client, kVerifyPeer, "tlsv1.2", nullptr);
    }
  }
  if (status != MOSQ_ERR_SUCCESS) return tl::unexpected(lost(status));
  return {};
}

Result<void> MqttClient::connect() {
  if (auto done = set_up(); !done) return done;
  const int status = mosquitto_connect(client_.get(), settings_.host.c_str(),
                                       settings_.port_or_default(), kKeepAlive);
  if (status != MOSQ_ERR_SUCCESS) return tl::unexpected(lost(status));
  return {};
}

Result<void> MqttClient::run(std::chrono::milliseconds wait) {
  const int status = mosquitto_loop(client_.get(), static_cast<int>(wait.count()), 1);
  if (status == MOSQ_ERR_SUCCESS && refusal_.empty()) return {};
  connected_ = false;
  return tl::unexpected(lost(status));
}

std::optional<int> MqttClient::publish(const std::string& topic, const std::string& payload,
                                       bool retain) {
  int number = 0;
  const int status =
      mosquitto_publish(client_.get(), &number, topic.c_str(), static_cast<int>(payload.size()),
                        payload.data(), kAtLeastOnce, retain);
  return status == MOSQ_ERR_SUCCESS ? std::optional(number) : std::nullopt;
}

void MqttClient::disconnect() { mosquitto_disconnect(client_.get()); }

Error MqttClient::lost(int status) const {
  const std::string broker = settings_.host + ":" + std::to_string(settings_.port_or_default());
  if (!refusal_.empty())
    return {"the broker refuses: " + refusal_, broker, "check user and vehicle"};
  if (status == MOSQ_ERR_TLS || !tls_error_.empty()) {
    return {"TLS: " + (tls_error_.empty() ? mosquitto_strerror(status) : tls_error_), broker,
            "check ca_file, certificate_file and key_file, and this host's time"};
  }
  if (status == MOSQ_ERR_ERRNO) {
    return {std::system_category().message(errno), broker, ""};
  }
  return {mosquitto_strerror(status), broker, ""};
}

}  // namespace infuse::daemon

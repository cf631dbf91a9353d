#include "daemon/config/mqtt_settings.hpp"

#include <boost/asio/ip/address.hpp>

namespace infuse::daemon {
namespace {

constexpr size_t kMaxTopicBytes = 256;
constexpr uint64_t kMinQueueBytes = 1 << 20;

/// One or several levels of a topic: no wildcards, no empty level.
bool is_topic(const std::string& text) {
  return !text.empty() && text.size() <= kMaxTopicBytes && text.front() != '/' &&
         text.back() != '/' && text.front() != '$' && text.find("//") == std::string::npos &&
         text.find_first_of("+#") == std::string::npos &&
         text.find_first_of(std::string_view("\0\n\r", 3)) == std::string::npos;
}

/// The addresses that infused.service permits: the loopback and private IPv4 networks.
bool is_permitted_by_unit(const std::string& host) {
  if (host == "localhost") return true;
  boost::system::error_code failed;
  const auto address = boost::asio::ip::make_address(host, failed);
  if (failed || !address.is_v4()) return false;
  const uint32_t bits = address.to_v4().to_uint();
  return bits >> 24 == 127 || bits >> 24 == 10 || bits >> 20 == 0xac1 || bits >> 16 == 0xc0a8 ||
         bits >> 16 == 0xa9fe;
}

}  // namespace

std::optional<std::string> MqttSettings::invalid() const {
  if (!enabled()) return std::nullopt;
  if (!is_topic(vehicle) || vehicle.find('/') != std::string::npos) {
    return "vehicle must be the name of this vehicle in the topics, without / + #";
  }
  if (!is_topic(topic)) return "topic must be levels separated by /, without + #";
  if (certificate_file.empty() != key_file.empty()) {
    return "certificate_file and key_file must be given together";
  }
  if (!certificate_file.empty() && !tls()) return "certificate_file needs ca_file";
  if (user.empty() && !password_file.empty()) return "password_file needs user";
  if (pose_interval < Duration{0}) return "pose_interval_s must not be negative";
  if (health_interval < Duration{0}) return "health_interval_s must not be negative";
  if (queue < kMinQueueBytes) return "queue_mb must be at least 1";
  return std::nullopt;
}

std::optional<Error> find_broker_doubt(const MqttSettings& settings) {
  if (!settings.enabled()) return std::nullopt;
  if (!settings.password_file.empty() && !settings.tls() && settings.host != "localhost") {
    return Error{"the broker's password is sent in the clear", "[mqtt]", "give ca_file"};
  }
  if (!is_permitted_by_unit(settings.host)) {
    return Error{
        "infused.service permits private IPv4 addresses only: it may not reach " + settings.host,
        "[mqtt]", "install the drop-in mqtt.conf, see infused(8)"};
  }
  return std::nullopt;
}

}  // namespace infuse::daemon

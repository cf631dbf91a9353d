#include "daemon/mqtt/mqtt_feed.hpp"

namespace infuse::daemon {

Result<std::unique_ptr<MqttFeed>> MqttFeed::start(const Config& config,
                                                  const std::filesystem::path& state_folder,
                                                  const std::string& release) {
  if (!config.mqtt.enabled()) return nullptr;
  MqttSettings settings = config.mqtt;
  for (std::string* file : {&settings.ca_file, &settings.certificate_file, &settings.key_file,
                            &settings.password_file}) {
    if (!file->empty()) *file = config.resolve(*file);
  }
  settings.config_digest = config.digest;
  settings.config_version = config.version;
  auto publisher = MqttPublisher::start(
      settings, state_folder.empty() ? state_folder : state_folder / "mqtt.db", release);
  if (!publisher) return tl::unexpected(publisher.error());
  return std::unique_ptr<MqttFeed>(new MqttFeed(*std::move(publisher), config.mqtt));
}

}  // namespace infuse::daemon

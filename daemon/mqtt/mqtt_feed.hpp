#pragma once

#include "daemon/config/config.hpp"
#include "daemon/mqtt/mqtt_publisher.hpp"
#include "daemon/mqtt/report_topics.hpp"

namespace infuse::daemon {

/// Passes reports on to the configured broker.
class MqttFeed {
 public:
  /// Connects; null if no broker is configured. Reports that wait are kept in `state_folder`, if it
  /// is not empty. `release`: the program's version. Errors: as `MqttPublisher::start`.
  static Result<std::unique_ptr<MqttFeed>> start(const Config& config,
                                                 const std::filesystem::path& state_folder,
                                                 const std::string& release);

  /// Adds a report, if it is one that the broker gets.
  template <class Report>
  void add(const Report& report) {
    if (auto selected = topics_.select(report)) publisher_->add(*std::move(selected));
  }

  /// As `MqttPublisher::stats`.
  QueueStats stats() const { return publisher_->stats(); }

  /// As `MqttPublisher::disk_problem`.
  std::string disk_problem() const { return publisher_->disk_problem(); }

  /// As `MqttPublisher::finish`.
  void finish(std::chrono::milliseconds timeout) { publisher_->finish(timeout); }

 private:
  MqttFeed(std::unique_ptr<MqttPublisher> publisher, const MqttSettings& settings)
      : publisher_(std::move(publisher)), topics_(settings) {}

  std::unique_ptr<MqttPublisher> publisher_;
  ReportTopics topics_;
};

}  // namespace infuse::daemon

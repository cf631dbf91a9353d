#pragma once

#include <chrono>
#include <filesystem>
#include <memory>
#include <thread>
#include <utility>

#include "daemon/config/mqtt_settings.hpp"
#include "daemon/mqtt/report_queue.hpp"
#include "daemon/protocol/reports.hpp"

namespace infuse::daemon {

/// Publishes reports to an MQTT broker on a thread of its own: whoever adds a report never waits
/// for the network or the disk. Reports wait in a `ReportQueue` until the broker has acknowledged
/// them, over lost connections and restarts, and are published in their order, each at least once.
class MqttPublisher {
 public:
  /// Starts the thread. `queue_file`: empty keeps the queue in memory. The files of `settings` are
  /// absolute paths. `release`: the program's version, for the status. Errors: a file of
  /// `settings` that cannot be read.
  static Result<std::unique_ptr<MqttPublisher>> start(const MqttSettings& settings,
                                                      const std::filesystem::path& queue_file,
                                                      std::string release);

  ~MqttPublisher();
  MqttPublisher(const MqttPublisher&) = delete;
  MqttPublisher& operator=(const MqttPublisher&) = delete;

  /// Adds a report; drops it and counts it if the thread is 1000 reports behind.
  void add(QueuedReport report);

  /// Fill level of the queue in KiB, and the number of reports that were dropped.
  QueueStats stats() const;

  /// Why reports wait in memory, to be lost at a restart, and not in the file; an empty text if
  /// they do not.
  std::string disk_problem() const;

  /// Publishes what waits and that the vehicle goes offline, for at most `timeout`, then ends. What
  /// is left is published after the next start.
  void finish(std::chrono::milliseconds timeout);

 private:
  class Worker;
  MqttPublisher(std::shared_ptr<Worker> worker, std::thread thread)
      : worker_(std::move(worker)), thread_(std::move(thread)) {}
  std::shared_ptr<Worker> worker_;
  std::thread thread_;
};

}  // namespace infuse::daemon

#pragma once

#include <boost/asio/io_context.hpp>
#include <boost/asio/signal_set.hpp>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "daemon/config/config.hpp"
#include "daemon/history/run_tracker.hpp"
#include "daemon/pipeline/publisher.hpp"
#include "daemon/sensors/recording_controller.hpp"
#include "daemon/service/map_watch.hpp"

namespace infuse::daemon {

/// What the service looks after. The references outlive it.
struct ServiceParts {
  boost::asio::io_context& io;
  Publisher& publisher;
  RecordingController& recordings;
  Server& server;
  std::function<void()> stop;                     ///< requests the end of the pipeline
  std::function<Stamp()> now;                     ///< the present
  std::vector<std::unique_ptr<MapWatch>> maps{};  ///< in use
};

/// The live daemon as a service: notifies the service manager, tracks runs, publishes the state of
/// recordings, and reloads the configuration on SIGHUP. Runs on the thread of the `io_context`.
class ServiceLifecycle {
 public:
  /// The references must outlive this object. `config` is the running configuration, read from
  /// `config_file`. `calibration_damage`: why the saved calibrations are not used; an alert.
  ServiceLifecycle(ServiceParts parts, const std::string& config_file, const Config& config,
                   const std::optional<std::string>& calibration_damage);

  /// Requests the end of the pipeline.
  void stop();

  /// Records the end of the run; called after the pipeline's end.
  void finish();

 private:
  void on_progress();
  void add_recent(const AlertReport& alert);
  void wait_for_reload();
  void reload_config();
  void apply_config(const Config& loaded);

  ServiceParts parts_;
  const std::string& config_file_;
  const Config& config_;  // at the start
  Config applied_;        // since the last reload
  const std::optional<std::string>& calibration_damage_;
  RunTracker run_tracker_;
  boost::asio::signal_set reload_signal_;
  bool ready_ = false;
  std::string recent_alerts_;
};

}  // namespace infuse::daemon

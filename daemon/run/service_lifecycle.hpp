#pragma once

#include <boost/asio/io_context.hpp>
#include <boost/asio/signal_set.hpp>
#include <string>

#include "daemon/config/config.hpp"
#include "daemon/live/live_pipeline.hpp"
#include "daemon/live/recording_controller.hpp"
#include "daemon/live/run_tracker.hpp"

namespace infuse::daemon {

/// The live daemon as a service: notifies the service manager, tracks runs, publishes the state of
/// recordings, and reloads the configuration on SIGHUP. Runs on the thread of the `io_context`.
class ServiceLifecycle {
 public:
  /// All arguments must outlive this object. `config` is the running configuration, read from
  /// `config_file`. `calibration_damage`: why the saved calibrations are not used; an alert.
  ServiceLifecycle(boost::asio::io_context& io, const std::string& config_file,
                   const Config& config, LivePipeline& live, RecordingController& recordings,
                   Server& server, const receive::TimeBase& base,
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

  const std::string& config_file_;
  const Config& config_;
  LivePipeline& live_;
  RecordingController& recordings_;
  Server& server_;
  const receive::TimeBase& base_;
  const std::optional<std::string>& calibration_damage_;
  RunTracker run_tracker_;
  boost::asio::signal_set reload_signal_;
  bool ready_ = false;
  std::string recent_alerts_;
};

}  // namespace infuse::daemon

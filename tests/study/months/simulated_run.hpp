#pragma once

#include <filesystem>
#include <functional>
#include <string>

#include "daemon/history/history_writer.hpp"
#include "daemon/sensors/recording_controller.hpp"
#include "daemon/service/daemon_host.hpp"
#include "daemon/service/service_lifecycle.hpp"
#include "daemon/setup/live_setup.hpp"

namespace infuse::study {

/// One run of the daemon's process, from its start to its end: everything of `infused` but the
/// threads of the pipeline, whose items are pushed, and the sockets of the sensors.
class SimulatedRun {
 public:
  /// Reads the configuration as `infused --config` does. `now`: the daemon's clock. Throws
  /// std::runtime_error where the daemon would not start.
  SimulatedRun(const std::filesystem::path& config_file, const std::filesystem::path& state,
               std::function<Stamp()> now);

  /// Restores what is frozen, and accepts requests; `on_command` handles commands for calibrations.
  void connect(daemon::DaemonHost::CommandHandler on_command);

  /// Publishes an item of the fusion thread.
  void push(const daemon::ReportItem& item);
  /// An item with room for what the devices count.
  daemon::ReportItem make_item() const;

  /// Lets the recorder and the event loop work.
  void work();

  /// Ends as at SIGTERM. Without it, the destructor is a crash: nothing is written any more.
  void finish();

  Result<std::string> handle_request(const daemon::Request& request) {
    return host_->handle_request(request);
  }
  daemon::Publisher& publisher() { return *publisher_; }
  daemon::RecordTap* tap() { return recordings_->tap(); }
  const daemon::Config& config() const { return config_; }
  const daemon::SensorSetup& setup() const { return setup_; }

 private:
  std::string config_file_;
  daemon::Config config_;
  daemon::SensorSetup setup_;
  std::optional<daemon::DaemonHost> host_;
  std::optional<SlotRing<daemon::ReportItem>> ring_;
  std::optional<daemon::Publisher> publisher_;
  std::optional<daemon::RecordingController> recordings_;
  std::optional<daemon::HistoryWriter> history_;
  std::optional<daemon::ServiceLifecycle> lifecycle_;
};

}  // namespace infuse::study

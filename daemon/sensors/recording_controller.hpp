#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include "daemon/pipeline/publisher.hpp"
#include "daemon/protocol/request.hpp"
#include "daemon/record/recorder.hpp"
#include "daemon/sensors/alert_pause.hpp"
#include "daemon/sensors/drive_description.hpp"

namespace infuse::daemon {

/// Handles recording requests, starts a recording when an alert is raised, and reports the state of
/// recordings. Runs on the thread of the `io_context`.
class RecordingController {
 public:
  /// Records into the configured folder, or into `drives` in the service manager's state directory
  /// ($STATE_DIRECTORY). Recording is disabled if there is neither.
  /// `now`: the present; called by any thread.
  RecordingController(const Config& config, const SensorSetup& setup, std::function<Stamp()> now,
                      RecorderThread thread = RecorderThread::kOwn);

  /// The recorder's input, for the io thread; null if recording is disabled.
  RecordTap* tap() { return recorder_ ? &recorder_->tap() : nullptr; }

  /// Sets the publisher that reports recordings and raises alerts. It must outlive every later
  /// call.
  void set_publisher(Publisher& publisher);

  /// Starts or ends a recording at a client's request. Errors: recording is disabled, an invalid
  /// name, a requested recording is already running, no disk space.
  Result<void> handle_request(const Request& request);

  /// Applies new limits to the next recordings. The folder, the memory, and whether the flight
  /// recorder is on do not change.
  void apply_settings(const RecordSettings& settings);

  /// Publishes the recorder's state if it has changed.
  void publish_updates();

  /// Folder of the recordings; empty if recording is disabled.
  const std::filesystem::path& directory() const { return directory_; }

  /// True while a recording is being written.
  bool is_recording() const { return recorder_ && recorder_->is_recording(); }

  /// Without a thread of the recorder: writes what has come since the last call.
  void work() {
    if (recorder_) recorder_->work();
  }

  /// Completes the recording; called after the io thread has ended.
  void finish();

 private:
  RecordingPlan make_plan(Stamp now) const;
  Result<void> begin(RecordingPlan plan, Stamp now);
  Result<void> create_directory() const;
  void on_alert(const AlertReport& alert);
  void publish_report(const RecordReport& report);
  void announce(const RecordReport& report);
  void raise_failure_alert(Stamp stamp, const std::string& what,
                           const std::filesystem::path& folder);

  RecordSettings settings_;
  const std::function<Stamp()> now_;
  std::filesystem::path directory_;
  DescribedDrive drive_;
  std::optional<Recorder> recorder_;
  Publisher* publisher_ = nullptr;
  AlertPause alert_pause_;
  bool end_published_ = true;
  std::optional<Finding> raised_failure_;  // set while the alert is raised
};

/// True if `name` is a valid name of a recording: letters, digits, - and _, at most 64 characters,
/// not starting with - or with the prefix of alert recordings.
bool is_recording_name(const std::string& name);

}  // namespace infuse::daemon

#pragma once

#include <optional>
#include <string>

#include "daemon/live/drive_description.hpp"
#include "daemon/pipeline/publisher.hpp"
#include "daemon/protocol/request.hpp"
#include "daemon/record/recorder.hpp"

namespace infuse::daemon {

/// Takes orders for recordings, begins one where an alert is raised, and tells how they stand. On
/// the thread of the `io_context`.
class RecordingController {
 public:
  /// Records into the configured folder, or into `drives` in that of the service manager
  /// ($STATE_DIRECTORY); nothing where there is neither.
  RecordingController(const Config& config, const LiveSetup& setup, const receive::TimeBase& base);

  /// For the io thread; null where nothing can be recorded.
  RecordTap* tap() { return recorder_ ? &recorder_->tap() : nullptr; }

  /// Where it is told, and whose alerts it looks at; outlives the last call of another function.
  void set_publisher(Publisher& publisher);

  /// Begins or ends a recording, as a client requested.
  Result<void> handle_request(const Request& request);

  /// The next recordings have these bounds. The folder, the memory, and whether there is a flight
  /// recorder stay as they are.
  void apply_settings(const RecordSettings& settings);

  /// Tells what is new.
  void publish_updates();

  /// One is being made.
  bool is_recording() const { return recorder_ && recorder_->is_recording(); }

  /// The io thread has ended: what was recorded is brought to its end.
  void finish();

 private:
  RecordingPlan make_plan(Stamp now) const;
  Result<void> begin(RecordingPlan plan, Stamp now);
  void on_alert(const AlertReport& alert);
  void publish_report(const RecordReport& report);
  void raise_failure_alert(const RecordReport& report);

  RecordSettings settings_;
  const receive::TimeBase base_;
  std::filesystem::path directory_;
  DescribedDrive drive_;
  std::optional<Recorder> recorder_;
  Publisher* publisher_ = nullptr;
  bool end_published_ = true;
  std::optional<Finding> raised_failure_;  // raised
};

/// Whether a recording may be called that: letters, digits, - and _, at most 64, no - in front, and
/// not as those of alerts are.
bool is_recording_name(const std::string& name);

}  // namespace infuse::daemon

#include "daemon/sensors/recording_controller.hpp"

#include <spdlog/spdlog.h>

#include <algorithm>
#include <cstdlib>
#include <span>

#include "daemon/health/service_alerts.hpp"
#include "drivers/recording/atomic_file.hpp"

namespace infuse::daemon {
namespace {

constexpr const char* kRequestedCause = "requested";

std::filesystem::path directory_of(const Config& config) {
  if (!config.record.directory.empty()) {
    return std::filesystem::absolute(config.resolve(config.record.directory)).lexically_normal();
  }
  const char* state = std::getenv("STATE_DIRECTORY");
  if (state == nullptr || *state != '/') return {};
  return std::filesystem::path(state) / "drives";
}

bool is_name_char(char c) {
  return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '_' ||
         c == '-';
}

/// "20261121-061136", UTC.
std::string time_name(Stamp stamp) {
  const auto seconds = static_cast<std::time_t>(stamp.ns() / 1'000'000'000);
  std::tm utc{};
  gmtime_r(&seconds, &utc);
  char text[32];
  std::strftime(text, sizeof(text), "%Y%m%d-%H%M%S", &utc);
  return text;
}

std::string alert_name(Stamp stamp, const std::string& id) {
  constexpr size_t kMaxIdLength = 40;
  std::string name = kAlertPrefix + time_name(stamp) + "-" + id.substr(0, kMaxIdLength);
  std::replace_if(
      name.begin(), name.end(), [](char c) { return !is_name_char(c); }, '_');
  return name;
}

}  // namespace

bool is_recording_name(const std::string& name) {
  constexpr size_t kMaxNameLength = 64;
  return !name.empty() && name.size() <= kMaxNameLength && name.front() != '-' &&
         std::all_of(name.begin(), name.end(), is_name_char) && !name.starts_with(kAlertPrefix);
}

RecordingController::RecordingController(const Config& config, const SensorSetup& setup,
                                         std::function<Stamp()> now, RecorderThread thread)
    : settings_(config.record),
      now_(std::move(now)),
      directory_(directory_of(config)),
      drive_(describe_drive(config, setup)) {
  if (directory_.empty()) return;
  recorder_.emplace(settings_, directory_, now_, thread);
  if (settings_.flight_recorder > Duration::zero()) {
    spdlog::info("flight recorder: the last {:.0f} s are recorded when an alert is raised",
                 to_seconds(settings_.flight_recorder));
  }
}

void RecordingController::set_publisher(Publisher& publisher) {
  publisher_ = &publisher;
  if (recorder_ && settings_.flight_recorder > Duration::zero()) {
    publisher.add_alert_listener([this](const AlertReport& alert) { on_alert(alert); });
  }
}

Result<void> RecordingController::handle_request(const Request& request) {
  if (!recorder_) {
    return fail("recording is disabled", "", "set directory in [record] of the configuration");
  }
  const Stamp now = now_();
  if (!request.on) {
    if (!recorder_->is_recording()) return fail("no recording is running");
    recorder_->end_at(now);
    return {};
  }
  RecordingPlan plan = this->make_plan(now);
  plan.cause = kRequestedCause;
  plan.name = request.name.empty() ? time_name(now) : request.name;
  if (!is_recording_name(plan.name)) {
    return fail("invalid name of a recording", "",
                "use letters, digits, - and _; the folder is " + directory_.string());
  }
  if (const auto last = recorder_->report();
      last && !last->ended && last->cause == kRequestedCause) {
    return fail("'" + last->name + "' is still being recorded", "",
                "end it first: infuse record --stop");
  }
  if (request.max_duration != Duration::zero())
    plan.max_duration = std::min(plan.max_duration, request.max_duration);
  if (request.max_bytes != 0) plan.max_bytes = std::min(plan.max_bytes, request.max_bytes);
  return begin(std::move(plan), now);
}

RecordingPlan RecordingController::make_plan(Stamp now) const {
  RecordingPlan plan;
  plan.directory = directory_;
  plan.from = now;
  plan.until = Stamp::latest();
  plan.max_duration = settings_.max_duration;
  plan.max_bytes = settings_.max_bytes;
  plan.split_duration = settings_.split;
  plan.split_bytes = settings_.split_bytes;
  plan.min_free_bytes = settings_.min_free;
  plan.description = drive_.description;
  plan.description.name = "recorded live";
  plan.copies = drive_.copies;
  // The calibrations in use now.
  for (CameraMount& camera : plan.description.rig.cameras) {
    const auto& calibrations = publisher_->totals().calibrations;
    const auto in_use = calibrations.find(camera.name);
    if (in_use != calibrations.end()) camera.T_camera_lidar = in_use->second.T_camera_lidar;
  }
  return plan;
}

Result<void> RecordingController::begin(RecordingPlan plan, Stamp now) {
  if (auto created = create_directory(); !created) return created;
  auto recording = Recording::begin(std::move(plan), now);
  if (!recording) return tl::unexpected(recording.error());
  if (raised_failure_) publisher_->publish_alert({now, kDaemonDevice, false, *raised_failure_});
  raised_failure_.reset();
  publish_updates();  // the end of the previous recording, whose failure is raised anew
  const RecordReport report = recording->report();
  recorder_->begin(*std::move(recording));
  spdlog::info("recording into {} ({})", report.folder, report.cause);
  for (const std::string& omission : drive_.not_recorded)
    spdlog::info("not recorded: {}", omission);
  end_published_ = false;
  publisher_->publish_record(report);
  return {};
}

/// The service's umask leaves the group nothing; a folder of the owner is left as it is.
Result<void> RecordingController::create_directory() const {
  namespace fs = std::filesystem;
  std::error_code failed;
  const bool created = fs::create_directories(directory_, failed);
  if (failed) return fail("cannot be created: " + failed.message(), directory_.string());
  if (!created && !settings_.directory.empty()) return {};
  fs::permissions(directory_, fs::perms::group_read | fs::perms::group_exec, fs::perm_options::add,
                  failed);
  return {};
}

// A running recording covers the alert already.
void RecordingController::on_alert(const AlertReport& alert) {
  if (!alert.raised || alert.device == kDaemonDevice || recorder_->is_recording()) return;
  const Stamp now = now_();
  RecordingPlan plan = this->make_plan(now);
  plan.cause = alert.device + "." + alert.finding.id;
  if (!alert_pause_.is_over(plan.cause, now, settings_.alert_pause)) return;
  plan.name = alert_name(now, plan.cause);
  plan.from = now - settings_.flight_recorder;
  plan.until = now + settings_.after_alert;
  if (const auto begun = begin(std::move(plan), now); !begun) {
    spdlog::error("cannot record the alert: {}", begun.error().message());
    return raise_failure_alert(now, "an alert is not recorded: " + begun.error().message(),
                               directory_);
  }
  alert_pause_.begin(alert.device + "." + alert.finding.id, now);
}

void RecordingController::apply_settings(const RecordSettings& settings) {
  const bool had_flight_recorder = settings_.flight_recorder > Duration::zero();
  const Duration flight = settings_.flight_recorder;
  settings_ = settings;
  if (had_flight_recorder != (settings.flight_recorder > Duration::zero()))
    settings_.flight_recorder = flight;
}

void RecordingController::publish_updates() {
  if (end_published_) return;
  const auto report = recorder_->report();
  if (report) publish_report(*report);
}

void RecordingController::publish_report(const RecordReport& report) {
  publisher_->publish_record(report);
  if (!report.ended) return;
  end_published_ = true;
  spdlog::info("{}: {:.1f} s, {:.1f} MB, {} lost{}{}", report.folder, to_seconds(report.duration),
               static_cast<double>(report.bytes) * 1e-6, report.lost,
               report.reason.empty() ? "" : ": ", report.reason);
  if (report.failed) {
    raise_failure_alert(report.stamp, "a recording ended prematurely: " + report.reason,
                        directory_);
  }
  if (report.name.starts_with(kAlertPrefix)) announce(report);
}

/// Lets who takes recordings off the vehicle know (systemd/infuse-upload.path), if there is one.
void RecordingController::announce(const RecordReport& report) {
  const char* state = std::getenv("STATE_DIRECTORY");
  const std::filesystem::path spool =
      std::filesystem::path(state == nullptr ? "" : state) / "spool";
  std::error_code failed;
  if (state == nullptr || !std::filesystem::is_directory(spool, failed)) return;
  const std::string line = report.folder + "\n";
  const auto written =
      recording::write_file_atomically(spool / report.name, std::as_bytes(std::span(line)), 0640);
  if (!written) {
    raise_failure_alert(report.stamp,
                        report.name + " is not in the spool, and stays on the vehicle: " +
                            written.error().message(),
                        spool);
  }
}

// Raised once, until the next recording begins.
void RecordingController::raise_failure_alert(Stamp stamp, const std::string& what,
                                              const std::filesystem::path& folder) {
  if (raised_failure_) return;
  raised_failure_ =
      make_finding(kRecordAlert, stamp, {what, "free space on the disk of " + folder.string()});
  publisher_->publish_alert({stamp, kDaemonDevice, true, *raised_failure_});
}

void RecordingController::finish() {
  if (!recorder_) return;
  recorder_->finish();
  publish_updates();
}

}  // namespace infuse::daemon

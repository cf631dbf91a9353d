#include "daemon/live/record_desk.hpp"

#include <spdlog/spdlog.h>

#include <algorithm>
#include <cstdlib>

namespace infuse::daemon {
namespace {

constexpr const char* kDevice = "infused";
constexpr const char* kAskedFor = "asked for";

std::filesystem::path directory_of(const Config& config) {
  if (!config.record.directory.empty()) {
    return std::filesystem::absolute(config.resolve(config.record.directory)).lexically_normal();
  }
  const char* state = std::getenv("STATE_DIRECTORY");
  if (state == nullptr || *state != '/') return {};
  return std::filesystem::path(state) / "drives";
}

bool is_plain(char c) {
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
  constexpr size_t kLongest = 40;
  std::string name = kAlertPrefix + time_name(stamp) + "-" + id.substr(0, kLongest);
  std::replace_if(
      name.begin(), name.end(), [](char c) { return !is_plain(c); }, '_');
  return name;
}

}  // namespace

bool is_recording_name(const std::string& name) {
  constexpr size_t kLongest = 64;
  return !name.empty() && name.size() <= kLongest && name.front() != '-' &&
         std::all_of(name.begin(), name.end(), is_plain) && !name.starts_with(kAlertPrefix);
}

RecordDesk::RecordDesk(const Config& config, const LiveSetup& setup, const receive::TimeBase& base)
    : settings_(config.record),
      base_(base),
      directory_(directory_of(config)),
      drive_(describe_drive(config, setup)) {
  if (directory_.empty()) return;
  recorder_.emplace(settings_, directory_, base_);
  if (settings_.flight > Duration::zero()) {
    spdlog::info("what was heard in the last {:.0f} s is recorded when an alert is raised",
                 to_seconds(settings_.flight));
  }
}

void RecordDesk::tell_to(Publisher& publisher) {
  publisher_ = &publisher;
  if (recorder_ && settings_.flight > Duration::zero()) {
    publisher.on_alert([this](const AlertReport& alert) { take_alert(alert); });
  }
}

Result<void> RecordDesk::ask(const Request& request) {
  if (!recorder_) {
    return fail("there is no place for recordings", "", "name a directory in [record]");
  }
  const Stamp now = base_.now();
  if (!request.on) {
    if (!recorder_->busy()) return fail("nothing is being recorded");
    recorder_->end_at(now);
    return {};
  }
  RecordingPlan plan = this->plan(now);
  plan.why = kAskedFor;
  plan.name = request.name.empty() ? time_name(now) : request.name;
  if (!is_recording_name(plan.name)) {
    return fail("a recording cannot be called that", "",
                "letters, digits, - and _; it lies in " + directory_.string());
  }
  if (const auto last = recorder_->report(); last && !last->ended && last->why == kAskedFor) {
    return fail("'" + last->name + "' is being recorded", "", "end it first: infuse record --stop");
  }
  if (request.longest != Duration::zero()) plan.longest = std::min(plan.longest, request.longest);
  if (request.largest != 0) plan.largest = std::min(plan.largest, request.largest);
  return begin(std::move(plan), now);
}

RecordingPlan RecordDesk::plan(Stamp now) const {
  RecordingPlan plan;
  plan.directory = directory_;
  plan.from = now;
  plan.until = Stamp::latest();
  plan.longest = settings_.longest;
  plan.largest = settings_.largest;
  plan.split = settings_.split;
  plan.split_bytes = settings_.split_bytes;
  plan.min_free = settings_.min_free;
  plan.description = drive_.description;
  plan.description.name = "recorded live";
  plan.copies = drive_.copies;
  // As they are by now.
  for (CameraMount& camera : plan.description.rig.cameras) {
    const auto& calibrations = publisher_->totals().calibrations;
    const auto in_use = calibrations.find(camera.name);
    if (in_use != calibrations.end()) camera.T_camera_lidar = in_use->second.T_camera_lidar;
  }
  return plan;
}

Result<void> RecordDesk::begin(RecordingPlan plan, Stamp now) {
  look_after();  // the end of the one before
  std::error_code failed;
  std::filesystem::create_directories(directory_, failed);
  if (failed) return fail("cannot be made: " + failed.message(), directory_.string());
  auto recording = Recording::begin(std::move(plan), now);
  if (!recording) return tl::unexpected(recording.error());
  const RecordReport report = recording->report();
  recorder_->begin(*std::move(recording));
  spdlog::info("recording into {} ({})", report.folder, report.why);
  for (const std::string& left_out : drive_.left_out) spdlog::info("not recorded: {}", left_out);
  told_end_ = false;
  publisher_->tell_record(report);
  if (failure_) publisher_->tell_alert({now, kDevice, false, *failure_});
  failure_.reset();
  return {};
}

// An alert during a recording is in it.
void RecordDesk::take_alert(const AlertReport& alert) {
  if (!alert.raised || alert.device == kDevice || recorder_->busy()) return;
  const Stamp now = base_.now();
  RecordingPlan plan = this->plan(now);
  plan.why = alert.device + "." + alert.finding.id;
  plan.name = alert_name(now, plan.why);
  plan.from = now - settings_.flight;
  plan.until = now + settings_.after_alert;
  if (const auto begun = begin(std::move(plan), now); !begun) {
    spdlog::error("the alert was not recorded: {}", begun.error().message());
  }
}

void RecordDesk::set(const RecordSettings& settings) {
  const bool flew = settings_.flight > Duration::zero();
  const Duration flight = settings_.flight;
  settings_ = settings;
  if (flew != (settings.flight > Duration::zero())) settings_.flight = flight;
}

void RecordDesk::look_after() {
  if (told_end_) return;
  const auto report = recorder_->report();
  if (report) tell(*report);
}

void RecordDesk::tell(const RecordReport& report) {
  publisher_->tell_record(report);
  if (!report.ended) return;
  told_end_ = true;
  spdlog::info("{}: {:.1f} s, {:.1f} MB, {} lost{}{}", report.folder, to_seconds(report.duration),
               static_cast<double>(report.bytes) * 1e-6, report.lost,
               report.reason.empty() ? "" : ": ", report.reason);
  if (report.failed) tell_failure(report);
}

void RecordDesk::tell_failure(const RecordReport& report) {
  failure_ = Finding{"record", Level::kWarn, report.stamp,
                     "a recording ended before it should have: " + report.reason,
                     "make room on the disk of " + directory_.string()};
  publisher_->tell_alert({report.stamp, kDevice, true, *failure_});
}

void RecordDesk::finish() {
  if (!recorder_) return;
  recorder_->finish();
  look_after();
}

}  // namespace infuse::daemon

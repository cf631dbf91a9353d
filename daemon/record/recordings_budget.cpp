#include "daemon/record/recordings_budget.hpp"

#include <spdlog/spdlog.h>

#include <algorithm>
#include <map>

namespace infuse::daemon {
namespace {

namespace fs = std::filesystem;

/// Size of all files below a folder. What vanishes meanwhile counts as nothing.
uint64_t bytes_below(const fs::path& folder) {
  uint64_t bytes = 0;
  std::error_code error;
  for (fs::recursive_directory_iterator entry(folder, error), end; !error && entry != end;
       entry.increment(error)) {
    std::error_code none;
    if (!entry->is_regular_file(none)) continue;
    const uintmax_t size = entry->file_size(none);
    if (!none) bytes += size;
  }
  return bytes;
}

/// "NAME" of the drive folders "NAME", "NAME.2", …
std::string recording_of(const fs::path& drive) {
  const std::string name = drive.filename().string();
  return name.substr(0, name.find('.'));
}

/// All drives of one recording.
struct DrivesOfRecording {
  std::string name;
  std::vector<fs::path> drives;
};

/// The drives in a folder, by recording.
std::map<std::string, std::vector<fs::path>> drives_in(const fs::path& directory) {
  std::map<std::string, std::vector<fs::path>> recordings;
  std::error_code error;
  for (fs::directory_iterator entry(directory, error), end; !error && entry != end;
       entry.increment(error)) {
    recordings[recording_of(entry->path())].push_back(entry->path());
  }
  return recordings;
}

/// The alert recordings, oldest first. Their names begin with their time; `last` was made last.
std::vector<DrivesOfRecording> alerts_by_age(std::map<std::string, std::vector<fs::path>> all,
                                             const std::string& last) {
  std::vector<DrivesOfRecording> alerts;
  for (auto& [name, drives] : all) {
    if (name.starts_with(kAlertPrefix)) alerts.push_back({name, std::move(drives)});
  }
  if (!last.starts_with(kAlertPrefix)) return alerts;
  std::stable_partition(alerts.begin(), alerts.end(),
                        [&](const DrivesOfRecording& alert) { return alert.name > last; });
  return alerts;
}

void remove_drive(const fs::path& drive, const char* why) {
  spdlog::info("{}: removed, {}", drive.string(), why);
  std::error_code ignored;
  fs::remove_all(drive, ignored);
}

}  // namespace

void RecordingsBudget::measure(const std::string& current) {
  bytes_ = 0;
  alerts_.clear();
  auto all = drives_in(directory_);
  all.erase(current);
  for (const auto& [name, drives] : all) {
    if (name.starts_with(kAlertPrefix)) continue;
    for (const fs::path& drive : drives) bytes_ += bytes_below(drive);
  }
  for (const DrivesOfRecording& alert : alerts_by_age(std::move(all), current)) {
    for (const fs::path& drive : alert.drives) {
      alerts_.push_back({drive, bytes_below(drive)});
      bytes_ += alerts_.back().bytes;
    }
  }
  std::reverse(alerts_.begin(), alerts_.end());
}

bool RecordingsBudget::make_room(uint64_t bytes) {
  while (bytes_ + bytes > budget_ && !alerts_.empty()) {
    remove_drive(alerts_.back().folder, "the budget of recordings is used up");
    bytes_ -= alerts_.back().bytes;
    alerts_.pop_back();
  }
  return bytes_ + bytes <= budget_;
}

void remove_old_alerts(const fs::path& directory, size_t keep, const std::string& last) {
  const auto recordings = alerts_by_age(drives_in(directory), last);
  for (size_t i = 0; i + keep < recordings.size(); ++i) {
    for (const fs::path& drive : recordings[i].drives) {
      remove_drive(drive, "newer alert recordings replace it");
    }
  }
}

}  // namespace infuse::daemon

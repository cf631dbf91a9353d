#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "daemon/protocol/reports.hpp"
#include "daemon/record/record_parser.hpp"
#include "drivers/recording/drive_writer.hpp"

namespace infuse::daemon {

/// What is recorded, and its limits.
struct RecordingPlan {
  std::filesystem::path directory;  ///< in which the drives are created
  std::string name;   ///< of the first drive; `name`.2, … follow if the recording is split
  std::string cause;  ///< "requested", or the id of the alert
  Stamp from, until;  ///< range of stamps of the recorded data
  Duration max_duration{0};
  uint64_t max_bytes = 0;       ///< size of all drives together, bytes
  Duration split_duration{0};   ///< after which the next drive is started; 0: never
  uint64_t split_bytes = 0;     ///< size after which the next drive is started, bytes; 0: never
  uint64_t min_free_bytes = 0;  ///< free space to leave on the disk, bytes
  recording::DriveDescription description;
  std::vector<recording::DriveWriter::CopiedFile> copies;
};

/// A recording in progress: records in, drives out. Ends by itself at its limits and when the disk
/// rejects data. Not thread-safe.
class Recording {
 public:
  /// Creates the first drive. Errors: the folder cannot be created, or its disk has too little free
  /// space.
  static Result<Recording> begin(RecordingPlan plan, Stamp now);

  /// Writes a record; ignores it if it lies outside the limits.
  void add(const Record& record);

  /// Flushes the files and checks the limits. `lost`: number of records lost so far. `caught_up`:
  /// true if every available record has been added; until then records that belong to the recording
  /// may still be waiting.
  void flush_and_check(Stamp now, uint64_t lost, bool caught_up);

  /// Ends the recording at stamp `until`; later records are ignored.
  void end_at(Stamp until) { plan_.until = std::min(plan_.until, until); }

  /// Ends the recording now. `reason` is reported; `failed`: the end is premature.
  void end(const std::string& reason, bool failed = false);

  /// State so far; `ended` is set after the end.
  const RecordReport& report() const { return report_; }

 private:
  static constexpr Duration kSyncPeriod{2'000'000'000};
  static constexpr Duration kMaxRecordDelay{1'000'000'000};  // how late records may arrive

  Recording(RecordingPlan plan, recording::DriveWriter drive)
      : plan_(std::move(plan)),
        drive_(std::move(drive)),
        first_images_(plan_.description.cameras.size()) {}
  Result<void> write(const Record& record);
  Result<void> write_image(const Record& record);
  Result<void> split_if_due(Stamp stamp);
  void flush(Stamp now);
  void check_bounds(Stamp now, bool caught_up);

  RecordingPlan plan_;
  recording::DriveWriter drive_;
  std::vector<std::optional<uint64_t>>
      first_images_;  // first sequence number of each camera in this drive
  RecordReport report_;
  std::optional<Stamp> first_stamp_, drive_begin_;
  uint64_t bytes_before_ = 0;  // size of the completed drives
  Stamp last_sync_;
};

/// Free space for this user on the disk of a folder, bytes; nothing if it cannot be determined.
std::optional<uint64_t> free_bytes(const std::filesystem::path& folder);

}  // namespace infuse::daemon

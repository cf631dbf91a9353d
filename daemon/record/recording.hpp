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

/// What is recorded, and where its bounds are.
struct RecordingPlan {
  std::filesystem::path directory;  ///< in which the drives are made
  std::string name;                 ///< of the first; `name`.2, ... follow where it is split
  std::string cause;                ///< "requested", or the alert
  Stamp from, until;                ///< records of these stamps
  Duration max_duration{0};
  uint64_t max_bytes = 0;       ///< bytes, of all drives together
  Duration split_duration{0};   ///< after which another drive is begun; 0: none
  uint64_t split_bytes = 0;     ///< the same by size; 0: none
  uint64_t min_free_bytes = 0;  ///< bytes left free on the disk
  recording::DriveDescription description;
  std::vector<recording::DriveWriter::CopiedFile> copies;
};

/// One recording while it is made: records in, drives out. Ends by itself at its bounds, and where
/// the disk takes no more. Of one thread at a time.
class Recording {
 public:
  /// Makes the first drive. Errors: the folder cannot be made, or too little is free on its disk.
  static Result<Recording> begin(RecordingPlan plan, Stamp now);

  /// Takes a record; nothing where it lies outside the bounds.
  void add(const Record& record);

  /// Looks after the disk and the bounds. `lost`: records that did not come, so far. `caught_up`:
  /// it was given all there is; until then records that are to be in it may wait.
  void flush_and_check(Stamp now, uint64_t lost, bool caught_up);

  /// No record is taken from `until` on.
  void end_at(Stamp until) { plan_.until = std::min(plan_.until, until); }

  /// Ends now, for that reason.
  void end(const std::string& reason, bool failed = false);

  /// What it came to so far; ended where `ended` is set.
  const RecordReport& report() const { return report_; }

 private:
  static constexpr Duration kSyncPeriod{2'000'000'000};
  static constexpr Duration kMaxRecordDelay{1'000'000'000};  // with records that are on their way

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
  std::vector<std::optional<uint64_t>> first_images_;  // of each camera, in this drive
  RecordReport report_;
  std::optional<Stamp> first_stamp_, drive_begin_;
  uint64_t bytes_before_ = 0;  // of drives that are done
  Stamp last_sync_;
};

/// Bytes free for this user on the disk of a folder; nothing where that cannot be told.
std::optional<uint64_t> free_bytes(const std::filesystem::path& folder);

}  // namespace infuse::daemon

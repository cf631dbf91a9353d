#pragma once

#include <cstdint>
#include <filesystem>
#include <string>

#include "daemon/owner/inspection.hpp"

namespace infuse::daemon {

/// A list of inspected captures: a line for each, and the totals.
class InspectionList {
 public:
  /// Adds a capture, and returns its line: name, models, sweeps, losses, problems.
  std::string add(const std::filesystem::path& capture, const Result<Inspection>& inspection);

  /// The last line of the list.
  std::string totals_text() const;

  /// The totals as one JSON object.
  Json totals_json() const;

  /// True if every capture could be read and holds a lidar.
  bool all_have_lidars() const { return with_lidar_ == captures_; }

 private:
  uint64_t captures_ = 0;
  uint64_t with_lidar_ = 0;
  uint64_t with_problems_ = 0;
  uint64_t sweeps_ = 0;
  uint64_t packets_ = 0;
  uint64_t packets_lost_ = 0;
};

}  // namespace infuse::daemon

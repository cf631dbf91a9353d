#pragma once

#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "daemon/command_line/progress_line.hpp"
#include "daemon/command_line/summary.hpp"
#include "daemon/protocol/json.hpp"
#include "daemon/setup/drive_setup.hpp"
#include "drivers/makers/arrivals.hpp"
#include "drivers/makers/capture_survey.hpp"
#include "drivers/measurement/error.hpp"

namespace infuse::daemon {

/// Contents of the files before decoding.
struct RecordingContents {
  makers::CaptureSurvey survey;
  std::map<std::string, makers::Arrivals> other_streams;  ///< "camera 0", "CAN frames", ...
  std::vector<Error> notes;
  bool has_map = false;
};

/// What a capture or drive holds.
struct Inspection {
  std::filesystem::path path;
  RecordingContents contents;
  Result<Summary> summary;  ///< of its replay; an error if it cannot be replayed
};

/// Inspects a capture or drive. Errors: it cannot be read.
Result<Inspection> inspect_recording(const std::filesystem::path& path,
                                     const LidarOverrides& overrides, ProgressLine& line);

/// True if a lidar has been decoded.
bool has_lidar(const Inspection& inspection);

/// Problems that need attention.
std::vector<std::string> list_problems(const Inspection& inspection);

/// Formats an inspection as one JSON object.
Json to_json(const Inspection& inspection);

/// Formats an inspection as several lines of text.
std::string to_text(const Inspection& inspection);

}  // namespace infuse::daemon

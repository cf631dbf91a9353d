#pragma once

#include <array>
#include <cstdint>
#include <iosfwd>
#include <optional>
#include <string>
#include <vector>

namespace infuse::study {

/// One rig that was driven twice: in other worlds, at other times, in other light.
struct DrivesTrial {
  uint64_t seed = 0;  ///< of the rig
  std::string lidar;
  int width = 0;
  bool fisheye = false;
  int usable = 0;           ///< number of the two results that are
  double rotation = 0;      ///< rad, between the two results
  double translation = 0;   ///< m
  double mahalanobis2 = 0;  ///< of the difference, by what differs from drive to drive; if both are
  std::array<double, 2> from_truth2{};  ///< of each error, by the stated covariance
  std::string reason;                   ///< why the first that is not usable is not
};

/// Which drives are made of a rig.
struct DrivesOptions {
  int scenes = 24;      ///< number of each drive
  double seconds = 40;  ///< duration of each drive
};

/// Calibrates both drives with the same intrinsics, which are off as `KnownParameters` states, each
/// with a clock that is off on its own. Returns nothing if a drive cannot be rendered.
std::optional<DrivesTrial> drive_twice(uint64_t seed, const DrivesOptions& options);

void write_drives_header(std::ostream& out);
void write_drives_row(std::ostream& out, const DrivesTrial& trial);

/// Reads rows that were written before; leaves out the header and incomplete rows.
std::vector<DrivesTrial> read_drives_rows(std::istream& in);

/// Writes how many results are usable, and of rigs with two usable ones the mean squared
/// Mahalanobis difference divided by 6 and how many lie beyond 99 %.
void write_drives_summary(std::ostream& out, const std::vector<DrivesTrial>& trials);

}  // namespace infuse::study

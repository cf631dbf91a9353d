#pragma once

#include <array>
#include <cstdint>
#include <iosfwd>
#include <string>
#include <vector>

namespace infuse::study {

/// Sets of sources that measure speed and rotation: all of a drive, and what remains of them alone.
enum class SourceSet : uint8_t { kAll, kWheelsAndBus, kWheelsAndGyro, kGnss, kLidar, kCount };
inline constexpr size_t kSourceSets = static_cast<size_t>(SourceSet::kCount);

/// One drive, by each set of its sources.
struct SourcesTrial {
  uint64_t seed = 0;
  std::string fault;  ///< what went wrong in it
  /// m, rms over stretches of 10 s: position at the end, from pose and heading at the begin. NaN:
  /// the drive has no such set, or some stretch has no pose.
  std::array<double, kSourceSets> error{};

  /// Error of all sources over that of the best set; NaN without one.
  double ratio() const;
};

/// Drives a vehicle whose sources, errors of sources, roads, weather and fault are drawn from a
/// seed, on samples: no lidar is rendered.
SourcesTrial drive_by_sources(uint64_t seed);

void write_sources_header(std::ostream& out);
void write_sources_row(std::ostream& out, const SourcesTrial& trial);

/// Reads rows that were written before; leaves out headers and incomplete rows.
std::vector<SourcesTrial> read_sources_rows(std::istream& in);

/// Writes median and worst ratio, of all drives and by fault.
void write_sources_summary(std::ostream& out, const std::vector<SourcesTrial>& trials);

}  // namespace infuse::study
